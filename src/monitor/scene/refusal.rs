//! Why a change of the world was not made.

/// A fault in a message about the world, with the object and field concerned. Nothing was changed.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SceneRefusal {
    /// The object's id, if the message is about one.
    pub object: Option<String>,
    /// Begins with the field, where one is at fault.
    pub message: String,
    /// Whether something that was meant to be in the scene, or to be elsewhere in it, is not.
    pub leaves_out: bool,
}

impl SceneRefusal {
    #[must_use]
    pub fn new(message: impl Into<String>) -> Self {
        Self { object: None, message: message.into(), leaves_out: false }
    }

    #[must_use]
    pub fn of(object: &str, message: impl Into<String>) -> Self {
        Self { object: Some(object.to_owned()), message: message.into(), leaves_out: true }
    }

    /// The same of something that was to be taken away and is not there.
    #[must_use]
    pub(super) fn of_nothing(self) -> Self {
        Self { leaves_out: false, ..self }
    }
}

impl std::fmt::Display for SceneRefusal {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match &self.object {
            Some(id) => write!(f, "object {}: {}", crate::monitor::status::quoted(id), self.message),
            None => f.write_str(&self.message),
        }
    }
}

impl std::error::Error for SceneRefusal {}
