//! The bodies of a checker: links and obstacles with geometry, where they ride, and the pairs of them.

use std::collections::HashMap;
use std::sync::Arc;

use rayon::prelude::*;

use super::capsule_fit::fit_capsule;
use super::capsules::{CapsulePairs, LinkCapsule};
use super::pair::PairInfo;
use super::report::Body;
use super::settings::{MeshModel, Settings};
use super::{PairList, SettingsError};
use crate::geometry::{Primitive, Shape};
use crate::math::{MatrixPose, Point, Pose};
use crate::query::CollisionBody;
use crate::robot::{Between, Chain, Frame, RobotModel, TravelRates};
use crate::world::{ObstacleId, World};

/// A link or an obstacle, in the frame of the body of the chain that it rides on.
#[derive(Clone, Debug)]
pub(super) struct Rider {
    /// The body of the chain; 0 is the root's.
    pub body: usize,
    pub solid: Arc<CollisionBody>,
    pub capsule: LinkCapsule,
}

/// A shape at its pose.
type Placed<'s> = (Pose, &'s Shape);

/// Every link and obstacle with geometry, by name of body: links first.
pub(super) fn riders(
    robot: &RobotModel,
    world: &World,
    chain: &Chain,
    mesh_model: MeshModel,
) -> Vec<Option<Rider>> {
    let links = (robot.links().iter().enumerate()).map(|(i, link)| {
        let seat = chain.seat(i)?;
        let place = pose(&seat.place);
        let shapes = link.collisions.iter().map(|c| (place * c.pose_ls, &c.shape)).collect();
        Some((seat.body, shapes))
    });
    let obstacles = (0..).map(ObstacleId).take(world.place_count());
    let obstacles = obstacles.map(|id| Some((0, world.place(id)?.placed_shapes().collect())));
    let all: Vec<Option<(usize, Vec<Placed>)>> = links.chain(obstacles).collect();
    (all.into_par_iter())
        .map(|rider| rider.and_then(|(body, shapes)| Rider::new(body, &shapes, mesh_model)))
        .collect()
}

impl Rider {
    fn new(body: usize, shapes: &[Placed], mesh_model: MeshModel) -> Option<Self> {
        let placed = || shapes.iter().map(|(pose, shape)| (pose, *shape));
        let solid = match mesh_model {
            MeshModel::Surface => CollisionBody::new(placed()),
            MeshModel::Solid => CollisionBody::with_solid_meshes(placed()),
        }?;
        Some(Self { body, solid: Arc::new(solid), capsule: capsule(shapes)? })
    }
}

/// A capsule around shapes; a single round one is its own.
fn capsule(shapes: &[Placed]) -> Option<LinkCapsule> {
    if let [(pose, Shape::Primitive(primitive))] = shapes {
        match *primitive {
            Primitive::Sphere { radius } => return Some(around_axis(pose, 0.0, radius)),
            Primitive::Capsule { radius, half_length } => {
                return Some(around_axis(pose, half_length, radius));
            }
            _ => {}
        }
    }
    let mut points = Vec::new();
    for (pose, shape) in shapes {
        match shape {
            Shape::Mesh(mesh) => {
                points.extend(mesh.triangles().iter().flatten().map(|&v| pose * mesh.vertices()[v as usize]));
            }
            Shape::Plane(_) | Shape::Points(_) | Shape::Voxels(_) => todo!("planes, points, cubes"),
            Shape::Primitive(primitive) => points.extend(primitive.hull_points().map(|p| pose * p)),
        }
    }
    points.sort_by(|p, q| p.iter().map(|c| c.to_bits()).cmp(q.iter().map(|c| c.to_bits())));
    points.dedup();
    fit_capsule(&points)
}

fn around_axis(pose: &Pose, half_length: f64, radius: f64) -> LinkCapsule {
    let end = |z: f64| pose * Point::new(0.0, 0.0, z);
    let rounding = 8.0 * f64::EPSILON * (pose.translation.vector.amax() + half_length + radius);
    LinkCapsule { a: end(-half_length), b: end(half_length), radius: radius + rounding }
}

/// Capsules of the bodies that occur in pairs, and the pairs of them.
pub(super) fn capsule_pairs(riders: &[Option<Rider>], infos: &[PairInfo]) -> CapsulePairs {
    let mut numbers = vec![usize::MAX; riders.len()];
    let mut capsules = Vec::new();
    for (i, rider) in riders.iter().enumerate() {
        if let Some(rider) = rider {
            numbers[i] = capsules.len();
            capsules.push((rider.body, rider.capsule));
        }
    }
    let pairs: Vec<_> = infos.iter().map(|p| (numbers[p.bodies.0], numbers[p.bodies.1])).collect();
    CapsulePairs::new(&capsules, &pairs)
}

/// How far bodies may move when joints do, relative to each other and to the world.
pub(super) fn travel_rates(robot: &RobotModel, chain: &Chain, riders: &[Option<Rider>]) -> TravelRates {
    let mut reach = vec![0.0_f64; chain.body_count()];
    for Rider { body, capsule, .. } in riders.iter().flatten() {
        let ends = [capsule.a, capsule.b].map(|p| p.coords.norm());
        reach[*body] = reach[*body].max(ends[0].max(ends[1]) + capsule.radius);
    }
    let limited = robot.joint_ids().filter_map(|j| {
        let limits = robot.joint(j).limits?;
        Some((robot.first_position(j)?, [limits.lower, limits.upper]))
    });
    let ranges: HashMap<usize, [f64; 2]> = limited.collect();
    chain.travel_rates(&reach, |index| ranges.get(&index).copied())
}

/// By pair: the joints between its bodies.
pub(super) fn joints_between(chain: &Chain, riders: &[Option<Rider>], infos: &[PairInfo]) -> Vec<Between> {
    let body = |i: usize| riders[i].as_ref().map_or(0, |rider| rider.body);
    infos.iter().map(|info| chain.between(body(info.bodies.0), body(info.bodies.1))).collect()
}

/// The pairs of a list, by index of rider.
pub(super) fn pair_infos(
    pairs: &PairList,
    links: usize,
    padding: &[f64],
    settings: &Settings,
) -> Vec<PairInfo> {
    let between_links = pairs.self_pairs().iter().map(|&(a, b)| PairInfo {
        ids: (Body::Link(a), Body::Link(b)),
        bodies: (a.index(), b.index()),
        padding: if settings.pad_self { padding[a.index()] + padding[b.index()] } else { 0.0 },
    });
    let with_world = pairs.world_pairs().iter().map(|&(link, obstacle)| PairInfo {
        ids: (Body::Link(link), Body::Obstacle(obstacle)),
        bodies: (link.index(), links + obstacle.0 as usize),
        padding: padding[link.index()],
    });
    between_links.chain(with_world).collect()
}

/// The padding (m) of every link.
pub(super) fn link_padding(robot: &RobotModel, settings: &Settings) -> Result<Vec<f64>, SettingsError> {
    let usable = |of: &str, value: f64| {
        if value.is_finite() && value >= 0.0 {
            Ok(value)
        } else {
            Err(SettingsError::BadPadding { of: of.to_owned(), value })
        }
    };
    let default = usable("", settings.padding)?;
    let mut padding = vec![default; robot.links().len()];
    for (name, &value) in &settings.link_padding {
        let link = (robot.link_by_name(name)).ok_or_else(|| SettingsError::UnknownLink(name.clone()))?;
        padding[link.index()] = usable(&format!(" of link '{name}'"), value)?;
    }
    Ok(padding)
}

fn pose(frame: &Frame<f64>) -> Pose {
    Pose::from(&MatrixPose::from(frame))
}
