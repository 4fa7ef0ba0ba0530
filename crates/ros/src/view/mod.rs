//! The live view: robot and world in a web browser, as the monitor judges them.
//!
//! ```text
//! monitor loop ──observer──> slot (the last judgement) <──at its own pace── server ──HTTP──> browsers: view/src
//! ```
//!
//! | path | what |
//! |---|---|
//! | `/`, `/view.js`, `/view.css`, `/licences.txt` | the page, built from `view/` and carried by the program |
//! | `/robot`, `/world` | geometry: bodies and shapes as JSON, with the numbers of meshes and clouds behind it |
//! | `/updates` | server-sent events: status, distances, poses |
//!
//! The monitor leaves a judgement in the slot and goes on; it waits for no browser. No path opens a file.

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
