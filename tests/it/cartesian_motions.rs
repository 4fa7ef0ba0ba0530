//! Tests of Cartesian lines and arcs (`MoveL`, `MoveC`) as joint samples: deviation between samples, and its proof.

use std::path::Path;
use std::sync::Arc;

use clearance::checker::{CollisionChecker, MotionOptions, MotionVerdict};
use clearance::geometry::math::{Point, Pose, Rotation, UnitVector, Vector};
use clearance::motion::{MotionSegment, Trajectory, sample_deviation};
use clearance::nalgebra::{DMatrix, DVector};
use clearance::robot::{Configuration, LinkId, LinkPoses, RobotModel};
use clearance::scene::{Settings, World};
use clearance::verifier::verify;

use crate::tally::shared_folder;

/// Samples of a motion, and steps of the true motion between two of them.
const SAMPLES: usize = 40;
const STEPS: usize = 16;

/// Damping of the inverse kinematics, and the step (rad) of its derivatives.
const DAMPING: f64 = 1e-8;
const DIFFERENCE: f64 = 1e-6;

struct Arm {
    robot: Arc<RobotModel>,
    link: LinkId,
    start: Configuration,
}

impl Arm {
    fn new(robot: RobotModel, link: &str, start: &[(String, f64)]) -> Self {
        let start = robot.configuration_from_names(start.iter().map(|(n, p)| (n.as_str(), *p))).unwrap();
        Self { link: robot.link_by_name(link).unwrap(), robot: Arc::new(robot), start }
    }

    fn demo() -> Self {
        let folder = Path::new("urdf/demo_arm");
        let robot = RobotModel::load(&folder.join("demo_arm.urdf"), Some(&folder.join("demo_arm.srdf")), &[]);
        let start = [0.0, 0.18, 0.0, -1.6, 0.0, 1.6, 0.3];
        let start: Vec<_> = (1..8).map(|i| format!("joint{i}")).zip(start).collect();
        Self::new(robot.unwrap(), "hand", &start)
    }

    /// The Panda of the shared robots, if they are there.
    fn panda() -> Option<Self> {
        let folder = shared_folder("robots")?;
        let text = std::fs::read_to_string(folder.join("robots.json")).unwrap();
        let list: serde_json::Value = serde_json::from_str(&text).unwrap();
        let entries = list.as_array().cloned().unwrap_or_else(|| list["robots"].as_array().unwrap().clone());
        let entry = entries.iter().find(|entry| entry["urdf"].as_str().unwrap().contains("panda"))?;
        let path = |key: &str| folder.join(entry[key].as_str().unwrap());
        let robot = RobotModel::load(&path("urdf"), Some(&path("srdf")), &[path("package_root")]).unwrap();
        let start = [0.0, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785];
        let start: Vec<_> = (1..8).map(|i| format!("panda_joint{i}")).zip(start).collect();
        Some(Self::new(robot, "panda_hand", &start))
    }

    fn pose(&self, q: &Configuration) -> Pose {
        let mut poses = LinkPoses::new(&self.robot);
        self.robot.forward_kinematics(q, &mut poses);
        *poses.pose(self.link)
    }

    /// Translation (m) and rotation (rad) from the link's pose to another one.
    fn error(&self, q: &Configuration, goal: &Pose) -> DVector<f64> {
        let pose = self.pose(q);
        let shift = goal.translation.vector - pose.translation.vector;
        let turn = (goal.rotation * pose.rotation.inverse()).scaled_axis();
        DVector::from_iterator(6, shift.iter().chain(turn.iter()).copied())
    }

    /// The state near `q` in which the link has a pose: damped least squares until it is reached.
    fn follow(&self, q: &Configuration, goal: &Pose) -> Configuration {
        let mut q = q.clone();
        for _ in 0..30 {
            let error = self.error(&q, goal);
            if error.norm() < 1e-11 {
                break;
            }
            let moved = |i: usize| {
                let mut positions = q.positions().to_vec();
                positions[i] += DIFFERENCE;
                self.robot.configuration(&positions).unwrap()
            };
            let columns: Vec<_> =
                (0..7).map(|i| (&error - self.error(&moved(i), goal)) / DIFFERENCE).collect();
            let jacobian = DMatrix::from_columns(&columns);
            let damped = &jacobian * jacobian.transpose() + DMatrix::identity(6, 6) * DAMPING;
            let step = jacobian.transpose() * damped.cholesky().unwrap().solve(&error);
            let mut positions = q.positions().to_vec();
            positions.iter_mut().zip(step.iter()).for_each(|(p, s)| *p += s);
            q = self.robot.configuration(&positions).unwrap();
        }
        assert!(self.error(&q, goal).norm() < 1e-9, "the pose is not reached");
        q
    }

    /// All states of the true motion of the link through poses by fraction.
    fn motion(&self, pose: impl Fn(f64) -> Pose) -> Vec<Configuration> {
        let mut states = vec![self.start.clone()];
        for i in 1..=SAMPLES * STEPS {
            #[expect(clippy::cast_precision_loss, reason = "small numbers")]
            let goal = pose(i as f64 / (SAMPLES * STEPS) as f64);
            states.push(self.follow(states.last().unwrap(), &goal));
        }
        states
    }

    /// A line, an arc with constant orientation, and an arc on which the link turns with it.
    fn motions(&self) -> [Vec<Configuration>; 3] {
        let start = self.pose(&self.start);
        let line = |t: f64| Pose::translation(-0.08 * t, 0.22 * t, 0.06 * t) * start;
        let centre = Point::from(start.translation.vector + Vector::new(-0.1, 0.0, 0.0));
        let turn = |t: f64| Rotation::from_axis_angle(&UnitVector::new_normalize(Vector::z()), 1.2 * t);
        let arc = |t: f64| {
            let offset = turn(t) * (Point::from(start.translation.vector) - centre);
            Pose::from_parts((centre.coords + offset).into(), start.rotation)
        };
        let turning = |t: f64| {
            let fixed = arc(t);
            Pose::from_parts(fixed.translation, turn(t) * start.rotation)
        };
        [self.motion(line), self.motion(arc), self.motion(turning)]
    }
}

fn samples(states: &[Configuration], every: usize) -> Vec<Configuration> {
    states.iter().step_by(every).cloned().collect()
}

/// Largest deviation of each position from the straight motions between samples.
fn true_deviation(states: &[Configuration], every: usize) -> Vec<f64> {
    let count = states[0].positions().len();
    let mut largest = vec![0.0_f64; count];
    for between in states.windows(every + 1).step_by(every) {
        let [a, b] = [&between[0], &between[every]].map(Configuration::positions);
        for (k, state) in between.iter().enumerate() {
            #[expect(clippy::cast_precision_loss, reason = "small numbers")]
            let t = k as f64 / every as f64;
            for i in 0..count {
                let straight = a[i] + t * (b[i] - a[i]);
                largest[i] = largest[i].max((state.positions()[i] - straight).abs());
            }
        }
    }
    largest
}

#[test]
fn lines_and_arcs_stay_within_the_deviation_of_their_samples() {
    for arm in [Some(Arm::demo()), Arm::panda()].into_iter().flatten() {
        for (number, states) in arm.motions().iter().enumerate() {
            for every in [STEPS, 2 * STEPS, 4 * STEPS] {
                let given = sample_deviation(&samples(states, every)).unwrap();
                let found = true_deviation(states, every);
                for (i, (found, given)) in found.iter().zip(&given).enumerate() {
                    let case = format!("{} motion {number} every {every} position {i}", arm.robot.name());
                    assert!(*found <= given + 1e-9, "{case}: {found} > {given}");
                }
                let [largest, most] = [&found, &given].map(|of| of.iter().copied().fold(0.0, f64::max));
                assert!(0.0 < largest && most < 0.05, "{number} {every}: {largest} {most}");
            }
        }
    }
}

/// All states of the true motion are free where the samples are proven free with the deviation.
#[test]
fn the_proof_with_the_deviation_holds_for_the_true_motion() {
    for arm in [Some(Arm::demo()), Arm::panda()].into_iter().flatten() {
        let (robot, world, settings) = (&arm.robot, World::default(), Settings::default());
        let checker = CollisionChecker::new(robot.clone(), &world, settings.clone()).unwrap();
        let mut workspace = checker.workspace();
        for states in arm.motions() {
            let samples = samples(&states, STEPS);
            let tube = sample_deviation(&samples).unwrap();
            let segments = samples.windows(2).map(|ends| MotionSegment::straight(robot, &ends[0], &ends[1]));
            let segments = segments.map(|segment| segment.with_tube(robot, tube.clone()).unwrap()).collect();
            let trajectory = Trajectory::of_segments(segments).unwrap();
            let (report, certificate) =
                checker.certify_trajectory(&trajectory, &MotionOptions::default(), &mut workspace);
            assert_eq!(report.verdict, MotionVerdict::Free, "{}", robot.name());
            verify(robot, &world, &settings, None, &certificate.unwrap()).unwrap();
            assert!(states.iter().all(|state| checker.is_free(state, &mut workspace)));
        }
    }
}
