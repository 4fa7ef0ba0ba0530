//! Fuzz target: OctoMap octree files.

#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| clearance_fuzz::inputs::octree(data));
