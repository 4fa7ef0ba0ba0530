//! Fuzz target: certificates of motions.

#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| clearance_fuzz::inputs::certificate(data));
