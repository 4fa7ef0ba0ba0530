//! Writer of binary STL files for simplified meshes, and their recognition by the header.

use clearance_geometry::TriangleMesh;

/// Start of the header of the files that are written here.
const TITLE: &[u8] = b"binary STL, simplified by clearance";

/// True if the start of a file is that of a simplified mesh.
#[must_use]
pub fn is_simplified_stl(start: &[u8]) -> bool {
    start.starts_with(TITLE)
}

/// Length of the header; it must not begin with `solid`, as texts do.
const HEADER: usize = 80;

/// A mesh as binary STL, in its frame (m). Coordinates are rounded to single precision; those of a simplified mesh are exact.
#[must_use]
pub fn stl(mesh: &TriangleMesh) -> Vec<u8> {
    let count = u32::try_from(mesh.triangles().len()).unwrap_or(u32::MAX);
    let mut bytes = [TITLE, b"; metres"].concat();
    bytes.resize(HEADER, 0);
    bytes.extend(count.to_le_bytes());
    for number in 0..count as usize {
        let triangle = mesh.triangle(number);
        let rows = [triangle.normal().data.0[0], triangle.a.into(), triangle.b.into(), triangle.c.into()];
        #[allow(clippy::cast_possible_truncation)] // a rounding
        bytes.extend(rows.as_flattened().iter().flat_map(|c: &f64| (*c as f32).to_le_bytes()));
        bytes.extend([0; 2]);
    }
    bytes
}
