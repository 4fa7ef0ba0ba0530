//! Fuzz target: planning scenes in YAML.

#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| clearance_fuzz::inputs::scene_yaml(data));
