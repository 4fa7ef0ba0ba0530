//! Gap in a scene: an announced object or setting that was rejected.

/// An announced object or setting that is not in the scene as announced.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct SceneGap {
    /// The part of the scene.
    pub subject: GapSubject,
    /// Name of the object or link; empty for an object without a name, an octomap and a matrix.
    pub name: String,
    /// The extent of the difference.
    pub extent: GapExtent,
}

/// The part of a scene that a gap is in.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum GapSubject {
    /// An obstacle of the world.
    Object,
    /// An object that was to be attached to a link, or to be detached.
    Attached,
    /// The octomap.
    Octomap,
    /// The allowed collision matrix.
    Matrix,
    /// The padding of a link.
    LinkPadding,
    /// The scale factor of a link.
    LinkScale,
}

/// Extent of the difference from the announced content.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum GapExtent {
    /// Its shapes are in the scene, but its pose or its link is not as announced.
    Pose,
    /// It is in the scene with its shapes, but still attached to a link that was to release it.
    Held,
    /// Shapes may be missing.
    Shapes,
}

impl SceneGap {
    /// A gap in a part of the scene.
    #[must_use]
    pub fn new(subject: GapSubject, name: impl Into<String>, extent: GapExtent) -> Self {
        Self { subject, name: name.into(), extent }
    }
}
