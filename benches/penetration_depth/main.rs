//! Benchmark of penetration depths and contacts: accuracy, bounds, times and checked properties, as one table.
//!
//! `cargo bench --bench penetration_depth`, pinned to one core by `taskset -c 1`; with `-- --short` a hundredth of the poses. Ends with 1
//! if a property does not hold.

#[path = "../../tests/it/random.rs"]
#[allow(dead_code)] // the tests use the rest
mod random;

mod convex;
mod shapes;

use std::process::ExitCode;
use std::sync::Arc;
use std::time::Instant;

use clearance::geometry::math::{MatrixPose, Pose};
use clearance::geometry::{Shape, TriangleMesh};
use clearance::proximity::{
    BodyPair, CollisionBody, ContactQuery, DeepestContact, PenetrationDepth, Scratch, SolidBody, collide,
    contact_points, penetration_depth,
};

use convex::{ConvexErrors, convex_errors};
use random::Random;
use shapes::{Body, meshes};

/// Largest relative error of the depth of convex pairs.
const CONVEX_ERROR: f64 = 1e-6;

/// Contacts that are searched besides the deepest.
const CONTACTS: usize = 8;

/// Numbers of poses.
struct Extent {
    convex: usize,
    bounds: usize,
    times: usize,
    laws: usize,
}

fn main() -> ExitCode {
    let is_short = std::env::args().any(|argument| argument == "--short");
    let share = if is_short { 100 } else { 1 };
    let extent = Extent {
        convex: 10_000 / share,
        bounds: 10_000 / share,
        times: 1000 / share,
        laws: 1_000_000 / share,
    };
    let mut is_right = true;
    println!("\ndepth of convex pairs: largest relative error of the upper and lower bound");
    for ConvexErrors { name, pairs, largest: [upper, lower] } in convex_errors(extent.convex) {
        println!("  {name:26} {pairs} pairs: upper {upper:.1e}, lower {lower:.1e}");
        is_right &= upper <= CONVEX_ERROR && lower <= CONVEX_ERROR;
    }
    println!(
        "\nclosed meshes with dents, one thread: preparation and first query, median query, bounds, contacts"
    );
    for triangles in [1_000, 10_000, 100_000] {
        times(triangles, extent.times);
    }
    println!("\nbounds of {} overlapping poses of meshes of 1000 triangles", extent.bounds);
    bounds(extent.bounds);
    println!(
        "\nlaws: after the upper bound the bodies are apart, after less than the lower bound they never are"
    );
    is_right &= laws(extent.laws);
    ExitCode::from(u8::from(!is_right))
}

/// Sorted values at a share of their number.
#[allow(clippy::cast_possible_truncation, clippy::cast_precision_loss, clippy::cast_sign_loss)] // small numbers
fn quantile(values: &mut [f64], share: f64) -> f64 {
    values.sort_by(f64::total_cmp);
    values[((values.len() - 1) as f64 * share) as usize]
}

/// Calls `measure` for so many pairs of overlapping bodies.
fn for_overlapping(
    bodies: &[Body],
    (count, seed): (usize, u64),
    mut measure: impl FnMut(&Body, &Body, &MatrixPose, &mut Random, &mut Scratch),
) {
    let (mut random, mut scratch) = (Random::new(seed), Scratch::default());
    let number = u32::try_from(bodies.len()).expect("few bodies");
    let mut left = count;
    while left > 0 {
        let [a, b] = [(); 2].map(|()| &bodies[random.below(number) as usize]);
        let pose = MatrixPose::from(&Pose::from_parts(random.vector(0.7).into(), random.rotation()));
        if collide(&a.surface, &b.surface, pose, &mut scratch).is_some() {
            left -= 1;
            measure(a, b, &pose, &mut random, &mut scratch);
        }
    }
}

fn moved(pose: &MatrixPose, depth: &PenetrationDepth, length: f64) -> MatrixPose {
    MatrixPose { translation: pose.translation + depth.direction * length, ..*pose }
}

fn times(triangles: u32, poses: usize) {
    let start = Instant::now();
    let bodies = meshes(triangles).map(Body::new);
    let built = start.elapsed().as_secs_f64() / 3.0 * 1e3;
    let firsts = bodies.iter().map(first_query).fold(0.0, f64::max);
    let (mut of_depth, mut of_contacts, mut ratios) = (Vec::new(), Vec::new(), Vec::new());
    for_overlapping(&bodies, (poses, 5), |a, b, pose, _, scratch| {
        let start = Instant::now();
        let depth = penetration_depth(&a.solid, &b.solid, pose, 0.0, scratch).expect("the bodies overlap");
        of_depth.push(start.elapsed().as_secs_f64() * 1e3);
        ratios.push(depth.upper / depth.lower);
        let start = Instant::now();
        let query = ContactQuery {
            bodies: BodyPair { a: &a.surface, b: &b.surface, pose_ab: pose },
            solids: [&a.solid, &b.solid],
            margin: 0.0,
            deepest: DeepestContact {
                witness_points: depth.witness_points,
                normal: Some(depth.direction),
                depth: depth.upper,
            },
        };
        std::hint::black_box(contact_points(&query, CONTACTS, scratch));
        of_contacts.push(start.elapsed().as_secs_f64() * 1e3);
    });
    println!(
        "  {triangles:6} triangles: built in {built:.1} ms, longest first query {firsts:.1} ms; depth: median {:.3} ms, p90 {:.3} ms, \
         upper/lower: median {:.3}, p90 {:.3}; {CONTACTS} contacts: median {:.3} ms, longest {:.3} ms",
        quantile(&mut of_depth, 0.5),
        quantile(&mut of_depth, 0.9),
        quantile(&mut ratios, 0.5),
        quantile(&mut ratios, 0.9),
        quantile(&mut of_contacts, 0.5),
        quantile(&mut of_contacts, 1.0),
    );
}

/// Time (ms) from the hierarchies of the checker to the first depth of a body in itself.
fn first_query(body: &Body) -> f64 {
    // a mesh of its own, of which nothing is prepared
    let mesh = TriangleMesh::new(body.mesh.vertices().to_vec(), body.mesh.triangles().to_vec());
    let shape = Shape::Mesh(Arc::new(mesh.expect("a valid mesh")));
    let shapes = [(&Pose::identity(), &shape)];
    let surface = CollisionBody::new(shapes).expect("a body with a shape");
    let start = Instant::now();
    let [a, b] = [(); 2].map(|()| SolidBody::of_body(&surface, shapes));
    let pose = MatrixPose::from(&Pose::translation(0.1, 0.0, 0.0));
    std::hint::black_box(penetration_depth(&a, &b, pose, 0.0, &mut Scratch::default()));
    start.elapsed().as_secs_f64() * 1e3
}

fn bounds(poses: usize) {
    let bodies = meshes(1_000).map(Body::new);
    let mut ratios = Vec::new();
    for_overlapping(&bodies, (poses, 6), |a, b, pose, _, scratch| {
        let depth = penetration_depth(&a.solid, &b.solid, pose, 0.0, scratch).expect("the bodies overlap");
        ratios.push(depth.upper / depth.lower);
    });
    println!(
        "  upper/lower: median {:.3}, p90 {:.3}, p99 {:.3}",
        quantile(&mut ratios, 0.5),
        quantile(&mut ratios, 0.9),
        quantile(&mut ratios, 0.99)
    );
}

/// On all processors; each pose is moved by the upper bound, and in two directions by a little less than the lower one.
fn laws(poses: usize) -> bool {
    let bodies = &meshes(1_000).map(Body::new);
    let threads = std::thread::available_parallelism().map_or(1, std::num::NonZero::get);
    let broken: usize = std::thread::scope(|scope| {
        let workers: Vec<_> = (0..threads)
            .map(|number| {
                let count = poses * (number + 1) / threads - poses * number / threads;
                scope.spawn(move || broken_laws(bodies, count, 7 + number as u64))
            })
            .collect();
        workers.into_iter().map(|worker| worker.join().expect("the measurement ends")).sum()
    });
    println!("  {poses} poses: {broken} broken");
    broken == 0
}

fn broken_laws(bodies: &[Body], poses: usize, seed: u64) -> usize {
    let mut broken = 0;
    for_overlapping(bodies, (poses, seed), |a, b, pose, random, scratch| {
        let depth = penetration_depth(&a.solid, &b.solid, pose, 0.0, scratch).expect("the bodies overlap");
        let apart = collide(&a.whole, &b.whole, moved(pose, &depth, depth.upper), scratch).is_none();
        let less = depth.lower * (1.0 - 1e-9) - 1e-8;
        let aside = random.vector(1.0).normalize();
        let still = [depth.direction, aside].iter().all(|n| {
            let translation = pose.translation + n * less.max(0.0);
            collide(&a.whole, &b.whole, MatrixPose { translation, ..*pose }, scratch).is_some()
        });
        if !apart || !still {
            println!(
                "  apart after the upper bound: {apart}; in contact before the lower one: {still}; {pose:?} {depth:?}"
            );
            broken += 1;
        }
    });
    broken
}
