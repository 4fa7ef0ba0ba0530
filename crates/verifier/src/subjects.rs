//! Subject of a verification: the bodies, and the pairs of them that must stay apart, with their paddings.

use clearance_geometry::Shape;
use clearance_geometry::math::Pose;
use clearance_robot::{LinkId, RobotModel};
use clearance_scene::AllowedCollisionMatrix;
use clearance_scene::{BodyId, MeshModel, PairList, Settings};
use clearance_scene::{ObstacleId, World};

use super::Refusal;
use super::body::Body;

/// A pair of bodies that must stay apart.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Pair {
    /// Links by index, then attached objects, then obstacles by their places.
    pub bodies: [usize; 2],
    pub names: [String; 2],
    /// Safety distance (m).
    pub padding: f64,
}

/// All pairs that have to be checked, in the order of the pair list.
pub(super) fn pairs(
    robot: &RobotModel,
    world: &World,
    settings: &Settings,
    matrix: Option<&AllowedCollisionMatrix>,
) -> Result<Vec<Pair>, Refusal> {
    let padding = paddings(robot, world, settings)?;
    let list = PairList::new(robot, world, matrix);
    let links = robot.links().len();
    let numbered = |body: BodyId| match body {
        BodyId::Link(id) => (id.index(), robot.link(id).name.clone()),
        BodyId::Attached(id) => (links + id.0 as usize, world.attached_object(id).name.clone()),
        BodyId::Obstacle(id) => {
            (links + world.attached().len() + id.0 as usize, world.obstacle(id).name.clone())
        }
    };
    let pair = |a: BodyId, b: BodyId, counts: bool| {
        let [(i, first), (j, second)] = [a, b].map(numbered);
        let padding = if counts { padding[i] + padding[j] } else { 0.0 };
        Pair { bodies: [i, j], names: [first, second], padding }
    };
    let mut pairs = Vec::new();
    if settings.check_self {
        pairs.extend(list.self_pairs().iter().map(|(a, b)| pair(*a, *b, settings.pad_self)));
    }
    if settings.check_world {
        pairs.extend(list.world_pairs().map(|(a, o)| pair(a, BodyId::Obstacle(o), true)));
    }
    Ok(pairs)
}

/// By link and attached object: the link that carries it.
pub(super) fn carriers(robot: &RobotModel, world: &World) -> Result<Vec<LinkId>, Refusal> {
    let attached = world.attached().iter().map(|object| {
        robot.link_by_name(&object.link).ok_or_else(|| Refusal::UnknownLink(object.link.clone()))
    });
    robot.link_ids().map(Ok).chain(attached).collect()
}

/// By body.
fn paddings(robot: &RobotModel, world: &World, settings: &Settings) -> Result<Vec<f64>, Refusal> {
    for name in settings.link_padding.keys().chain(settings.link_scale.keys()) {
        robot.link_by_name(name).ok_or_else(|| Refusal::UnknownLink(name.clone()))?;
    }
    let usable = |name: &str, value: f64| {
        let usable = value.is_finite() && value >= 0.0;
        usable.then_some(value).ok_or_else(|| Refusal::BadPadding { of: name.to_owned(), value })
    };
    let of_link =
        |name: &str| usable(name, settings.link_padding.get(name).copied().unwrap_or(settings.padding));
    let of_object = |name: &str| usable(name, settings.object_padding.get(name).copied().unwrap_or(0.0));
    let links = robot.links().iter().map(|link| of_link(&link.name));
    let attached =
        world.attached().iter().map(|object| Ok(of_link(&object.link)? + of_object(&object.name)?));
    let obstacles = (0..).map(ObstacleId).take(world.place_count());
    let obstacles = obstacles.map(|id| world.place(id).map_or(Ok(0.0), |obstacle| of_object(&obstacle.name)));
    links.chain(attached).chain(obstacles).collect()
}

/// Links, then attached objects, then obstacles, with their scale factors applied; `None` for bodies without shapes and bodies that no
/// pair names.
pub(super) fn bodies(
    robot: &RobotModel,
    world: &World,
    settings: &Settings,
    pairs: &[Pair],
) -> Result<Vec<Option<Body>>, Refusal> {
    let solid = settings.mesh_model == MeshModel::Solid;
    let scale_of_link = |name: &str| settings.link_scale.get(name).copied().unwrap_or(1.0);
    let scale_of_object = |name: &str| settings.object_scale.get(name).copied().unwrap_or(1.0);
    let links = robot.links().iter().map(|link| {
        let shapes = link.collisions.iter().map(|c| (c.pose_ls, &c.shape));
        (link.name.as_str(), scale_of_link(&link.name), shapes.collect::<Vec<(Pose, _)>>())
    });
    let attached = world.attached().iter().map(|object| {
        let shapes = object.shapes.iter().map(|s| (object.pose_lo * s.pose_os, &s.shape));
        let scale = scale_of_link(&object.link) * scale_of_object(&object.name);
        (object.name.as_str(), scale, shapes.collect())
    });
    let obstacles = (0..).map(ObstacleId).take(world.place_count()).map(|id| match world.place(id) {
        Some(obstacle) => {
            let name = obstacle.name.as_str();
            (name, scale_of_object(name), obstacle.placed_shapes().collect())
        }
        None => ("", 1.0, Vec::new()),
    });
    let mut named = vec![false; robot.links().len() + world.attached().len() + world.place_count()];
    for index in pairs.iter().flat_map(|pair| pair.bodies) {
        named[index] = true;
    }
    (links.chain(attached).chain(obstacles).zip(named))
        .map(|((name, scale, shapes), named)| {
            (named && !shapes.is_empty()).then(|| body(name, scale, &shapes, solid)).transpose()
        })
        .collect()
}

/// The body of shapes scaled by a factor.
fn body(name: &str, scale: f64, shapes: &[(Pose, &Shape)], solid: bool) -> Result<Body, Refusal> {
    if scale == 1.0 {
        return Ok(Body::new(shapes, solid));
    }
    let scaled = shapes.iter().map(|(pose, shape)| Ok((*pose, shape.scaled(scale)?)));
    let scaled: Vec<(Pose, Shape)> =
        scaled.collect::<Result<_, _>>().map_err(|why| Refusal::CannotScale { of: name.to_owned(), why })?;
    Ok(Body::new(&scaled.iter().map(|(pose, shape)| (*pose, shape)).collect::<Vec<_>>(), solid))
}
