//! Covers of all links of a robot by spheres.

use clearance_geometry::math::{Extremes, Point};
use clearance_robot::{LinkId, RobotModel};
use rayon::prelude::*;

use crate::ball::Ball;
use crate::branch_and_bound::Accuracy;
use crate::inner_cover::{InnerCover, uncovered_depth};
use crate::link_solid::LinkSolid;
use crate::options::{CoverError, CoverSize};
use crate::outer_cover::{Aim, BoundedBall, OuterCover, ProvenCover, around, largest_excess};
use crate::search_limit::SearchLimit;

/// Accuracy of the uncovered depth.
const DEPTH: Accuracy = Accuracy { relative: 0.02, absolute: 1e-5, most_cells: 100_000, enough: 0.0 };

/// Part of the time that is left for the search of inner spheres; the rest is for the depth that is left out.
const SEARCH_TIME: f64 = 0.6;

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
    /// True if the limit has ended the search: more time can give a smaller error. An excess or depth that was asked for may not be reached.
    pub is_cut: bool,
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

    /// True if the limit has ended the search of a link.
    #[must_use]
    pub fn is_cut(&self) -> bool {
        self.links.iter().any(|link| link.is_cut)
    }
}

/// The search of the cover of a link.
struct LinkSearch<'s> {
    link: LinkId,
    solid: &'s LinkSolid,
    /// `None` if the limit has ended its preparation.
    search: Option<OuterCover<'s>>,
    limit: &'s SearchLimit,
}

impl<'s> LinkSearch<'s> {
    fn new((link, solid): &'s (LinkId, LinkSolid), limit: &'s SearchLimit) -> Self {
        Self { link: *link, solid, search: OuterCover::new(solid, limit), limit }
    }

    /// A cover that is found fast, if time may end the search.
    fn quick(&self, aim: Aim) -> Option<Vec<BoundedBall>> {
        self.search.as_ref().filter(|_| self.limit.has_deadline())?.quick(aim)
    }

    /// The cover, and `known` or a better one if the limit ends the search. `None` if no cover of this excess is found.
    fn cover(&self, aim: Aim, known: Option<Vec<BoundedBall>>) -> Option<LinkCover> {
        let cover = match (&self.search, aim) {
            (None, _) => ProvenCover { balls: around(self.solid, self.limit), is_cut: true },
            (Some(search), Aim::Count(count)) => search.of_count(count, known),
            (Some(search), Aim::Excess(excess)) => search.of_excess(excess, known)?,
        };
        Some(link_cover(self.link, &cover))
    }
}

/// Spheres that contain the collision geometry of each link: every triangle, and the inside of closed meshes and primitives. Their excess is a
/// proven bound on how far they reach out. The same input gives the same spheres, on any number of threads, unless the limit ends the search:
/// then, the best spheres that are proven so far are returned, and [`LinkCover::is_cut`] is true.
///
/// `on_link` is called when a link is covered, from any thread.
///
/// # Errors
/// If a count or the excess is not positive, or a link has geometry that cannot be covered.
pub fn sphere_cover(
    robot: &RobotModel,
    size: &CoverSize,
    limit: &SearchLimit,
    on_link: &(dyn Fn(LinkId) + Sync),
) -> Result<SphereCover, CoverError> {
    size.validate()?;
    let solids = solids(robot, size)?;
    let searches: Vec<LinkSearch> = solids.par_iter().map(|solid| LinkSearch::new(solid, limit)).collect();
    let mut aims: Vec<Aim> = match size {
        CoverSize::PerLink(count) => vec![Aim::Count(*count); searches.len()],
        CoverSize::Excess(excess) => vec![Aim::Excess(*excess); searches.len()],
        CoverSize::Links(counts) => searches.iter().map(|search| count_of(counts, search.link)).collect(),
        CoverSize::Total(total) => allocation(&searches, *total, limit)?,
    };
    // first all links fast, so that no link is left out if the time ends
    let quick: Vec<_> =
        searches.par_iter().zip(&aims).map(|(search, aim)| (search, *aim, search.quick(*aim))).collect();
    let covers = quick.into_par_iter().map(|(search, aim, known)| {
        let cover = search.cover(aim, known);
        on_link(search.link);
        cover.ok_or_else(|| CoverError::NotReached {
            link: robot.link(search.link).name.clone(),
            excess: if let Aim::Excess(excess) = aim { excess } else { f64::INFINITY },
        })
    });
    let mut links: Vec<LinkCover> = covers.collect::<Result<_, _>>()?;
    if let CoverSize::Total(total) = size {
        share_rest(&searches, &mut aims, &mut links, *total);
    }
    Ok(SphereCover { links })
}

fn count_of(counts: &[(LinkId, usize)], link: LinkId) -> Aim {
    Aim::Count(counts.iter().find(|(other, _)| *other == link).map_or(1, |(_, count)| *count))
}

fn link_cover(link: LinkId, ProvenCover { balls, is_cut }: &ProvenCover) -> LinkCover {
    let sphere = |(ball, excess): &BoundedBall| CoverSphere {
        centre: ball.centre,
        radius: ball.radius,
        excess: excess.upper,
    };
    let lower = balls.iter().map(|(_, excess)| excess.lower).fold(0.0, Extremes::greater);
    let error = [lower, largest_excess(balls)];
    LinkCover { link, spheres: balls.iter().map(sphere).collect(), error, is_cut: *is_cut }
}

/// The solids of the links with collision geometry that a cover is about.
pub fn solids(robot: &RobotModel, size: &CoverSize) -> Result<Vec<(LinkId, LinkSolid)>, CoverError> {
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
fn allocation(searches: &[LinkSearch], total: usize, limit: &SearchLimit) -> Result<Vec<Aim>, CoverError> {
    if total < searches.len() {
        return Err(CoverError::TooFew { count: total, links: searches.len() });
    }
    let mut counts = vec![1; searches.len()];
    let covers: Vec<&OuterCover> = searches.iter().filter_map(|search| search.search.as_ref()).collect();
    let extent = covers.iter().map(|cover| cover.extent()).fold(0.0, Extremes::greater);
    let (mut low, mut high) = (1e-4 * extent + 1e-9, extent + 2e-9);
    for _ in 0..14 {
        if covers.len() < searches.len() || limit.is_over() {
            break;
        }
        let middle = (low * high).sqrt();
        let needed: Vec<usize> = covers.par_iter().map(|cover| cover.quick_count(middle)).collect();
        if needed.iter().sum::<usize>() <= total {
            (high, counts) = (middle, needed);
        } else {
            low = middle;
        }
    }
    Ok(counts.into_iter().map(Aim::Count).collect())
}

/// Gives spheres that are left over to the links with the largest excess.
fn share_rest(searches: &[LinkSearch], aims: &mut [Aim], links: &mut [LinkCover], total: usize) {
    for _ in 0..MOST_REPEATS {
        let rest = total.saturating_sub(links.iter().map(|link| link.spheres.len()).sum());
        let error = |i: usize| links[i].error[1];
        let Some(worst) = (0..links.len()).max_by(|i, j| error(*i).total_cmp(&error(*j))) else { return };
        if rest == 0 || searches[worst].limit.is_over() {
            return;
        }
        aims[worst] = Aim::Count(links[worst].spheres.len() + 1 + rest / MOST_REPEATS);
        match searches[worst].cover(aims[worst], None) {
            Some(larger) if larger.error[1] < links[worst].error[1] => links[worst] = larger,
            _ => return,
        }
    }
}

/// Spheres that lie inside the closed meshes and primitives of each link; a link without an inside has none. The size is a count, or a depth
/// (m) instead of an excess: of few spheres, such that all points inside that are deeper than this are in a sphere. [`LinkCover::error`]
/// bounds the depth that is left. If the limit ends the search, the spheres that were found so far are returned, and the bound holds for
/// them.
///
/// # Errors
/// If a count or the depth is not positive, if the size is a total, if no cover of the depth is found, or if a link has geometry that has
/// no inside by definition.
pub fn inner_sphere_cover(
    robot: &RobotModel,
    size: &CoverSize,
    limit: &SearchLimit,
    on_link: &(dyn Fn(LinkId) + Sync),
) -> Result<SphereCover, CoverError> {
    size.validate()?;
    if matches!(size, CoverSize::Total(_)) {
        return Err(CoverError::NoTotal);
    }
    let cover = |(link, solid): &(LinkId, LinkSolid)| {
        let aim = match size {
            CoverSize::Excess(depth) => Aim::Excess(*depth),
            CoverSize::PerLink(count) | CoverSize::Total(count) => Aim::Count(*count),
            CoverSize::Links(counts) => count_of(counts, *link),
        };
        let search_limit = limit.part(SEARCH_TIME);
        let balls = InnerCover::new(solid, &search_limit).map_or_else(Vec::new, |cover| match aim {
            Aim::Count(count) => cover.of_count(count),
            Aim::Excess(depth) => cover.of_depth(depth),
        });
        let depth = uncovered_depth(solid, &balls, &DEPTH, limit);
        let is_cut = search_limit.is_over() || limit.is_over();
        if let Aim::Excess(excess) = aim
            && depth.upper > excess
            && !is_cut
        {
            return Err(CoverError::NotReached { link: robot.link(*link).name.clone(), excess });
        }
        let sphere = |ball: &Ball| CoverSphere { centre: ball.centre, radius: ball.radius, excess: 0.0 };
        on_link(*link);
        Ok(LinkCover {
            link: *link,
            spheres: balls.iter().map(sphere).collect(),
            error: [depth.lower, depth.upper],
            is_cut,
        })
    };
    let links = solids(robot, size)?.par_iter().map(cover).collect::<Result<_, _>>()?;
    Ok(SphereCover { links })
}
