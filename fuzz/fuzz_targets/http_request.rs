//! Fuzz target: HTTP requests to the live view.

#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| clearance_fuzz::inputs::http_request(data));
