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
//!
//! The monitor stores each evaluation in the slot and continues; it never waits for a browser. No path opens a file.

pub mod address; // address of the server
pub mod assets; // files of the page
pub mod document; // geometry document: JSON and arrays
pub mod geometry_documents; // robot and world as geometry documents
pub mod http_service; // responses to HTTP requests
pub mod in_memory; // connection in memory, for fuzz targets
pub mod latest_evaluation; // slot with the last evaluation
pub mod reach; // reach of the robot, for the camera
pub mod server; // HTTP server
pub mod update_message; // evaluation to update message
pub mod watched_stream; // connection that detects a stalled peer

#[cfg(test)]
mod tests;
