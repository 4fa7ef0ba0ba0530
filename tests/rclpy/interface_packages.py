"""Build helper: writes the interfaces of a text file as ament packages: interface_packages.py FILE FOLDER

Prints the names of the packages in the order in which they have to be built.
"""

import re
import sys
from pathlib import Path

SECTION = re.compile(r"^==== (\w+)/(msg|srv)/(\w+)\n", re.MULTILINE)
OTHER_PACKAGE = re.compile(r"^(\w+)/\w+", re.MULTILINE)

# Nothing here is called from C++, so its generators are left out. The one target that is compiled as C++ spends its time
# in headers: in one batch it reads them once.
CMAKE = """\
cmake_minimum_required(VERSION 3.16)
project({package})
{find_packages}
list(FILTER AMENT_EXTENSIONS_rosidl_generate_idl_interfaces EXCLUDE REGEX "_cpp:")
rosidl_generate_interfaces({package}
  {files}
  DEPENDENCIES {dependencies}
)
set_target_properties({package}__rosidl_typesupport_fastrtps_c PROPERTIES UNITY_BUILD ON UNITY_BUILD_BATCH_SIZE 12)
ament_package()
"""
PACKAGE_XML = """\
<?xml version="1.0"?>
<package format="3">
  <name>{package}</name>
  <version>0.0.0</version>
  <description>A part of {package}, for tests.</description>
  <maintainer email="maintainers@users.noreply.h-seed-610e6e80.example">The clearance maintainers</maintainer>
  <license>BSD-3-Clause</license>
  <buildtool_depend>ament_cmake</buildtool_depend>
  {depends}
  <member_of_group>rosidl_interface_packages</member_of_group>
  <export><build_type>ament_cmake</build_type></export>
</package>
"""


def read_packages(text):
    """The interfaces by package and file name."""
    packages = {}
    _, *parts = SECTION.split(text)
    for package, kind, name, fields in zip(*(parts[i::4] for i in range(4)), strict=True):
        packages.setdefault(package, {})[f"{kind}/{name}.{kind}"] = fields
    return packages


def write_package(folder, package, interfaces):
    dependencies = sorted({other for text in interfaces.values() for other in OTHER_PACKAGE.findall(text)} - {package})
    for name, text in interfaces.items():
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
    cmake = CMAKE.format(
        package=package,
        find_packages="\n".join(
            f"find_package({name} REQUIRED)" for name in ("ament_cmake", "rosidl_default_generators", *dependencies)
        ),
        files="\n  ".join(interfaces),
        dependencies=" ".join(dependencies),
    )
    depends = "\n  ".join(f"<depend>{name}</depend>" for name in dependencies)
    (folder / "CMakeLists.txt").write_text(cmake)
    (folder / "package.xml").write_text(PACKAGE_XML.format(package=package, depends=depends))


def main(source, folder):
    for package, interfaces in read_packages(Path(source).read_text()).items():
        write_package(Path(folder) / package, package, interfaces)
        print(package)


main(*sys.argv[1:])
