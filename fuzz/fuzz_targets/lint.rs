//! Fuzz target: lint of OBJ meshes, defects and distances to the visual geometry.

#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| clearance_fuzz::inputs::lint(data));
