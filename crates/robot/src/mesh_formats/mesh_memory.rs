//! Memory estimates of meshes, checked before allocation: a failed allocation would end the process.

/// Largest measured memory (bytes) of one triangle and one vertex, from reading a file to the finished hierarchies.
const TRIANGLE: usize = 500;
const VERTEX: usize = 200;

/// Memory is checked in steps (bytes).
pub(super) const STEP: usize = 64 << 20;

/// Estimated memory (bytes) of a mesh with its hierarchies.
pub fn of_mesh(vertices: usize, triangles: usize) -> usize {
    (vertices.saturating_mul(VERTEX)).saturating_add(triangles.saturating_mul(TRIANGLE))
}

/// Checks whether this number of bytes can be allocated now. They are not kept, and overcommitted memory is not detected.
///
/// # Errors
/// A clause with the required amount.
pub fn check(bytes: usize) -> Result<(), String> {
    let mut room = Vec::<u8>::new();
    let granted = room.try_reserve_exact(bytes);
    // an unused allocation would be optimized away, and the check with it
    std::hint::black_box(room.as_ptr());
    granted.map_err(|_| format!("need about {} MiB of memory, more than is available", bytes >> 20))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn more_than_any_machine_has_is_an_error() {
        assert_eq!(check(0), Ok(()));
        assert_eq!(check(STEP), Ok(()));
        for bytes in [1 << 60, usize::MAX] {
            assert!(check(bytes).unwrap_err().contains("MiB of memory"));
        }
        assert_eq!(of_mesh(usize::MAX, usize::MAX), usize::MAX);
    }
}
