//! Link or attached object with collision geometry.

use std::collections::HashMap;
use std::sync::Arc;

use clearance_geometry::constants::MOTION_SLACK;
use clearance_geometry::math::{Extremes, MatrixPose, Pose};
use clearance_geometry::{ScaleError, Shape};
use clearance_proximity::{CollisionBody, SolidBody};
use clearance_robot::{Chain, Frame, LinkId, LinkInBody, Reach, RobotModel};
use clearance_scene::{AttachedObject, BodyId, ObstacleShape, PairList, Settings, World};
use rayon::prelude::*;

use super::geometry_settings::{
    check_volumes, checked_scale, link_padding, link_scale, object_padding, object_scale,
};
use super::scaled_body::{BodyBuild, LazySolidBody, ScaledBody};
use crate::capsules::{LinkCapsule, RootCapsule};
use crate::settings_error::SettingsError;

/// A link or an attached object with geometry, in the frame of the chain body that carries it.
#[derive(Clone, Debug)]
pub struct RobotBody {
    id: BodyId,
    link: LinkId,
    padding: f64,
    solid: Arc<CollisionBody>,
    capsule: LinkCapsule,
    solids: Arc<LazySolidBody>,
    built_from: BuiltFrom,
}

/// Inputs that a robot body was built from; equal inputs give equal bodies.
#[derive(Clone, Debug)]
struct BuiltFrom {
    link_in_body: LinkInBody,
    build: BodyBuild,
    attached: Option<(Pose, Arc<[ObstacleShape]>)>,
}

impl BuiltFrom {
    fn is_same(&self, other: &Self) -> bool {
        let same_object = match (&self.attached, &other.attached) {
            (None, None) => true,
            (Some((pose, shapes)), Some((other_pose, others))) => {
                pose == other_pose && Arc::ptr_eq(shapes, others)
            }
            _ => false,
        };
        same_object && self.link_in_body == other.link_in_body && self.build == other.build
    }
}

/// The robot bodies of a list of pairs, in its order. Bodies in `known`, from the same robot, are reused.
pub fn robot_bodies(
    robot: &RobotModel,
    chain: &Chain,
    scene: SceneOfRobot,
    known: &[RobotBody],
) -> Result<Vec<RobotBody>, SettingsError> {
    let SceneOfRobot { world, pairs, settings } = scene;
    let padding = link_padding(robot, settings)?;
    check_volumes(robot, &settings.volumes)?;
    let bodies: Vec<BodyId> = pairs.parts().collect();
    let known: HashMap<BodyId, &RobotBody> =
        known.iter().map(|robot_body| (robot_body.id, robot_body)).collect();
    (bodies.into_par_iter())
        .map(|id| {
            let object = match id {
                BodyId::Attached(id) => Some(world.attached_object(id).as_ref()),
                _ => None,
            };
            let link = carrier(robot, id, object)?;
            let link_in_body = *chain.seat(link.index()).expect("links that carry geometry have seats");
            let name = object.map_or(&robot.link(link).name, |object| &object.name);
            // as in MoveIt: an attached object is scaled with its link
            let of_link = link_scale(settings, &robot.link(link).name);
            let of_object = object.map_or(Ok(1.0), |object| object_scale(settings, &object.name))?;
            let built_from = BuiltFrom {
                link_in_body,
                build: BodyBuild::new(
                    checked_scale(name, of_link * of_object)?,
                    settings.mesh_model,
                    &settings.volumes,
                    Some(&robot.link(link).name),
                ),
                attached: object.map(|object| (object.pose_lo, Arc::clone(&object.shapes))),
            };
            let padding =
                padding[link.index()] + object.map_or(Ok(0.0), |o| object_padding(settings, &o.name))?;
            if let Some(same) = known.get(&id).filter(|known| known.built_from.is_same(&built_from)) {
                return Ok(RobotBody { padding, ..(*same).clone() });
            }
            let shapes = placed_shapes(robot, link, object, &built_from.link_in_body);
            RobotBody::new(id, link, &shapes, padding, built_from)
                .map_err(|why| SettingsError::CannotScale { of: name.clone(), why })
        })
        .collect()
}

/// The scene that a robot is checked in.
#[derive(Clone, Copy, Debug)]
pub struct SceneOfRobot<'s> {
    pub world: &'s World,
    pub pairs: &'s PairList,
    pub settings: &'s Settings,
}

fn carrier(robot: &RobotModel, id: BodyId, object: Option<&AttachedObject>) -> Result<LinkId, SettingsError> {
    match (id, object) {
        (BodyId::Link(link), _) => Ok(link),
        (_, Some(object)) => robot.link_by_name(&object.link).ok_or_else(|| SettingsError::NoCarrier {
            object: object.name.clone(),
            link: object.link.clone(),
        }),
        _ => unreachable!("an obstacle is no part of a robot"),
    }
}

/// The shapes of a link, or of an object attached to it, with their poses in the chain body.
fn placed_shapes<'s>(
    robot: &'s RobotModel,
    link: LinkId,
    object: Option<&'s AttachedObject>,
    link_in_body: &LinkInBody,
) -> Vec<(Pose, &'s Shape)> {
    let pose_bl = pose_of(&link_in_body.place);
    match object {
        Some(object) => {
            object.shapes.iter().map(|s| (pose_bl * object.pose_lo * s.pose_os, &s.shape)).collect()
        }
        None => robot.link(link).collisions.iter().map(|c| (pose_bl * c.pose_ls, &c.shape)).collect(),
    }
}

impl RobotBody {
    fn new(
        id: BodyId,
        link: LinkId,
        shapes: &[(Pose, &Shape)],
        padding: f64,
        built_from: BuiltFrom,
    ) -> Result<Self, ScaleError> {
        let ScaledBody { body, capsule, solids } = ScaledBody::new(shapes, &built_from.build)?;
        Ok(Self { id, link, padding, solid: body, capsule, solids, built_from })
    }

    #[inline]
    pub fn id(&self) -> BodyId {
        self.id
    }

    /// Index of the chain body that carries it; 0 is the root.
    #[inline]
    pub fn chain_body(&self) -> usize {
        self.built_from.link_in_body.body
    }

    /// The link itself, or the link that carries the attached object.
    #[inline]
    pub fn link(&self) -> LinkId {
        self.link
    }

    /// Safety distance (m).
    #[inline]
    pub fn padding(&self) -> f64 {
        self.padding
    }

    #[inline]
    pub fn solid(&self) -> &CollisionBody {
        &self.solid
    }

    /// Its shapes for queries of penetration depth.
    pub fn solids(&self) -> &SolidBody {
        self.solids.get()
    }

    /// Capsule around its shapes, in the frame of the chain body, without padding.
    #[inline]
    pub fn capsule(&self) -> &LinkCapsule {
        &self.capsule
    }

    /// Pose of its link in the frame of the chain body.
    pub fn pose_bl(&self) -> Pose {
        pose_of(&self.built_from.link_in_body.place)
    }

    /// Its capsule in the root frame, without padding.
    #[inline]
    pub fn reach_at(&self, pose: &MatrixPose) -> Reach {
        self.capsule.reach_at(pose)
    }

    /// As [`Self::reach_at`], for the frame of its chain body.
    #[inline]
    pub fn reach_in(&self, frame: &Frame<f64>) -> Reach {
        self.reach_at(&MatrixPose::from(frame))
    }

    /// Its capsule in the root frame, grown by its padding, for the frame of its chain body.
    #[inline]
    pub fn padded_capsule(&self, frame: &Frame<f64>) -> RootCapsule {
        RootCapsule::of_reach(&self.reach_in(frame), self.padding)
    }

    /// Radius (m) of its capsule with its padding.
    pub fn padded_radius(&self) -> f64 {
        self.capsule.radius + self.padding
    }

    /// Distance (m) from the origin of its chain body to the farther end of its capsule's segment.
    pub fn farther_end(&self) -> f64 {
        let ends = [self.capsule.a, self.capsule.b].map(|p| p.coords.norm());
        ends[0].greater(ends[1])
    }

    /// Radius (m) around the origin of its chain body that contains it.
    pub fn radius_around_origin(&self) -> f64 {
        (self.farther_end() + self.capsule.radius) * (1.0 + MOTION_SLACK) + MOTION_SLACK
    }
}

fn pose_of(frame: &Frame<f64>) -> Pose {
    Pose::from(&MatrixPose::from(frame))
}
