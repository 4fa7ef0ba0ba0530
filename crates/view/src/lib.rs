//! The live view: shows robot and world in a web browser, with the results of the monitor.
//!
//! ```text
//! monitor loop ──observer──> latest evaluation <──at its own rate── server ──HTTP──> browsers: view/src
//! ```
//!
//! | path | content |
//! |---|---|
//! | `/`, `/view.js`, `/view.css`, `/licences.txt` | the page, built from `view/` and embedded in the program |
//! | `/robot`, `/world` | geometry: bodies and shapes as JSON, followed by the binary data of meshes and clouds |
//! | `/updates` | server-sent events: status, distances, poses |
//! | `/joints`, POST to `/state` | only without a node: ranges of the sliders; the move of one of them |
//!
//! The monitor stores each evaluation in the slot and continues; it never waits for a browser. No path opens a file.
//!
//! Without a node, [`StateView`] shows the states that the program or the sliders of the page set. Nothing here uses ROS.

// minima of floating-point numbers: see `math/extremes.rs` of clearance-geometry
#![cfg_attr(not(test), warn(clippy::disallowed_methods))]

mod address; // address of the server
mod assets; // files of the page
mod document; // geometry document: JSON and arrays
mod geometry_documents; // robot and world as geometry documents
mod http_service; // responses to HTTP requests
mod in_memory; // connection in memory, for fuzz targets
mod latest_evaluation; // slot with the last evaluation
mod reach; // reach of the robot, for the camera
mod server; // HTTP server
mod state_control; // state that sliders move
mod state_view; // server of a view without a node
mod update_message; // evaluation to update message
mod watched_stream; // connection that detects a stalled peer

#[cfg(test)]
mod state_tests;
#[cfg(test)]
mod tests;

pub use address::{ViewAddress, ViewAddressError};
#[doc(hidden)]
pub use in_memory::respond_in_memory;
pub use server::{Observer, View, ViewError};
pub use state_view::{StateView, StateViewError};
