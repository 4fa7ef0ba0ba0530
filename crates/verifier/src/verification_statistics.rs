//! Work counters of an accepted certificate.

/// Statistics of an accepted certificate.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct VerificationStatistics {
    /// Segments of the motion.
    pub segments: usize,
    /// Pairs of bodies, each apart throughout every segment.
    pub pairs: usize,
    /// Pairs proven apart on an interval.
    pub proofs: usize,
    /// Proofs for which boxes around the bodies were too rough, and their own corners were used.
    pub exact_bounds: usize,
    /// Pairs of triangles or primitives whose distance was tested.
    pub element_tests: u64,
}

impl VerificationStatistics {
    /// Adds the work of one more segment.
    pub(super) fn add(&mut self, segment: &Self) {
        self.proofs += segment.proofs;
        self.exact_bounds += segment.exact_bounds;
        self.element_tests += segment.element_tests;
    }
}
