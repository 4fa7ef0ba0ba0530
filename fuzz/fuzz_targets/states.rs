//! Fuzz target: files of robot states.

#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| clearance_fuzz::inputs::states(data));
