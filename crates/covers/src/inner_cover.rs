//! Inner cover of one solid: balls that lie inside of it.
//!
//! The ball around a point inside whose radius is its distance from the surface contains no point outside.

use clearance_geometry::math::{Extremes, Point};

use crate::ball::{Ball, ROUNDING};
use crate::branch_and_bound::{Accuracy, CellValue, DistanceBounds, maximise};
use crate::cover_search::CoverSearch;
use crate::distance_grid::DistanceGrid;
use crate::link_solid::LinkSolid;
use crate::offset_balls::largest_balls;
use crate::samples::inner_points;
use crate::search_limit::SearchLimit;

/// Largest number of candidate balls.
const CANDIDATES: usize = 3000;

/// Number of searches with points that the one before has left uncovered.
const MOST_SEARCHES: usize = 6;

/// Largest number of balls that are added for points which the search has left uncovered, and the accuracy of their depths.
const MOST_ADDED: usize = 200;
const ADDED: Accuracy = Accuracy { relative: 0.02, absolute: 1e-5, most_cells: 60_000, enough: 0.0 };

/// A solid with the data for the search of inner covers.
#[derive(Debug)]
pub struct InnerCover<'s> {
    solid: &'s LinkSolid,
    grid: DistanceGrid,
    candidates: Vec<Ball>,
    limit: &'s SearchLimit,
}

impl<'s> InnerCover<'s> {
    /// `None` if the limit ends before.
    pub fn new(solid: &'s LinkSolid, limit: &'s SearchLimit) -> Option<Self> {
        let grid = DistanceGrid::new(solid, limit)?;
        let inside = |ball: &Ball| {
            let radius = -solid.signed_distance(&ball.centre) - ROUNDING;
            (radius > 0.0).then_some(Ball { centre: ball.centre, radius })
        };
        let candidates = largest_balls(&grid, 0.0, CANDIDATES).iter().filter_map(inside).collect();
        Some(Self { solid, grid, candidates, limit })
    }

    /// At most `count` balls inside; points deep inside are in one of them. Empty if nothing is inside.
    pub fn of_count(&self, count: usize) -> Vec<Ball> {
        if let Some(own) = self.own_spheres(count) {
            return own;
        }
        let deepest = self.candidates.iter().map(|ball| ball.radius).fold(0.0, Extremes::greater);
        let (mut low, mut high) = (1e-3 * deepest, deepest);
        let mut best: Vec<Ball> = self.deepest().into_iter().collect();
        for _ in 0..12 {
            if self.limit.is_over() {
                break;
            }
            let middle = 0.5 * (low + high);
            match self.search(&inner_points(&self.grid, middle), Some(count)) {
                Some(balls) => (high, best) = (middle, balls),
                None => low = middle,
            }
        }
        best
    }

    /// Few balls inside, such that points deeper than `depth` (m) are in one of them, unless [`MOST_ADDED`] balls do not suffice or the limit
    /// ends the search: the caller must check this.
    pub fn of_depth(&self, depth: f64) -> Vec<Ball> {
        let found = self.search_depth(depth);
        self.own_spheres(found.len()).unwrap_or(found)
    }

    /// The spheres that the solid consists of, if there are at most `count`.
    fn own_spheres(&self, count: usize) -> Option<Vec<Ball>> {
        let spheres = self.solid.spheres().filter(|spheres| spheres.len() <= count)?;
        let inside = |ball: Ball| Ball { radius: ball.radius - ROUNDING, ..ball };
        Some(spheres.into_iter().map(inside).filter(|ball| ball.radius > 0.0).collect())
    }

    fn search_depth(&self, depth: f64) -> Vec<Ball> {
        let mut points = inner_points(&self.grid, 0.95 * depth);
        let mut balls = self.search(&points, None).unwrap_or_else(|| self.deepest().into_iter().collect());
        if self.candidates.is_empty() {
            return balls;
        }
        for number in 0..MOST_ADDED {
            let left = uncovered_depth(self.solid, &balls, &ADDED, self.limit);
            if left.upper <= depth || self.limit.is_over() {
                break;
            }
            if number < MOST_SEARCHES {
                points.push(left.witness);
                points.extend(self.uncovered_points(&balls, 0.95 * depth));
                balls = self.search(&points, None).unwrap_or(balls);
                continue;
            }
            if left.lower <= 4.0 * ROUNDING {
                break;
            }
            balls.push(Ball { centre: left.witness, radius: left.lower - 2.0 * ROUNDING });
        }
        balls
    }

    fn deepest(&self) -> Option<Ball> {
        self.candidates.iter().copied().max_by(|a, b| a.radius.total_cmp(&b.radius))
    }

    /// Grid points deeper than `depth` (m) that are in no ball, at most about 200.
    fn uncovered_points(&self, balls: &[Ball], depth: f64) -> Vec<Point> {
        let deep = (0..self.grid.values.len()).filter(|i| self.grid.values[*i] < -depth);
        let points = deep.map(|i| self.grid.point(i));
        let free: Vec<Point> = points.filter(|p| !balls.iter().any(|ball| ball.contains(p, 0.0))).collect();
        let stride = free.len() / 200 + 1;
        free.into_iter().step_by(stride).collect()
    }

    fn search(&self, points: &[Point], count: Option<usize>) -> Option<Vec<Ball>> {
        if points.is_empty() {
            return Some(self.deepest().into_iter().collect());
        }
        CoverSearch::new(points, self.candidates.clone(), self.limit).find(count, 300)
    }
}

/// Bounds on the largest depth (m) of a point inside the solid that is in no ball: a ball of this radius around it lies inside.
pub fn uncovered_depth(
    solid: &LinkSolid,
    balls: &[Ball],
    accuracy: &Accuracy,
    limit: &SearchLimit,
) -> DistanceBounds {
    let known = if solid.has_inside() { 0.5 * solid.extent() } else { 0.0 };
    maximise(solid.bounds(), known, (accuracy, limit), |centre, reach, around| {
        let is_covered = balls.iter().any(|ball| ball.slack(centre) >= reach + ROUNDING);
        if is_covered {
            return None;
        }
        let signed = match around {
            Some(around) => solid.signed_distance_near(centre, around),
            None => solid.signed_distance(centre),
        };
        let depth = -signed;
        let is_free = depth > 0.0 && !balls.iter().any(|ball| ball.contains(centre, 0.0));
        let sample = is_free.then_some((*centre, depth));
        let known = (*centre, signed);
        (depth > -reach).then_some(CellValue { upper: depth + reach + ROUNDING, sample, known })
    })
}
