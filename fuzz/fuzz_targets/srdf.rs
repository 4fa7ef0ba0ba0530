//! Fuzz target: SRDF robot descriptions.

#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| clearance_fuzz::inputs::srdf(data));
