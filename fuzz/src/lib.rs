//! Library of the fuzz targets: one function for each input format.
//! See `README.md`.

pub mod inputs;
