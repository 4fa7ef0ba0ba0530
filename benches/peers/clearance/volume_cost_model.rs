//! Cost model of bounding volume types: number and cost of the volume and primitive tests of a query.

use std::collections::BTreeMap;
use std::hint::black_box;
use std::sync::Arc;

use clearance::geometry::math::Pose;
use clearance::geometry::{Shape, TriangleMesh, VolumeKind};
use clearance::proximity::{CollisionBody, Scratch, collide, distance};

/// Repetitions of a query whose time is taken; the fastest counts.
const REPEATS: usize = 5;

/// One line of the cost model `T = N_bv * C_bv + N_p * C_p`, in the mean of the poses.
pub struct Cost {
    pub volume: &'static str,
    pub question: &'static str,
    pub volume_tests: f64,
    pub volume_test_ns: f64,
    pub primitive_tests: f64,
    pub primitive_test_ns: f64,
}

/// Of every volume type, for "free" and "distance", over all poses of two meshes (by gap).
pub fn cost_model(meshes: &[Arc<TriangleMesh>; 2], poses: &BTreeMap<&str, Vec<Pose>>) -> Vec<Cost> {
    let poses: Vec<&Pose> = poses.values().flatten().collect();
    VolumeKind::ALL.into_iter().flat_map(|kind| costs(kind, meshes, &poses)).collect()
}

fn costs(kind: VolumeKind, meshes: &[Arc<TriangleMesh>; 2], poses: &[&Pose]) -> Vec<Cost> {
    let body = |mesh: &Arc<TriangleMesh>| {
        let shape = Shape::Mesh(Arc::clone(mesh));
        Some(CollisionBody::new([(&Pose::identity(), &shape)])?.with_volumes_of(kind, &[kind]))
    };
    let (Some(a), Some(b)) = (body(&meshes[0]), body(&meshes[1])) else { return Vec::new() };
    let free = measure(poses, |pose, scratch| {
        black_box(collide(&a, &b, pose, scratch));
    });
    let far = measure(poses, |pose, scratch| {
        black_box(distance(&a, &b, pose, f64::INFINITY, scratch));
    });
    [("free", free), ("distance", far)]
        .map(|(question, samples)| fitted(kind.name(), question, &samples))
        .into()
}

/// Volume tests, pairs of triangles screened, and the time (ns) that a query took.
type Sample = [f64; 3];

#[allow(clippy::cast_precision_loss)] // counts of work
fn measure(poses: &[&Pose], mut query: impl FnMut(&Pose, &mut Scratch)) -> Vec<Sample> {
    let mut scratch = Scratch::default();
    let sample = |pose: &&Pose| {
        let mut least = f64::INFINITY;
        for _ in 0..REPEATS {
            scratch.work = clearance::proximity::Work::default();
            let start = std::time::Instant::now();
            query(pose, &mut scratch);
            least = least.min(start.elapsed().as_secs_f64() * 1e9);
        }
        [scratch.work.volume_tests as f64, scratch.work.screened_pairs as f64, least]
    };
    poses.iter().map(sample).collect()
}

/// Least squares of the times over the counts, neither cost below zero.
#[allow(clippy::cast_precision_loss)] // counts of poses
fn fitted(volume: &'static str, question: &'static str, samples: &[Sample]) -> Cost {
    let sum = |f: fn(&Sample) -> f64| samples.iter().map(f).sum::<f64>();
    let (vv, pp, vp) = (sum(|s| s[0] * s[0]), sum(|s| s[1] * s[1]), sum(|s| s[0] * s[1]));
    let (vt, pt) = (sum(|s| s[0] * s[2]), sum(|s| s[1] * s[2]));
    let determinant = vv * pp - vp * vp;
    let both = ((vt * pp - pt * vp) / determinant, (pt * vv - vt * vp) / determinant);
    let (volume_test_ns, primitive_test_ns) = match both {
        (v, p) if v >= 0.0 && p >= 0.0 => (v, p),
        (_, p) if p >= 0.0 => (0.0, pt / pp),
        _ => (vt / vv, 0.0),
    };
    let mean = |total: f64| total / samples.len().max(1) as f64;
    Cost {
        volume,
        question,
        volume_tests: mean(sum(|s| s[0])),
        volume_test_ns,
        primitive_tests: mean(sum(|s| s[1])),
        primitive_test_ns,
    }
}
