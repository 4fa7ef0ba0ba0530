//! Covers of all links of a robot by spheres.

use clearance_geometry::math::{Extremes, Point};
use clearance_robot::{LinkId, RobotModel};
use rayon::prelude::*;

use crate::ball::Ball;
use crate::branch_and_bound::Accuracy;
use crate::inner_cover::{InnerCover, uncovered_depth};
use crate::link_solid::LinkSolid;
use crate::options::{CoverError, CoverSize};
use crate::outer_cover::{OuterCover, largest_excess};

/// Accuracy of the uncovered depth.
const DEPTH: Accuracy = Accuracy { relative: 0.02, absolute: 1e-5, most_cells: 100_000, enough: 0.0 };

/// Largest number of links that get spheres which the first allocation leaves over.
const MOST_REPEATS: usize = 8;

/// A sphere in the frame of its link.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CoverSphere {
    /// Centre (m).
    pub centre: Point,
    /// Radius (m).
    pub radius: f64,
    /// Proven bound (m) on the distance of its points from the link's geometry; 0 for inner covers.
    pub excess: f64,
}

/// The spheres of a link.
#[derive(Clone, Debug, PartialEq)]
pub struct LinkCover {
    /// The link.
    pub link: LinkId,
    /// The spheres, in the link frame.
    pub spheres: Vec<CoverSphere>,
    /// Proven bounds (m), lower and upper. Outer covers: on the largest distance of a point of the spheres from the link's geometry. Inner
    /// covers: on the largest depth of a point inside the link that is in no sphere.
    pub error: [f64; 2],
}

/// A cover of a robot: the links with collision geometry, in the order of the model.
#[derive(Clone, Debug, PartialEq)]
pub struct SphereCover {
    /// The covers of the links.
    pub links: Vec<LinkCover>,
}

impl SphereCover {
    /// Number of spheres.
    #[must_use]
    pub fn count(&self) -> usize {
        self.links.iter().map(|link| link.spheres.len()).sum()
    }

    /// The largest of the links' upper bounds (m).
    #[must_use]
    pub fn largest_error(&self) -> f64 {
        self.links.iter().map(|link| link.error[1]).fold(0.0, Extremes::greater)
    }
}

/// Spheres that contain the collision geometry of each link: every triangle, and the inside of closed meshes and primitives. Their excess is a
/// proven bound on how far they reach out. The same input gives the same spheres.
///
/// `on_link` is called when a link is covered, from any thread.
///
/// # Errors
/// If a count or the excess is not positive, or a link has geometry that cannot be covered.
pub fn sphere_cover(
    robot: &RobotModel,
    size: &CoverSize,
    on_link: &(dyn Fn(LinkId) + Sync),
) -> Result<SphereCover, CoverError> {
    size.validate()?;
    let solids = solids(robot, size)?;
    let covers: Vec<(LinkId, OuterCover)> =
        solids.par_iter().map(|(link, solid)| (*link, OuterCover::new(solid))).collect();
    let of_count = |(link, cover): &(LinkId, OuterCover), count: usize| {
        let cover = link_cover(*link, &cover.of_count(count));
        on_link(*link);
        cover
    };
    let of_excess = |(link, cover): &(LinkId, OuterCover), excess: f64| {
        let name = || robot.link(*link).name.clone();
        let cover = cover.of_excess(excess).map(|balls| link_cover(*link, &balls));
        on_link(*link);
        cover.ok_or_else(|| CoverError::NotReached { link: name(), excess })
    };
    let links = match size {
        CoverSize::PerLink(count) => covers.par_iter().map(|cover| of_count(cover, *count)).collect(),
        CoverSize::Links(counts) => {
            let count = |link: LinkId| counts.iter().find(|(other, _)| *other == link).map_or(1, |(_, n)| *n);
            covers.par_iter().map(|cover| of_count(cover, count(cover.0))).collect()
        }
        CoverSize::Excess(excess) => {
            covers.par_iter().map(|cover| of_excess(cover, *excess)).collect::<Result<_, _>>()?
        }
        CoverSize::Total(total) => {
            let mut counts = allocation(&covers, *total)?;
            let pairs: Vec<_> = covers.iter().zip(counts.iter().copied()).collect();
            let mut links: Vec<LinkCover> =
                pairs.into_par_iter().map(|(cover, count)| of_count(cover, count)).collect();
            share_rest(&covers, &mut counts, &mut links, *total);
            links
        }
    };
    Ok(SphereCover { links })
}

fn link_cover(link: LinkId, balls: &[crate::outer_cover::BoundedBall]) -> LinkCover {
    let sphere = |(ball, excess): &crate::outer_cover::BoundedBall| CoverSphere {
        centre: ball.centre,
        radius: ball.radius,
        excess: excess.upper,
    };
    let lower = balls.iter().map(|(_, excess)| excess.lower).fold(0.0, Extremes::greater);
    LinkCover { link, spheres: balls.iter().map(sphere).collect(), error: [lower, largest_excess(balls)] }
}

/// The solids of the links with collision geometry that a cover is about.
fn solids(robot: &RobotModel, size: &CoverSize) -> Result<Vec<(LinkId, LinkSolid)>, CoverError> {
    let mut solids = vec![];
    for id in robot.link_ids() {
        if matches!(size, CoverSize::Links(counts) if !counts.iter().any(|(link, _)| *link == id)) {
            continue;
        }
        if let Some(solid) = solid_of(robot, id)? {
            solids.push((id, solid));
        }
    }
    Ok(solids)
}

/// The solid of a link; `None` if it has no collision geometry.
pub fn solid_of(robot: &RobotModel, id: LinkId) -> Result<Option<LinkSolid>, CoverError> {
    let link = robot.link(id);
    LinkSolid::of_link(link)
        .map_err(|error| CoverError::Link { link: link.name.clone(), reason: error.to_string() })
}

/// Counts for the links such that a quick search reaches nearly the same excess on each.
fn allocation(covers: &[(LinkId, OuterCover)], total: usize) -> Result<Vec<usize>, CoverError> {
    if total < covers.len() {
        return Err(CoverError::TooFew { count: total, links: covers.len() });
    }
    let extent = covers.iter().map(|(_, cover)| cover.extent()).fold(0.0, Extremes::greater);
    let (mut low, mut high) = (1e-4 * extent + 1e-9, extent + 2e-9);
    let mut counts = vec![1; covers.len()];
    for _ in 0..14 {
        let middle = (low * high).sqrt();
        let needed: Vec<usize> = covers.par_iter().map(|(_, cover)| cover.quick_count(middle)).collect();
        if needed.iter().sum::<usize>() <= total {
            (high, counts) = (middle, needed);
        } else {
            low = middle;
        }
    }
    Ok(counts)
}

/// Gives spheres that are left over to the links with the largest excess.
fn share_rest(covers: &[(LinkId, OuterCover)], counts: &mut [usize], links: &mut [LinkCover], total: usize) {
    for _ in 0..MOST_REPEATS {
        let rest = total.saturating_sub(links.iter().map(|link| link.spheres.len()).sum());
        let error = |i: usize| links[i].error[1];
        let Some(worst) = (0..links.len()).max_by(|i, j| error(*i).total_cmp(&error(*j))) else { return };
        if rest == 0 {
            return;
        }
        counts[worst] = links[worst].spheres.len() + 1 + rest / MOST_REPEATS;
        let (link, cover) = &covers[worst];
        let larger = link_cover(*link, &cover.of_count(counts[worst]));
        if larger.error[1] >= links[worst].error[1] {
            return;
        }
        links[worst] = larger;
    }
}

/// Spheres that lie inside the closed meshes and primitives of each link; a link without an inside has none. The size is a count, or a depth
/// (m) instead of an excess: of few spheres, such that few points inside are deeper than this and in no sphere. [`LinkCover::error`] bounds
/// the depth that is left.
///
/// # Errors
/// If a count or the depth is not positive, if the size is a total, or if a link has geometry that has no inside by definition.
pub fn inner_sphere_cover(
    robot: &RobotModel,
    size: &CoverSize,
    on_link: &(dyn Fn(LinkId) + Sync),
) -> Result<SphereCover, CoverError> {
    size.validate()?;
    if matches!(size, CoverSize::Total(_)) {
        return Err(CoverError::NoTotal);
    }
    let cover = |(link, solid): &(LinkId, LinkSolid)| {
        let cover = InnerCover::new(solid);
        let balls = match size {
            CoverSize::Excess(depth) => cover.of_depth(*depth),
            CoverSize::PerLink(count) | CoverSize::Total(count) => cover.of_count(*count),
            CoverSize::Links(counts) => {
                cover.of_count(counts.iter().find(|(other, _)| other == link).map_or(1, |(_, n)| *n))
            }
        };
        let depth = uncovered_depth(solid, &balls, &DEPTH);
        let sphere = |ball: &Ball| CoverSphere { centre: ball.centre, radius: ball.radius, excess: 0.0 };
        on_link(*link);
        LinkCover {
            link: *link,
            spheres: balls.iter().map(sphere).collect(),
            error: [depth.lower, depth.upper],
        }
    };
    Ok(SphereCover { links: solids(robot, size)?.par_iter().map(cover).collect() })
}
