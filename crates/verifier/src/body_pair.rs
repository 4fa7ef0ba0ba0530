//! Pair of bodies, by their indices, that a certificate must prove apart.

/// A pair of bodies that must stay apart.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct BodyPair {
    /// Indices into one list of all bodies: links, then attached objects, then obstacles by their places.
    pub bodies: [usize; 2],
    pub names: [String; 2],
    /// Safety distance (m).
    pub padding: f64,
}
