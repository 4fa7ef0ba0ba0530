//! Pairs of names that may collide, or are checked although the SRDF allows them: validation, and allowed collision
//! matrix.

use clearance::robot::{LinkId, RobotModel};
use clearance::scene::{AllowedCollisionMatrix, AttachedObject, Scene, Settings};

/// Names of pairs of links and objects.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct PairSelection {
    /// Pairs that may collide.
    pub allowed: Vec<(String, String)>,
    /// Pairs that are checked. They override those that are allowed.
    pub checked: Vec<(String, String)>,
}

/// A name that cannot be used.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum NameError {
    /// Neither the robot nor the scene has it.
    #[error("{option}: there is no {kind} '{name}'")]
    Unknown {
        /// The option that contains it.
        option: &'static str,
        /// Kind of the missing body: `object`, or `link or object`.
        kind: &'static str,
        /// The name.
        name: String,
    },
    /// A pair that is to be checked cannot be.
    #[error("checked_collisions: '{a}' and '{b}' cannot be checked: {why}")]
    Unchecked {
        /// Name of the first body.
        a: String,
        /// Name of the second body.
        b: String,
        /// The reason.
        why: &'static str,
    },
    /// A pair that may collide is one body.
    #[error(
        "allowed_collisions: '{0}' is paired with itself, and a body is not checked against itself: name two"
    )]
    OneBody(String),
    /// An object has the name of a link.
    #[error("object '{0}': the robot has a link of this name; take another name")]
    OfLink(String),
}

/// Rejects objects with the name of a link: results and allowed collisions would not say which of both is meant.
///
/// # Errors
/// The first such object.
fn check_objects(robot: &RobotModel, scene: &Scene) -> Result<(), NameError> {
    let obstacles = scene.world.obstacles().map(|obstacle| &obstacle.name);
    let mut names = obstacles.chain(scene.world.attached().iter().map(|object| &object.name));
    let of_link = names.find(|name| robot.link_by_name(name).is_some());
    of_link.map_or(Ok(()), |name| Err(NameError::OfLink(name.clone())))
}

impl PairSelection {
    /// Checks that the robot or the scene has the links and objects that these pairs and the settings name, that pairs which are to be
    /// checked can be, and that no object has the name of a link.
    ///
    /// # Errors
    /// The first name or pair that cannot be used.
    pub fn check_names(
        &self,
        settings: &Settings,
        robot: &RobotModel,
        scene: &Scene,
    ) -> Result<(), NameError> {
        check_objects(robot, scene)?;
        for (option, pairs) in [("allowed_collisions", &self.allowed), ("checked_collisions", &self.checked)]
        {
            let mut names = pairs.iter().flat_map(|(a, b)| [a, b]);
            if let Some(name) = names.find(|name| !is_known(name, robot, scene)) {
                return Err(NameError::Unknown { option, kind: "link or object", name: name.clone() });
            }
        }
        if let Some((name, _)) = self.allowed.iter().find(|(a, b)| a == b) {
            return Err(NameError::OneBody(name.clone()));
        }
        let Settings { object_padding, object_scale, .. } = settings;
        for (option, values) in [("object_padding", object_padding), ("object_scale", object_scale)] {
            if let Some(name) = values.keys().find(|name| !is_object(name, scene)) {
                return Err(NameError::Unknown { option, kind: "object", name: name.clone() });
            }
        }
        for (a, b) in &self.checked {
            if let Some(why) = why_unchecked(a, b, settings, robot, scene) {
                return Err(NameError::Unchecked { a: a.clone(), b: b.clone(), why });
            }
        }
        Ok(())
    }

    /// Removes the pairs, and the paddings and scales of the settings, of objects that the scene does not have.
    pub fn remove_missing_objects(&mut self, settings: &mut Settings, robot: &RobotModel, scene: &Scene) {
        for pairs in [&mut self.allowed, &mut self.checked] {
            pairs.retain(|(a, b)| is_known(a, robot, scene) && is_known(b, robot, scene));
        }
        for values in [&mut settings.object_padding, &mut settings.object_scale] {
            values.retain(|name, _| is_object(name, scene));
        }
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

/// True if the scene has an obstacle or an attached object of this name.
fn is_object(name: &str, scene: &Scene) -> bool {
    scene.world.id(name).is_some() || scene.world.attached_by_name(name).is_some()
}

/// True if the robot has a link, or the scene an object of this name.
fn is_known(name: &str, robot: &RobotModel, scene: &Scene) -> bool {
    robot.link_by_name(name).is_some() || is_object(name, scene)
}

/// Why a pair of names cannot be checked, if it cannot be.
fn why_unchecked(
    a: &str,
    b: &str,
    settings: &Settings,
    robot: &RobotModel,
    scene: &Scene,
) -> Option<&'static str> {
    let links = [a, b].map(|name| robot.link_by_name(name));
    let is_obstacle = |name: &str| scene.world.id(name).is_some();
    let obstacles = [a, b].map(is_obstacle);
    let is_empty = |link: LinkId| robot.link(link).collisions.is_empty();
    let checks = if obstacles.contains(&true) { settings.check_world } else { settings.check_self };
    match links {
        _ if a == b => Some("they are one body"),
        _ if obstacles == [true; 2] => Some("both are obstacles"),
        _ if links.into_iter().flatten().any(is_empty) => Some("a link has no collision geometry"),
        [Some(a), Some(b)] if robot.same_rigid_body(a, b) => Some("fixed joints make them one rigid body"),
        _ if !checks => Some("check_self or check_world is off"),
        _ => why_attached_unchecked(a, b, robot, scene),
    }
}

/// Why a pair cannot be checked because of an attached object, if it cannot be.
fn why_attached_unchecked(a: &str, b: &str, robot: &RobotModel, scene: &Scene) -> Option<&'static str> {
    let attached = |name: &str| scene.world.attached_by_name(name);
    match (attached(a), attached(b)) {
        (Some(one), Some(other)) => (one.link == other.link).then_some("one link holds both objects"),
        (Some(object), None) => why_touching(object, b, robot),
        (None, Some(object)) => why_touching(object, a, robot),
        (None, None) => None,
    }
}

/// Why an attached object may touch the body `name`, if it may.
fn why_touching(object: &AttachedObject, name: &str, robot: &RobotModel) -> Option<&'static str> {
    // an obstacle with the name of a touch link is checked
    robot.link_by_name(name)?;
    let holds = object.link == name;
    let why = if holds { "the link holds the object" } else { "the link is a touch link of the object" };
    object.may_touch(name).then_some(why)
}
