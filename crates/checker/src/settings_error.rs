//! Errors in the settings of a checker.

use clearance_geometry::ScaleError;

/// A setting that is invalid for this robot or this world.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SettingsError {
    /// A padding or a scale names a link that the robot does not have.
    #[error("padding or scale is given for link '{0}', which the robot has not")]
    UnknownLink(String),
    /// The volumes of a link are selected that the robot does not have.
    #[error("volumes: the robot has no link '{link}'; its links with collision geometry are {known}")]
    UnknownVolumeLink {
        /// Name of the unknown link.
        link: String,
        /// Names of the links that have geometry.
        known: String,
    },
    /// A padding is negative or not finite.
    #[error("padding{of} is {value:?}, but must be a finite number of metres, zero or more")]
    BadPadding {
        /// Empty for the default padding, or text such as ` of link 'arm'`.
        of: String,
        /// The rejected padding (m).
        value: f64,
    },
    /// A scale factor is out of range.
    #[error("the scale of '{of}' is {value:?}, but must be more than zero and at most 1000")]
    BadScale {
        /// Name of the link or object.
        of: String,
        /// The rejected factor.
        value: f64,
    },
    /// A shape cannot be scaled by the given factor.
    #[error("'{of}' can not be scaled: {why}")]
    CannotScale {
        /// Name of the link or object.
        of: String,
        /// The reason.
        why: ScaleError,
    },
    /// An object is attached to a link that the robot does not have.
    #[error("object '{object}' is attached to link '{link}', which the robot has not")]
    NoCarrier {
        /// Name of the attached object.
        object: String,
        /// Name of the unknown link.
        link: String,
    },
}
