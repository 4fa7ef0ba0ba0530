//! Proof that balls contain a solid, and enlargement of balls until they do.
//!
//! Each triangle is split until every piece lies in one ball, by a margin: then, all points within the margin of the surface are covered, too.
//! The box around the closed parts is split into cells until each lies in one ball, lies outside, or is within the margin of the surface.
//! A gap is a small piece or cell that is not proven to be covered. [`Containment::close`] enlarges the ball that needs it least for each gap, so that
//! the result always contains the solid.

use clearance_geometry::math::{Extremes, Point, Vector};

use crate::ball::{Ball, ROUNDING};
use crate::link_solid::LinkSolid;
use crate::search_limit::SearchLimit;

/// Largest number of cells of one proof about the inside.
const MOST_CELLS: usize = 400_000;

/// Largest number of gaps that are collected.
const MOST_GAPS: usize = 5000;

/// Containment of one solid.
pub struct Containment<'s> {
    solid: &'s LinkSolid,
    /// All points of the solid within this distance (m) of the surface are covered, if the surface is.
    margin: f64,
    limit: &'s SearchLimit,
}

/// The limit has ended a proof.
struct Ended;

/// Handler of gaps.
trait Gaps {
    /// Balls that cover what has been closed so far.
    fn balls(&self) -> &[Ball];
    /// A piece that no ball contains, and its size (m); true if it needs no further split.
    fn on_gap(&mut self, corners: &[Point], size: f64) -> bool;
}

/// Collects gaps as points.
struct Witnesses<'b> {
    balls: &'b [Ball],
    smallest: f64,
    /// Growth (m) of a ball that closes a gap which does not count.
    tolerance: f64,
    points: Vec<Point>,
}

/// Enlarges balls.
struct Growth {
    balls: Vec<Ball>,
    /// Radii (m) before the growth.
    radii: Vec<f64>,
    /// Signed distances (m) of the centres from the solid.
    depths: Vec<f64>,
    smallest: f64,
    margin: f64,
    tolerance: f64,
}

impl Gaps for Witnesses<'_> {
    fn balls(&self) -> &[Ball] {
        self.balls
    }

    fn on_gap(&mut self, corners: &[Point], size: f64) -> bool {
        let reach =
            |ball: &Ball| corners.iter().map(|c| -ball.slack(c)).fold(f64::NEG_INFINITY, Extremes::greater);
        if self.balls.iter().any(|ball| reach(ball) <= self.tolerance) {
            return true;
        }
        if size <= self.smallest && self.points.len() < MOST_GAPS {
            #[allow(clippy::cast_precision_loss)] // three or eight
            let sum = corners.iter().map(|c| c.coords).sum::<Vector>() / corners.len() as f64;
            self.points.push(Point::from(sum));
        }
        size <= self.smallest || self.points.len() >= MOST_GAPS
    }
}

impl Gaps for Growth {
    fn balls(&self) -> &[Ball] {
        &self.balls
    }

    fn on_gap(&mut self, corners: &[Point], size: f64) -> bool {
        let needed = |ball: &Ball| {
            let farthest = corners.iter().map(|c| (c - ball.centre).norm()).fold(0.0, Extremes::greater);
            farthest + self.margin + 2.0 * ROUNDING
        };
        let needs: Vec<f64> = self.balls.iter().map(needed).collect();
        let excess = |i: usize| needs[i] + self.depths[i];
        let best = (1..needs.len()).fold(0, |best, i| if excess(i) < excess(best) { i } else { best });
        if size > self.smallest && needs[best] - self.radii[best] > self.tolerance {
            return false;
        }
        let ball = &mut self.balls[best];
        ball.radius = ball.radius.greater(needs[best]);
        true
    }
}

impl<'s> Containment<'s> {
    /// Proofs about a solid; to the `margin` (m), the chord error is added.
    pub fn new(solid: &'s LinkSolid, margin: f64, limit: &'s SearchLimit) -> Self {
        Self { solid, margin: margin + solid.chord_error() + 4.0 * ROUNDING, limit }
    }

    /// Points in gaps, at most [`MOST_GAPS`]. Gaps that a growth of a ball by `tolerance` (m) closes do not count.
    pub fn gaps(&self, balls: &[Ball], tolerance: f64) -> Vec<Point> {
        let smallest = 8.0 * tolerance;
        let mut witnesses = Witnesses { balls, smallest, tolerance, points: vec![] };
        // gaps guide the search: those that are found before the limit are good ones, too
        if self.visit_surface(&mut witnesses).is_ok() && witnesses.points.is_empty() {
            let _ = self.visit_inside(&mut witnesses, smallest);
        }
        witnesses.points
    }

    /// Enlarges balls until they contain the solid. Gaps are closed without further splits if that takes at most `tolerance` (m).
    /// `None` if the limit ends the proof.
    pub fn close(&self, balls: &[Ball], tolerance: f64) -> Option<Vec<Ball>> {
        let depths: Vec<f64> = balls.iter().map(|ball| self.solid.signed_distance(&ball.centre)).collect();
        let smallest = tolerance.lesser(0.25 * self.margin);
        let radii = balls.iter().map(|ball| ball.radius).collect();
        let (balls, margin) = (balls.to_vec(), self.margin);
        let mut growth = Growth { balls, radii, depths, smallest, margin, tolerance };
        self.visit_surface(&mut growth).ok()?;
        growth.margin = 0.0;
        self.visit_inside(&mut growth, 0.0).ok()?;
        Some(growth.balls)
    }

    fn visit_surface(&self, gaps: &mut impl Gaps) -> Result<(), Ended> {
        let mut open = vec![];
        for triangle in self.solid.triangles() {
            open.push(triangle.corners());
            while let Some(corners) = open.pop() {
                if self.limit.is_over() {
                    return Err(Ended);
                }
                if is_in_one(gaps.balls(), &corners, self.margin) {
                    continue;
                }
                let [a, b, c] = corners;
                let lengths = [(b - a).norm(), (c - b).norm(), (a - c).norm()];
                let longest = (1..3).fold(0, |l, i| if lengths[i] > lengths[l] { i } else { l });
                if !gaps.on_gap(&corners, lengths[longest]) {
                    let [p, q, r] = [[a, b, c], [b, c, a], [c, a, b]][longest];
                    let middle = p + (q - p) * 0.5;
                    open.extend([[p, middle, r], [middle, q, r]]);
                }
            }
        }
        Ok(())
    }

    /// The surface must be covered by the margin. Cells at the surface are not split below `smallest` (m).
    fn visit_inside(&self, gaps: &mut impl Gaps, smallest: f64) -> Result<(), Ended> {
        if !self.solid.has_inside() {
            return Ok(());
        }
        let [low, high] = self.solid.bounds();
        let middle = low + (high - low) * 0.5;
        let around = (middle, self.solid.signed_distance(&middle));
        let mut open = vec![(middle, 0.5 * (high - low).amax(), around)];
        // the triangles are within the chord error of the surface
        let near = self.margin - self.solid.chord_error();
        let mut cells = 0;
        while let Some((centre, half, around)) = open.pop() {
            if self.limit.is_over() {
                return Err(Ended);
            }
            cells += 1;
            let reach = half * 3.0_f64.sqrt() + ROUNDING;
            let corners = corners(&centre, half);
            if is_in_one(gaps.balls(), &corners, 0.0) {
                continue;
            }
            let signed = self.solid.signed_distance_near(&centre, around);
            if signed > reach
                || (reach < near
                    && self.solid.surface_distance(&centre, signed.abs() + ROUNDING) + reach <= near)
            {
                continue;
            }
            let at_surface = signed.abs() <= reach;
            if at_surface && half < smallest {
                continue;
            }
            let size = if cells > MOST_CELLS { 0.0 } else { 2.0 * half };
            // other cells at the surface are split until they are within its margin
            if (at_surface && size > 0.0) || !gaps.on_gap(&corners, size) {
                let quarter = 0.5 * half;
                open.extend(self::corners(&centre, quarter).map(|child| (child, quarter, (centre, signed))));
            }
        }
        Ok(())
    }
}

fn corners(centre: &Point, half: f64) -> [Point; 8] {
    std::array::from_fn(|i| {
        let side = |bit: usize| if i & bit == 0 { -half } else { half };
        centre + Vector::new(side(1), side(2), side(4))
    })
}

/// True if one ball contains all corners by a margin; then it contains their convex hull.
fn is_in_one(balls: &[Ball], corners: &[Point], margin: f64) -> bool {
    balls.iter().any(|ball| corners.iter().all(|corner| ball.contains(corner, margin + ROUNDING)))
}
