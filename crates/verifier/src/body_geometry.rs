//! Builds the bodies of links, attached objects and obstacles, with their scale factors.

use clearance_geometry::Shape;
use clearance_geometry::math::Pose;
use clearance_robot::{LinkId, RobotModel};
use clearance_scene::{MeshModel, ObstacleId, Settings, World};

use super::Rejection;
use super::body::Body;
use super::body_pair::BodyPair;

/// By link and attached object: the link that carries it.
pub(super) fn carriers(robot: &RobotModel, world: &World) -> Result<Vec<LinkId>, Rejection> {
    let attached = world.attached().iter().map(|object| {
        let no_carrier = || Rejection::NoCarrier { object: object.name.clone(), link: object.link.clone() };
        robot.link_by_name(&object.link).ok_or_else(no_carrier)
    });
    robot.link_ids().map(Ok).chain(attached).collect()
}

/// Links, then attached objects, then obstacles, with their scale factors applied; `None` for bodies without shapes and bodies that no
/// pair names.
pub(super) fn bodies(
    robot: &RobotModel,
    world: &World,
    settings: &Settings,
    pairs: &[BodyPair],
) -> Result<Vec<Option<Body>>, Rejection> {
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
fn body(name: &str, scale: f64, shapes: &[(Pose, &Shape)], solid: bool) -> Result<Body, Rejection> {
    if scale == 1.0 {
        return Ok(Body::new(shapes, solid));
    }
    let scaled = shapes.iter().map(|(pose, shape)| Ok((*pose, shape.scaled(scale)?)));
    let scaled: Vec<(Pose, Shape)> = scaled
        .collect::<Result<_, _>>()
        .map_err(|why| Rejection::CannotScale { of: name.to_owned(), why })?;
    Ok(Body::new(&scaled.iter().map(|(pose, shape)| (*pose, shape)).collect::<Vec<_>>(), solid))
}
