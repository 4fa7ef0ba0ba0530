//! Search for points deep inside two overlapping solids.
//!
//! A ball around a point, as large as the point is deep, lies in the solid. Two balls with the same centre, one in each solid, overlap until
//! the centre has moved by the sum of their radii. A point near a joint axis hardly moves.

use clearance_geometry::constants::MOTION_SLACK;
use clearance_geometry::math::{MatrixPose, Point, Pose, Vector};
use clearance_geometry::{Primitive, Shape};
use clearance_proximity::{CollisionBody, Scratch, collide, distance};
use fastrand::Rng;

use crate::joint_path::{PlacedAxis, PlacedPath};

/// Random points at which a search starts.
const STARTS: usize = 60;

/// Starts from which it continues.
const CLIMBS: usize = 3;

/// First and last step (m) of a climb.
const STEPS: [f64; 2] = [0.02, 1e-5];

/// Depth of points in a solid.
#[derive(Debug)]
pub enum PointDepth {
    /// A closed mesh: its surface, and the same as a solid.
    Mesh {
        /// Hierarchy of the surface.
        surface: Box<CollisionBody>,
        /// The same with its inside.
        solid: Box<CollisionBody>,
    },
    /// A primitive at a pose.
    Primitive(Primitive, Pose),
}

impl PointDepth {
    /// Depths in a shape; `None` for shapes without an inside.
    #[must_use]
    pub fn new(pose: &Pose, shape: &Shape) -> Option<Self> {
        Some(match shape {
            Shape::Primitive(primitive) => Self::Primitive(*primitive, *pose),
            Shape::Mesh(_) => Self::Mesh {
                surface: Box::new(CollisionBody::new([(pose, shape)])?),
                solid: Box::new(CollisionBody::with_solid_meshes([(pose, shape)])?),
            },
            Shape::Plane(_) | Shape::Points(_) | Shape::Voxels(_) => return None,
        })
    }

    /// Depth (m) of a point: the radius of a ball around it within the solid, or negative outside.
    fn of(&self, p: &Point, probe: &CollisionBody, scratch: &mut Scratch) -> f64 {
        match self {
            Self::Primitive(primitive, pose) => depth_in(primitive, &pose.inverse_transform_point(p)),
            Self::Mesh { surface, solid } => {
                let pose = MatrixPose { translation: p.coords, ..MatrixPose::identity() };
                let near = distance(surface, probe, pose, f64::INFINITY, scratch);
                let radius = near.map_or(f64::INFINITY, |near| near.distance);
                if collide(solid, probe, pose, scratch).is_some() { radius } else { -radius }
            }
        }
    }
}

/// Depth (m) of a point in a primitive, a lower bound inside.
pub fn depth_in(primitive: &Primitive, p: &Point) -> f64 {
    let radial = p.x.hypot(p.y);
    match primitive {
        Primitive::Box { half_extents: [x, y, z] } => (x - p.x.abs()).min(y - p.y.abs()).min(z - p.z.abs()),
        Primitive::Sphere { radius } => radius - p.coords.norm(),
        Primitive::Cylinder { radius, half_length } => (radius - radial).min(half_length - p.z.abs()),
        Primitive::Capsule { radius, half_length } => {
            let z = p.z.clamp(-half_length, *half_length);
            radius - radial.hypot(p.z - z)
        }
        Primitive::Cone { radius, half_length } => {
            // distance from the slant
            let height = 2.0 * half_length;
            let slant = ((half_length - p.z) * radius - radial * height) / radius.hypot(height);
            slant.min(p.z + half_length)
        }
    }
}

/// Search for balls with one centre inside two solids.
#[derive(Debug)]
pub struct InnerPointSearch {
    /// Points that were found before, in the frames of the first and of the second link.
    known: [Option<Point>; 2],
    random: Rng,
    probe: CollisionBody,
}

/// Two solids at the centre of a box.
#[derive(Clone, Copy)]
pub struct OverlapBox<'b> {
    /// Depths in both solids.
    pub depths: [&'b PointDepth; 2],
    /// The path at the centre.
    pub placed: &'b PlacedPath,
    /// Half widths (rad, m), by variable.
    pub half_widths: &'b [f64],
    /// Box (m) in the frame of the first link that contains the overlap.
    pub region: [Point; 2],
}

/// A ball in a solid of each link, with one centre at the centre of a box.
#[derive(Clone, Copy, Debug)]
pub struct ConcentricBalls {
    /// Centre (m) in the frame of the first and of the second link.
    pub centres: [Point; 2],
    /// Radius (m) in the solid of the first and of the second link.
    pub radii: [f64; 2],
}

impl InnerPointSearch {
    /// A search without known points; `None` if no probe can be built.
    #[must_use]
    pub fn new() -> Option<Self> {
        let probe = Shape::Primitive(Primitive::Sphere { radius: 0.0 });
        let probe = CollisionBody::with_solid_meshes([(&Pose::identity(), &probe)])?;
        Some(Self { known: [None; 2], random: Rng::with_seed(5), probe })
    }

    /// Two balls that overlap in the whole box.
    pub fn find(&mut self, overlap: &OverlapBox, scratch: &mut Scratch) -> Option<ConcentricBalls> {
        let pose_ab = &overlap.placed.pose_ab;
        let known = [self.known[0], self.known[1].map(|p| pose_ab * p)];
        let mut starts: Vec<(f64, Point)> = Vec::new();
        for p in known.into_iter().flatten() {
            starts.push((self.room(overlap, &p, scratch), p));
        }
        let [low, high] = overlap.region;
        if starts.iter().all(|(room, _)| *room <= 0.0) {
            for _ in 0..STARTS {
                let p = Point::from(low.coords.zip_map(&high.coords, |l, h| l + (h - l) * self.random.f64()));
                starts.push((self.room(overlap, &p, scratch), p));
            }
        }
        starts.sort_by(|a, b| b.0.total_cmp(&a.0));
        for start in starts.into_iter().take(CLIMBS) {
            let (room, p) = self.climb(overlap, start, scratch);
            if room > 0.0 {
                let centres = [p, &pose_ab.inverse() * p];
                self.known = centres.map(Some);
                let radii = self.depths(overlap, &p, scratch).map(certain_radius);
                return Some(ConcentricBalls { centres, radii });
            }
        }
        None
    }

    /// Moves a point along the axes while its room grows, by smaller and smaller steps, until the room is positive.
    fn climb(
        &self,
        overlap: &OverlapBox,
        (mut room, mut p): (f64, Point),
        scratch: &mut Scratch,
    ) -> (f64, Point) {
        let [mut step, last] = STEPS;
        let axes = [Vector::x(), Vector::y(), Vector::z()];
        while step > last && room <= 0.0 {
            let mut grew = false;
            for direction in axes.iter().flat_map(|axis| [*axis, -axis]) {
                let next = p + direction * step;
                let of_next = self.room(overlap, &next, scratch);
                if of_next > room {
                    (room, p, grew) = (of_next, next, true);
                }
            }
            if !grew {
                step *= 0.5;
            }
        }
        (room, p)
    }

    /// Depths (m) of a point in both solids.
    fn depths(&self, overlap: &OverlapBox, p: &Point, scratch: &mut Scratch) -> [f64; 2] {
        let [a, b] = overlap.depths;
        let p_b = &overlap.placed.pose_ab.inverse() * *p;
        [a.of(p, &self.probe, scratch), b.of(&p_b, &self.probe, scratch)]
    }

    /// How much farther (m) a point may move than the box allows; negative if it is not inside, or may leave.
    fn room(&self, overlap: &OverlapBox, p: &Point, scratch: &mut Scratch) -> f64 {
        let [in_a, in_b] = self.depths(overlap, p, scratch);
        let moved = displacement(overlap.placed, overlap.half_widths, [p, p]);
        let radii = [in_a, in_b].map(certain_radius);
        if radii.iter().all(|radius| *radius > MOTION_SLACK) {
            radii[0] + radii[1] - moved
        } else {
            // all such points are behind those inside
            in_a.min(in_b) - moved - 1.0
        }
    }
}

/// The radius (m) of a ball in a solid around a point of this depth, less the rounding of depths.
fn certain_radius(depth: f64) -> f64 {
    depth * (1.0 - MOTION_SLACK) - 0.5 * MOTION_SLACK
}

/// The largest relative displacement (m) of a point of the first link and one of the second, both in the frame of the first.
///
/// One link of the path is held still, which makes the displacement least.
pub fn displacement(placed: &PlacedPath, half_widths: &[f64], [a, b]: [&Point; 2]) -> f64 {
    let of_first = displacements(placed.axes.iter(), half_widths, a);
    let mut of_second = displacements(placed.axes.iter().rev(), half_widths, b);
    of_second.reverse();
    let held = |cut: usize| of_first[..cut].iter().chain(&of_second[cut..]).sum::<f64>();
    let moved = (0..=placed.axes.len()).map(held).fold(f64::INFINITY, f64::min);
    moved * (1.0 + 2.0 * MOTION_SLACK) + 2.0 * MOTION_SLACK
}

/// By joint, the nearest to the point first: the largest displacement (m) of the point by it.
fn displacements<'p>(axes: impl Iterator<Item = &'p PlacedAxis>, half_widths: &[f64], p: &Point) -> Vec<f64> {
    let mut moved = 0.0;
    axes.map(|axis| {
        let delta = axis.factor.abs() * half_widths[axis.variable];
        let displacement = if axis.turns {
            let reach = axis.axis.cross(&(p - axis.origin)).norm() + moved;
            2.0 * reach * (0.5 * delta.min(std::f64::consts::PI)).sin()
        } else {
            delta
        };
        moved += displacement;
        displacement
    })
    .collect()
}
