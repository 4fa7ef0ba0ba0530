//! Fuzz target: OBJ meshes whose defects and distances are searched.

#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| clearance_fuzz::inputs::lint(data));
