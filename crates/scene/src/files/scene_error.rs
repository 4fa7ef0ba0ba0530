//! Error in a scene file: message, name of the file and of the object.

use clearance_robot::check_name_length;

/// An error in a scene file, with the object and field concerned.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SceneError {
    /// Name of the file.
    pub file: String,
    /// Id of the object, if the error is about one.
    pub object: Option<String>,
    /// The field and its error.
    pub message: String,
}

impl std::fmt::Display for SceneError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match &self.object {
            Some(id) => write!(f, "{}: object '{id}': {}", self.file, self.message),
            None => write!(f, "{}: {}", self.file, self.message),
        }
    }
}

impl std::error::Error for SceneError {}

/// The start of a name that is too long.
fn shortened(name: &str) -> String {
    name.chars().take(40).chain(['…']).collect()
}

impl SceneError {
    pub(super) fn of_file(file: &str, message: impl Into<String>) -> Self {
        Self { file: file.to_owned(), object: None, message: message.into() }
    }

    pub(super) fn of_object(file: &str, object: &str, message: impl Into<String>) -> Self {
        let object = check_name_length(object).map_or_else(|_| shortened(object), |()| object.to_owned());
        Self { object: Some(object), ..Self::of_file(file, message) }
    }
}
