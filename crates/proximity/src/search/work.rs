//! Counters of elementary tests: the cost of queries, in numbers of tests rather than in seconds.

use clearance_geometry::InsideWork;

/// Counters of elementary tests: they guard speed without timing noise (Gottschalk, Lin & Manocha 1996:
/// `T = N_bv * C_bv + N_p * C_p`).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Work {
    /// Tests of two bounding volumes.
    pub volume_tests: u64,
    /// Pairs tested eight at a time in f32: two triangles, or a triangle and a primitive, a point or a cube.
    pub screened_pairs: u64,
    /// Tests in f64 of two elements: triangles, convex primitives, planes, points or cubes.
    pub primitive_tests: u64,
    /// Points of which a winding number was computed, to find out whether they are inside a closed mesh; the steps of each are counted
    /// as volume tests.
    pub winding_numbers: u64,
}

impl Work {
    /// Total cost in units of volume tests: a test in f64 costs about six of them, one in f32 hardly more than one.
    #[must_use]
    #[inline]
    pub fn cost(&self) -> u64 {
        self.volume_tests + self.screened_pairs + 6 * self.primitive_tests
    }

    /// Adds tests whether points are inside a mesh.
    #[inline]
    pub(crate) fn add_inside_tests(&mut self, tests: InsideWork) {
        self.volume_tests += tests.visited;
        self.winding_numbers += tests.winding_numbers;
    }
}

impl std::ops::AddAssign for Work {
    fn add_assign(&mut self, other: Self) {
        self.volume_tests += other.volume_tests;
        self.screened_pairs += other.screened_pairs;
        self.primitive_tests += other.primitive_tests;
        self.winding_numbers += other.winding_numbers;
    }
}
