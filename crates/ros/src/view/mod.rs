//! The live view: shows robot and world in a web browser, with the results of the monitor.
//!
//! ```text
//! monitor loop ──observer──> slot (the last evaluation) <──at its own rate── server ──HTTP──> browsers: view/src
//! ```
//!
//! | path | content |
//! |---|---|
//! | `/`, `/view.js`, `/view.css`, `/licences.txt` | the page, built from `view/` and embedded in the program |
//! | `/robot`, `/world` | geometry: bodies and shapes as JSON, followed by the binary data of meshes and clouds |
//! | `/updates` | server-sent events: status, distances, poses |
//!
//! The monitor stores each evaluation in the slot and continues; it never waits for a browser. No path opens a file.

mod address;
mod assets;
mod document;
mod in_memory;
mod reach;
mod scene;
mod server;
mod site;
mod slot;
mod update;
mod watched_stream;

#[cfg(test)]
mod tests;

pub use address::{ViewAddress, ViewAddressError};
pub use in_memory::respond_in_memory;
pub use server::{View, ViewError};
