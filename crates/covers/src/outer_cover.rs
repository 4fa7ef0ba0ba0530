//! Outer cover of one solid by balls: search, refinement, proof.

use clearance_geometry::math::{Extremes, Point};

use crate::ball::{Ball, ROUNDING};
use crate::branch_and_bound::{Accuracy, DistanceBounds};
use crate::containment::Containment;
use crate::cover_search::CoverSearch;
use crate::distance_grid::DistanceGrid;
use crate::excess::ball_excess;
use crate::link_solid::LinkSolid;
use crate::offset_balls::largest_balls;
use crate::refinement::{Refined, Refinement};
use crate::samples::{inner_points, surface_points, thinned};
use crate::search_limit::SearchLimit;

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

/// A cover with less than this part of the allowed excess may need much fewer balls.
const MUCH_ROOM: f64 = 0.6;

/// Part of the time that is left for a search; the rest is for its proof.
const SEARCH_TIME: f64 = 0.6;

/// Number of bisections of a quick search.
const QUICK: usize = 6;

/// A ball with proven bounds on its excess.
pub type BoundedBall = (Ball, DistanceBounds);

/// A solid with the data for the search of covers.
pub struct OuterCover<'s> {
    solid: &'s LinkSolid,
    grid: DistanceGrid,
    surface: Vec<Point>,
    spacing: f64,
    limit: &'s SearchLimit,
}

/// Goal of the search for a cover: a number of balls, or an excess.
#[derive(Clone, Copy, Debug)]
pub enum Aim {
    /// At most this many balls, with little excess.
    Count(usize),
    /// Few balls, with at most this excess (m).
    Excess(f64),
}

/// A cover that contains its solid for sure.
#[derive(Clone, Debug)]
pub struct ProvenCover {
    pub balls: Vec<BoundedBall>,
    /// True if the limit has ended the search.
    pub is_cut: bool,
}

impl<'s> OuterCover<'s> {
    /// `None` if the limit ends before.
    pub fn new(solid: &'s LinkSolid, limit: &'s SearchLimit) -> Option<Self> {
        let grid = DistanceGrid::new(solid, limit)?;
        let (surface, spacing) = surface_points(solid);
        Some(Self { solid, grid, surface, spacing, limit })
    }

    /// Length (m) of the diagonal of the box around the solid.
    pub fn extent(&self) -> f64 {
        self.solid.extent()
    }

    /// The spheres that the solid consists of, if there are at most `count`: a cover without excess.
    fn own_spheres(&self, count: usize) -> Option<Vec<BoundedBall>> {
        let spheres = self.solid.spheres().filter(|spheres| spheres.len() <= count)?;
        let growth = 4.0 * ROUNDING;
        let bounded = |Ball { centre, radius }| {
            let bounds = DistanceBounds { lower: 0.0, upper: growth + ROUNDING, witness: centre };
            (Ball { centre, radius: radius + growth }, bounds)
        };
        Some(spheres.into_iter().map(bounded).collect())
    }

    /// Number of balls that a quick search needs for an excess (m).
    pub fn quick_count(&self, excess: f64) -> usize {
        self.search(excess, None, 0, self.limit).map_or(usize::MAX / 4096, |balls| balls.len())
    }

    /// A cover by a quick search; `None` if none is found and proven before the limit.
    pub fn quick(&self, aim: Aim) -> Option<Vec<BoundedBall>> {
        let most = if let Aim::Count(count) = aim { count } else { usize::MAX };
        if let Some(own) = self.own_spheres(most) {
            return Some(own);
        }
        let balls = match aim {
            Aim::Count(1) => self.around(),
            Aim::Count(count) => self.bisect(count, None, (QUICK, 0), self.limit),
            Aim::Excess(excess) => self.search(0.9 * excess, None, 0, self.limit)?,
        };
        let excess = self.refinement(0.0).largest_excess(&balls);
        let margin = self.margin(excess);
        self.closed(&Containment::new(self.solid, margin, self.limit), &balls, margin)
    }

    /// At most `count` balls that contain the solid, with little excess. If the limit ends the search, `known` or a better cover.
    pub fn of_count(&self, count: usize, known: Option<Vec<BoundedBall>>) -> ProvenCover {
        if let Some(balls) = self.own_spheres(count) {
            return ProvenCover { balls, is_cut: false };
        }
        let limit = self.limit.part(SEARCH_TIME);
        let found = self.best_of_count(count, None, &limit);
        let found = self.finish(found).map(|found| self.or_single(found));
        let is_cut = limit.is_over() || self.limit.is_over();
        let balls = match (found, known) {
            (Some(found), Some(known)) if is_cut && largest_excess(&known) < largest_excess(&found) => known,
            (Some(found), _) => found,
            (None, known) => known.unwrap_or_else(|| around(self.solid, self.limit)),
        };
        ProvenCover { balls, is_cut }
    }

    /// The cover, or one ball that has less excess.
    fn or_single(&self, found: Vec<BoundedBall>) -> Vec<BoundedBall> {
        if found.len() == 1 {
            return found;
        }
        let single = self.finish(self.best_of_count(1, None, self.limit));
        match single {
            Some(single) if largest_excess(&single) <= largest_excess(&found) => single,
            _ => found,
        }
    }

    /// Few balls that contain the solid with an excess of at most `excess` (m); `None` if none are found. If the limit ends the search, `known`
    /// or a better cover.
    pub fn of_excess(&self, excess: f64, known: Option<Vec<BoundedBall>>) -> Option<ProvenCover> {
        let mut found = self.search_excess(excess);
        if let Some(own) = self.own_spheres(found.as_ref().map_or(usize::MAX, Vec::len))
            && largest_excess(&own) <= excess
        {
            found = Some(own);
        }
        if !self.limit.is_over() {
            return found.map(|balls| ProvenCover { balls, is_cut: false });
        }
        let known = known.unwrap_or_else(|| around(self.solid, self.limit));
        Some(ProvenCover { balls: found.unwrap_or(known), is_cut: true })
    }

    fn search_excess(&self, excess: f64) -> Option<Vec<BoundedBall>> {
        let mut aim = 0.96 * excess;
        let mut cover = None;
        for _ in 0..MOST_ATTEMPTS {
            let found = self.finish(self.refine(&self.search(aim, None, 300, self.limit)?, self.limit))?;
            let reached = largest_excess(&found);
            if reached <= excess {
                cover = Some(found);
                break;
            }
            aim *= (0.98 * excess / reached).greater(0.6).lesser(0.97);
        }
        let mut cover = cover?;
        // the refinement may have left room for one ball less, or for much fewer
        let mut tries_many = largest_excess(&cover) < MUCH_ROOM * excess;
        for _ in 0..MOST_ATTEMPTS {
            if cover.len() < 2 || largest_excess(&cover) > 0.94 * excess {
                break;
            }
            let count = if tries_many { cover.len() / 2 } else { cover.len() - 1 };
            match self.finish(self.best_of_count(count, Some(excess), self.limit)) {
                Some(fewer) if largest_excess(&fewer) <= excess => cover = fewer,
                _ if tries_many => tries_many = false,
                _ => break,
            }
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

    fn search(
        &self,
        excess: f64,
        count: Option<usize>,
        steps: usize,
        limit: &SearchLimit,
    ) -> Option<Vec<Ball>> {
        let points = self.points();
        let mut candidates = largest_balls(&self.grid, excess, CANDIDATES);
        if excess < FINE * self.grid.step {
            // balls around points of the surface have no more excess than their radius
            candidates.extend(self.surface.iter().map(|p| Ball { centre: *p, radius: excess }));
        }
        CoverSearch::new(&points, candidates, limit).find(count, steps)
    }

    fn refine(&self, balls: &[Ball], limit: &SearchLimit) -> Refined {
        Refinement::new(&self.grid, 0.0, limit).refine(balls, &self.points(), 12)
    }

    fn refinement(&self, margin: f64) -> Refinement<'_> {
        Refinement::new(&self.grid, margin, self.limit)
    }

    /// Margin (m) of the proof for balls of this excess (m).
    fn margin(&self, excess: f64) -> f64 {
        MARGIN * excess.greater(1e-4 * self.solid.extent())
    }

    /// At most `count` balls that contain the sample points, by bisection of the excess of the candidates. `known` is an excess (m) that is
    /// likely to be possible.
    fn bisect(
        &self,
        count: usize,
        known: Option<f64>,
        (bisections, steps): (usize, usize),
        limit: &SearchLimit,
    ) -> Vec<Ball> {
        let mut low = 1e-4 * self.solid.extent() + 1e-9;
        let mut high = 0.5 * self.solid.extent() + 2e-9;
        let mut balls = self.around();
        let mut first = known;
        for _ in 0..if count == 1 { 0 } else { bisections } {
            if high < 1.04 * low || limit.is_over() {
                break;
            }
            let middle = first.take().unwrap_or_else(|| (low * high).sqrt());
            match self.search(middle, Some(count), steps, limit) {
                Some(found) => (high, balls) = (middle, found),
                None => low = middle,
            }
        }
        balls
    }

    /// Balls with the smallest excess that is found. `known` is an excess (m) that is likely to be possible.
    fn best_of_count(&self, count: usize, known: Option<f64>, limit: &SearchLimit) -> Refined {
        let mut best = self.refine(&self.bisect(count, known, (12, 150), limit), limit);
        // a single ball is found by refinement
        for _ in 0..if count == 1 { 0 } else { 6 } {
            let Some(found) = self.search(0.96 * best.excess, Some(count), 1000, limit) else { break };
            let refined = self.refine(&found, limit);
            if refined.excess > 0.995 * best.excess {
                break;
            }
            best = refined;
        }
        best
    }

    /// Proven cover from one that contains the sample points; `None` if the limit ends the proof.
    fn finish(&self, refined: Refined) -> Option<Vec<BoundedBall>> {
        let margin = self.margin(refined.excess);
        let containment = Containment::new(self.solid, margin, self.limit);
        let mut points = self.points();
        let mut best = self.closed(&containment, &refined.balls, margin)?;
        let mut balls = refined.balls;
        for _ in 0..if balls.len() > MANY { 2 } else { 4 } {
            let gaps = containment.gaps(&balls, 2.0 * margin);
            if gaps.is_empty() {
                break;
            }
            points.extend(thinned(gaps.into_iter(), 0.5 * self.spacing));
            balls = self.refinement(2.0 * margin).refine(&balls, &points, 4).balls;
            let Some(closed) = self.closed(&containment, &balls, margin) else { break };
            if largest_excess(&closed) < largest_excess(&best) {
                best = closed;
            }
        }
        Some(self.or_grown(best, &containment, &balls, margin))
    }

    /// The cover, or a better one by larger balls: a ball that alone closes many gaps runs away, and reaches out far.
    fn or_grown(
        &self,
        mut best: Vec<BoundedBall>,
        containment: &Containment,
        balls: &[Ball],
        margin: f64,
    ) -> Vec<BoundedBall> {
        let aim = self.refinement(0.0).largest_excess(balls);
        let mut growth = margin;
        while aim + 4.0 * growth < largest_excess(&best) && !self.limit.is_over() {
            let grown: Vec<Ball> =
                balls.iter().map(|ball| Ball { radius: ball.radius + growth, ..*ball }).collect();
            let Some(closed) = self.closed(containment, &grown, margin) else { break };
            if largest_excess(&closed) < largest_excess(&best) {
                best = closed;
            }
            growth *= 2.0;
        }
        best
    }

    fn closed(&self, containment: &Containment, balls: &[Ball], tolerance: f64) -> Option<Vec<BoundedBall>> {
        let balls = containment.close(balls, tolerance)?;
        let estimate = self.refinement(0.0);
        let estimates: Vec<f64> = balls.iter().map(|ball| estimate.excess(ball, f64::INFINITY)).collect();
        let mut order: Vec<usize> = (0..balls.len()).collect();
        order.sort_by(|i, j| estimates[*j].total_cmp(&estimates[*i]).then(i.cmp(j)));
        // once a large excess is known, the others need only be below it
        let mut accuracy = ACCURACY;
        let mut cover: Vec<Option<BoundedBall>> = vec![None; balls.len()];
        for i in order {
            let bounds = ball_excess(self.solid, &balls[i], &accuracy, self.limit);
            accuracy.enough = accuracy.enough.greater(bounds.lower);
            cover[i] = Some((balls[i], bounds));
        }
        Some(cover.into_iter().flatten().collect())
    }
}

/// The ball around the box of a solid, which contains the solid.
pub fn around(solid: &LinkSolid, limit: &SearchLimit) -> Vec<BoundedBall> {
    let [low, high] = solid.bounds();
    let radius = 0.5 * (high - low).norm() + 4.0 * ROUNDING;
    let ball = Ball { centre: low + (high - low) * 0.5, radius };
    vec![(ball, ball_excess(solid, &ball, &ACCURACY, limit))]
}

/// Proven bound (m) on the distance of all points of the balls from the solid.
pub fn largest_excess(cover: &[BoundedBall]) -> f64 {
    cover.iter().map(|(_, excess)| excess.upper).fold(0.0, Extremes::greater)
}
