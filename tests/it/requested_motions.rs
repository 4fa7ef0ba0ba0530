//! Tests that the checked motion is the requested one: random robots with mimic, continuous and prismatic joints.
//!
//! `CLEARANCE_RANDOM_ROBOTS` sets the number of robots of the test of the library; the command line gets a hundredth of them.

use std::fmt::Write;
use std::sync::Arc;

use clearance::geometry::math::{Point, Pose, Rotation, UnitVector, Vector};
use clearance::{
    CollisionChecker, MeshFiles, MotionOptions, MotionSegment, MotionVerdict, Obstacle, Primitive,
    RobotModel, Settings, Shape, World,
};

use crate::program::Folder;
use crate::random::Random;

/// Radius (m) of the ball at the end of the chain, and of the obstacle.
const RADIUS: f64 = 0.05;
/// Samples of a requested motion; between two of them nothing moves farther than `1e-2` of its largest distance.
const SAMPLES: u32 = 4000;

struct Mimic {
    of: usize,
    multiplier: f64,
    offset: f64,
}

/// A joint of a chain; its child link begins at `origin` in the frame of its parent.
struct Joint {
    kind: &'static str,
    axis: Vector,
    origin: Vector,
    mimic: Option<Mimic>,
}

/// A chain of joints with a ball at its end.
struct ChainRobot {
    joints: Vec<Joint>,
}

impl ChainRobot {
    fn random(random: &mut Random) -> Self {
        let count = 2 + random.below(5) as usize;
        let mut joints = Vec::new();
        for i in 0..count {
            let kind = ["revolute", "continuous", "prismatic"][random.below(3) as usize];
            let mimic = (i > 0 && random.below(2) == 0).then(|| Mimic {
                of: random.below(u32::try_from(i).unwrap()) as usize,
                multiplier: [0.0, 1.0, -0.5, 2.0, -3.0, random.within(-2.0, 2.0)][random.below(6) as usize],
                offset: [0.0, random.within(-1.0, 1.0)][random.below(2) as usize],
            });
            let axis = [Vector::x(), Vector::y(), Vector::z(), random.vector(1.0)][random.below(4) as usize];
            joints.push(Joint { kind, axis: axis.normalize(), origin: random.vector(0.4), mimic });
        }
        Self { joints }
    }

    fn urdf(&self) -> String {
        let mut urdf = "<robot name='r'><link name='base'/>".to_owned();
        for (i, joint) in self.joints.iter().enumerate() {
            let parent = if i == 0 { "base".to_owned() } else { format!("l{}", i - 1) };
            let geometry = if i + 1 == self.joints.len() {
                format!("<collision><geometry><sphere radius='{RADIUS}'/></geometry></collision>")
            } else {
                String::new()
            };
            let Joint { kind, axis, origin, mimic } = joint;
            let limit = "<limit lower='-500' upper='500' effort='1' velocity='1'/>";
            let mimic = mimic.as_ref().map_or(String::new(), |Mimic { of, multiplier, offset }| {
                format!("<mimic joint='j{of}' multiplier='{multiplier:?}' offset='{offset:?}'/>")
            });
            let triple = |v: &Vector| format!("{:?} {:?} {:?}", v.x, v.y, v.z);
            write!(
                urdf,
                "<link name='l{i}'>{geometry}</link><joint name='j{i}' type='{kind}'><parent link='{parent}'/><child link='l{i}'/>\
                 <origin xyz='{}'/><axis xyz='{}'/>{limit}{mimic}</joint>",
                triple(origin),
                triple(axis)
            )
            .unwrap();
        }
        urdf + "</robot>"
    }

    /// Values of all joints, from those of the joints that mimic no other.
    fn values(&self, free: impl Fn(usize) -> f64) -> Vec<f64> {
        let mut values: Vec<f64> = Vec::new();
        for (i, joint) in self.joints.iter().enumerate() {
            let value =
                joint.mimic.as_ref().map_or_else(|| free(i), |m| m.multiplier * values[m.of] + m.offset);
            values.push(value);
        }
        values
    }

    /// Position (m) of the ball.
    fn ball(&self, values: &[f64]) -> Point {
        let mut pose = Pose::identity();
        for (joint, value) in self.joints.iter().zip(values) {
            let moved = if joint.kind == "prismatic" {
                Pose::translation_of(joint.axis * *value)
            } else {
                let axis = UnitVector::new_normalize(joint.axis);
                Pose::from_parts(Vector::zeros().into(), Rotation::from_axis_angle(&axis, *value))
            };
            pose = pose * Pose::translation_of(joint.origin) * moved;
        }
        pose * Point::origin()
    }

    /// The joint at the end of the chain of joints that a joint mimics, and whether it moves with it.
    fn leader(&self, mut joint: usize) -> (usize, bool) {
        let mut moves = true;
        while let Some(mimic) = &self.joints[joint].mimic {
            moves &= mimic.multiplier != 0.0;
            joint = mimic.of;
        }
        (joint, moves)
    }
}

trait Translation {
    fn translation_of(by: Vector) -> Pose;
}

impl Translation for Pose {
    fn translation_of(by: Vector) -> Pose {
        Pose::from_parts(by.into(), Rotation::identity())
    }
}

/// A straight motion of some named joints, past a ball.
struct Request {
    /// Numbers of the named joints.
    named: Vec<usize>,
    /// Values of the named joints at both ends.
    ends: [Vec<f64>; 2],
    /// Values of all joints at both ends, if the named ones agree.
    all: Option<[Vec<f64>; 2]>,
    obstacle: Point,
}

impl Request {
    fn random(robot: &ChainRobot, random: &mut Random) -> Self {
        let count = robot.joints.len();
        let mut named: Vec<usize> = (0..count).filter(|_| random.below(2) == 0).collect();
        if named.is_empty() {
            named.push(random.below(u32::try_from(count).unwrap()) as usize);
        }
        for i in (1..named.len()).rev() {
            named.swap(i, random.below(u32::try_from(i + 1).unwrap()) as usize);
        }
        let determined = |leader: usize| named.iter().any(|j| robot.leader(*j) == (leader, true));
        let mut end = || {
            let drives: Vec<f64> = (0..count).map(|_| random.within(-3.0, 3.0)).collect();
            robot.values(|i| if determined(i) { drives[i] } else { 0.0 })
        };
        let all = [end(), end()];
        let mut ends = all.each_ref().map(|all| named.iter().map(|j| all[*j]).collect::<Vec<f64>>());
        let at = robot.ball(&between(&all, random.within(0.0, 1.0)));
        let off = [0.0, 0.04, 0.5][random.below(3) as usize];
        let obstacle = at + random.vector(off);
        // one of several joints that move or stand together is elsewhere
        let off = named.iter().position(|j| {
            let (leader, moves) = robot.leader(*j);
            robot.joints[*j].mimic.is_some()
                && (!moves || named.iter().any(|other| other != j && robot.leader(*other) == (leader, true)))
        });
        let mut agree = true;
        if let Some(off) = off.filter(|_| random.below(4) == 0) {
            ends[random.below(2) as usize][off] += 50.0;
            agree = false;
        }
        Self { named, ends, all: agree.then_some(all), obstacle }
    }

    fn names(&self) -> Vec<String> {
        self.named.iter().map(|j| format!("j{j}")).collect()
    }

    /// `j0=0.5 j3=1`, for one end.
    fn words(&self, end: usize) -> String {
        let named = self.named.iter().zip(&self.ends[end]);
        named.map(|(j, value)| format!("j{j}={value:?}")).collect::<Vec<_>>().join(" ")
    }

    fn distance(&self, robot: &ChainRobot, t: f64) -> f64 {
        let all = self.all.as_ref().expect("the request is possible");
        (robot.ball(&between(all, t)) - self.obstacle).norm() - 2.0 * RADIUS
    }

    /// Fails if a result is one of another motion.
    fn assert_result_of_this(&self, robot: &ChainRobot, found: &Found) {
        let urdf = robot.urdf();
        match *found {
            Found::Rejected => assert!(self.all.is_none(), "rejected: {} in {urdf}", self.words(1)),
            _ if self.all.is_none() => panic!("accepted: {} to {} in {urdf}", self.words(0), self.words(1)),
            Found::Free { until } => {
                for k in 0..=SAMPLES {
                    let t = f64::from(k) / f64::from(SAMPLES);
                    let distance = self.distance(robot, t);
                    assert!(t >= until || distance > -1e-9, "{distance} at {t}: {} in {urdf}", self.words(1));
                }
            }
            Found::Contact { at } => {
                let distance = self.distance(robot, at);
                assert!(
                    distance < 1e-6,
                    "{distance} at {at}: {} to {} in {urdf}",
                    self.words(0),
                    self.words(1)
                );
            }
            Found::Near { at } => {
                let distance = self.distance(robot, at);
                assert!(
                    distance < 2e-3,
                    "{distance} at {at}: {} to {} in {urdf}",
                    self.words(0),
                    self.words(1)
                );
            }
        }
    }
}

/// Result that is reported for one interval of a motion.
enum Found {
    Rejected,
    /// Free before `until`.
    Free {
        until: f64,
    },
    Contact {
        at: f64,
    },
    /// Nearer than the tolerance.
    Near {
        at: f64,
    },
}

/// Values of all joints at `t` of a straight motion.
fn between([from, to]: &[Vec<f64>; 2], t: f64) -> Vec<f64> {
    from.iter().zip(to).map(|(from, to)| from + t * (to - from)).collect()
}

fn number_of_robots() -> u32 {
    let given = std::env::var("CLEARANCE_RANDOM_ROBOTS").ok();
    given.map_or(2000, |count| count.parse().expect("CLEARANCE_RANDOM_ROBOTS is a number"))
}

#[test]
fn the_library_checks_the_requested_motion() {
    let mut random = Random::new(29);
    let [mut free, mut contact, mut rejected] = [0; 3];
    for _ in 0..number_of_robots() {
        let chain = ChainRobot::random(&mut random);
        let request = Request::random(&chain, &mut random);
        let robot = Arc::new(RobotModel::from_urdf(&chain.urdf(), &MeshFiles::default()).unwrap());
        let mut world = World::default();
        let ball = Shape::Primitive(Primitive::sphere(RADIUS).unwrap());
        world.add(Obstacle::of_shape("b", Pose::translation_of(request.obstacle.coords), ball)).unwrap();
        let checker = CollisionChecker::new(Arc::clone(&robot), &world, Settings::default()).unwrap();
        let end = |end: usize| {
            let names = request.names();
            let named = names.iter().map(String::as_str).zip(request.ends[end].iter().copied());
            robot.configuration_from_names(named).ok()
        };
        let (Some(from), Some(to)) = (end(0), end(1)) else {
            request.assert_result_of_this(&chain, &Found::Rejected);
            rejected += 1;
            continue;
        };
        let segment = MotionSegment::straight(&robot, &from, &to);
        let report = checker.check_motion_with(&segment, &MotionOptions::default(), &mut checker.workspace());
        for found in match report.verdict {
            MotionVerdict::Free => {
                free += 1;
                vec![Found::Free { until: f64::INFINITY }]
            }
            MotionVerdict::Contact { t: [safe, hit], .. } => {
                contact += 1;
                vec![Found::Free { until: safe }, Found::Contact { at: hit }]
            }
            MotionVerdict::Undecided { t: [from, to], .. } => {
                vec![Found::Free { until: from }, Found::Near { at: f64::midpoint(from, to) }]
            }
        } {
            request.assert_result_of_this(&chain, &found);
        }
    }
    let least = number_of_robots() / 20;
    assert!([free, contact, rejected].iter().all(|count| *count > least), "{free} {contact} {rejected}");
}

#[test]
fn the_command_line_checks_the_requested_motion() {
    let mut random = Random::new(31);
    let folder = Folder::new();
    for i in 0..number_of_robots() / 25 {
        let chain = ChainRobot::random(&mut random);
        let request = Request::random(&chain, &mut random);
        folder.write("r.urdf", &chain.urdf());
        let Point { coords: at } = request.obstacle;
        folder.write(
            "w.yaml",
            &format!(
                "world:\n  collision_objects:\n    - id: b\n      header: {{frame_id: base}}\n      primitives: \
                 [{{type: sphere, dimensions: [{RADIUS}]}}]\n      primitive_poses: [{{position: [{:?}, {:?}, {:?}], \
                 orientation: [0, 0, 0, 1]}}]\n",
                at.x, at.y, at.z
            ),
        );
        let (names, [from, to]) = (request.names(), &request.ends);
        let given = ["motion", "--urdf", "r.urdf", "--world", "w.yaml", "--format", "json"];
        let output = match i % 3 {
            0 => {
                folder.run(&[&given[..], &["--from", &request.words(0), "--to", &request.words(1)]].concat())
            }
            1 => {
                folder.write(
                    "e.json",
                    &serde_json::json!({"joints": names, "edges": [[from, to]]}).to_string(),
                );
                folder.run(&[&given[..], &["--edges", "e.json"]].concat())
            }
            _ => {
                let point = |positions: &[f64], sec: u32| {
                    format!("  - {{positions: {positions:?}, time_from_start: {{sec: {sec}, nanosec: 0}}}}\n")
                };
                let points = point(from, 0) + &point(to, 1);
                folder.write("t.yaml", &format!("joint_names: [{}]\npoints:\n{points}", names.join(", ")));
                folder.run(&[&given[..], &["--trajectory", "t.yaml"]].concat())
            }
        };
        if output.status.code() == Some(2) {
            request.assert_result_of_this(&chain, &Found::Rejected);
            continue;
        }
        let answer: serde_json::Value =
            serde_json::from_slice(&output.stdout).unwrap_or_else(|e| panic!("{e}: {output:?}"));
        let result = &answer["results"][0];
        let t = |i: usize| result["t"][i].as_f64().unwrap_or_else(|| panic!("{result}"));
        for found in match result["verdict"].as_str() {
            Some("free") => vec![Found::Free { until: f64::INFINITY }],
            Some("contact") => vec![Found::Free { until: t(0) }, Found::Contact { at: t(1) }],
            Some("undecided") => {
                vec![Found::Free { until: t(0) }, Found::Near { at: f64::midpoint(t(0), t(1)) }]
            }
            _ => panic!("{result}"),
        } {
            request.assert_result_of_this(&chain, &found);
        }
    }
}
