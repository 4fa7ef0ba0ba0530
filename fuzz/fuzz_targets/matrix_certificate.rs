//! Fuzz target: certificates of collision matrices.

#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| clearance_fuzz::inputs::matrix_certificate(data));
