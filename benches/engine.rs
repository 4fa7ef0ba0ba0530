//! `cargo bench --bench engine`: times of state checks and least distances, compared with the tests' reference engine,
//! on the bundled robots.
//!
//! Both answer the same states in the same run, in turn; CPU time of the thread, median of the rounds. Ratios are what counts.
//! `benches/peers` compares with other libraries.

#[allow(dead_code)]
#[path = "../tests/it/random.rs"]
mod random;
#[path = "../tests/it/reference/mod.rs"]
mod reference;

use std::hint::black_box;
use std::path::Path;
use std::sync::Arc;

use clearance::geometry::math::Pose;
use clearance::robot::{LinkId, LinkPoses};
use clearance::scene::BodyId;
use clearance::{CollisionChecker, Configuration, Question, RobotModel, Settings, World};
use cpu_time::ThreadTime;

use random::Random;
use reference::ReferenceBody;

const ROUNDS: usize = 15;
const STATES: usize = 200;

/// The slow path: every pair, one after the other, kinematics included.
struct Reference {
    robot: Arc<RobotModel>,
    bodies: Vec<Option<ReferenceBody>>,
    pairs: Vec<(LinkId, LinkId)>,
}

impl Reference {
    fn new(checker: &CollisionChecker) -> Self {
        let robot = Arc::clone(checker.robot());
        let body = |l: &clearance::robot::Link| {
            let shapes = || l.collisions.iter().map(|c| (&c.pose_ls, &c.shape));
            (!l.collisions.is_empty()).then(|| ReferenceBody::new(shapes()))
        };
        Self {
            bodies: robot.links().iter().map(body).collect(),
            pairs: checker.pairs().link_pairs().collect(),
            robot,
        }
    }

    fn each_pair(
        &self,
        q: &Configuration,
        mut ask: impl FnMut(&ReferenceBody, &ReferenceBody, &Pose) -> bool,
    ) {
        let mut poses = LinkPoses::new(&self.robot);
        self.robot.forward_kinematics(q, &mut poses);
        for &(a, b) in &self.pairs {
            let (Some(x), Some(y)) = (&self.bodies[a.index()], &self.bodies[b.index()]) else { continue };
            if ask(x, y, &poses.pose(a).inv_mul(poses.pose(b))) {
                return;
            }
        }
    }

    fn is_free(&self, q: &Configuration) -> bool {
        let mut free = true;
        self.each_pair(q, |a, b, pose_ab| {
            free = reference::collide(a, b, pose_ab).is_none();
            !free
        });
        free
    }

    fn distance(&self, q: &Configuration) -> f64 {
        let mut least = f64::INFINITY;
        self.each_pair(q, |a, b, pose_ab| {
            least = reference::distance(a, b, pose_ab, least).map_or(least, |s| s.distance.min(least));
            least == 0.0
        });
        least
    }
}

fn checker(name: &str) -> CollisionChecker {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let path = |kind: &str| root.join(format!("urdf/{name}/{name}.{kind}"));
    let robot = RobotModel::load(&path("urdf"), Some(&path("srdf")), &[]).expect("a bundled robot loads");
    CollisionChecker::new(Arc::new(robot), &World::default(), Settings::default())
        .expect("settings are sound")
}

fn random_states(checker: &CollisionChecker, random: &mut Random) -> Vec<Configuration> {
    let robot = checker.robot();
    let state = |_| {
        let positions: Vec<f64> = (robot.joint_ids())
            .filter(|j| robot.first_position(*j).is_some())
            .map(|j| robot.joint(j).limits.map_or(0.0, |l| random.within(l.lower, l.upper)))
            .collect();
        robot.configuration(&positions).expect("within limits")
    };
    (0..STATES).map(state).collect()
}

/// Microseconds a state of each contestant: the median of the rounds, in which all take their turn.
#[allow(clippy::cast_precision_loss)] // few states
fn race(contestants: &mut [(&str, &mut dyn FnMut())]) -> Vec<f64> {
    let mut times = vec![Vec::new(); contestants.len()];
    for _ in 0..ROUNDS {
        for ((_, pass), times) in contestants.iter_mut().zip(&mut times) {
            let start = ThreadTime::now();
            pass();
            times.push(start.elapsed().as_secs_f64() * 1e6 / STATES as f64);
        }
    }
    let median = |mut times: Vec<f64>| {
        times.sort_by(f64::total_cmp);
        times[times.len() / 2]
    };
    times.into_iter().map(median).collect()
}

fn print_row(robot: &str, question: &str, contestants: &mut [(&str, &mut dyn FnMut())]) {
    let medians = race(contestants);
    let slow = medians[0];
    for ((name, _), time) in contestants.iter().zip(&medians) {
        println!("{robot:10} {question:9} {name:12} {time:10.3} µs a state {:8.1}x", slow / time);
    }
}

fn main() {
    for name in ["demo_arm", "dual_arm"] {
        let checker = checker(name);
        let slow = Reference::new(&checker);
        let states = random_states(&checker, &mut Random::new(7));
        let mut workspace = checker.workspace();
        let least = Question::Distance { limit: f64::INFINITY };
        for q in &states {
            let report = checker.check(q, least, &mut workspace);
            assert_eq!(slow.is_free(q), report.is_free());
            let nearest = report.nearest.expect("nothing is farther than infinity");
            assert!(
                matches!(nearest.b, BodyId::Link(_)) && (slow.distance(q) - nearest.distance).abs() < 1e-9
            );
        }
        let mut single = checker.workspace();
        let mut batch = checker.workspace();
        let mut free = vec![false; states.len()];
        print_row(
            name,
            "free",
            &mut [
                ("reference", &mut || each(&states, |q| slow.is_free(q))),
                ("is_free", &mut || each(&states, |q| checker.is_free(q, &mut single))),
                ("batch", &mut || checker.are_free_with(&states, &mut batch, black_box(&mut free))),
            ],
        );
        print_row(
            name,
            "distance",
            &mut [
                ("reference", &mut || each(&states, |q| slow.distance(q))),
                ("check", &mut || each(&states, |q| checker.check(q, least, &mut workspace))),
            ],
        );
    }
}

fn each<T>(states: &[Configuration], mut ask: impl FnMut(&Configuration) -> T) {
    for q in states {
        black_box(ask(q));
    }
}
