//! Collision bodies of a robot: links and attached objects, the chain bodies that carry them, and the pairs of them.

use std::collections::HashMap;
use std::sync::Arc;

use clearance_geometry::math::{Extremes, MatrixPose, Pose};
use clearance_geometry::{ScaleError, Shape};
use clearance_proximity::CollisionBody;
use clearance_robot::{Chain, DisplacementRates, Frame, LinkId, LinkInBody, PathsToRoot, RobotModel};
use clearance_scene::{AttachedObject, ObstacleShape, World};
use rayon::prelude::*;

use super::SettingsError;
use super::capsule_fit::capsule_around;
use super::capsules::{CapsulePairs, LinkCapsule};
use super::pair::PairInfo;
use clearance_scene::BodyId;
use clearance_scene::PairList;
use clearance_scene::{MeshModel, Settings};

/// A link or an attached object with geometry, in the frame of the chain body that carries it.
#[derive(Clone, Debug)]
pub(super) struct RobotBody {
    pub id: BodyId,
    /// Index of the chain body; 0 is the root's.
    pub body: usize,
    /// The link that carries the attached object, or the link itself.
    pub link: LinkId,
    /// Safety distance (m).
    pub padding: f64,
    pub solid: Arc<CollisionBody>,
    pub capsule: LinkCapsule,
    made_of: MadeOf,
}

/// Inputs that a robot body was built from; equal inputs give equal bodies.
#[derive(Clone, Debug)]
struct MadeOf {
    seat: LinkInBody,
    mesh_model: MeshModel,
    scale: f64,
    attached: Option<(Pose, Arc<[ObstacleShape]>)>,
}

impl MadeOf {
    fn is_same(&self, other: &Self) -> bool {
        let same_object = match (&self.attached, &other.attached) {
            (None, None) => true,
            (Some((pose, shapes)), Some((other_pose, others))) => {
                pose == other_pose && Arc::ptr_eq(shapes, others)
            }
            _ => false,
        };
        same_object
            && self.seat == other.seat
            && self.mesh_model == other.mesh_model
            && self.scale.to_bits() == other.scale.to_bits()
    }
}

/// The kinematic chain of a robot that carries its attached objects.
pub(super) fn chain(robot: &RobotModel, world: &World) -> Chain {
    let mut has_geometry: Vec<bool> = robot.links().iter().map(|l| !l.collisions.is_empty()).collect();
    for object in world.attached() {
        if let Some(link) = robot.link_by_name(&object.link) {
            has_geometry[link.index()] = true;
        }
    }
    robot.chain(&has_geometry)
}

/// The robot bodies of a list of pairs, in its order. Bodies in `known`, from the same robot, are reused.
pub(super) fn robot_bodies(
    robot: &RobotModel,
    world: &World,
    (chain, pairs): (&Chain, &PairList),
    settings: &Settings,
    known: &[RobotBody],
) -> Result<Vec<RobotBody>, SettingsError> {
    let padding = link_padding(robot, settings)?;
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
            let seat = *chain.seat(link.index()).expect("links that carry geometry have seats");
            let name = object.map_or(&robot.link(link).name, |object| &object.name);
            // as in MoveIt: an attached object is scaled with its link
            let of_link = settings.link_scale.get(&robot.link(link).name).copied().unwrap_or(1.0);
            let of_object = object.map_or(Ok(1.0), |object| object_scale(settings, &object.name))?;
            let made_of = MadeOf {
                seat,
                mesh_model: settings.mesh_model,
                scale: usable_scale(name, of_link * of_object)?,
                attached: object.map(|object| (object.pose_lo, Arc::clone(&object.shapes))),
            };
            let padding =
                padding[link.index()] + object.map_or(Ok(0.0), |o| object_padding(settings, &o.name))?;
            if let Some(same) = known.get(&id).filter(|known| known.made_of.is_same(&made_of)) {
                return Ok(RobotBody { padding, ..(*same).clone() });
            }
            RobotBody::new(robot, (id, link), object, padding, made_of)
                .map_err(|why| SettingsError::CannotScale { of: name.clone(), why })
        })
        .collect()
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

impl RobotBody {
    fn new(
        robot: &RobotModel,
        (id, link): (BodyId, LinkId),
        object: Option<&AttachedObject>,
        padding: f64,
        made_of: MadeOf,
    ) -> Result<Self, ScaleError> {
        let place = pose(&made_of.seat.place);
        let shapes: Vec<(Pose, &Shape)> = match object {
            Some(object) => {
                object.shapes.iter().map(|s| (place * object.pose_lo * s.pose_os, &s.shape)).collect()
            }
            None => robot.link(link).collisions.iter().map(|c| (place * c.pose_ls, &c.shape)).collect(),
        };
        let (solid, capsule) = solid(&shapes, made_of.scale, made_of.mesh_model)?;
        Ok(Self { id, body: made_of.seat.body, link, padding, solid, capsule, made_of })
    }

    /// Pose of its link in the frame of the chain body.
    pub fn seat(&self) -> &LinkInBody {
        &self.made_of.seat
    }
}

/// The collision body of some shapes, each scaled by a factor, and a capsule around it.
///
/// # Panics
/// When there are no shapes.
pub(super) fn solid(
    shapes: &[(Pose, &Shape)],
    scale: f64,
    mesh_model: MeshModel,
) -> Result<(Arc<CollisionBody>, LinkCapsule), ScaleError> {
    let scaled = |shape: &Shape| if scale == 1.0 { Ok(shape.clone()) } else { shape.scaled(scale) };
    let shapes = shapes.iter().map(|(pose, shape)| Ok((*pose, scaled(shape)?)));
    let shapes: Vec<(Pose, Shape)> = shapes.collect::<Result<_, ScaleError>>()?;
    let placed = || shapes.iter().map(|(pose, shape)| (pose, shape));
    let solid = match mesh_model {
        MeshModel::Surface => CollisionBody::new(placed()),
        MeshModel::Solid => CollisionBody::with_solid_meshes(placed()),
    };
    let solid = solid.expect("there are shapes");
    Ok((Arc::new(solid), capsule_around(&shapes).expect("there are shapes")))
}

/// The pairs, by index of robot body.
pub(super) fn pair_infos(pairs: &PairList, robot_bodies: &[RobotBody], settings: &Settings) -> Vec<PairInfo> {
    let index: HashMap<BodyId, usize> =
        robot_bodies.iter().enumerate().map(|(i, robot_body)| (robot_body.id, i)).collect();
    let info = |&(a, b): &(BodyId, BodyId)| {
        let bodies = (index[&a], index[&b]);
        let padding = robot_bodies[bodies.0].padding + robot_bodies[bodies.1].padding;
        PairInfo { ids: (a, b), bodies, padding: if settings.pad_self { padding } else { 0.0 } }
    };
    pairs.self_pairs().iter().map(info).collect()
}

/// Capsules around the robot bodies, and the pairs of them.
pub(super) fn capsule_pairs(robot_bodies: &[RobotBody], infos: &[PairInfo]) -> CapsulePairs {
    let capsules: Vec<_> =
        robot_bodies.iter().map(|robot_body| (robot_body.body, robot_body.capsule)).collect();
    let pairs: Vec<_> = infos.iter().map(|p| p.bodies).collect();
    CapsulePairs::new(&capsules, &pairs)
}

/// Bounds on the motion of bodies when joints move, relative to each other and to the world.
pub(super) fn travel_rates(
    robot: &RobotModel,
    chain: &Chain,
    robot_bodies: &[RobotBody],
) -> DisplacementRates {
    let mut reach = vec![0.0_f64; chain.body_count()];
    for RobotBody { body, capsule, .. } in robot_bodies {
        let ends = [capsule.a, capsule.b].map(|p| p.coords.norm());
        reach[*body] = reach[*body].greater(ends[0].greater(ends[1]) + capsule.radius);
    }
    let limited = robot.joint_ids().filter_map(|j| {
        let limits = robot.joint(j).limits?;
        Some((robot.first_position(j)?, [limits.lower, limits.upper]))
    });
    let ranges: HashMap<usize, [f64; 2]> = limited.collect();
    chain.displacement_rates(&reach, |index| ranges.get(&index).copied())
}

/// By pair: the number of joints on either side of the lowest common ancestor of its bodies.
pub(super) fn joints_between(
    ways: &PathsToRoot,
    robot_bodies: &[RobotBody],
    infos: &[PairInfo],
) -> Vec<[u32; 2]> {
    let mut counts = Vec::with_capacity(infos.len());
    for of_one in infos.chunk_by(|a, b| a.bodies.0 == b.bodies.0) {
        let first = robot_bodies[of_one[0].bodies.0].body;
        let common = ways.common_depths(first);
        counts.extend(of_one.iter().map(|info| {
            let second = robot_bodies[info.bodies.1].body;
            [first, second].map(|body| {
                let joints = ways.depth(body) - common[second];
                u32::try_from(joints).expect("links are named by 32 bits")
            })
        }));
    }
    counts
}

/// The padding (m) of every link.
fn link_padding(robot: &RobotModel, settings: &Settings) -> Result<Vec<f64>, SettingsError> {
    let default = usable("", settings.padding)?;
    let mut padding = vec![default; robot.links().len()];
    let known =
        |name: &String| robot.link_by_name(name).ok_or_else(|| SettingsError::UnknownLink(name.clone()));
    for (name, &value) in &settings.link_padding {
        padding[known(name)?.index()] = usable(&format!(" of link '{name}'"), value)?;
    }
    for name in settings.link_scale.keys() {
        known(name)?;
    }
    Ok(padding)
}

/// The padding (m) of an object.
pub(super) fn object_padding(settings: &Settings, object: &str) -> Result<f64, SettingsError> {
    let value = settings.object_padding.get(object).copied().unwrap_or(0.0);
    usable(&format!(" of object '{object}'"), value)
}

/// The scale factor of an object's shapes.
pub(super) fn object_scale(settings: &Settings, object: &str) -> Result<f64, SettingsError> {
    usable_scale(object, settings.object_scale.get(object).copied().unwrap_or(1.0))
}

fn usable(of: &str, value: f64) -> Result<f64, SettingsError> {
    if value.is_finite() && value >= 0.0 {
        Ok(value)
    } else {
        Err(SettingsError::BadPadding { of: of.to_owned(), value })
    }
}

fn usable_scale(of: &str, value: f64) -> Result<f64, SettingsError> {
    if value.is_finite() && value > 0.0 && value <= 1e3 {
        Ok(value)
    } else {
        Err(SettingsError::BadScale { of: of.to_owned(), value })
    }
}

pub(super) fn pose(frame: &Frame<f64>) -> Pose {
    Pose::from(&MatrixPose::from(frame))
}
