//! Measures given spheres of a robot: how far they stick out of each link, and how much of its surface is in no sphere.

use clearance_geometry::math::Extremes;
use clearance_geometry::{Primitive, Shape};
use clearance_robot::{LinkId, RobotModel};
use rayon::prelude::*;

use crate::ball::Ball;
use crate::branch_and_bound::{Accuracy, DistanceBounds};
use crate::excess::ball_excess;
use crate::link_solid::LinkSolid;
use crate::options::CoverError;
use crate::search_limit::SearchLimit;
use crate::sphere_cover::solid_of;
use crate::uncovered_area::{UncoveredArea, uncovered_area};

/// Accuracy of the excess of each sphere.
const ACCURACY: Accuracy = Accuracy { relative: 0.01, absolute: 1e-6, most_cells: 100_000, enough: 0.0 };

/// Measurement of the spheres of a link.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeasuredLink {
    /// The link.
    pub link: LinkId,
    /// Number of spheres.
    pub spheres: usize,
    /// Part of the surface in no sphere.
    pub uncovered: UncoveredArea,
    /// Proven bounds (m), lower and upper, on the largest distance of a sphere's point from the link's geometry.
    pub excess: [f64; 2],
}

/// Measurement of a model of spheres.
#[derive(Clone, Debug, PartialEq)]
pub struct MeasuredCover {
    /// The links of the robot that have collision geometry.
    pub links: Vec<MeasuredLink>,
    /// Names of the links with spheres that stand for no collision geometry of the robot: nothing is said about these spheres.
    pub unmeasured: Vec<String>,
}

/// Measures the spheres of `spheres`, a model with the link names of `robot`, beside the collision geometry of `robot`. If the limit ends the
/// measurement, the bounds hold and are wide.
///
/// # Errors
/// If a link of `spheres` has collision geometry other than spheres, or a link of `robot` has geometry that cannot be covered.
pub fn measure_spheres(
    robot: &RobotModel,
    spheres: &RobotModel,
    limit: &SearchLimit,
) -> Result<MeasuredCover, CoverError> {
    let mut links = vec![];
    for id in robot.link_ids() {
        if let Some(solid) = solid_of(robot, id)? {
            links.push((id, solid, balls(spheres, &robot.link(id).name)?));
        }
    }
    let is_measured = |name: &str| {
        robot.link_by_name(name).is_some_and(|id| links.iter().any(|(measured, ..)| *measured == id))
    };
    let with_spheres = spheres.links().iter().filter(|link| !link.collisions.is_empty());
    let unmeasured = with_spheres.map(|link| link.name.clone()).filter(|name| !is_measured(name)).collect();
    let links = links.par_iter().map(|(link, solid, balls)| measured(*link, solid, balls, limit)).collect();
    Ok(MeasuredCover { links, unmeasured })
}

fn measured(link: LinkId, solid: &LinkSolid, balls: &[Ball], limit: &SearchLimit) -> MeasuredLink {
    let excesses: Vec<DistanceBounds> =
        balls.iter().map(|ball| ball_excess(solid, ball, &ACCURACY, limit)).collect();
    let largest = |of: fn(&DistanceBounds) -> f64| excesses.iter().map(of).fold(0.0, Extremes::greater);
    let excess = [largest(|e| e.lower), largest(|e| e.upper)];
    MeasuredLink { link, spheres: balls.len(), uncovered: uncovered_area(solid, balls, limit), excess }
}

/// The spheres of a link; none if the link does not exist.
fn balls(spheres: &RobotModel, name: &str) -> Result<Vec<Ball>, CoverError> {
    let Some(link) = spheres.link_by_name(name) else { return Ok(vec![]) };
    let ball = |collision: &clearance_robot::Collision| match collision.shape {
        Shape::Primitive(Primitive::Sphere { radius }) => {
            Ok(Ball { centre: collision.pose_ls.translation.vector.into(), radius })
        }
        _ => Err(CoverError::Link {
            link: name.to_owned(),
            reason: format!("its collision geometry is a {}, but must be spheres", collision.shape.kind()),
        }),
    };
    spheres.link(link).collisions.iter().map(ball).collect()
}
