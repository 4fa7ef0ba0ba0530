//! Reader of point clouds in PLY files: the vertices only.

use clearance_files::ply_format::PlyFile;

use super::points::{CloudError, CloudPoints};

/// # Errors
/// If the header is incomplete, or the data does not end where it says.
pub(super) fn read(bytes: &[u8]) -> Result<CloudPoints, CloudError> {
    let PlyFile { elements, mut numbers } = PlyFile::open(bytes)?;
    let mut cloud = CloudPoints::default();
    let Some(at) = elements.iter().position(|element| element.name == "vertex") else {
        return Err(CloudError("the header has no element vertex".to_owned()));
    };
    let (before, vertices, after) = (&elements[..at], &elements[at], &elements[at + 1..]);
    if after.iter().any(|element| element.name == "vertex") {
        return Err(CloudError("the header has more than one element vertex".to_owned()));
    }
    for element in before {
        numbers.skip(element)?;
    }
    let xyz = vertices.coordinates()?;
    for i in 0..vertices.count {
        cloud.push(numbers.point(vertices, xyz, i)?)?;
    }
    if elements.iter().any(|e| e.name == "face" && e.count > 0) {
        cloud.remarks.push("its faces are not used: only its vertices are points".to_owned());
    }
    // vertices with more numbers than the header lists are only noticed by what remains
    for element in after {
        numbers.skip(element)?;
    }
    cloud.remarks.extend(numbers.end()?);
    Ok(cloud)
}

#[cfg(test)]
#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // small numbers
mod tests;
