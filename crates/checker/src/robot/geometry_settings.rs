//! Validates the settings of links and objects: paddings, scale factors and kinds of bounding volumes.

use clearance_robot::RobotModel;
use clearance_scene::{Settings, VolumeSelection};

use crate::settings_error::SettingsError;

/// The padding (m) of every link.
pub fn link_padding(robot: &RobotModel, settings: &Settings) -> Result<Vec<f64>, SettingsError> {
    let default = checked_padding("", settings.padding)?;
    let mut padding = vec![default; robot.links().len()];
    let known =
        |name: &String| robot.link_by_name(name).ok_or_else(|| SettingsError::UnknownLink(name.clone()));
    for (name, &value) in &settings.link_padding {
        padding[known(name)?.index()] = checked_padding(&format!(" of link '{name}'"), value)?;
    }
    for name in settings.link_scale.keys() {
        known(name)?;
    }
    Ok(padding)
}

/// Rejects kinds of volumes of links that the robot does not have.
pub fn check_volumes(robot: &RobotModel, volumes: &VolumeSelection) -> Result<(), SettingsError> {
    let Some(link) = volumes.links.keys().find(|name| robot.link_by_name(name).is_none()) else {
        return Ok(());
    };
    let known = robot.links().iter().filter(|link| !link.collisions.is_empty());
    let known = known.map(|link| link.name.as_str()).collect::<Vec<_>>().join(", ");
    Err(SettingsError::UnknownVolumeLink { link: link.clone(), known })
}

/// The padding (m) of an object.
pub fn object_padding(settings: &Settings, object: &str) -> Result<f64, SettingsError> {
    let value = settings.object_padding.get(object).copied().unwrap_or(0.0);
    checked_padding(&format!(" of object '{object}'"), value)
}

/// The scale factor of a link's shapes, and of the objects attached to it.
pub fn link_scale(settings: &Settings, link: &str) -> f64 {
    settings.link_scale.get(link).copied().unwrap_or(1.0)
}

/// The scale factor of an object's shapes.
pub fn object_scale(settings: &Settings, object: &str) -> Result<f64, SettingsError> {
    checked_scale(object, settings.object_scale.get(object).copied().unwrap_or(1.0))
}

/// A padding (m), unless it is invalid.
fn checked_padding(of: &str, value: f64) -> Result<f64, SettingsError> {
    if value.is_finite() && value >= 0.0 {
        Ok(value)
    } else {
        Err(SettingsError::BadPadding { of: of.to_owned(), value })
    }
}

/// A scale factor, unless it is invalid.
pub fn checked_scale(of: &str, value: f64) -> Result<f64, SettingsError> {
    if value.is_finite() && value > 0.0 && value <= 1e3 {
        Ok(value)
    } else {
        Err(SettingsError::BadScale { of: of.to_owned(), value })
    }
}
