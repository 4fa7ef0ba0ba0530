//! Outer cover of one solid by balls: search, refinement, proof.

use clearance_geometry::math::{Extremes, Point};

use crate::ball::Ball;
use crate::branch_and_bound::{Accuracy, DistanceBounds};
use crate::containment::Containment;
use crate::cover_search::CoverSearch;
use crate::distance_grid::DistanceGrid;
use crate::excess::ball_excess;
use crate::link_solid::LinkSolid;
use crate::offset_balls::largest_balls;
use crate::refinement::{Refined, Refinement};
use crate::samples::{inner_points, surface_points, thinned};

/// Largest number of candidate balls.
const CANDIDATES: usize = 2500;

/// Margin of the proof, and step of the growth that closes gaps, relative to the excess.
const MARGIN: f64 = 2e-3;

/// Accuracy of the largest excess.
const ACCURACY: Accuracy = Accuracy { relative: 0.01, absolute: 1e-6, most_cells: 20_000, enough: 0.0 };

/// Number of balls above which less time is spent on each.
const MANY: usize = 60;

/// An excess below this number of steps of the grid is fine: then, the grid has too few centres of balls.
const FINE: f64 = 4.0;

/// Largest number of searches for one excess.
const MOST_ATTEMPTS: usize = 10;

/// A ball with proven bounds on its excess.
pub type BoundedBall = (Ball, DistanceBounds);

/// A solid with the data for the search of covers.
pub struct OuterCover<'s> {
    solid: &'s LinkSolid,
    grid: DistanceGrid,
    surface: Vec<Point>,
    spacing: f64,
}

impl<'s> OuterCover<'s> {
    pub fn new(solid: &'s LinkSolid) -> Self {
        let grid = DistanceGrid::new(solid);
        let (surface, spacing) = surface_points(solid);
        Self { solid, grid, surface, spacing }
    }

    /// Length (m) of the diagonal of the box around the solid.
    pub fn extent(&self) -> f64 {
        self.solid.extent()
    }

    /// Number of balls that a quick search needs for an excess (m).
    pub fn quick_count(&self, excess: f64) -> usize {
        self.search(excess, None, 0).map_or(usize::MAX / 4096, |balls| balls.len())
    }

    /// At most `count` balls that contain the solid, with little excess.
    pub fn of_count(&self, count: usize) -> Vec<BoundedBall> {
        self.finish(self.best_of_count(count, None))
    }

    /// Few balls that contain the solid with an excess of at most `excess` (m); `None` if none are found.
    pub fn of_excess(&self, excess: f64) -> Option<Vec<BoundedBall>> {
        let mut aim = 0.96 * excess;
        let mut cover = None;
        for _ in 0..MOST_ATTEMPTS {
            let found = self.finish(self.refine(&self.search(aim, None, 300)?));
            let reached = largest_excess(&found);
            if reached <= excess {
                cover = Some(found);
                break;
            }
            aim *= (0.98 * excess / reached).greater(0.6).lesser(0.97);
        }
        let mut cover = cover?;
        // the refinement may have left room for one ball less
        for _ in 0..MOST_ATTEMPTS {
            if cover.len() < 2 || largest_excess(&cover) > 0.94 * excess {
                break;
            }
            let fewer = self.finish(self.best_of_count(cover.len() - 1, Some(excess)));
            if largest_excess(&fewer) > excess {
                break;
            }
            cover = fewer;
        }
        Some(cover)
    }

    /// The ball around the box of the solid.
    fn around(&self) -> Vec<Ball> {
        let [low, high] = self.solid.bounds();
        vec![Ball { centre: low + (high - low) * 0.5, radius: 0.5 * (high - low).norm() }]
    }

    fn points(&self) -> Vec<Point> {
        let mut points = self.surface.clone();
        points.extend(inner_points(&self.grid, 0.0));
        points
    }

    fn search(&self, excess: f64, count: Option<usize>, steps: usize) -> Option<Vec<Ball>> {
        let points = self.points();
        let mut candidates = largest_balls(&self.grid, excess, CANDIDATES);
        if excess < FINE * self.grid.step {
            // balls around points of the surface have no more excess than their radius
            candidates.extend(self.surface.iter().map(|p| Ball { centre: *p, radius: excess }));
        }
        CoverSearch::new(&points, candidates).find(count, steps)
    }

    fn refine(&self, balls: &[Ball]) -> Refined {
        Refinement::new(&self.grid, 0.0).refine(balls, &self.points(), 12)
    }

    /// Balls with the smallest excess that is found, by bisection of the excess of the candidates. `known` is an excess (m) that is likely
    /// to be possible.
    fn best_of_count(&self, count: usize, known: Option<f64>) -> Refined {
        let mut low = 1e-4 * self.solid.extent() + 1e-9;
        let mut high = 0.5 * self.solid.extent() + 2e-9;
        let mut balls = self.around();
        let mut first = known;
        for _ in 0..if count == 1 { 0 } else { 12 } {
            if high < 1.04 * low {
                break;
            }
            let middle = first.take().unwrap_or_else(|| (low * high).sqrt());
            match self.search(middle, Some(count), 150) {
                Some(found) => (high, balls) = (middle, found),
                None => low = middle,
            }
        }
        let mut best = self.refine(&balls);
        // a single ball is found by refinement
        for _ in 0..if count == 1 { 0 } else { 6 } {
            let Some(found) = self.search(0.96 * best.excess, Some(count), 1000) else { break };
            let refined = self.refine(&found);
            if refined.excess > 0.995 * best.excess {
                break;
            }
            best = refined;
        }
        best
    }

    /// Proven cover from one that contains the sample points.
    fn finish(&self, refined: Refined) -> Vec<BoundedBall> {
        let margin = MARGIN * refined.excess.greater(1e-4 * self.solid.extent());
        let containment = Containment::new(self.solid, margin);
        let mut points = self.points();
        let mut best = self.closed(&containment, &refined.balls, margin);
        let mut balls = refined.balls;
        for _ in 0..if balls.len() > MANY { 2 } else { 4 } {
            let gaps = containment.gaps(&balls, 2.0 * margin);
            if gaps.is_empty() {
                break;
            }
            points.extend(thinned(gaps.into_iter(), 0.5 * self.spacing));
            balls = Refinement::new(&self.grid, 2.0 * margin).refine(&balls, &points, 4).balls;
            let closed = self.closed(&containment, &balls, margin);
            if largest_excess(&closed) < largest_excess(&best) {
                best = closed;
            }
        }
        best
    }

    fn closed(&self, containment: &Containment, balls: &[Ball], tolerance: f64) -> Vec<BoundedBall> {
        let balls = containment.close(balls, tolerance);
        let estimate = Refinement::new(&self.grid, 0.0);
        let estimates: Vec<f64> = balls.iter().map(|ball| estimate.excess(ball, f64::INFINITY)).collect();
        let mut order: Vec<usize> = (0..balls.len()).collect();
        order.sort_by(|i, j| estimates[*j].total_cmp(&estimates[*i]).then(i.cmp(j)));
        // once a large excess is known, the others need only be below it
        let mut accuracy = ACCURACY;
        let mut cover: Vec<Option<BoundedBall>> = vec![None; balls.len()];
        for i in order {
            let bounds = ball_excess(self.solid, &balls[i], &accuracy);
            accuracy.enough = accuracy.enough.greater(bounds.lower);
            cover[i] = Some((balls[i], bounds));
        }
        cover.into_iter().flatten().collect()
    }
}

/// Proven bound (m) on the distance of all points of the balls from the solid.
pub fn largest_excess(cover: &[BoundedBall]) -> f64 {
    cover.iter().map(|(_, excess)| excess.upper).fold(0.0, Extremes::greater)
}
