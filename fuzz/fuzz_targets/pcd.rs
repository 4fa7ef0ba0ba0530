//! Fuzz target: PCD point clouds.

#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| clearance_fuzz::inputs::pcd(data));
