//! Error of a rejected scene update, with the gap that it leaves in the scene.

use clearance_robot::quoted;

use super::{GapExtent, GapSubject, SceneGap};

/// An error in a message about the world, with the object and field concerned. The rejected part changes nothing.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SceneRejection {
    /// The object's id, if the message is about one.
    pub object: Option<String>,
    /// Error text; starts with the name of the field, if a field is wrong.
    pub message: String,
    /// The gap that it leaves in the scene; `None` if the scene is still on the safe side.
    pub gap: Option<SceneGap>,
}

impl SceneRejection {
    /// A rejection that leaves no gap.
    #[must_use]
    pub fn new(message: impl Into<String>) -> Self {
        Self { object: None, message: message.into(), gap: None }
    }

    /// Rejection of an object, whose shapes are then missing.
    #[must_use]
    pub fn of(object: &str, message: impl Into<String>) -> Self {
        let gap = SceneGap::new(GapSubject::Object, object, GapExtent::Shapes);
        Self { object: Some(object.to_owned()), message: message.into(), gap: Some(gap) }
    }

    /// Rejection of an octomap, whose cells are then missing.
    #[must_use]
    pub fn of_octomap(message: impl Into<String>) -> Self {
        Self::of(super::OCTOMAP, message).leaving(SceneGap::new(GapSubject::Octomap, "", GapExtent::Shapes))
    }

    /// The same rejection with the given gap.
    #[must_use]
    pub(crate) fn leaving(self, gap: SceneGap) -> Self {
        Self { gap: Some(gap), ..self }
    }

    /// The same rejection without a gap, where the scene is still on the safe side: for example, an object to be removed does not exist.
    #[must_use]
    pub(super) fn without_gap(self) -> Self {
        Self { gap: None, ..self }
    }

    /// The same rejection for an object that is in the scene, but at another pose.
    #[must_use]
    pub fn of_pose(self) -> Self {
        Self { gap: self.gap.map(|gap| SceneGap { extent: GapExtent::Pose, ..gap }), ..self }
    }

    /// The same rejection for an object that was to be attached or detached.
    #[must_use]
    pub fn of_attached(self) -> Self {
        Self { gap: self.gap.map(|gap| SceneGap { subject: GapSubject::Attached, ..gap }), ..self }
    }
}

impl std::fmt::Display for SceneRejection {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match &self.object {
            Some(id) => write!(f, "object {}: {}", quoted(id), self.message),
            None => f.write_str(&self.message),
        }
    }
}

impl std::error::Error for SceneRejection {}
