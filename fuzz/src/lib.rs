//! The inputs of the fuzz targets. See `README.md`.

pub mod inputs;
