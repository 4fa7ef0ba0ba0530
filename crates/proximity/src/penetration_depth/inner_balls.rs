//! Balls inside solids: lower bounds on the penetration depth.
//!
//! If a ball of radius r around p lies inside one solid and a ball of radius s around q inside another, no translation shorter than
//! `r + s - |p - q|` separates them: the balls would still overlap.

use clearance_geometry::math::{MatrixPose, Point, Vector};
use clearance_geometry::{ClosedSurface, TriangleMesh};

use super::convex_solid::SupportMap;
use super::solid_body::{Part, Union, spread_directions};
use crate::search::Scratch;

/// Number of points on the surface of each part from which balls are grown.
const SAMPLES: usize = 64;

/// Number of directions in which common inner points are searched.
const NEIGHBOURS: usize = 26;

/// Number of bisections of a ball's radius.
const BISECTIONS: usize = 8;

/// Part of its distance from the surface point that a ball's radius has to reach, to count as tangent there.
const TANGENT: f64 = 0.99;

/// A ball inside a solid, in the frame of its body.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ball {
    pub centre: Point,
    pub radius: f64,
}

/// A point of a surface, and the unit vector into the solid.
#[derive(Clone, Copy, Debug)]
pub(super) struct SurfacePoint {
    pub point: Point,
    pub inward: Vector,
}

impl Ball {
    /// Lower bound (m) on a translation that separates the solid around this ball from one around another.
    pub fn depth(&self, other: &Self) -> f64 {
        self.radius + other.radius - nalgebra::distance(&self.centre, &other.centre)
    }

    pub fn transformed(&self, pose: &MatrixPose) -> Self {
        Self { centre: pose * self.centre, radius: self.radius }
    }

    /// The ball around a point of a body, as large as it is found; `None` for a point outside.
    pub fn around(centre: Point, body: &Union, scratch: &mut Scratch) -> Option<Self> {
        body.inner_radius(&centre, scratch).map(|radius| Self { centre, radius })
    }

    /// About the largest ball that touches the surface at a point from inside, with a radius of at most `most` (m).
    pub fn tangent(at: &SurfacePoint, most: f64, body: &Union, scratch: &mut Scratch) -> Option<Self> {
        let mut best: Option<Self> = None;
        let mut is_tangent = |radius: f64| {
            let Some(found) = Self::around(at.point + at.inward * radius, body, scratch) else {
                return false;
            };
            if best.is_none_or(|best| found.radius > best.radius) {
                best = Some(found);
            }
            found.radius >= TANGENT * radius
        };
        if !is_tangent(most) {
            let (mut tangent, mut too_large) = (0.0, most);
            for _ in 0..BISECTIONS {
                let radius = 0.5 * (tangent + too_large);
                if is_tangent(radius) { tangent = radius } else { too_large = radius }
            }
        }
        best
    }
}

/// Balls spread through a body.
pub(super) fn inner_balls(body: &Union, scratch: &mut Scratch) -> Vec<Ball> {
    let size = body.size();
    let mut balls: Vec<Ball> = (body.parts.iter())
        .flat_map(Part::surface_samples)
        .filter_map(|at| Ball::tangent(&at, size, body, scratch))
        .collect();
    balls.sort_by(|a, b| b.radius.total_cmp(&a.radius));
    balls
}

impl Part {
    fn surface_samples(&self) -> Vec<SurfacePoint> {
        match self {
            Self::Convex(solid) => (spread_directions(SAMPLES).iter())
                .map(|n| SurfacePoint { point: solid.support(n) + n.scale(solid.radius()), inward: -**n })
                .collect(),
            Self::Mesh { mesh, pose } => (samples_of_mesh(mesh).into_iter())
                .map(|at| SurfacePoint { point: pose * at.point, inward: pose * at.inward })
                .collect(),
            Self::Plane(_) => Vec::new(),
        }
    }
}

/// Points spread over the area of a closed mesh.
#[allow(clippy::cast_possible_truncation, clippy::cast_precision_loss, clippy::cast_sign_loss)] // small numbers
fn samples_of_mesh(mesh: &TriangleMesh) -> Vec<SurfacePoint> {
    let faces = mesh.solid().surfaces().iter().flat_map(ClosedSurface::triangles);
    let corners = faces.map(|t| t.map(|v| mesh.vertices()[v as usize]));
    let with_area = corners.map(|[a, b, c]| ([a, b, c], (b - a).cross(&(c - a))));
    let with_area: Vec<_> = with_area.filter(|(_, normal)| normal.norm() > 0.0).collect();
    let step = with_area.iter().map(|(_, normal)| normal.norm()).sum::<f64>() / SAMPLES as f64;
    let mut area = 0.5 * step;
    let mut samples = Vec::with_capacity(SAMPLES + 1);
    for ([a, b, c], normal) in with_area {
        let before = (area / step).floor();
        area += normal.norm();
        let count = (area / step).floor() - before;
        for i in 0..count as usize {
            // spread along the line from the middle of an edge to the opposite corner
            let share = (i as f64 + 1.0) / (count + 1.0) * 0.9;
            let middle = nalgebra::center(&b, &c);
            samples
                .push(SurfacePoint { point: a + (middle - a) * (1.0 - share), inward: -normal.normalize() });
        }
    }
    samples
}

/// The largest lower bound (m) from any pair of balls of two bodies; the balls of b are already in the frame of a.
pub(super) fn deepest_pair(of_a: &[Ball], of_b: &[Ball]) -> Option<(f64, [Ball; 2])> {
    let mut best: Option<(f64, [Ball; 2])> = None;
    for a in of_a {
        for b in of_b {
            // both lists are sorted by radius: no later ball of b is larger
            if best.is_some_and(|(depth, _)| a.radius + b.radius <= depth) {
                break;
            }
            let depth = a.depth(b);
            if best.is_none_or(|(best, _)| depth > best) {
                best = Some((depth, [*a, *b]));
            }
        }
    }
    best
}

/// The best of some pairs of balls with a common centre, which is near a point; none where no centre is inside both bodies.
pub(super) fn common_balls(
    near: &Point,
    distance: f64,
    [body_a, body_b]: [&Union; 2],
    pose_ab: &MatrixPose,
    scratch: &mut Scratch,
) -> Option<(f64, [Ball; 2])> {
    let pose_ba = pose_ab.inverse();
    let mut best: Option<(f64, [Ball; 2])> = None;
    for n in spread_directions(NEIGHBOURS) {
        for share in [0.3, 1.0] {
            let centre = near + n.scale(share * distance);
            let Some(of_a) = Ball::around(centre, body_a, scratch) else { continue };
            let Some(of_b) = Ball::around(&pose_ba * centre, body_b, scratch) else { continue };
            let pair = [of_a, of_b.transformed(pose_ab)];
            let depth = pair[0].depth(&pair[1]);
            if best.is_none_or(|(deepest, _)| depth > deepest) {
                best = Some((depth, pair));
            }
        }
    }
    best
}

/// Moves the centres of two balls to where the bound is larger: steps along the axes and along the line between the centres, shorter
/// after each round without progress.
pub(super) fn improved(
    start: [Ball; 2],
    [body_a, body_b]: [&Union; 2],
    pose_ab: &MatrixPose,
    first_step: f64,
    scratch: &mut Scratch,
) -> f64 {
    let [mut a, mut b] = start;
    let pose_ba = pose_ab.inverse();
    let mut best = a.depth(&b);
    let mut step = first_step;
    for _ in 0..6 {
        let mut is_better = false;
        for direction in [Vector::x(), -Vector::x(), Vector::y(), -Vector::y(), Vector::z(), -Vector::z()] {
            let moved = Ball::around(a.centre + direction * step, body_a, scratch);
            if let Some(moved) = moved.filter(|moved| moved.depth(&b) > best) {
                (a, best, is_better) = (moved, moved.depth(&b), true);
            }
            let moved = Ball::around(&pose_ba * (b.centre + direction * step), body_b, scratch);
            let moved = moved.map(|moved| moved.transformed(pose_ab));
            if let Some(moved) = moved.filter(|moved| a.depth(moved) > best) {
                (b, best, is_better) = (moved, a.depth(&moved), true);
            }
        }
        if !is_better {
            step *= 0.4;
        }
    }
    best
}
