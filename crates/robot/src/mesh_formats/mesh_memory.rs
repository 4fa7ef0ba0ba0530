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

/// Memory (bytes) of growing lists, checked in steps.
#[derive(Debug, Default)]
pub struct Growth {
    available: usize,
}

impl Growth {
    /// Checks whether lists of together `count` elements of type `T` can be allocated; a list that grows has room for twice its elements.
    ///
    /// # Errors
    /// As for [`check`].
    pub fn check<T>(&mut self, count: usize) -> Result<(), String> {
        let needed = count.saturating_mul(2 * size_of::<T>());
        if needed > self.available {
            let needed = needed.saturating_add(STEP);
            check(needed)?;
            self.available = needed;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn growth_is_checked_before_it_happens() {
        let mut growth = Growth::default();
        for count in [0, 1, 1000, STEP / 16] {
            assert_eq!(growth.check::<u64>(count), Ok(()));
            assert!(growth.available >= 16 * count);
        }
        assert!(growth.check::<u64>(usize::MAX / 32).unwrap_err().contains("MiB of memory"));
    }

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
