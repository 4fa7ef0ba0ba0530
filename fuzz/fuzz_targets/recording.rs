//! Fuzz target: MCAP recordings, replayed.

#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| clearance_fuzz::inputs::recording(data));
