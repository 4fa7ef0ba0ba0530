//! Tests of the check between states when messages and transforms on the way were received and not evaluated.

use clearance_geometry::math::{Pose, Vector, pose_from_xyz_rpy};
use clearance_geometry::{Primitive, Shape};
use clearance_motion::{ObstacleLimits, SpeedLimit};
use clearance_scene::{Obstacle, ObstacleTwist, Transform, TransformTree};
use std::sync::OnceLock;

use super::*;

/// A ball of 10 cm that slides along x and y, on a base that drives in a plane.
const GANTRY: &str = r#"<robot name="gantry">
  <link name="map"/><link name="base"/><link name="beam"/>
  <link name="tool"><collision><geometry><sphere radius="0.1"/></geometry></collision></link>
  <joint name="drive" type="planar"><parent link="map"/><child link="base"/><axis xyz="0 0 1"/></joint>
  <joint name="x" type="prismatic">
    <parent link="base"/><child link="beam"/><axis xyz="1 0 0"/><limit lower="-9" upper="9" effort="1" velocity="1"/>
  </joint>
  <joint name="y" type="prismatic">
    <parent link="beam"/><child link="tool"/><axis xyz="0 1 0"/><limit lower="-9" upper="9" effort="1" velocity="1"/>
  </joint>
</robot>"#;

/// Radius (m) of the tool.
const TOOL: f64 = 0.1;

fn robot() -> Arc<RobotModel> {
    static ROBOT: OnceLock<Arc<RobotModel>> = OnceLock::new();
    let read = || Arc::new(RobotModel::from_urdf(GANTRY, &MeshFiles::default()).unwrap());
    Arc::clone(ROBOT.get_or_init(read))
}

/// Balls of 20 cm with velocities along x (m/s), whose states have a time (s).
fn among(balls: &[(&str, [f64; 2], f64, f64)], world_number: u64) -> Arc<Revision> {
    let at = |&(name, [x, y], speed, seconds): &(_, [f64; 2], _, _)| {
        (name, Pose::translation(x, y, 0.0), speed, seconds)
    };
    let balls: Vec<_> = balls.iter().map(at).collect();
    Arc::new(among_turned(&balls, world_number))
}

/// As `among`, with the balls' poses.
fn among_turned(balls: &[(&str, Pose, f64, f64)], world_number: u64) -> Revision {
    let mut world = World::default();
    for (name, pose_ro, ..) in balls {
        let ball = Shape::Primitive(Primitive::Sphere { radius: 0.2 });
        world.add(Obstacle::of_shape(*name, *pose_ro, ball)).unwrap();
    }
    let checker = CollisionChecker::new(robot(), &world, Settings::default()).unwrap();
    let mut revision = Revision::new(checker, 1, world_number);
    revision.obstacle_twists = balls
        .iter()
        .filter(|(name, ..)| *name != "post")
        .map(|(name, _, speed, seconds)| ObstacleTwist {
            name: (*name).to_owned(),
            linear_o: Vector::new(*speed, 0.0, 0.0),
            angular_o: Vector::default(),
            stamp: time(START + seconds),
            received: Duration::from_secs_f64(seconds.max(0.0)),
        })
        .collect();
    revision
}

const POST: (&str, [f64; 2], f64, f64) = ("post", [1.0, 0.0], 0.0, 0.0);
const STANDING_BASE: [(&str, f64); 3] = [("drive/x", 0.0), ("drive/y", 0.0), ("drive/theta", 0.0)];

fn gantry(settings: MonitorSettings, revision: Arc<Revision>) -> Monitor {
    let mut monitor = Monitor::new(MonitorSettings { stale_after: 9.0, ..settings }, stopwatch);
    monitor.set_checker(revision);
    monitor
}

fn from(source: u8, seconds: f64, joints: &[(&str, f64)]) -> JointStateInput {
    JointStateInput { source: SourceId([source; 16]), ..input(seconds, joints) }
}

fn placed(seconds: f64, [x, y]: [f64; 2]) -> JointStateInput {
    from(1, seconds, &[&STANDING_BASE[..], &[("x", x), ("y", y)]].concat())
}

fn is_proven(evaluation: &Evaluation) -> bool {
    assert_eq!(code(evaluation), "FREE");
    evaluation.motion_since_previous == MotionSincePrevious::ProvenFree
}

/// The motion after messages that were received one after the other, and evaluated at the last one only.
fn at_last(messages: &[(u8, &[(&str, f64)])]) -> bool {
    let mut monitor = gantry(MonitorSettings::default(), among(&[POST], 1));
    monitor.on_joint_state(placed(-1.0, [0.0, 0.0]), at(0.0));
    let (last, before) = messages.split_last().unwrap();
    for (number, (source, joints)) in (1..).zip(before) {
        let seconds = 1e-3 * f64::from(number);
        monitor.receive(from(*source, seconds, joints), at(seconds));
    }
    is_proven(&monitor.on_joint_state(from(last.0, 0.02, last.1), at(0.02)))
}

#[test]
fn messages_of_several_publishers_are_passed_over_in_their_order() {
    assert!(at_last(&[(1, &[("x", 1.0), ("y", 1.0)])]), "the straight way is free");
    assert!(!at_last(&[(1, &[("x", 1.0), ("y", 0.0)]), (1, &[("x", 1.0), ("y", 1.0)])]));
    assert!(!at_last(&[(1, &[("x", 1.0)]), (3, &[("y", 1.0)])]), "two publishers");
    assert!(at_last(&[(1, &[("x", 0.1)]), (3, &[("y", 0.1)])]), "so little that the distances suffice");
    assert!(!at_last(&[(1, &[("x", 1.0), ("y", 0.0)]), (1, &[("y", 1.0), ("x", 1.0)])]), "another order");
    assert!(!at_last(&[(1, &[("x", 1.0), ("y", 0.0)]), (1, &[("y", 1.0)])]), "fewer names");
}

/// A driver that does not renew its stamp, or a coarse clock.
#[test]
fn a_message_with_the_stamp_and_positions_of_the_last_state_does_not_hide_what_was_passed_over() {
    let mut monitor = gantry(MonitorSettings::default(), among(&[POST], 1));
    let one = || placed(0.0, [0.0, 0.0]);
    monitor.on_joint_state(one(), at(0.0));
    let again = monitor.on_joint_state(one(), at(0.01));
    assert_eq!(again.motion_since_previous, MotionSincePrevious::NotChecked(NoMotion::NoNewState));
    monitor.receive(placed(0.0, [2.0, 0.0]), at(0.02));
    assert!(!is_proven(&monitor.on_joint_state(one(), at(0.03))));
    let again = monitor.on_joint_state(one(), at(0.04));
    assert_eq!(again.motion_since_previous, MotionSincePrevious::NotChecked(NoMotion::NoNewState));
}

/// Transforms from map to base, through odom.
struct Base {
    tree: TransformTree,
    monitor: Monitor,
}

impl Base {
    fn new(settings: MonitorSettings) -> Self {
        let transform_joints = vec!["drive".to_owned()];
        let settings = MonitorSettings { transform_joints, transform_ttl: 9.0, ..settings };
        let mut base = Self { tree: TransformTree::default(), monitor: gantry(settings, among(&[POST], 1)) };
        base.odom(0.0);
        base.drive(0.0, [0.0, 0.0]);
        base
    }

    fn odom(&mut self, seconds: f64) {
        self.insert("odom", "map", seconds, [0.0, 0.0]);
    }

    fn drive(&mut self, seconds: f64, place: [f64; 2]) {
        self.insert("base", "odom", seconds, place);
    }

    fn insert(&mut self, frame: &str, parent: &str, seconds: f64, [x, y]: [f64; 2]) {
        let (parent, pose_pf) = (parent.to_owned(), Pose::translation(x, y, 0.0));
        let stamp = Some(time(START + seconds));
        assert!(self.tree.insert(frame, Transform { parent, pose_pf, stamp }));
    }

    fn evaluated(&mut self, seconds: f64) -> Evaluation {
        self.monitor.note_transforms(&self.tree);
        self.monitor.on_joint_state(from(1, seconds, &[("x", 0.0), ("y", 0.0)]), at(seconds))
    }

    fn heartbeat(&mut self, seconds: f64) -> Evaluation {
        self.monitor.note_transforms(&self.tree);
        self.monitor.on_heartbeat(at(seconds))
    }
}

#[test]
fn transforms_that_come_in_a_burst_are_part_of_the_motion() {
    let proven = |ways: &[[f64; 2]]| {
        let mut base = Base::new(MonitorSettings::default());
        base.evaluated(0.0);
        for (number, place) in (1..).zip(ways) {
            base.drive(5e-4 * f64::from(number), *place);
        }
        is_proven(&base.evaluated(0.5))
    };
    assert!(proven(&[[1.0, 1.0]]));
    assert!(!proven(&[[1.0, 0.0], [1.0, 1.0]]));
    assert!(proven(&[[0.5, 0.5], [1.0, 1.0]]), "on the line");
    assert!(proven(&[[0.1, 0.0], [0.1, 0.1]]), "so little that the distances suffice");
    assert!(!proven(&[[1.0, 0.0], [0.0, 0.0]]), "there and back");
    let many: Vec<[f64; 2]> = (0..600).map(|i| [1e-3 * f64::from(i % 2), 0.0]).collect();
    assert!(!proven(&many), "more than are kept");
}

/// A base that drives away and comes back while a transform above it is missing, or within one stamp.
#[test]
fn positions_from_tf_that_are_not_read_are_not_forgotten() {
    let proven = |is_cut: bool, way: [f64; 2], seconds: [f64; 2]| {
        let mut base = Base::new(MonitorSettings::default());
        base.evaluated(0.0);
        if is_cut {
            base.insert("odom", "hall", 0.1, [0.0, 0.0]);
            base.heartbeat(0.1);
        }
        base.drive(seconds[0], way);
        if is_cut {
            base.heartbeat(0.15);
        }
        base.drive(seconds[1], [0.0, 0.0]);
        if is_cut {
            base.heartbeat(0.2);
            base.odom(0.2);
        }
        is_proven(&base.evaluated(0.25))
    };
    assert!(proven(false, [0.0, 0.0], [0.1, 0.2]));
    assert!(!proven(true, [2.0, 0.0], [0.15, 0.2]));
    assert!(!proven(false, [2.0, 0.0], [0.0, 0.0]), "the stamp of the first transform");
}

/// A slow transform on the way to the base does not end the time that its motion takes.
#[test]
fn each_transform_on_the_way_to_the_base_has_a_time_of_its_own() {
    let settings = || MonitorSettings { between_states_acceleration: 400.0, ..MonitorSettings::default() };
    let proven = |is_slow: bool| {
        let mut base = Base::new(settings());
        base.evaluated(0.0);
        let mut proven = 0;
        for step in 1..40 {
            let seconds = 0.2 * f64::from(step);
            base.drive(seconds, [1e-3 * f64::from(step), 0.0]);
            if !is_slow {
                base.odom(seconds);
            }
            proven += u32::from(is_proven(&base.evaluated(seconds)));
        }
        proven
    };
    // a tube of 400 · 0.2² / 8 = 2 m
    assert_eq!([proven(false), proven(true)], [0, 0]);
}

#[test]
fn positions_from_tf_are_kept_at_the_time_of_the_newest_transform_that_is_not_ahead() {
    for odom_ahead in [0.0, 0.8] {
        let (mut base, mut history) = (Base::new(MonitorSettings::default()), JointStateHistory::default());
        for step in 0..50 {
            let seconds = 0.02 * f64::from(step);
            base.drive(seconds, [seconds, 0.0]);
            if step % 40 == 1 {
                base.odom(seconds + odom_ahead);
            }
            let evaluation = base.heartbeat(seconds);
            let evaluation = if step == 0 { base.evaluated(seconds) } else { evaluation };
            history.note(&evaluation, Some(time(START + seconds)));
        }
        let (robot, q) = history.at(time(START + 0.91)).unwrap();
        let x = robot.position_names().iter().position(|name| name == "drive/x").unwrap();
        assert!(
            (q.positions()[x] - 0.91).abs() < 1e-9,
            "{} with odom {odom_ahead} s ahead",
            q.positions()[x]
        );
    }
}

#[test]
fn a_history_begins_anew_when_the_clock_is_set_back_a_little() {
    let (mut monitor, mut history) =
        (gantry(MonitorSettings::default(), among(&[], 1)), JointStateHistory::default());
    let mut note = |seconds: f64, x: f64| {
        let evaluation = monitor.on_joint_state(placed(seconds, [x, 0.0]), at(seconds));
        history.note(&evaluation, Some(time(START + seconds)));
        let (robot, q) = history.at(time(START + seconds)).unwrap();
        let index = robot.position_names().iter().position(|name| name == "x").unwrap();
        (q.positions()[index], history.coverage(time(START + seconds - 0.05), 0.5))
    };
    for step in 0..100 {
        note(0.02 * f64::from(step), 5.0);
    }
    assert_eq!(note(0.5, 1.0), (1.0, Coverage::Before));
    assert_eq!(note(0.6, 2.0), (2.0, Coverage::Known));
}

/// A cart that passes through the tool between two slow joint states, and stands since.
#[test]
fn a_tracked_obstacle_is_not_forgotten_at_a_heartbeat() {
    let proven = |way: &[(f64, f64)]| {
        let cart =
            |x: f64, speed: f64, seconds: f64, number| among(&[("cart", [x, 0.0], speed, seconds)], number);
        let mut monitor = gantry(MonitorSettings::default(), cart(2.0, 0.0, 0.0, 1));
        monitor.on_joint_state(placed(0.0, [0.0, 0.0]), at(0.0));
        for (number, (x, speed)) in (2_u32..).zip(way) {
            let seconds = 0.05 * f64::from(number);
            monitor.set_checker(cart(*x, *speed, seconds, u64::from(number)));
            for heartbeat in 0..5 {
                monitor.on_heartbeat(at(seconds + 0.01 * f64::from(heartbeat)));
            }
        }
        is_proven(&monitor.on_joint_state(placed(1.0, [0.0, 0.0]), at(1.0)))
    };
    assert!(proven(&[(2.0, 0.0)]));
    assert!(proven(&[(2.1, 0.0), (2.0, 0.0)]));
    assert!(!proven(&[(-2.0, 0.0)]), "its last state says that it stands");
    assert!(!proven(&[(2.0, -40.0), (-2.0, 0.0), (-2.0, 0.0)]));
    assert!(!proven(&[(-2.0, 0.0), (2.0, 0.0)]), "there and back");
}

/// Whether a motion is proven during which a cart has these worlds.
fn is_proven_beside(settings: MonitorSettings, worlds: impl IntoIterator<Item = Revision>) -> bool {
    let mut worlds = worlds.into_iter().map(Arc::new);
    let mut monitor = gantry(settings, worlds.next().unwrap());
    monitor.on_joint_state(placed(0.0, [0.0, 0.0]), at(0.0));
    worlds.for_each(|revision| monitor.set_checker(revision));
    is_proven(&monitor.on_joint_state(placed(0.1, [0.0, 0.0]), at(0.1)))
}

/// In the mode of separation, a sliding joint within one second of its stop is as fast as it is.
#[test]
fn a_sliding_joint_near_its_stop_does_not_measure_all_distances() {
    let separation = SeparationSettings {
        human_speed: 0.0,
        robot_speed: 0.2,
        reaction_time: 0.1,
        deceleration: 5.0,
        acceleration: 1.0,
        margin: 0.1,
    };
    let speed = SpeedSettings {
        separation: Some(SeparationRules::of_all(separation)),
        release_count: 1,
        ..SpeedSettings::default()
    };
    let range = |velocity: f64| {
        let settings = MonitorSettings { speed: speed.clone(), ..MonitorSettings::default() };
        let mut monitor = gantry(settings, among(&[POST], 1));
        let velocities = vec![0.0, 0.0, 0.0, velocity, 0.0];
        let input = JointStateInput { velocities, ..placed(1.0, [8.9, 0.0]) };
        monitor.on_joint_state(input, at(1.0)).checked_state.unwrap().slowdown_range
    };
    let [slow, fast] = [range(0.1), range(2.0)];
    assert!(slow > 0.0 && fast > 2.0 * slow && fast < 2.0, "{slow} {fast}");
}

/// People walk about a robot, and turn with their way.
#[test]
fn a_tracked_obstacle_that_circles_the_root_moves() {
    let proven = |yaw: f64| {
        let turn = pose_from_xyz_rpy([0.0; 3], [0.0, 0.0, yaw]);
        let poses = [Pose::identity(), turn].map(|turn| turn * Pose::translation(2.0, 0.0, 0.0));
        let worlds =
            (1..).zip(poses).map(|(number, pose)| among_turned(&[("cart", pose, 0.0, 0.05)], number));
        is_proven_beside(MonitorSettings::default(), worlds)
    };
    assert!(proven(0.1));
    assert!(!proven(std::f64::consts::PI));
}

#[test]
fn the_trembling_of_a_tracker_does_not_replace_a_speed_limit() {
    let limit = SpeedLimit { speed: 1.6, acceleration: 0.0 };
    let settings = MonitorSettings {
        obstacle_limits: Arc::new(ObstacleLimits { default: limit, ..ObstacleLimits::default() }),
        obstacle_latency: 0.0,
        ..MonitorSettings::default()
    };
    // the tool and the cart are spheres: 0.16 m are more than the gap
    let proven = |gap: f64, places: &[f64]| {
        let cart = |x: &f64| Pose::translation(x + gap + 0.2 + TOOL, 0.0, 0.0);
        let worlds = (1..)
            .zip(places.iter().map(cart))
            .map(|(number, pose)| among_turned(&[("cart", pose, 0.0, 0.05)], number));
        is_proven_beside(settings.clone(), worlds)
    };
    assert!(proven(0.3, &[0.0]) && proven(0.3, &[0.0, 0.002]));
    assert!(!proven(0.05, &[0.0]) && !proven(0.05, &[0.0, 0.002]));
}

/// States that were applied together, and a message that ends the velocity.
#[test]
fn the_poses_of_an_obstacle_within_one_revision_are_kept() {
    let pose = |x: f64| Pose::translation(x, 0.0, 0.0);
    let proven = |passed: &[f64], is_tracked: bool| {
        let first = among_turned(&[("cart", pose(2.0), 0.0, 0.0)], 1);
        let mut second = among_turned(&[("cart", pose(2.0), 0.0, 0.05)], 2);
        second.obstacle_poses.insert("cart".to_owned(), passed.iter().map(|x| pose(*x)).collect());
        if !is_tracked {
            second.obstacle_twists.clear();
        }
        is_proven_beside(MonitorSettings::default(), [first, second])
    };
    for is_tracked in [true, false] {
        assert!(proven(&[2.0], is_tracked) && proven(&[2.1, 2.0], is_tracked));
        assert!(!proven(&[-2.0, 2.0], is_tracked), "there and back");
    }
}

fn looking_ahead(limit: SpeedLimit) -> MonitorSettings {
    let obstacle_limits = Arc::new(ObstacleLimits { default: limit, ..ObstacleLimits::default() });
    let (look_ahead_horizon, look_ahead_acceleration) = (3.0, 0.0);
    MonitorSettings { look_ahead_horizon, look_ahead_acceleration, obstacle_limits, ..settings_of_lookout() }
}

/// Time to contact of a tool that stands until one second, and then moves along x at a speed, at a later time.
fn time_to_contact(balls: &[(&str, [f64; 2], f64, f64)], limit: SpeedLimit, speed: f64, seconds: f64) -> f64 {
    let mut monitor = gantry(looking_ahead(limit), among(balls, 1));
    let mut last = f64::NAN;
    for step in 0..=100 {
        let now = seconds - 1.0 + 0.01 * f64::from(step);
        let moving = now > 1.0 + 1e-9;
        let x = if moving { speed * (now - 1.0) } else { 0.0 };
        let velocities = vec![0.0, 0.0, 0.0, if moving { speed } else { 0.0 }, 0.0];
        let evaluation =
            monitor.on_joint_state(JointStateInput { velocities, ..placed(now, [x, 0.0]) }, at(now));
        assert_eq!(code(&evaluation), "FREE");
        last = evaluation.time_to_contact();
    }
    last
}

#[test]
fn the_robot_was_where_its_states_say_since_the_pose_of_an_obstacle() {
    let none = SpeedLimit::default();
    // it moves away from a post that it never came from
    let behind = ("slow", [-1.3, 0.0], 1e-3, 0.3);
    assert!(time_to_contact(&[behind], none, 2.0, 1.1) > 0.0);
    // it was hit 0.4 s after the pose, while it stood
    let fast = ("fast", [1.3, 0.0], -2.5, 0.4);
    assert_eq!(time_to_contact(&[fast], none, 0.0, 1.1), 0.0);
    assert_eq!(time_to_contact(&[fast], none, -0.5, 1.1), 0.0);
    // a post beside its way does not hide this
    assert_eq!(time_to_contact(&[fast, ("post", [0.0, -0.4], 0.0, 0.0)], none, 0.5, 1.1), 0.0);
    // another obstacle, whose state is old, does not move this one back
    let leaving = ("leaving", [1.0, 0.0], 2.0, 1.1);
    assert!(time_to_contact(&[leaving, ("old", [0.0, 9.0], 0.1, 0.2)], none, 0.0, 1.1) > 0.0);
}

#[test]
fn an_obstacle_that_may_have_touched_since_its_pose_has_no_time_left() {
    // it reaches the tool after 0.5 s at its velocity, and after less if it accelerates
    let cart = |seconds| [("cart", [1.3, 0.0], -2.0, seconds)];
    let limit = SpeedLimit { speed: 0.0, acceleration: 4.0 };
    let left = |age: f64, limit| time_to_contact(&cart(1.1 - age), limit, 0.0, 1.1);
    let none = SpeedLimit::default();
    assert!(left(0.3, none) > 0.0 && left(0.3, limit) > 0.0);
    assert!(left(0.45, none) > 0.0);
    for age in [0.45, 0.6, 0.9, 1.0] {
        assert_eq!(left(age, limit), 0.0, "{age}");
    }
}

/// A ball that has passed the tool since its pose, by its velocity: the tool that leaves the pose comes to it.
#[test]
fn a_robot_that_leaves_the_old_pose_of_an_obstacle_that_has_passed_is_slowed() {
    let separation = SeparationRules::of_all(SeparationSettings {
        human_speed: 1.6,
        robot_speed: 1.0,
        reaction_time: 0.1,
        deceleration: 5.0,
        acceleration: 1.0,
        margin: 0.1,
    });
    let by_distances = SpeedSettings {
        world: SpeedDistances { slowdown: 1.0, stop: 0.1 },
        reaction_time: 0.1,
        release_count: 1,
        trigger_count: 1,
        ..SpeedSettings::default()
    };
    let by_separation =
        SpeedSettings { separation: Some(separation), release_count: 1, ..SpeedSettings::default() };
    for speed in [by_distances, by_separation] {
        let share = |age: f64, velocity: f64| {
            let cart = ("cart", [0.7, 0.0], -1.0, 1.0 - age);
            let settings = MonitorSettings { speed: speed.clone(), ..MonitorSettings::default() };
            let mut monitor = gantry(settings, among(&[cart], 1));
            let velocities = vec![0.0, 0.0, 0.0, velocity, 0.0];
            let input = JointStateInput { velocities, ..placed(1.0, [0.0, 0.0]) };
            let evaluation = monitor.on_joint_state(input, at(1.0));
            assert_eq!(code(&evaluation), "FREE");
            evaluation.speed_scale
        };
        // it is still on the side of its pose
        assert_eq!(share(0.0, -0.5), 1.0);
        assert_eq!(share(0.1, -0.5), 1.0);
        // 1.1 m later it is 0.1 m behind the tool
        assert_eq!([share(1.1, 0.0), share(1.1, -0.5), share(1.1, -2.0)], [0.0; 3]);
    }
}
