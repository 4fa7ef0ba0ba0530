//! Tests of nearly touching triangles and sheets on both sides of a plane, whose exact distance is known.
//!
//! The distance is the gap, to the last bit: the plane proves that it is not less, the touching points that it is not
//! more. Sunk instead of lifted, a corner over a face pierces it.

use clearance::geometry::TriangleMesh;
use clearance::geometry::math::{Point, Pose, Vector};

use super::laws::{Case, Scrutiny, judge_with_truth};
use super::ledger::{Family, Ledger, survey};
use super::share;
use super::solid_oracle::solid_distance;
use super::subject::Subject;
use super::triangles::OF_TRIANGLES;
use crate::random::Random;

/// A mesh on one side of the plane.
struct Piece {
    vertices: Vec<Point>,
    faces: Vec<[u32; 3]>,
    feature: Feature,
    /// A point of the feature.
    touching: Point,
}

/// How deep a corner is sunk at most, relative to how far the rest of its piece keeps from the plane: so little that it
/// comes through well inside the face, though that be a sliver.
const DEEPEST: f64 = 1e-7;

/// What of a piece lies in the plane.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Feature {
    Corner,
    Edge,
    Face,
}

impl Feature {
    fn any(random: &mut Random) -> Self {
        [Self::Corner, Self::Edge, Self::Face][random.below(3) as usize]
    }

    fn corners(self) -> usize {
        match self {
            Self::Corner => 1,
            Self::Edge => 2,
            Self::Face => 3,
        }
    }
}

/// A point well inside the feature of a triangle's first corners.
fn point_of(feature: Feature, corners: [Point; 3], random: &mut Random) -> Point {
    let mut weights = [0; 3].map(|_| random.within(0.2, 1.0));
    weights[feature.corners()..].fill(0.0);
    let sum: f64 = weights.iter().sum();
    let terms = corners.iter().zip(weights).map(|(c, w)| c.coords * (w / sum));
    let mut point = Point::from(terms.sum::<Vector>());
    point.z = 0.0;
    point
}

impl Piece {
    /// One triangle, its feature in the plane and the rest on one side of it.
    fn triangle(random: &mut Random, size: f64, side: f64) -> Self {
        let feature = Feature::any(random);
        let mut vertices = random.triangle(size).corners();
        for (i, v) in vertices.iter_mut().enumerate() {
            v.z = if i < feature.corners() { 0.0 } else { side * size * random.within(0.1, 1.0) };
        }
        let touching = point_of(feature, vertices, random);
        Self { vertices: vertices.to_vec(), faces: vec![[0, 1, 2]], feature, touching }
    }

    /// A bumpy sheet of `2 * cells * cells` triangles that comes to the plane at one feature.
    fn sheet(random: &mut Random, size: f64, cells: u32, side: f64) -> Self {
        let feature = Feature::any(random);
        let step = size / f64::from(cells);
        let bump = side * step * 10f64.powf(random.within(-4.0, 0.0));
        let mut vertices = vec![];
        for i in 0..=cells {
            for j in 0..=cells {
                let (x, y) = (step * f64::from(i), step * f64::from(j));
                let jitter = random.vector(0.3 * step);
                vertices.push(Point::new(x + jitter.x, y + jitter.y, bump * random.within(0.1, 1.0)));
            }
        }
        let at = |i: u32, j: u32| i * (cells + 1) + j;
        let halves =
            |i, j| [[at(i, j), at(i + 1, j), at(i, j + 1)], [at(i + 1, j + 1), at(i, j + 1), at(i + 1, j)]];
        let cells_of = |i| (0..cells).map(move |j| (i, j));
        let faces: Vec<[u32; 3]> = (0..cells).flat_map(cells_of).flat_map(|(i, j)| halves(i, j)).collect();
        let chosen = faces[random.below(2 * cells * cells) as usize].map(|v| v as usize);
        for v in &chosen[..feature.corners()] {
            vertices[*v].z = 0.0;
        }
        let touching = point_of(feature, chosen.map(|v| vertices[v]), random);
        Self { vertices, faces, feature, touching }
    }

    /// How far the corners that are not in the plane keep from it.
    fn lowest(&self) -> f64 {
        let heights = self.vertices.iter().map(|v| v.z.abs()).filter(|z| *z > 0.0);
        heights.fold(f64::INFINITY, f64::min)
    }

    /// Turns and shifts in the plane, then lifts: heights stay exact until then.
    fn placed(mut self, turn: f64, under: &Point, lift: f64) -> Self {
        let (sin, cos) = turn.sin_cos();
        let pivot = self.touching;
        for v in &mut self.vertices {
            let offset = *v - pivot;
            v.x = under.x + cos * offset.x - sin * offset.y;
            v.y = under.y + sin * offset.x + cos * offset.y;
            v.z += lift;
        }
        self
    }

    fn subject(&self, frame: &Pose) -> Subject {
        let vertices = self.vertices.iter().map(|v| frame.inverse_transform_point(v)).collect();
        Subject::mesh(TriangleMesh::new(vertices, self.faces.clone()).expect("a piece is a mesh"))
    }
}

/// A gap from 1e-12 m to a millimetre; values beside the contact distance come often.
fn gap(random: &mut Random) -> f64 {
    match random.below(10) {
        0 => 0.0,
        1 => 1e-9 * (1.0 - 1e-3),
        2 => 1e-9 * (1.0 + 1e-3),
        _ => 10f64.powf(random.within(-12.0, -3.0)),
    }
}

fn judge_known(lower: &Piece, upper: Piece, family: &Family, random: &mut Random, ledger: &mut Ledger) {
    let gap = gap(random);
    let pierces = (lower.feature, upper.feature) == (Feature::Face, Feature::Corner) && random.below(2) == 0;
    let (truth, lift) = if pierces { (0.0, -gap.min(DEEPEST * upper.lowest())) } else { (gap, gap) };
    let upper = upper.placed(random.within(0.0, std::f64::consts::TAU), &lower.touching, lift);
    let mut frame = || if random.below(2) == 0 { Pose::identity() } else { random.pose(1.0) };
    let (frame_a, frame_b) = (frame(), frame());
    let (a, b) = (lower.subject(&frame_a), upper.subject(&frame_b));
    let case = Case { a: &a, b: &b, pose_ab: frame_a.inv_mul(&frame_b) };
    let known = |_: &Case, below: f64| (truth < below).then_some(truth);
    let scrutiny = Scrutiny::mostly_laws(random);
    judge_with_truth(&case, family.accuracy, scrutiny, random, ledger, known);
    // the oracle is judged too
    let found = solid_distance(&a.solid, &b.solid, &case.pose_ab, f64::INFINITY).unwrap_or(f64::INFINITY);
    let reach = a.solid.reach + b.solid.reach + case.pose_ab.translation.vector.amax();
    if (found - truth).abs() > family.accuracy.band(reach).above {
        ledger.note("the oracle", &[format!("{found:e} instead of {truth:e}")]);
    }
}

#[test]
fn triangles_nearly_touch() {
    let family = Family { name: "nearly touching triangles", accuracy: OF_TRIANGLES };
    let count = share(3000, 1_000_000);
    let ledger = survey(count, 200, |random, ledger| {
        let size = 10f64.powf(random.within(-2.0, 1.0));
        let (lower, upper) = (Piece::triangle(random, size, -1.0), Piece::triangle(random, size, 1.0));
        judge_known(&lower, upper, &family, random, ledger);
    });
    ledger.finish(&family, count);
}

#[test]
fn sheets_nearly_touch() {
    let family = Family { name: "nearly touching sheets", accuracy: OF_TRIANGLES };
    let count = share(150, 20_000);
    let ledger = survey(count, 201, |random, ledger| {
        let mut sheet = |side| {
            let cells = 1 + {
                let most = if random.below(8) == 0 { 31 } else { 12 };
                random.below(most)
            };
            let size = 10f64.powf(random.within(-1.0, 0.5));
            Piece::sheet(random, size, cells, side)
        };
        let (lower, upper) = (sheet(-1.0), sheet(1.0));
        judge_known(&lower, upper, &family, random, ledger);
    });
    ledger.finish(&family, count);
}
