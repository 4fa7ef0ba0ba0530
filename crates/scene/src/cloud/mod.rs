//! Point clouds from files (PCD, PLY), and from any bytes that hold records.
//!
//! The parsers are part of this project. Existing crates for these formats build a value for every number of every field, or do not
//! support compressed PCD, and trust the counts of the header.

mod lzf;
mod pcd;
mod ply;
mod points;

pub use clearance_files::ply_format::{ByteOrder, NumberKind};
pub use points::{CloudError, CloudPoints, Column, Columns, is_at_origin};

use clearance_files::ply_format::is_ply;

/// True if the bytes start like a point cloud file that [`read_cloud`] supports.
#[must_use]
pub fn is_cloud(bytes: &[u8]) -> bool {
    is_ply(bytes) || pcd::is_pcd(bytes)
}

/// The points of a PCD or PLY file, recognised by its content.
///
/// # Errors
/// The missing or contradictory part of the file.
pub fn read_cloud(bytes: &[u8]) -> Result<CloudPoints, CloudError> {
    if is_ply(bytes) {
        ply::read(bytes)
    } else if pcd::is_pcd(bytes) {
        pcd::read(bytes)
    } else {
        Err(CloudError("the file is neither a PCD nor a PLY by what it holds".to_owned()))
    }
}
