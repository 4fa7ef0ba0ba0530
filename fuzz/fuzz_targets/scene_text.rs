//! Fuzz target: planning scenes in MoveIt's `.scene` text.

#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| clearance_fuzz::inputs::scene_text(data));
