//! Warnings about unusual but usable input.

use clearance_files::readable_text::on_one_line;

use super::Place;

/// A warning about content of a URDF, SRDF or mesh that was accepted and should be checked by the user.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Warning {
    /// Location in the input.
    pub place: Place,
    /// Cause and effect.
    pub message: String,
}

impl std::fmt::Display for Warning {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&on_one_line(&format!("{}{}", self.place, self.message)))
    }
}
