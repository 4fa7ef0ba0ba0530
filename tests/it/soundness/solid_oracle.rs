//! Test oracle: distance of two bodies, the least over all pairs of parts, pruned by a tree of boxes.

use clearance::geometry::math::{Point, Pose, Vector};
use clearance::geometry::{Plane, Primitive, Shape};

use super::double_double::{ExactPose, Vec3};
use super::outline::{Bounds, Motion};
use super::parts::Part;

/// What rounding may hide where f64 prunes, relative to the largest coordinate.
const PRUNING_SLACK: f64 = 1e-14;

#[derive(Clone, Debug)]
struct Node {
    bounds: Bounds,
    content: Content,
}

#[derive(Clone, Copy, Debug)]
enum Content {
    Part(usize),
    Children(usize, usize),
}

/// The oracle's own copy of a body.
#[derive(Clone, Debug)]
pub struct Solid {
    parts: Vec<Part>,
    /// None without parts.
    nodes: Vec<Node>,
    planes: Vec<Plane>,
    /// Largest coordinate (m).
    pub reach: f64,
}

impl Solid {
    pub fn new<'a>(shapes: impl IntoIterator<Item = (&'a Pose, &'a Shape)>) -> Self {
        let (mut parts, mut planes) = (vec![], vec![]);
        let at = |pose: &ExactPose, centre: &[f32; 3]| {
            pose.then(&ExactPose::from(&Pose::from_parts(centre.map(f64::from).into(), nalgebra::one())))
        };
        for (pose, shape) in shapes {
            let exact = ExactPose::from(pose);
            match shape {
                Shape::Primitive(primitive) => parts.push(Part::primitive(primitive, &exact)),
                Shape::Mesh(mesh) => parts.extend(mesh.triangles().iter().map(|t| {
                    Part::triangle(t.map(|v| exact.point(&Vec3::from(&mesh.vertices()[v as usize]))), 0.0)
                })),
                Shape::Plane(plane) => planes.push(plane.transformed(pose)),
                Shape::Points(cloud) => parts.extend(cloud.points().iter().map(|p| {
                    let ball = Primitive::Sphere { radius: cloud.radius() };
                    Part::primitive(&ball, &at(&exact, p))
                })),
                Shape::Voxels(voxels) => parts.extend(voxels.cubes().iter().map(|cube| {
                    let solid = Primitive::Box { half_extents: [f64::from(cube.half_edge); 3] };
                    Part::primitive(&solid, &at(&exact, &cube.centre))
                })),
            }
        }
        Self::of(parts, planes)
    }

    fn of(parts: Vec<Part>, planes: Vec<Plane>) -> Self {
        let bounds: Vec<Bounds> = parts.iter().map(|p| p.outline.bounds(p.radius)).collect();
        let farthest = |b: &Bounds| (b.centre.coords.abs() + b.half).amax();
        let of_planes = planes.iter().map(|plane| plane.offset.abs());
        let reach = bounds.iter().map(farthest).chain(of_planes).fold(0.0, f64::max);
        let mut order: Vec<usize> = (0..parts.len()).collect();
        let mut nodes = Vec::with_capacity(2 * parts.len());
        if !parts.is_empty() {
            build(&bounds, &mut order, &mut nodes);
        }
        Self { parts, nodes, planes, reach }
    }

    /// A sphere around the parts of the body, in its frame; where there are only planes, some point of one.
    pub fn ball(&self) -> (Point, f64) {
        match (self.nodes.last(), self.planes.first()) {
            (Some(Node { bounds, .. }), _) => (bounds.centre, bounds.radius()),
            (None, Some(plane)) => (plane.foot(), 0.0),
            (None, None) => unreachable!("a body is made of something"),
        }
    }

    pub fn part_count(&self) -> usize {
        self.parts.len() + self.planes.len()
    }

    /// The distance of a point (in the body's frame) from the body.
    pub fn distance_to(&self, point: &Point) -> f64 {
        let probe = Self::of(vec![Part::triangle([Vec3::from(point); 3], 0.0)], vec![]);
        solid_distance(self, &probe, &Pose::identity(), f64::INFINITY).unwrap_or(f64::INFINITY)
    }
}

/// Splits at the median of the longest side, down to single parts; returns the node.
fn build(bounds: &[Bounds], order: &mut [usize], nodes: &mut Vec<Node>) -> usize {
    let around = order.iter().map(|i| bounds[*i]).reduce(|x, y| x.joined(&y)).expect("a body has parts");
    let content = if let [part] = order {
        Content::Part(*part)
    } else {
        let along = |i: &usize| bounds[*i].centre[around.half.imax()];
        let middle = order.len() / 2;
        order.select_nth_unstable_by(middle, |i, j| along(i).total_cmp(&along(j)));
        let (left, right) = order.split_at_mut(middle);
        Content::Children(build(bounds, left, nodes), build(bounds, right, nodes))
    };
    nodes.push(Node { bounds: around, content });
    nodes.len() - 1
}

/// The least distance (m) of two bodies if it is less than `limit`; b is posed in the frame of a.
pub fn solid_distance(a: &Solid, b: &Solid, pose_ab: &Pose, limit: f64) -> Option<f64> {
    let reach = a.reach + b.reach + pose_ab.translation.vector.amax();
    let below = limit.min(plane_distance(a, b, pose_ab)).min(plane_distance(b, a, &pose_ab.inverse()));
    let mut search = Search {
        a,
        b,
        pose_ab,
        exact: ExactPose::from(pose_ab),
        motion: Motion::from(pose_ab),
        slack: PRUNING_SLACK * reach,
        best: below,
        direction: Vector::zeros(),
    };
    if let (Some(i), Some(j)) = (a.nodes.len().checked_sub(1), b.nodes.len().checked_sub(1)) {
        let lower = search.lower_bound((i, j));
        search.nodes((i, j), lower);
    }
    (search.best < limit).then_some(search.best)
}

/// The least distance of a body's planes from parts of another; of planes only parallel ones are apart, and there are none here.
fn plane_distance(a: &Solid, b: &Solid, pose_ab: &Pose) -> f64 {
    let of_plane = |plane: &Plane| {
        let seen = plane.transformed(&pose_ab.inverse());
        let n = seen.normal.into_inner();
        let extents = b.parts.iter().map(|part| part.extent(&n));
        let gaps = extents.map(|(low, high)| (low - seen.offset).max(seen.offset - high).max(0.0));
        gaps.fold(if b.planes.is_empty() { f64::INFINITY } else { 0.0 }, f64::min)
    };
    a.planes.iter().map(of_plane).fold(f64::INFINITY, f64::min)
}

struct Search<'s> {
    a: &'s Solid,
    b: &'s Solid,
    pose_ab: &'s Pose,
    exact: ExactPose,
    motion: Motion,
    slack: f64,
    best: f64,
    /// Between the nearest parts so far: a unit vector, or zero while it is not known.
    direction: Vector,
}

impl Search<'_> {
    fn lower_bound(&self, (i, j): (usize, usize)) -> f64 {
        let (x, y) = (&self.a.nodes[i].bounds, &self.b.nodes[j].bounds);
        self.motion.lower_bound(x, y, &self.direction) - self.slack
    }

    fn nodes(&mut self, (i, j): (usize, usize), lower: f64) {
        if self.best <= 0.0 || lower >= self.best {
            return;
        }
        let (x, y) = (&self.a.nodes[i], &self.b.nodes[j]);
        let pairs = match (x.content, y.content) {
            (Content::Part(i), Content::Part(j)) => return self.parts(i, j),
            (Content::Children(l, r), Content::Part(_)) => [(l, j), (r, j)],
            (Content::Children(l, r), _) if x.bounds.radius() >= y.bounds.radius() => [(l, j), (r, j)],
            (_, Content::Children(l, r)) => [(i, l), (i, r)],
        };
        let lower = pairs.map(|pair| self.lower_bound(pair));
        let first = usize::from(lower[1] < lower[0]);
        for k in [first, 1 - first] {
            self.nodes(pairs[k], lower[k]);
        }
    }

    fn parts(&mut self, i: usize, j: usize) {
        let (x, y) = (&self.a.parts[i], &self.b.parts[j]);
        let radii = x.radius + y.radius;
        let gap = self.best + radii + self.slack;
        if x.outline.apart(&y.outline.moved(self.pose_ab), gap, &self.direction) {
            return;
        }
        let found = x.core.nearest(&y.core.moved(&self.exact));
        let distance = (found.squared.sqrt() - radii).max(0.0);
        if distance < self.best {
            self.best = distance;
            self.direction = found.direction.try_normalize(f64::MIN_POSITIVE).unwrap_or_default();
        }
    }
}
