//! Pairs that are allowed to collide, or checked although the SRDF allows them.

use clearance::robot::RobotModel;
use clearance::scene::{AllowedCollisionMatrix, Scene, Settings};

/// Names of pairs of links and objects.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct PairSelection {
    /// Pairs that may collide.
    pub allowed: Vec<(String, String)>,
    /// Pairs that are checked. They override those that are allowed.
    pub checked: Vec<(String, String)>,
}

/// A name that neither the robot nor the scene has.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{option}: there is no {kind} '{name}'")]
pub struct UnknownName {
    /// The option that contains it.
    pub option: &'static str,
    kind: &'static str,
    /// The name.
    pub name: String,
}

impl PairSelection {
    /// Checks that the robot or the scene has the links and objects that these pairs and the settings name.
    ///
    /// # Errors
    /// The first name that does not exist.
    pub fn check_names(
        &self,
        settings: &Settings,
        robot: &RobotModel,
        scene: &Scene,
    ) -> Result<(), UnknownName> {
        let is_object =
            |name: &str| scene.world.id(name).is_some() || scene.world.attached_by_name(name).is_some();
        let is_known = |name: &str| robot.link_by_name(name).is_some() || is_object(name);
        for (option, pairs) in [("allowed_collisions", &self.allowed), ("checked_collisions", &self.checked)]
        {
            if let Some(name) = pairs.iter().flat_map(|(a, b)| [a, b]).find(|name| !is_known(name)) {
                return Err(UnknownName { option, kind: "link or object", name: name.clone() });
            }
        }
        let Settings { object_padding, object_scale, .. } = settings;
        for (option, values) in [("object_padding", object_padding), ("object_scale", object_scale)] {
            if let Some(name) = values.keys().find(|name| !is_object(name)) {
                return Err(UnknownName { option, kind: "object", name: name.clone() });
            }
        }
        Ok(())
    }

    /// The matrix that selects the pairs; none if the SRDF alone does.
    #[must_use]
    pub fn matrix(&self, robot: &RobotModel, scene: &Scene) -> Option<AllowedCollisionMatrix> {
        if self.allowed.is_empty() && self.checked.is_empty() {
            return scene.matrix.clone();
        }
        let mut matrix = scene.matrix.clone().unwrap_or_else(|| AllowedCollisionMatrix::of_robot(robot));
        for (pairs, allowed) in [(&self.allowed, true), (&self.checked, false)] {
            for (a, b) in pairs {
                matrix.set(a, b, allowed);
            }
        }
        Some(matrix)
    }
}
