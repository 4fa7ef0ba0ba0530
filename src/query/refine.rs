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

/// Nearest points from nearly nearest ones, in the frame of a, and a distance (m) that the cores have for certain.
pub(super) fn refine(a: &Core, b: &Core, pose_ab: &Pose, start: PointPair) -> (PointPair, f64) {
    let mut best = start;
    let mut least = nalgebra::distance(&start[0], &start[1]);
    let mut proven: f64 = 0.0;
    let mut simplex = vec![];
    let mut from_b_to_a = start[0] - start[1];
    for _ in 0..MOST_STEPS {
        let Some(outward) = from_b_to_a.try_normalize(0.0) else {
            break;
        };
        let support = support(a, b, pose_ab, &-outward);
        proven = proven.max(outward.dot(&support.difference));
        if least - proven <= ACCURACY || simplex.len() == 4 {
            break;
        }
        simplex.push(support);
        let weights = nearest_to_origin(&simplex);
        let pair = weighted(&simplex, &weights);
        from_b_to_a = pair[0] - pair[1];
        let apart = from_b_to_a.norm();
        if apart < least {
            (least, best) = (apart, pair);
        }
        let mut kept = weights.iter().map(|w| *w > 0.0);
        simplex.retain(|_| kept.next().unwrap_or(false));
    }
    (best, proven)
}

/// The points of a and b farthest along `direction` and against it.
fn support(a: &Core, b: &Core, pose_ab: &Pose, direction: &Vector) -> Support {
    let on_a = a.support(direction);
    let on_b = pose_ab * b.support(&-(pose_ab.rotation.inverse() * direction));
    Support { on_a, on_b, difference: on_a - on_b }
}

fn weighted(simplex: &[Support], weights: &[f64; 4]) -> PointPair {
    let sum = |point: fn(&Support) -> Vector| {
        let terms = simplex.iter().zip(weights).map(|(s, w)| point(s) * *w);
        Point::from(terms.sum::<Vector>())
    };
    [sum(|s| s.on_a.coords), sum(|s| s.on_b.coords)]
}

/// Weights of the point of the simplex nearest to the origin: the best over all faces that have it inside.
fn nearest_to_origin(simplex: &[Support]) -> [f64; 4] {
    let mut best = ([0.0; 4], f64::INFINITY);
    for face in 1u32..(1 << simplex.len()) {
        let members: Vec<usize> = (0..simplex.len()).filter(|i| face & (1 << i) != 0).collect();
        let Some(inside) = weights_inside(simplex, &members) else {
            continue;
        };
        let mut weights = [0.0; 4];
        for (&i, w) in members.iter().zip(inside) {
            weights[i] = w;
        }
        let terms = simplex.iter().zip(weights);
        let norm = terms.map(|(s, w)| s.difference * w).sum::<Vector>().norm();
        if norm < best.1 {
            best = (weights, norm);
        }
    }
    best.0
}

/// Weights of the point nearest to the origin on the plane through a face's corners, if it lies inside the face.
fn weights_inside(simplex: &[Support], members: &[usize]) -> Option<Vec<f64>> {
    let (first, others) = members.split_first()?;
    let corner = simplex[*first].difference;
    let edges: Vec<Vector> = others.iter().map(|&i| simplex[i].difference - corner).collect();
    let along = |i: usize| -edges[i].dot(&corner);
    let rest = match edges[..] {
        [] => vec![],
        [e] => vec![along(0) / e.norm_squared()],
        [e, f] => {
            let (ee, ef, ff) = (e.norm_squared(), e.dot(&f), f.norm_squared());
            let area = e.cross(&f).norm_squared();
            vec![(ff * along(0) - ef * along(1)) / area, (ee * along(1) - ef * along(0)) / area]
        }
        _ => {
            let matrix = nalgebra::Matrix3::from_columns(&edges);
            (matrix.lu().solve(&-corner)?).iter().copied().collect()
        }
    };
    let weights: Vec<f64> = std::iter::once(1.0 - rest.iter().sum::<f64>()).chain(rest).collect();
    weights.iter().all(|w| *w >= 0.0).then_some(weights)
}
