//! Brings nearest points of two convex cores to full accuracy.
//!
//! GJK stalls near 1e-5 m on curved solids, where its simplices become thin. From where it stalled the same iteration
//! goes on here with a slower distance sub-algorithm that looks at every face of the simplex (Gilbert, Johnson &
//! Keerthi 1988), so that thin simplices lose their thin faces instead of their accuracy. The gap between supporting
//! planes tells when there is nothing left to gain.

use super::core::Core;
use crate::geometry::PointPair;
use crate::math::{Point, Pose, Vector};

/// Accuracy (m) at which refinement ends: a tenth of the contact distance.
const ACCURACY: f64 = 1e-10;

const MOST_STEPS: usize = 100;

/// A point of a less a point of b, both extreme in one direction.
#[derive(Clone, Copy, Debug)]
struct Support {
    on_a: Point,
    on_b: Point,
    difference: Vector,
}

/// Up to four points whose convex hull is looked at.
struct Simplex {
    corners: [Support; 4],
    count: usize,
}

impl Simplex {
    fn corners(&self) -> &[Support] {
        &self.corners[..self.count]
    }

    fn push(&mut self, support: Support) {
        self.corners[self.count] = support;
        self.count += 1;
    }

    /// Leaves out the corners without weight.
    fn retain(&mut self, weights: &[f64; 4]) {
        let mut kept = 0;
        for (i, weight) in weights.iter().enumerate().take(self.count) {
            if *weight > 0.0 {
                self.corners[kept] = self.corners[i];
                kept += 1;
            }
        }
        self.count = kept;
    }

    fn weighted(&self, weights: &[f64; 4], of: fn(&Support) -> Vector) -> Vector {
        let terms = self.corners().iter().zip(weights).map(|(s, w)| of(s) * *w);
        terms.sum()
    }

    fn pair(&self, weights: &[f64; 4]) -> PointPair {
        let point = |of| Point::from(self.weighted(weights, of));
        [point(|s: &Support| s.on_a.coords), point(|s: &Support| s.on_b.coords)]
    }
}

/// Nearest points from nearly nearest ones, in the frame of a, and a distance (m) that the cores have for certain.
pub(super) fn refine(a: &Core, b: &Core, pose_ab: &Pose, start: PointPair) -> (PointPair, f64) {
    let mut best = start;
    let mut least = nalgebra::distance(&start[0], &start[1]);
    let mut proven: f64 = 0.0;
    let nothing = Support { on_a: start[0], on_b: start[1], difference: start[0] - start[1] };
    let mut simplex = Simplex { corners: [nothing; 4], count: 0 };
    let mut from_b_to_a = nothing.difference;
    for _ in 0..MOST_STEPS {
        let Some(outward) = from_b_to_a.try_normalize(0.0) else {
            break;
        };
        let support = support(a, b, pose_ab, &-outward);
        proven = proven.max(outward.dot(&support.difference));
        if least - proven <= ACCURACY || simplex.count == 4 {
            break;
        }
        simplex.push(support);
        let weights = nearest_to_origin(&simplex);
        let pair = simplex.pair(&weights);
        from_b_to_a = pair[0] - pair[1];
        let apart = from_b_to_a.norm();
        if apart < least {
            (least, best) = (apart, pair);
        }
        simplex.retain(&weights);
    }
    (best, proven)
}

/// The points of a and b farthest along `direction` and against it.
fn support(a: &Core, b: &Core, pose_ab: &Pose, direction: &Vector) -> Support {
    let on_a = a.support(direction);
    let on_b = pose_ab * b.support(&-(pose_ab.rotation.inverse() * direction));
    Support { on_a, on_b, difference: on_a - on_b }
}

/// Weights of the point of the simplex nearest to the origin: the best over all faces that have it inside.
fn nearest_to_origin(simplex: &Simplex) -> [f64; 4] {
    let mut best = ([0.0; 4], f64::INFINITY);
    for face in 1u32..(1 << simplex.count) {
        let Some(weights) = weights_inside(simplex, face) else {
            continue;
        };
        let norm = simplex.weighted(&weights, |s| s.difference).norm();
        if norm < best.1 {
            best = (weights, norm);
        }
    }
    best.0
}

/// Weights of the point nearest to the origin on the plane through the corners of a face (a bit each), if it lies inside the
/// face.
fn weights_inside(simplex: &Simplex, face: u32) -> Option<[f64; 4]> {
    let mut members = [0; 4];
    let mut count = 0;
    for i in (0..simplex.count).filter(|i| face & (1 << i) != 0) {
        members[count] = i;
        count += 1;
    }
    let corner = simplex.corners[members[0]].difference;
    let edge = |k: usize| simplex.corners[members[k]].difference - corner;
    let along = |e: &Vector| -e.dot(&corner);
    let mut weights = [0.0; 4];
    match count {
        1 => {}
        2 => weights[members[1]] = along(&edge(1)) / edge(1).norm_squared(),
        3 => {
            let (e, f) = (edge(1), edge(2));
            let (ee, ef, ff) = (e.norm_squared(), e.dot(&f), f.norm_squared());
            let area = e.cross(&f).norm_squared();
            weights[members[1]] = (ff * along(&e) - ef * along(&f)) / area;
            weights[members[2]] = (ee * along(&f) - ef * along(&e)) / area;
        }
        _ => {
            let matrix = nalgebra::Matrix3::from_columns(&[edge(1), edge(2), edge(3)]);
            let rest = matrix.lu().solve(&-corner)?;
            for k in 1..4 {
                weights[members[k]] = rest[k - 1];
            }
        }
    }
    weights[members[0]] = 1.0 - weights.iter().sum::<f64>();
    members[..count].iter().all(|&i| weights[i] >= 0.0).then_some(weights)
}
