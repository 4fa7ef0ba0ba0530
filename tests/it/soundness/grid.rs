//! Tests of triangles and meshes with corners on a grid, against distances in exact integers.
//! Corners are at integers times a power of two, and poses map the grid to itself. Everything touches, overlaps
//! and lines up all the time, and every result is known exactly.

use clearance::geometry::TriangleMesh;
use clearance::geometry::math::{Point, Pose, Rotation, RotationMatrix};

use super::grid_oracle::{Quotient, squared_distance};
use super::laws::{Case, Scrutiny, judge_with_truth};
use super::ledger::{Accuracy, Family, Ledger, survey};
use super::share;
use super::subject::Subject;
use crate::random::Random;

/// Distances may differ from the exact ones by rounding only.
const OF_THE_GRID: Accuracy = Accuracy { absolute: 0.0, of_reach: 2e-15, shortfall: 0.0 };

type Corner = [i64; 3];

/// A mesh of integer corners.
struct GridMesh(Vec<[Corner; 3]>);

/// One of the 24 turns of the cube, then an integer shift.
struct GridPose {
    /// Row i of the rotation: the axis that it takes, and its sign.
    rows: [(usize, i64); 3],
    shift: Corner,
}

impl GridPose {
    fn random(random: &mut Random, reach: u32) -> Self {
        let first = random.below(3) as usize;
        let swap = random.below(2) == 1;
        let mut axes = [first, (first + 1) % 3, (first + 2) % 3];
        if swap {
            axes.swap(1, 2);
        }
        let mut signs = [0; 3].map(|_| if random.below(2) == 0 { 1 } else { -1 });
        // a rotation, not a mirror
        let parity = if swap { -1 } else { 1 };
        signs[2] = parity * signs[0] * signs[1];
        let rows = [0, 1, 2].map(|i| (axes[i], signs[i]));
        Self { rows, shift: corner(random, reach) }
    }

    fn applied(&self, c: &Corner) -> Corner {
        [0, 1, 2].map(|i| self.rows[i].1 * c[self.rows[i].0] + self.shift[i])
    }

    fn in_metres(&self, unit: f64) -> Pose {
        let mut matrix = RotationMatrix::zeros();
        for (i, (axis, sign)) in self.rows.into_iter().enumerate() {
            matrix[(i, axis)] = float(sign);
        }
        let rotation = Rotation::from_rotation_matrix(&nalgebra::Rotation3::from_matrix_unchecked(matrix));
        Pose::from_parts(metres(&self.shift, unit).coords.into(), rotation)
    }
}

#[allow(clippy::cast_precision_loss)]
fn float(i: i64) -> f64 {
    i as f64
}

fn metres(c: &Corner, unit: f64) -> Point {
    Point::from(c.map(|x| float(x) * unit))
}

fn corner(random: &mut Random, reach: u32) -> Corner {
    [0; 3].map(|_| i64::from(random.below(2 * reach + 1)) - i64::from(reach))
}

impl GridMesh {
    /// Loose triangles around a few places, so that some are near each other and some are degenerate.
    fn random(random: &mut Random, count: u32, reach: u32) -> Self {
        let edge = 1 + random.below(reach);
        let around = |centre: Corner, random: &mut Random| {
            let offset = corner(random, edge);
            [0, 1, 2].map(|i| centre[i] + offset[i])
        };
        let triangle = |_| {
            let centre = corner(random, reach);
            [0; 3].map(|_| around(centre, random))
        };
        Self((0..count).map(triangle).collect())
    }

    /// One triangle whose corners lie in one line, or in one point: a turn that rounds gives it a normal made of noise.
    fn collinear(random: &mut Random, reach: u32) -> Self {
        let (start, step) = (corner(random, reach), corner(random, 2));
        let mut along = || {
            let steps = i64::from(random.below(5)) - 2;
            [0, 1, 2].map(|i| start[i] + steps * step[i])
        };
        Self(vec![[along(), along(), along()]])
    }

    fn subject(&self, unit: f64) -> Subject {
        let vertices: Vec<Point> = self.0.iter().flatten().map(|c| metres(c, unit)).collect();
        let faces = (0..).step_by(3).map(|i| [i, i + 1, i + 2]).take(self.0.len());
        Subject::mesh(TriangleMesh::new(vertices, faces.collect()).expect("a grid mesh"))
    }

    fn squared_distance(&self, other: &Self, pose: &GridPose) -> Quotient {
        let moved: Vec<[Corner; 3]> = other.0.iter().map(|t| t.map(|c| pose.applied(&c))).collect();
        let pairs = self.0.iter().flat_map(|s| moved.iter().map(move |t| squared_distance(s, t)));
        pairs.reduce(Quotient::least).expect("a mesh is never empty")
    }
}

fn judge_grid(
    [a, b]: [&GridMesh; 2],
    pose: &GridPose,
    unit: f64,
    family: &Family,
    random: &mut Random,
    ledger: &mut Ledger,
) {
    let exact = a.squared_distance(b, pose);
    let truth = exact.root() * unit;
    assert!(exact.is_zero() || truth > 2e-9, "the grid is too fine for definite answers: {truth}");
    let (a, b) = (a.subject(unit), b.subject(unit));
    let case = Case { a: &a, b: &b, pose_ab: pose.in_metres(unit) };
    let known = |_: &Case, below: f64| (truth < below).then_some(truth);
    let scrutiny = Scrutiny::mostly_answers(random);
    judge_with_truth(&case, family.accuracy, scrutiny, random, ledger, known);
}

/// A power of two from a tenth of a millimetre to a kilometre, for coarse grids from a micrometre: what does not touch is
/// farther apart than the contact distance.
fn unit(random: &mut Random, reach: u32) -> f64 {
    let finest: i32 = if reach <= 2 { -20 } else { -13 };
    2f64.powi(finest + i32::try_from(random.below(11 + finest.unsigned_abs())).expect("small"))
}

#[test]
fn triangles_on_a_grid() {
    let family = Family { name: "grid triangles", accuracy: OF_THE_GRID };
    let count = share(4000, 2_000_000);
    let ledger = survey(count, 300, |random, ledger| {
        let reach = 1 + random.below(8);
        let (a, b) = (GridMesh::random(random, 1, reach), GridMesh::random(random, 1, reach));
        let (pose, unit) = (GridPose::random(random, reach), unit(random, reach));
        judge_grid([&a, &b], &pose, unit, &family, random, ledger);
    });
    assert_eq!(ledger.undecided, 0, "on the grid every answer is definite");
    ledger.finish(&family, count);
}

#[test]
fn degenerate_triangles_on_a_grid() {
    let family = Family { name: "grid, without area", accuracy: OF_THE_GRID };
    let count = share(20_000, 2_000_000);
    let ledger = survey(count, 302, |random, ledger| {
        let reach = 1 + random.below(6);
        let a = GridMesh::collinear(random, reach);
        let b = match random.below(2) {
            0 => GridMesh::collinear(random, reach),
            _ => GridMesh::random(random, 1, reach),
        };
        let (pose, unit) = (GridPose::random(random, reach), unit(random, reach));
        judge_grid([&a, &b], &pose, unit, &family, random, ledger);
    });
    assert_eq!(ledger.undecided, 0, "on the grid every answer is definite");
    ledger.finish(&family, count);
}

#[test]
fn meshes_on_a_grid() {
    let family = Family { name: "grid meshes", accuracy: OF_THE_GRID };
    let count = share(300, 100_000);
    let ledger = survey(count, 301, |random, ledger| {
        let reach = 4 + random.below(20);
        let mut mesh = || {
            let triangles = 1 + random.below(40);
            GridMesh::random(random, triangles, reach)
        };
        let (a, b) = (mesh(), mesh());
        let (pose, unit) = (GridPose::random(random, 2 * reach), unit(random, reach));
        judge_grid([&a, &b], &pose, unit, &family, random, ledger);
    });
    assert_eq!(ledger.undecided, 0, "on the grid every answer is definite");
    ledger.finish(&family, count);
}
