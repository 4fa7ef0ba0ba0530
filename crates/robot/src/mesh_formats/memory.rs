//! Estimated memory of meshes, checked before it is allocated: an allocation that fails ends the process.

/// Memory (bytes) of one triangle and one vertex from reading a file until its hierarchies are built, as measured at most.
const TRIANGLE: usize = 500;
const VERTEX: usize = 200;

/// Memory is checked in steps (bytes).
pub(super) const STEP: usize = 64 << 20;

/// Estimated memory (bytes) of a mesh with its hierarchies.
pub fn of_mesh(vertices: usize, triangles: usize) -> usize {
    (vertices.saturating_mul(VERTEX)).saturating_add(triangles.saturating_mul(TRIANGLE))
}

/// Whether so many bytes can be had now. They are not kept: what the system grants without having it is not found out.
///
/// # Errors
/// A clause that says how much is needed.
pub fn check(bytes: usize) -> Result<(), String> {
    let mut room = Vec::<u8>::new();
    let granted = room.try_reserve_exact(bytes);
    // an allocation without use would be optimized away, and with it the check
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
