//! Tests of `~/retreat_direction`: tasks of the feed, and directions of the two-link robot. Its URDF contains the
//! derivation of the expected results.

use std::f64::consts::PI;

use clearance_geometry::math::Pose;
use clearance_geometry::{Primitive, Shape};
use clearance_monitor::{JointStateInput, Monitor, MonitorSettings, Now, Revision, Time};
use clearance_robot::{MeshFiles, RobotModel};
use clearance_scene::{Obstacle, Settings, World};

use super::*;
use crate::messages::time_and_geometry::stamp_message;

const URDF: &str = include_str!("../../../../../urdf/two_link/two_link.urdf");
const JOINTS: [&str; 2] = ["joint1", "joint2"];
/// The ball of the tip is in the cube of the base, at the middle of a face and near it: it leaves as joint2 falls.
const ONTO: [f64; 2] = [0.0, 11.0 * PI / 12.0];
const STRETCHED: [f64; 2] = [0.0, 0.0];

fn evaluation(world: &World, positions: [f64; 2]) -> Evaluation {
    let robot = RobotModel::from_urdf(URDF, &MeshFiles::default()).unwrap();
    let checker = CollisionChecker::new(Arc::new(robot), world, Settings::default()).unwrap();
    let mut monitor = Monitor::new(MonitorSettings::default(), || Duration::ZERO);
    monitor.set_checker(Arc::new(Revision::new(checker, 3, 1)));
    let now = Now { ros: Some(Time::from_nanoseconds(5)), steady: Duration::ZERO };
    let names = JOINTS.map(str::to_owned).to_vec();
    let (positions, stamp) = (positions.to_vec(), Time::from_nanoseconds(5));
    monitor.on_joint_state(JointStateInput { names, positions, stamp, ..JointStateInput::default() }, now)
}

fn alone(positions: [f64; 2]) -> Evaluation {
    evaluation(&World::default(), positions)
}

/// A feed at 10 Hz, with the tasks that it has queued.
struct Feed {
    sender: RetreatFeed,
    tasks: Receiver<Task>,
    parameters: Parameters,
    free: Evaluation,
    colliding: Evaluation,
}

impl Feed {
    fn new(retreat_rate: f64) -> Self {
        let (sender, tasks) = feed();
        let parameters = Parameters { retreat_rate, ..Parameters::default() };
        Self { sender, tasks, parameters, free: alone(STRETCHED), colliding: alone(ONTO) }
    }

    fn note(&mut self, milliseconds: u64, collides: bool) {
        let evaluation = if collides { &self.colliding } else { &self.free };
        self.sender.note(evaluation, &self.parameters, Duration::from_millis(milliseconds));
    }

    fn taken(&self) -> Option<Task> {
        wait_at_most(Duration::ZERO, self.tasks.receive()).flatten()
    }

    fn noted(&mut self, milliseconds: u64, collides: bool) -> Option<Task> {
        self.note(milliseconds, collides);
        self.taken()
    }
}

#[test]
fn directions_come_at_their_rate_and_none_waits_behind_another() {
    let mut feed = Feed::new(10.0);
    assert_eq!(feed.noted(0, true), Some(Task::Publish));
    assert_eq!(feed.noted(99, true), None);
    feed.note(100, true);
    feed.note(200, true);
    assert_eq!((feed.taken(), feed.taken()), (Some(Task::Publish), None));
    // the note at 200 ms found the queue full, so it did not count
    assert_eq!(feed.noted(201, true), Some(Task::Publish));
}

#[test]
fn a_direction_is_withdrawn_as_soon_as_the_collision_is_left() {
    let mut feed = Feed::new(10.0);
    assert_eq!(feed.noted(0, true), Some(Task::Publish));
    assert_eq!(feed.noted(1, false), Some(Task::Withdraw));
    assert_eq!(feed.noted(2, false), None, "once");
    // not before its time: in and out again at a high rate does not raise the rate of computations
    assert_eq!(feed.noted(3, true), None);
    // but the worker may have seen that state, if it began only now
    assert_eq!(feed.noted(4, false), Some(Task::Withdraw));
    assert_eq!(feed.noted(100, true), Some(Task::Publish));

    // where the queue is full, it is withdrawn with the next evaluation
    feed.note(200, true);
    feed.note(201, false);
    assert_eq!((feed.taken(), feed.taken()), (Some(Task::Publish), None));
    assert_eq!(feed.noted(202, false), Some(Task::Withdraw));
    assert_eq!(feed.noted(203, false), None);
}

#[test]
fn a_topic_that_is_turned_off_is_withdrawn_once() {
    let mut feed = Feed::new(0.0);
    assert_eq!(feed.noted(0, true), None);
    feed.parameters.retreat_rate = 1e-300;
    assert_eq!(feed.noted(1, true), Some(Task::Publish));
    assert_eq!(feed.noted(1_000_000, true), None);
    feed.parameters.retreat_rate = 0.0;
    assert_eq!(feed.noted(1_000_001, true), Some(Task::TurnOff));
    assert_eq!(feed.noted(1_000_002, true), None);
}

/// A small step along the direction reduces the depth, and steps along it lead out.
#[test]
fn the_direction_of_a_collision_leads_out() {
    let message = direction(&alone(ONTO), &mut None).unwrap();
    assert_eq!(message.name, JOINTS);
    assert!(message.position.is_empty() && message.effort.is_empty());
    assert_eq!(
        (message.header.frame_id.as_str(), &message.header.stamp),
        ("base", &stamp_message(Time::from_nanoseconds(5)))
    );
    let length = message.velocity[0].hypot(message.velocity[1]);
    assert!((length - 1.0).abs() < 1e-12, "{message:?}");

    let mut positions = ONTO;
    let mut workspace = None;
    let steps = (0..100).take_while(|_| {
        let Ok(message) = direction(&alone(positions), &mut workspace) else { return false };
        for (position, velocity) in positions.iter_mut().zip(message.velocity) {
            *position += 0.01 * velocity;
        }
        true
    });
    // the ball is 0.04 m deep
    assert!((1..20).contains(&steps.count()), "{positions:?}");
    assert_eq!(alone(positions).status, Status::Free);
}

#[test]
fn without_a_direction_the_reason_is_known() {
    assert_eq!(direction(&alone(STRETCHED), &mut None), Err(NoDirection::NotColliding("FREE")));
    let mut world = World::default();
    let ball = Shape::Primitive(Primitive::Sphere { radius: 0.1 });
    world.add(Obstacle::of_shape("ball", Pose::translation(0.0, 0.0, 0.0), ball)).unwrap();
    let Err(why) = direction(&evaluation(&world, STRETCHED), &mut None) else {
        panic!("the base does not move")
    };
    let NoDirection::Stuck(pair) = &why else { panic!("{why:?}") };
    assert!(pair.contains(&"ball".to_owned()), "{pair:?}");
    assert!(why.text().unwrap().contains("'ball'"));
}
