# Cargo, its profile and its target folder.
include_guard(GLOBAL)

find_program(CARGO cargo HINTS "$ENV{CARGO_HOME}/bin" "$ENV{HOME}/.cargo/bin" REQUIRED)

# `-DCARGO_PROFILE=dev` builds without optimization.
set(CARGO_PROFILE "release" CACHE STRING "Profile that cargo builds with")
if(CARGO_PROFILE STREQUAL "dev")
  set(PROFILE_FOLDER "debug")
else()
  set(PROFILE_FOLDER "${CARGO_PROFILE}")
endif()
set(TARGET_FOLDER "${CMAKE_BINARY_DIR}/cargo" CACHE PATH "Folder that cargo builds in")
