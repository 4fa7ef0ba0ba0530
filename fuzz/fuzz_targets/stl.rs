//! Fuzz target: STL meshes.

#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| clearance_fuzz::inputs::stl(data));
