//! Why a change of the world was not made.

use clearance_robot::quoted;

use super::{Extent, Gap, Subject};

/// A fault in a message about the world, with the object and field concerned. Nothing was changed.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SceneRejection {
    /// The object's id, if the message is about one.
    pub object: Option<String>,
    /// Begins with the field, where one is at fault.
    pub message: String,
    /// The gap that it leaves in the scene; `None` if the scene errs on the safe side.
    pub gap: Option<Gap>,
}

impl SceneRejection {
    /// Of something that leaves no gap.
    #[must_use]
    pub fn new(message: impl Into<String>) -> Self {
        Self { object: None, message: message.into(), gap: None }
    }

    /// Of an object whose shapes are missing.
    #[must_use]
    pub fn of(object: &str, message: impl Into<String>) -> Self {
        let gap = Gap::new(Subject::Object, object, Extent::Shapes);
        Self { object: Some(object.to_owned()), message: message.into(), gap: Some(gap) }
    }

    #[must_use]
    pub fn of_octomap(message: impl Into<String>) -> Self {
        Self::of(super::OCTOMAP, message).leaving(Gap::new(Subject::Octomap, "", Extent::Shapes))
    }

    /// The same with the gap that it leaves.
    #[must_use]
    pub fn leaving(self, gap: Gap) -> Self {
        Self { gap: Some(gap), ..self }
    }

    /// The same where the scene errs on the safe side, such as for something to be removed that is not there.
    #[must_use]
    pub(super) fn without_gap(self) -> Self {
        Self { gap: None, ..self }
    }

    /// The same where the object is in the scene, but elsewhere.
    #[must_use]
    pub fn of_pose(self) -> Self {
        Self { gap: self.gap.map(|gap| Gap { extent: Extent::Pose, ..gap }), ..self }
    }

    /// The same of an object that a link was to take up or let go.
    #[must_use]
    pub fn of_attached(self) -> Self {
        Self { gap: self.gap.map(|gap| Gap { subject: Subject::Attached, ..gap }), ..self }
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
