//! Search for contact points of two links that touch and never move relative to each other.

use clearance_geometry::Shape;
use clearance_geometry::Triangle;
use clearance_geometry::math::{Point, Pose};
use clearance_proximity::distance;
use clearance_verifier::{ContactEvidence, ElementPoint};

use crate::inner_points::depth_in;
use crate::pair_problem::{PairProblem, PairWorkspace};

/// Room (m) for rounding in the verifier.
const ROUNDING: f64 = 1e-11;

/// Factors towards the centre of a primitive, for points of its surface that rounding has moved outside.
const SHRINKS: [f64; 3] = [0.0, 1e-12, 1e-11];

/// Evidence that the surfaces of two links without a joint between them touch.
pub fn search(problem: &PairProblem, workspace: &mut PairWorkspace) -> Option<ContactEvidence> {
    problem.path.place(&[], &mut workspace.placed);
    let PairWorkspace { placed, scratch, .. } = workspace;
    let [a, b] = problem.links;
    let near = distance(&a.body, &b.body, placed.pose_ab, problem.threshold(), scratch)?;
    let [p, q] = near.witness_points;
    let (of_a, p) = nearest(&a.shapes, &p)?;
    let (of_b, q) = nearest(&b.shapes, &(&placed.pose_ab.inverse() * q))?;
    let apart = (p - &placed.pose_ab * q).norm();
    let contact = Some([of_a, of_b]);
    let proof = "=".to_owned();
    (apart + ROUNDING <= problem.threshold()).then(|| ContactEvidence {
        contact,
        proof,
        ..Default::default()
    })
}

/// The point of shapes that is nearest to a point, both in the frame of their link.
fn nearest(shapes: &[(Pose, Shape)], p: &Point) -> Option<(ElementPoint, Point)> {
    let mut best: Option<(f64, ElementPoint, Point)> = None;
    for (number, (pose, shape)) in shapes.iter().enumerate() {
        let local = pose.inverse_transform_point(p);
        let mut consider = |face: usize, at: [f64; 3], found: Point| {
            let found = pose * found;
            let distance = (found - p).norm();
            if best.as_ref().is_none_or(|(least, ..)| distance < *least) {
                best = Some((distance, ElementPoint { shape: number, face, at }, found));
            }
        };
        match shape {
            Shape::Primitive(primitive) => {
                let shrunk = SHRINKS.map(|factor| Point::from(local.coords * (1.0 - factor)));
                if let Some(inside) = shrunk.into_iter().find(|x| depth_in(primitive, x) >= 0.0) {
                    consider(0, inside.into(), inside);
                }
            }
            Shape::Mesh(mesh) => {
                for face in 0..mesh.triangles().len() {
                    let triangle = mesh.triangle(face);
                    let weights = weights(&triangle, &triangle.nearest_point(&local));
                    let [u, v, w] = weights;
                    let [a, b, c] = triangle.corners().map(|corner| corner.coords);
                    consider(face, weights, Point::from(a * u + b * v + c * w));
                }
            }
            Shape::Plane(_) | Shape::Points(_) | Shape::Voxels(_) => {}
        }
    }
    best.map(|(_, point, found)| (point, found))
}

/// Weights of the corners of a triangle whose sum is nearest to a point in it; none is negative.
fn weights(triangle: &Triangle, p: &Point) -> [f64; 3] {
    let [e, f, g] = [triangle.b - triangle.a, triangle.c - triangle.a, p - triangle.a];
    let (ee, ef, ff, eg, fg) = (e.dot(&e), e.dot(&f), f.dot(&f), e.dot(&g), f.dot(&g));
    let determinant = ee * ff - ef * ef;
    let [v, w] = if determinant > 0.0 {
        [(ff * eg - ef * fg) / determinant, (ee * fg - ef * eg) / determinant]
    } else {
        [if ee > 0.0 { eg / ee } else { 0.0 }, 0.0]
    };
    let (v, w) = (v.clamp(0.0, 1.0), w.clamp(0.0, 1.0));
    let sum = (v + w).max(1.0);
    let (v, w) = (v / sum, w / sum);
    [(1.0 - v - w).max(0.0), v, w]
}
