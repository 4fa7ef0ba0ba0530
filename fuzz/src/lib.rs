//! Library of the fuzz targets; their functions are in `inputs`. See `README.md`.

pub mod inputs;
