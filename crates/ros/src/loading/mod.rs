//! The loader: builds checkers from robot descriptions and scene messages, on its own thread.

pub mod guarded; // work in which a panic must not end the node
pub mod loader; // the loader
pub mod loader_inputs; // inputs of one pass
pub mod logged_meshes; // remarks on meshes that were logged
