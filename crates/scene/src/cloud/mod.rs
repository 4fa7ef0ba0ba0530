//! Clouds of points from files (PCD, PLY), and from any bytes that hold records.
//!
//! The parsers are our own: the crates that read these formats build a value for every number of every field, or do not
//! know compressed PCD, and trust the counts of the header.

mod lzf;
mod pcd;
mod ply;
mod points;

pub use clearance_files::ply_format::{ByteOrder, NumberKind};
pub use points::{CloudError, CloudPoints, Column, Columns};

use clearance_files::ply_format::is_ply;

/// Whether the bytes begin as a cloud file does that [`read_cloud`] knows.
#[must_use]
pub fn is_cloud(bytes: &[u8]) -> bool {
    is_ply(bytes) || pcd::is_pcd(bytes)
}

/// The points of a PCD or PLY file, which is recognised by what it holds.
///
/// # Errors
/// What the file lacks or where it contradicts itself.
pub fn read_cloud(bytes: &[u8]) -> Result<CloudPoints, CloudError> {
    if is_ply(bytes) {
        ply::read(bytes)
    } else if pcd::is_pcd(bytes) {
        pcd::read(bytes)
    } else {
        Err(CloudError("the file is neither a PCD nor a PLY by what it holds".to_owned()))
    }
}
