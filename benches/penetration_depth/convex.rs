//! Errors of penetration depths of convex pairs, measured against exact depths.
//!
//! The Minkowski difference of two polyhedra has faces across the normals of either and across the cross products of their edges: the
//! depth is the least overlap along these directions. Balls and capsules have closed formulas.

use clearance::geometry::math::{MatrixPose, Point, Pose, Vector};
use clearance::geometry::{Primitive, Shape, TriangleMesh};
use clearance::proximity::{Scratch, SolidBody, penetration_depth};

use crate::random::Random;

/// Largest relative errors of the bounds of many pairs.
pub struct ConvexErrors {
    pub name: &'static str,
    pub pairs: usize,
    /// Of the upper and the lower bound.
    pub largest: [f64; 2],
}

/// The errors for each kind of pairs.
pub fn convex_errors(pairs: usize) -> Vec<ConvexErrors> {
    vec![
        errors("box, box", pairs, |random| {
            let [a, b] = [(); 2].map(|()| [(); 3].map(|()| random.within(0.05, 0.4)));
            let solids = [a, b].map(|half_extents| Shape::Primitive(Primitive::Box { half_extents }));
            let pose = random.pose(0.4);
            let corners = [cuboid(a, &Pose::identity()), cuboid(b, &pose)];
            (solids, pose, overlap(&corners))
        }),
        errors("tetrahedron, tetrahedron", pairs, |random| {
            let corners = [(); 2].map(|()| [(); 4].map(|()| random.point(0.5)));
            let pose = random.pose(0.3);
            let placed = [corners[0].to_vec(), corners[1].map(|p| pose * p).to_vec()];
            let solids = corners.map(|corners| Shape::Mesh(std::sync::Arc::new(tetrahedron(corners))));
            (solids, pose, overlap(&placed.map(Polyhedron::of_tetrahedron)))
        }),
        errors("capsule, capsule", pairs, |random| {
            let capsules = [(); 2].map(|()| [random.within(0.1, 0.3), random.within(0.05, 0.4)]);
            let pose = random.pose(0.4);
            let exact = overlap_of_capsules(&capsules, &pose);
            let solid = |[radius, half_length]: [f64; 2]| {
                Shape::Primitive(Primitive::Capsule { radius, half_length })
            };
            (capsules.map(solid), pose, exact)
        }),
    ]
}

/// Poses without an exact depth, or where the solids are apart, do not count.
fn errors(
    name: &'static str,
    pairs: usize,
    mut pair: impl FnMut(&mut Random) -> ([Shape; 2], Pose, Option<f64>),
) -> ConvexErrors {
    let (mut random, mut scratch) = (Random::new(3), Scratch::default());
    let (mut largest, mut count) = ([0.0_f64; 2], 0);
    while count < pairs {
        let (shapes, pose, exact) = pair(&mut random);
        let Some(exact) = exact.filter(|exact| *exact > 1e-3) else { continue };
        let [a, b] = shapes.each_ref().map(|shape| SolidBody::new([(&Pose::identity(), shape)]));
        let found = penetration_depth(&a, &b, MatrixPose::from(&pose), 0.0, &mut scratch);
        let found = found.expect("the solids overlap");
        largest[0] = largest[0].max((found.upper - exact).abs() / exact);
        largest[1] = largest[1].max((found.lower - exact).abs() / exact);
        count += 1;
    }
    ConvexErrors { name, pairs, largest }
}

/// Corners, normals of faces and directions of edges.
struct Polyhedron {
    corners: Vec<Point>,
    normals: Vec<Vector>,
    edges: Vec<Vector>,
}

impl Polyhedron {
    fn of_tetrahedron(corners: Vec<Point>) -> Self {
        let all = [[0, 1, 2], [0, 1, 3], [0, 2, 3], [1, 2, 3]];
        let normal = |[i, j, k]: [usize; 3]| (corners[j] - corners[i]).cross(&(corners[k] - corners[i]));
        let edges = (0..4).flat_map(|i| (0..i).map(move |j| (i, j)));
        Self {
            normals: all.map(normal).to_vec(),
            edges: edges.map(|(i, j)| corners[i] - corners[j]).collect(),
            corners,
        }
    }
}

fn cuboid(half: [f64; 3], pose: &Pose) -> Polyhedron {
    let side = |i: usize, k: usize| if i >> k & 1 == 0 { -half[k] } else { half[k] };
    let corners = (0..8).map(|i| pose * Point::new(side(i, 0), side(i, 1), side(i, 2))).collect();
    let axes: Vec<Vector> = (0..3).map(|k| pose * Vector::ith(k, 1.0)).collect();
    Polyhedron { corners, normals: axes.clone(), edges: axes }
}

fn tetrahedron(corners: [Point; 4]) -> TriangleMesh {
    let [a, b, c, d] = corners;
    let is_turned = (b - a).cross(&(c - a)).dot(&(d - a)) > 0.0;
    let faces = [[0, 1, 2], [0, 3, 1], [1, 3, 2], [0, 2, 3]];
    let faces = faces.map(|[i, j, k]| if is_turned { [i, k, j] } else { [i, j, k] });
    TriangleMesh::new(corners.to_vec(), faces.to_vec()).expect("a valid mesh")
}

/// The least overlap (m) along the candidates for normals of the Minkowski difference.
fn overlap([a, b]: &[Polyhedron; 2]) -> Option<f64> {
    let crossed = a.edges.iter().flat_map(|e| b.edges.iter().map(move |f| e.cross(f)));
    let axes = a.normals.iter().chain(&b.normals).copied().chain(crossed);
    let mut least = f64::INFINITY;
    for axis in axes.filter(|axis| axis.norm() > 1e-9) {
        let n = axis.normalize();
        let range = |corners: &[Point]| {
            let heights = corners.iter().map(|p| n.dot(&p.coords));
            heights.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], h| [low.min(h), high.max(h)])
        };
        let ([low_a, high_a], [low_b, high_b]) = (range(&a.corners), range(&b.corners));
        least = least.min(high_a - low_b).min(high_b - low_a);
    }
    (least > 0.0).then_some(least)
}

/// The sum of the radii minus the distance of the axes, unless these cross.
fn overlap_of_capsules(capsules: &[[f64; 2]; 2], pose: &Pose) -> Option<f64> {
    let ends = |half: f64| [Point::new(0.0, 0.0, -half), Point::new(0.0, 0.0, half)];
    let (first, second) = (ends(capsules[0][1]), ends(capsules[1][1]).map(|p| pose * p));
    let [p, q] = clearance::geometry::nearest_on_segments(&first, &second);
    let apart = nalgebra::distance(&p, &q);
    let depth = capsules[0][0] + capsules[1][0] - apart;
    (apart > 1e-3 && depth > 0.0).then_some(depth)
}
