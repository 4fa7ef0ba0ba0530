//! Tests of proven decisions against random states, and against a search that brings links as near to each other as it
//! can.

use std::path::Path;
use std::sync::Arc;
use std::time::{Duration, Instant};

use clearance_checker::{CollisionChecker, Question};
use clearance_collision_matrix::{DecidedPair, Decision, MatrixBuilder, MatrixDocument, MatrixOptions};
use clearance_robot::RobotModel;
use clearance_scene::{AllowedCollisionMatrix, BodyId, Settings, World};
use clearance_verifier::MatrixVerifier;
use fastrand::Rng;

/// Robots of the shared folder: name, URDF.
const SHARED: [(&str, &str); 4] = [
    ("panda", "moveit_resources_panda_description/urdf/panda.urdf"),
    ("ur5e", "ur_description/urdf/ur5e.urdf"),
    ("iiwa14", "kuka_lbr_iiwa_support/urdf/lbr_iiwa_14_r820.urdf"),
    ("baxter", "baxter_description/urdf/baxter.urdf"),
];

/// Limits of a comparison.
#[derive(Clone, Copy)]
struct Amount {
    states: u64,
    time: Duration,
    /// Starts of the search for each pair.
    starts: usize,
}

/// Numbers of comparisons.
#[derive(Debug, Default)]
struct Counts {
    states: u64,
    never: usize,
    always: usize,
    descents: usize,
    least_distance: f64,
}

/// A pair of bodies whose decision is proven.
struct ProvenPair<'p> {
    pair: &'p DecidedPair,
    bodies: (BodyId, BodyId),
    collides: bool,
}

struct Comparison<'r> {
    robot: &'r Arc<RobotModel>,
    checker: CollisionChecker,
    proven: Vec<ProvenPair<'r>>,
}

impl<'r> Comparison<'r> {
    /// Keeps the pairs that the checker checks: links that move relative to each other.
    fn new(robot: &'r Arc<RobotModel>, pairs: &'r [DecidedPair]) -> Self {
        let all = AllowedCollisionMatrix::default();
        let (world, settings) = (World::default(), Settings::default());
        let checker = CollisionChecker::with_matrix(Arc::clone(robot), &world, settings, Some(&all)).unwrap();
        let body = |name: &str| {
            robot.link_ids().find(|link| robot.described_name(*link) == name).map(BodyId::Link).unwrap()
        };
        let moves = |pair: &&DecidedPair| pair.variables > 0;
        let proven = pairs.iter().filter(moves).filter_map(|pair| {
            let collides = match pair.decision {
                Decision::Never { .. } => false,
                Decision::Always { .. } => true,
                Decision::Sometimes { .. } | Decision::Undecided { .. } => return None,
            };
            Some(ProvenPair { pair, bodies: (body(&pair.link1), body(&pair.link2)), collides })
        });
        let proven = proven.collect();
        Self { robot, checker, proven }
    }

    /// Random states; every fourth has some positions at their limits.
    fn random_states(&self, amount: &Amount, counts: &mut Counts) {
        let (mut random, end) = (Rng::with_seed(11), Instant::now() + amount.time);
        let mut workspace = self.checker.workspace();
        let ranges = self.robot.sampling_ranges();
        while counts.states < amount.states && Instant::now() < end {
            let mut q = self.robot.random_configuration(&mut random);
            if counts.states.is_multiple_of(4) {
                let at_limits =
                    q.positions().iter().zip(&ranges).map(|(value, [low, high])| match random.u8(0..4) {
                        0 if low.is_finite() => *low,
                        1 if high.is_finite() => *high,
                        _ => *value,
                    });
                let positions: Vec<f64> = at_limits.collect();
                q = self.robot.configuration(&positions).unwrap_or(q);
            }
            let report = self.checker.check(&q, Question::Pairs, &mut workspace);
            for ProvenPair { pair, bodies: (a, b), collides } in &self.proven {
                let found = report.colliding_pairs.iter().any(|p| *p == (*a, *b) || *p == (*b, *a));
                assert_eq!(found, *collides, "{} – {} at {:?}", pair.link1, pair.link2, q.positions());
            }
            counts.states += 1;
        }
    }

    /// Brings the links of each pair that never collides as near to each other as steps along the derivative of their distance can.
    fn descents(&self, amount: &Amount, counts: &mut Counts) {
        let mut random = Rng::with_seed(12);
        counts.least_distance = f64::INFINITY;
        for proven in self.proven.iter().filter(|proven| !proven.collides) {
            for _ in 0..amount.starts {
                let distance = self.descend(proven, &mut random);
                counts.descents += 1;
                counts.least_distance = counts.least_distance.min(distance);
                assert!(distance > 0.0, "{} – {}", proven.pair.link1, proven.pair.link2);
            }
        }
    }

    fn descend(&self, proven: &ProvenPair, random: &mut Rng) -> f64 {
        let ranges = self.robot.sampling_ranges();
        let mut workspace = self.checker.workspace();
        let mut evaluate = |positions: &[f64]| {
            let q = self.robot.configuration(positions).ok()?;
            let found = self.checker.clearance_of_pairs(&q, &[proven.bodies], None, &mut workspace);
            Some((found.pairs.first()?.distance, found.row(0).to_vec()))
        };
        let mut positions = self.robot.random_configuration(random).positions().to_vec();
        let Some((mut distance, mut slopes)) = evaluate(&positions) else { return f64::INFINITY };
        let mut scale = 1.0;
        while scale > 1e-3 && distance > 0.0 {
            let squared: f64 = slopes.iter().map(|slope| slope * slope).sum();
            if squared < 1e-12 {
                break;
            }
            let step = scale * (distance / squared).min(0.5 / squared.sqrt());
            let moved = positions.iter().zip(&slopes).zip(&ranges);
            let next: Vec<f64> =
                moved.map(|((q, slope), [low, high])| (q - step * slope).clamp(*low, *high)).collect();
            match evaluate(&next) {
                Some((there, then)) if there < distance * (1.0 - 1e-6) => {
                    (positions, distance, slopes) = (next, there, then);
                    scale = (1.5f64 * scale).min(1.0);
                }
                _ => scale *= 0.5,
            }
        }
        distance
    }
}

fn compare(robot: &Arc<RobotModel>, amount: &Amount) -> Counts {
    let settings = Settings::default();
    let builder = MatrixBuilder::new(robot, &settings).unwrap();
    let started = Instant::now();
    let pairs = builder.decide(&[], &MatrixOptions::default(), &|_| {});
    let decided = started.elapsed();
    let document = MatrixDocument::new(robot, &settings, pairs.clone());
    let certificate = document.certificate(robot, &settings);
    let verifier = MatrixVerifier::new(robot, &settings).unwrap();
    for proof in &certificate.always {
        let verified = verifier.verify_always(proof);
        let boxes = verified.unwrap_or_else(|rejection| panic!("{rejection}"));
        assert!(boxes > 0);
    }
    let of = |name: &str| pairs.iter().filter(|pair| pair.decision.name() == name).count();
    println!(
        "{}: {} never, {} always, {} undecided, decided in {:.1} s",
        robot.name(),
        of("never"),
        of("always"),
        of("undecided"),
        decided.as_secs_f64()
    );
    for pair in pairs.iter().filter(|pair| pair.decision.name() == "undecided") {
        println!("  undecided: {} – {}, in contact in {}", pair.link1, pair.link2, pair.contact_share);
    }
    let comparison = Comparison::new(robot, &pairs);
    let count =
        |collides: bool| comparison.proven.iter().filter(|proven| proven.collides == collides).count();
    let mut counts = Counts { never: count(false), always: count(true), ..Counts::default() };
    comparison.random_states(amount, &mut counts);
    comparison.descents(amount, &mut counts);
    counts
}

fn demo() -> Arc<RobotModel> {
    let urdf = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../urdf/demo_arm/demo_arm.urdf");
    Arc::new(RobotModel::load(&urdf, None, &[]).unwrap())
}

#[test]
fn random_states_agree_with_the_proofs() {
    let amount = Amount { states: 3000, time: Duration::from_secs(600), starts: 1 };
    let counts = compare(&demo(), &amount);
    assert!(counts.states == 3000 && counts.never > 20 && counts.always > 2, "{counts:?}");
    assert!(counts.descents == counts.never && counts.least_distance < 0.1, "{counts:?}");
}

/// By hand: `cargo test --release -p clearance-collision-matrix -- --ignored --nocapture many_random_states`.
/// `CLEARANCE_SECONDS` is the time for the random states of one robot.
#[test]
#[ignore = "takes minutes"]
fn many_random_states() {
    let seconds = std::env::var("CLEARANCE_SECONDS").ok().and_then(|text| text.parse().ok()).unwrap_or(120);
    let amount = Amount { states: 10_000_000, time: Duration::from_secs(seconds), starts: 20 };
    println!("demo arm: {:?}", compare(&demo(), &amount));
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/robots");
    for (name, urdf) in SHARED {
        let urdf = folder.join(urdf);
        if !urdf.is_file() {
            println!("NOT TESTED: {} is not here", urdf.display());
            continue;
        }
        let robot = Arc::new(RobotModel::load(&urdf, None, std::slice::from_ref(&folder)).unwrap());
        println!("{name}: {:?}", compare(&robot, &amount));
    }
}
