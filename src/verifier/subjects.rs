//! What has to be proven: the bodies, and the pairs of them that must stay apart, with their paddings.

use super::Refusal;
use super::body::Body;
use crate::checker::{AllowedCollisionMatrix, MeshModel, PairList, Settings};
use crate::math::Pose;
use crate::robot::RobotModel;
use crate::world::{ObstacleId, World};

/// A pair of bodies that must stay apart.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Pair {
    /// Links by index, then obstacles.
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
    let padding = paddings(robot, settings)?;
    let list = PairList::new(robot, world, matrix);
    let link = |index: usize| robot.links()[index].name.clone();
    let mut pairs = Vec::new();
    if settings.check_self {
        pairs.extend(list.self_pairs().iter().map(|(a, b)| {
            let bodies = [a.index(), b.index()];
            let padding = if settings.pad_self { padding[bodies[0]] + padding[bodies[1]] } else { 0.0 };
            Pair { bodies, names: bodies.map(link), padding }
        }));
    }
    if settings.check_world {
        pairs.extend(list.world_pairs().iter().map(|(a, o)| Pair {
            bodies: [a.index(), robot.links().len() + o.0 as usize],
            names: [link(a.index()), world.obstacle(*o).name.clone()],
            padding: padding[a.index()],
        }));
    }
    Ok(pairs)
}

/// By link.
fn paddings(robot: &RobotModel, settings: &Settings) -> Result<Vec<f64>, Refusal> {
    for name in settings.link_padding.keys() {
        robot.link_by_name(name).ok_or_else(|| Refusal::UnknownLink(name.clone()))?;
    }
    let padding = |name: &String| {
        let value = settings.link_padding.get(name).copied().unwrap_or(settings.padding);
        let usable = value.is_finite() && value >= 0.0;
        usable.then_some(value).ok_or_else(|| Refusal::BadPadding { of: name.clone(), value })
    };
    robot.links().iter().map(|link| padding(&link.name)).collect()
}

/// Links, then obstacles; `None` for those without shapes and those that no pair names.
pub(super) fn bodies(
    robot: &RobotModel,
    world: &World,
    settings: &Settings,
    pairs: &[Pair],
) -> Vec<Option<Body>> {
    let solid = settings.mesh_model == MeshModel::Solid;
    let links = robot.links().iter().map(|link| {
        let shapes = link.collisions.iter().map(|c| (c.pose_ls, &c.shape));
        shapes.collect::<Vec<(Pose, _)>>()
    });
    let obstacles = (0..).map(ObstacleId).take(world.place_count()).map(|id| {
        let obstacle = world.place(id);
        obstacle.map_or_else(Vec::new, |obstacle| obstacle.placed_shapes().collect::<Vec<_>>())
    });
    let mut named = vec![false; robot.links().len() + world.place_count()];
    for index in pairs.iter().flat_map(|pair| pair.bodies) {
        named[index] = true;
    }
    (links.chain(obstacles).zip(named))
        .map(|(shapes, named)| (named && !shapes.is_empty()).then(|| Body::new(&shapes, solid)))
        .collect()
}
