//! Fuzz target: CDR messages of topics and services.

#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| clearance_fuzz::inputs::message(data));
