//! Pairs of bodies that must be proven apart, with their paddings.

use clearance_robot::RobotModel;
use clearance_scene::{AllowedCollisionMatrix, BodyId, ObstacleId, PairList, Settings, World};

use super::Rejection;
use super::body_pair::BodyPair;

/// All pairs that have to be checked, in the order of the pair list.
pub(super) fn pairs(
    robot: &RobotModel,
    world: &World,
    settings: &Settings,
    matrix: Option<&AllowedCollisionMatrix>,
) -> Result<Vec<BodyPair>, Rejection> {
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
        BodyPair { bodies: [i, j], names: [first, second], padding }
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

/// Padding (m) of each link, attached object and obstacle.
fn paddings(robot: &RobotModel, world: &World, settings: &Settings) -> Result<Vec<f64>, Rejection> {
    for name in settings.link_padding.keys().chain(settings.link_scale.keys()) {
        robot.link_by_name(name).ok_or_else(|| Rejection::UnknownLink(name.clone()))?;
    }
    let usable = |name: &str, value: f64| {
        let usable = value.is_finite() && value >= 0.0;
        usable.then_some(value).ok_or_else(|| Rejection::BadPadding { of: name.to_owned(), value })
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
