//! Fit of a capsule or box to points: the shape contains all points for sure, and a search makes its estimated excess small.

use clearance_geometry::math::{Extremes, Point, Rotation, Vector, pose_from_xyz_rpy};

use crate::ball::ROUNDING;
use crate::cover_shape::{CoverShape, ShapeSize};
use crate::distance_grid::DistanceGrid;
use crate::link_parts::{LinkPart, principal_axes};
use crate::samples::{directions, thinned};
use crate::search_limit::SearchLimit;

/// Number of trials to turn and move a shape in one fit.
const TRIALS: usize = 160;

/// Number of directions whose extreme points count in the search, and of cells along the longest edge that keep one point.
const EXTREME: u32 = 100;
const CELLS: f64 = 24.0;

/// Kinds of shapes that contain a link or a part of it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ShapeKind {
    /// Capsules (line-swept spheres).
    Capsule,
    /// Oriented boxes.
    Box,
}

/// Search of shapes around points of one solid.
pub struct ShapeFit<'g> {
    kind: ShapeKind,
    grid: &'g DistanceGrid,
    /// Distance (m) by which every point lies inside of its shape.
    margin: f64,
    directions: Vec<Vector>,
    limit: &'g SearchLimit,
}

/// A shape with the parameters of the search and its estimated excess (m).
#[derive(Clone, Copy, Debug)]
pub struct Fitted {
    pub shape: CoverShape,
    pub excess: f64,
    parameters: Parameters,
}

/// Free parameters of the shape around given points; its size follows from them.
#[derive(Clone, Copy, Debug)]
struct Parameters {
    /// Orientation: roll, pitch, yaw (rad).
    rpy: [f64; 3],
    /// Of a capsule: shift (m) of its axis, and growth (m) of its radius over the least.
    shift: [f64; 2],
    growth: f64,
}

impl<'g> ShapeFit<'g> {
    pub fn new(kind: ShapeKind, grid: &'g DistanceGrid, margin: f64, limit: &'g SearchLimit) -> Self {
        Self { kind, grid, margin, directions: directions(64), limit }
    }

    /// A shape that contains all points of a part, with little excess.
    pub fn fit(&self, part: &LinkPart) -> Fitted {
        let points = search_points(part);
        let starts = starts(self.kind, part);
        let mut best = self.evaluated(starts[0], &points);
        for start in &starts[1..] {
            let trial = self.evaluated(*start, &points);
            if trial.excess < best.excess {
                best = trial;
            }
        }
        let mut random = fastrand::Rng::with_seed(3);
        let mut random = || 2.0 * random.f64() - 1.0;
        let (mut step, size) = (0.3, circumradius(&best.shape.size));
        for _ in 0..TRIALS {
            if self.limit.is_over() {
                break;
            }
            let Parameters { rpy, shift, growth } = best.parameters;
            let parameters = Parameters {
                rpy: rpy.map(|angle| angle + step * random()),
                shift: shift.map(|shift| shift + 0.5 * step * size * random()),
                growth: (growth + 0.3 * step * size * random()).greater(0.0),
            };
            let trial = self.evaluated(parameters, &points);
            if trial.excess < best.excess {
                best = trial;
                step *= 1.6;
            } else {
                step = (0.88 * step).greater(1e-4);
            }
        }
        // the search leaves points out; the shape does not
        let all: Vec<Point> = part.points().copied().collect();
        self.evaluated(best.parameters, &all)
    }

    fn evaluated(&self, parameters: Parameters, points: &[Point]) -> Fitted {
        let shape = shape_around(self.kind, &parameters, points, self.margin);
        Fitted { shape, excess: self.estimate(&shape), parameters }
    }

    /// Approximate largest distance (m) of a point of a shape from the solid.
    fn estimate(&self, shape: &CoverShape) -> f64 {
        let pose_ls = shape.pose_ls();
        let value = |p: Point| self.grid.value(&(pose_ls * p));
        let mut most = value(Point::origin());
        match shape.size {
            ShapeSize::Capsule { radius, half_length } => {
                for direction in &self.directions {
                    for part in [-1.0, -0.5, 0.0, 0.5, 1.0] {
                        // the halves of the ends that point outward
                        let part = if direction.z * part < 0.0 { 0.5 * part } else { part };
                        let axis = Point::new(0.0, 0.0, part * half_length);
                        most = most.greater(value(axis + direction * radius));
                    }
                }
            }
            ShapeSize::Box { half_extents: half } => {
                let steps = [-1.0, -0.5, 0.0, 0.5, 1.0];
                for x in steps {
                    for y in steps {
                        for z in steps {
                            most = most.greater(value(Point::new(x * half[0], y * half[1], z * half[2])));
                        }
                    }
                }
            }
        }
        most.greater(0.0)
    }
}

/// Radius (m) of the ball around the centre of a shape that contains it.
pub fn circumradius(size: &ShapeSize) -> f64 {
    match size {
        ShapeSize::Capsule { radius, half_length } => radius + half_length,
        ShapeSize::Box { half_extents } => Vector::from(*half_extents).norm(),
    }
}

/// The shape of these parameters that contains all points by a margin (m).
fn shape_around(kind: ShapeKind, parameters: &Parameters, points: &[Point], margin: f64) -> CoverShape {
    // the orientation as it is read from a URDF
    let rotation = pose_from_xyz_rpy([0.0; 3], parameters.rpy).rotation;
    let locals: Vec<Point> = points.iter().map(|p| rotation.inverse_transform_point(p)).collect();
    let first = locals.first().copied().unwrap_or_default();
    let (low, high) = locals.iter().fold((first, first), |(low, high), p| (low.inf(p), high.sup(p)));
    let middle = low + (high - low) * 0.5;
    match kind {
        ShapeKind::Box => {
            let half_extents = ((high - low) * 0.5).map(|half| half + margin).data.0[0];
            let centre = rotation * middle;
            CoverShape { centre, rpy: parameters.rpy, size: ShapeSize::Box { half_extents } }
        }
        ShapeKind::Capsule => {
            let axis = [middle.x + parameters.shift[0], middle.y + parameters.shift[1]];
            let off_axis = |p: &Point| (p.x - axis[0]).hypot(p.y - axis[1]);
            let radius = locals.iter().map(off_axis).fold(0.0, Extremes::greater) + parameters.growth;
            let (mut lower, mut upper) = (f64::INFINITY, f64::NEG_INFINITY);
            for p in &locals {
                let reach = (radius * radius - off_axis(p).powi(2)).greater(0.0).sqrt();
                lower = lower.lesser(p.z + reach);
                upper = upper.greater(p.z - reach);
            }
            let (half_length, height) = (0.5 * (upper - lower).greater(0.0), 0.5 * (lower + upper));
            let to_segment = |p: &Point| {
                let beyond = ((p.z - height).abs() - half_length).greater(0.0);
                off_axis(p).hypot(beyond)
            };
            let radius = locals.iter().map(to_segment).fold(0.0, Extremes::greater) + margin;
            let centre = rotation * Point::new(axis[0], axis[1], height);
            CoverShape { centre, rpy: parameters.rpy, size: ShapeSize::Capsule { radius, half_length } }
        }
    }
}

/// Points of a part that guide the search: a few hundred.
fn search_points(part: &LinkPart) -> Vec<Point> {
    let along = |direction: &Vector| {
        let [low, high] = part.range(direction);
        high - low
    };
    let longest = [Vector::x(), Vector::y(), Vector::z()].iter().map(along).fold(0.0, Extremes::greater);
    let mut points = thinned(part.points().copied(), longest / CELLS + ROUNDING);
    for direction in directions(EXTREME) {
        let height = |p: &&Point| direction.dot(&p.coords);
        points.extend(part.points().max_by(|p, q| height(p).total_cmp(&height(q))));
    }
    points
}

/// Orientations to begin with: the axes of the link, and the principal axes; of capsules, each as z.
fn starts(kind: ShapeKind, part: &LinkPart) -> Vec<Parameters> {
    let [x, y, _] = principal_axes(&part.triangles);
    let frames = [[Vector::x(), Vector::y()], [x, y]].map(|[x, y]| [x, y, x.cross(&y)]);
    let turned = frames.iter().flat_map(|[x, y, z]| match kind {
        ShapeKind::Box => vec![[*x, *y, *z]],
        ShapeKind::Capsule => vec![[*x, *y, *z], [*y, *z, *x], [*z, *x, *y]],
    });
    let of_frame = |frame: [Vector; 3]| {
        let (roll, pitch, yaw) = Rotation::from_basis_unchecked(&frame).euler_angles();
        Parameters { rpy: [roll, pitch, yaw], shift: [0.0; 2], growth: 0.0 }
    };
    turned.map(of_frame).collect()
}
