//! Point clouds in PLY files: the vertices only.

use super::points::{CloudError, CloudPoints};
use crate::ply_format::PlyFile;

/// # Errors
/// When the header is incomplete, or the data ends before the last vertex.
pub(super) fn read(bytes: &[u8]) -> Result<CloudPoints, CloudError> {
    let PlyFile { elements, mut numbers } = PlyFile::open(bytes)?;
    let mut cloud = CloudPoints::default();
    for element in &elements {
        if element.name != "vertex" {
            numbers.skip(element)?;
            continue;
        }
        let xyz = element.coordinates()?;
        for i in 0..element.count {
            cloud.push(numbers.point(element, xyz, i)?)?;
        }
        if elements.iter().any(|e| e.name == "face" && e.count > 0) {
            cloud.remarks.push("its faces are not used: only its vertices are points".to_owned());
        }
        return Ok(cloud);
    }
    Err(CloudError("the header has no element vertex".to_owned()))
}

#[cfg(test)]
#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // small numbers
mod tests;
