//! Tests of a root that `tf` moves relative to world-fixed obstacles: staleness, speed scale and time to contact.

use clearance_geometry::math::Pose;
use clearance_scene::{ObjectChange, Operation, Scene, SceneContext, SceneUpdate, Transform, TransformTree};

use super::*;

/// A room, the robot in it, and its monitor.
pub(super) struct Room {
    robot: Arc<RobotModel>,
    pub monitor: Monitor,
    scene: Scene,
    pub transforms: TransformTree,
}

impl Room {
    /// A room with one obstacle in `map`; `tf` has published the pose of the root once.
    pub fn new() -> Self {
        let (scene, transforms) = (Scene::default(), TransformTree::default());
        let mut room =
            Self { robot: Arc::clone(revision(1).checker.robot()), monitor: monitor(), scene, transforms };
        room.send(0.0, 0.0);
        let pillar =
            ObjectChange { frame: "map".to_owned(), ..ObjectChange::named("pillar", Operation::Add) };
        let ball = clearance_geometry::Shape::Primitive(clearance_geometry::Primitive::sphere(0.1).unwrap());
        let shapes = vec![clearance_scene::ObstacleShape { pose_os: Pose::identity(), shape: ball }];
        room.change(ObjectChange { shapes, pose_fo: Pose::translation(9.0, 0.0, 0.0), ..pillar });
        room
    }

    /// The same after half a second of joint states.
    fn in_use() -> Self {
        let mut room = Self::new();
        for seconds in [0.0, 0.5] {
            room.send(0.0, seconds);
            room.evaluated(seconds);
        }
        room
    }

    /// Publishes the position of the root along x on `tf`.
    pub fn send(&mut self, x: f64, seconds: f64) {
        let stamp = Some(time(START + seconds));
        let pose_pf = Pose::translation(x, 0.0, 0.0);
        self.transforms.insert("base", Transform { parent: "map".to_owned(), pose_pf, stamp });
    }

    pub fn change(&mut self, change: ObjectChange) {
        let context = SceneContext::new(&self.robot, None, &self.transforms, Some(time(START)), 1e9);
        let applied = self.scene.apply(&SceneUpdate::Object(Box::new(change)), &context);
        assert!(applied.refusals.is_empty());
        self.put_in_force();
    }

    /// Moves the obstacles to follow `tf`, as the loader does.
    pub fn follow(&mut self) {
        let context = SceneContext::new(&self.robot, None, &self.transforms, Some(time(START)), 1.0);
        self.scene.follow_anchor_frames(&context);
        self.put_in_force();
    }

    fn put_in_force(&mut self) {
        self.put_in_force_of(None);
    }

    /// Sets a checker whose obstacles were placed this number of seconds after the start.
    fn put_in_force_of(&mut self, placed_at: Option<f64>) {
        let checker =
            CollisionChecker::new(Arc::clone(&self.robot), &self.scene.world, Settings::default()).unwrap();
        let mut revision = Revision::new(checker, 1, 0);
        revision.anchor_frames = self.scene.anchor_frames(&self.robot);
        revision.placed_at = placed_at.map(Duration::from_secs_f64);
        self.monitor.set_checker(Arc::new(revision));
    }

    /// The evaluation of a fresh joint state.
    pub fn evaluated(&mut self, seconds: f64) -> Evaluation {
        self.monitor.note_transforms(&self.transforms);
        self.monitor.on_joint_state(state(seconds, FREE), at(seconds))
    }
}

#[test]
fn a_root_pose_published_once_stays_known() {
    let mut room = Room::new();
    for seconds in [0.0, 0.5, 5.0, 500.0] {
        assert_eq!(code(&room.evaluated(seconds)), "FREE");
    }
}

#[test]
fn a_root_pose_published_repeatedly_is_unknown_when_that_ends() {
    let mut room = Room::new();
    for seconds in [0.0, 0.5, 1.0] {
        // the root is at rest
        room.send(0.0, seconds);
        assert_eq!(code(&room.evaluated(seconds)), "FREE");
    }
    assert_eq!(code(&room.evaluated(1.99)), "FREE");
    let silent = room.evaluated(2.01);
    assert_eq!(code(&silent), "stale_world");
    assert!(silent.status.reason().unwrap().to_string().contains("the robot's root in map"));
    // the same is detected while ROS time stands still
    room.send(0.0, 3.0);
    assert_eq!(code(&room.evaluated(3.0)), "FREE");
    room.monitor.note_transforms(&room.transforms);
    let standing = Now { steady: Duration::from_secs(5), ..at(3.0) };
    let evaluation = room.monitor.on_joint_state(state(3.001, FREE), standing);
    assert_eq!(code(&evaluation), "stale_world");
}

#[test]
fn without_obstacles_nobody_has_to_know_where_the_root_is() {
    let mut room = Room::in_use();
    assert_eq!(code(&room.evaluated(9.0)), "stale_world");
    room.change(ObjectChange::named("pillar", Operation::Remove));
    assert!(!room.monitor.uses_transforms());
    assert_eq!(code(&room.monitor.on_joint_state(state(9.1, FREE), at(9.1))), "FREE");
    // an obstacle that is added then is placed in a frame with a transform that has been stale for long
    let ball = clearance_geometry::Shape::Primitive(clearance_geometry::Primitive::sphere(0.1).unwrap());
    let shapes =
        vec![clearance_scene::ObstacleShape { pose_os: Pose::translation(9.0, 0.0, 0.0), shape: ball }];
    room.change(ObjectChange { shapes, ..ObjectChange::named("crate", Operation::Add) });
    assert_eq!(code(&room.evaluated(9.2)), "stale_world");
    room.send(0.0, 9.3);
    assert_eq!(code(&room.evaluated(9.3)), "FREE");
}

#[test]
fn one_transform_on_the_path_hides_no_missing_ones() {
    let mut room = Room::new();
    let of_map =
        Transform { parent: "room".to_owned(), pose_pf: Pose::identity(), stamp: Some(time(START - 3.0)) };
    room.transforms.insert("map", of_map);
    let pillar = ObjectChange::named("pillar", Operation::Move);
    room.change(ObjectChange {
        frame: "room".to_owned(),
        pose_fo: Pose::translation(9.0, 0.0, 0.0),
        ..pillar
    });
    for seconds in [0.0, 0.5, 1.0] {
        room.send(0.0, seconds);
        assert_eq!(code(&room.evaluated(seconds)), "FREE");
    }
    assert_eq!(code(&room.evaluated(2.1)), "stale_world");
}

/// Odometry goes on; the localiser above it falls silent. Its stamps are in the future.
#[test]
fn a_transform_that_falls_silent_is_old_whatever_its_stamp() {
    for lead in [0.0, 0.9, 30.0] {
        let mut room = Room::new();
        let of = |parent: &str, seconds: f64| Transform {
            parent: parent.to_owned(),
            pose_pf: Pose::identity(),
            stamp: Some(time(START + seconds)),
        };
        let mut silent_after = None;
        for i in 0..60_u32 {
            let seconds = 0.05 * f64::from(i);
            if i < 10 {
                room.transforms.insert("odom", of("map", seconds + lead));
            }
            room.transforms.insert("base", of("odom", seconds));
            if code(&room.evaluated(seconds)) == "stale_world" {
                silent_after.get_or_insert(seconds - 0.45);
            }
        }
        let silent_after = silent_after.unwrap();
        assert!((0.99..1.06).contains(&silent_after), "{silent_after} s after it, {lead} s ahead");
    }
}

#[test]
fn the_moment_at_which_tf_has_been_silent_for_too_long_is_news() {
    let mut room = Room::in_use();
    room.monitor.set_settings(MonitorSettings {
        heartbeat_rate: 0.1,
        stale_after: 9.0,
        ..MonitorSettings::default()
    });
    room.evaluated(0.6);
    let due = room.monitor.time_to_heartbeat(at(0.6)).as_secs_f64();
    assert!((0.9..0.91).contains(&due), "{due}");
    assert_eq!(code(&room.monitor.on_heartbeat(at(0.6 + due))), "stale_world");
    // the same for obstacles that are not moved to follow `tf`
    room.send(3.0, 2.0);
    room.evaluated(2.0);
    room.send(3.1, 2.5);
    room.evaluated(2.5);
    let due = room.monitor.time_to_heartbeat(at(2.5)).as_secs_f64();
    assert!(due < 1.0, "{due}");
}

#[test]
fn obstacles_that_nobody_puts_where_they_belong_are_not_known() {
    let mut room = Room::new();
    for (x, seconds) in [(0.0, 0.0), (1.0, 0.1), (2.0, 0.9)] {
        room.send(x, seconds);
        assert_eq!(code(&room.evaluated(seconds)), "FREE", "they are on their way");
    }
    room.send(3.0, 1.2);
    let late = room.evaluated(1.2);
    assert_eq!(code(&late), "stale_world");
    assert!(late.status.reason().unwrap().to_string().contains("where tf has them"));
    room.send(7.0, 1.3);
    room.follow();
    // the ball is at (2, 0, 0), and the pillar has moved there too
    assert_eq!(code(&room.evaluated(1.3)), "COLLIDING");
}

#[test]
fn obstacles_that_took_long_to_build_are_as_old_as_what_they_were_placed_by() {
    let mut room = Room::new();
    for i in 0..10_u32 {
        room.send(0.2 * f64::from(i), 0.2 * f64::from(i));
        room.evaluated(0.2 * f64::from(i));
    }
    // the obstacles match the root's pose at 0 s, whenever the checker is set
    room.put_in_force_of(Some(0.0));
    assert_eq!(code(&room.evaluated(1.8)), "stale_world");
    room.put_in_force_of(Some(1.0));
    assert_eq!(code(&room.evaluated(1.8)), "FREE");
    room.follow();
    room.put_in_force_of(Some(1.8));
    assert_eq!(code(&room.evaluated(1.8)), "FREE");
}

#[test]
fn what_stands_in_nothing_while_the_root_drives_is_not_known() {
    let mut room = Room::new();
    let stamp = Some(time(START));
    room.transforms = TransformTree::default();
    room.change(ObjectChange::named("pillar", Operation::Remove));
    let ball = clearance_geometry::Shape::Primitive(clearance_geometry::Primitive::sphere(0.1).unwrap());
    let shapes =
        vec![clearance_scene::ObstacleShape { pose_os: Pose::translation(9.0, 0.0, 0.0), shape: ball }];
    room.change(ObjectChange { shapes, ..ObjectChange::named("crate", Operation::Add) });
    assert!(room.monitor.uses_transforms());
    assert_eq!(code(&room.evaluated(5.0)), "FREE", "tf says nothing of the root");
    let pose_pf = Pose::identity();
    room.transforms.insert("base", Transform { parent: "odom".to_owned(), pose_pf, stamp });
    assert_eq!(code(&room.evaluated(5.1)), "FREE", "it will stand there from now on");
    assert_eq!(code(&room.evaluated(6.2)), "stale_world");
    room.follow();
    assert_eq!(code(&room.evaluated(6.3)), "FREE");
}

#[test]
fn a_root_that_tf_no_longer_connects_with_the_room_is_not_known() {
    let mut room = Room::new();
    assert_eq!(code(&room.evaluated(0.0)), "FREE");
    let pose_pf = Pose::identity();
    room.transforms.insert(
        "base",
        Transform { parent: "elsewhere".to_owned(), pose_pf, stamp: Some(time(START + 0.1)) },
    );
    let lost = room.evaluated(0.1);
    assert_eq!(code(&lost), "stale_world");
    assert!(lost.stale_world.is_some() && lost.robot_state.is_some());
}

/// The pillar is 6.8 m in front of the ball. The root drives at 1 m/s, and `tf` publishes its pose 50 times a second.
fn drive(settings: MonitorSettings, speed: f64, seconds: f64) -> (Room, Evaluation) {
    let mut room = Room::new();
    room.monitor.set_settings(settings);
    let mut last = None;
    for i in 0..=100 {
        let share = f64::from(i) / 100.0;
        room.send(seconds * speed * share, seconds * share);
        room.follow();
        room.monitor.note_transforms(&room.transforms);
        last = Some(
            room.monitor.on_joint_state(moving(seconds * share, FREE, &[0.0, 0.0]), at(seconds * share)),
        );
    }
    (room, last.unwrap())
}

#[test]
fn driving_towards_an_obstacle_slows_the_robot_down_and_away_from_it_does_not() {
    let distances =
        |world| SpeedSettings { world, reaction_time: 0.5, release_count: 1, ..SpeedSettings::default() };
    let with = |slowdown| MonitorSettings {
        speed: distances(SpeedDistances { slowdown, stop: 0.2 }),
        ..MonitorSettings::default()
    };
    // 0.8 m are left, minus 0.5 m for the reaction time
    let (_, evaluation) = drive(with(1.0), 3.0, 2.0);
    assert!(
        (evaluation.speed_scale - 0.0).abs() < 1e-9,
        "1.5 m in half a second: {}",
        evaluation.speed_scale
    );
    let (_, evaluation) = drive(with(1.0), 1.0, 6.0);
    assert!((evaluation.speed_scale - 0.125).abs() < 1e-6, "{}", evaluation.speed_scale);
    // 1.3 m are left, which is more than the slow-down distance
    let (_, evaluation) = drive(with(1.0), 1.0, 5.5);
    assert!((evaluation.speed_scale - 0.75).abs() < 1e-6, "{}", evaluation.speed_scale);
    let (_, evaluation) = drive(with(8.0), -1.0, 0.5);
    assert!((evaluation.speed_scale - 1.0).abs() < 1e-9, "{}", evaluation.speed_scale);
}

#[test]
fn of_a_root_that_moves_no_time_to_contact_is_certain() {
    let (mut room, evaluation) = drive(settings_of_lookout(), 1.0, 2.0);
    assert!(evaluation.time_to_contact() <= 0.0);
    assert!(evaluation.warnings.iter().any(|warning| warning.contains("the robot's root moves in 'map'")));
    // the root stops, without a new joint state
    room.send(2.0, 2.1);
    room.monitor.note_transforms(&room.transforms);
    assert!(room.monitor.on_heartbeat(at(2.1)).time_to_contact() > 0.0);
    room.send(2.1, 2.2);
    room.monitor.note_transforms(&room.transforms);
    assert!(room.monitor.on_heartbeat(at(2.2)).time_to_contact() <= 0.0, "it moves on");
}

/// With limits of its accelerations, the time to contact holds for all motions of the root, the fastest one included.
#[test]
fn the_time_to_contact_of_a_root_that_moves_holds_within_its_accelerations() {
    let acceleration = 0.5;
    let with = |look_ahead_root_accelerations| MonitorSettings {
        look_ahead_root_accelerations,
        look_ahead_horizon: 2.0,
        ..settings_of_lookout()
    };
    for (speed, seconds) in [(1.0, 6.0), (1.0, 6.5), (2.0, 3.0), (3.0, 2.0)] {
        let (_, evaluation) = drive(with([acceleration, 0.1]), speed, seconds);
        let gap = 6.8 - speed * seconds;
        let first = ((speed * speed + 2.0 * acceleration * gap).sqrt() - speed) / acceleration;
        let found = evaluation.time_to_contact();
        assert!(found <= first, "{found} {first} at {speed} m/s");
        assert!(found > 0.6 * first.min(2.0) - 0.05, "{found} {first} at {speed} m/s");
    }
    // no transform for half a second: the root has moved on
    let (mut room, before) = drive(with([acceleration, 0.1]), 1.0, 6.0);
    let later = room.monitor.on_joint_state(moving(6.5, FREE, &[0.0, 0.0]), at(6.5));
    let difference = before.time_to_contact() - later.time_to_contact();
    assert!((0.4..0.6).contains(&difference), "{difference}");
    let (_, evaluation) = drive(with([acceleration, 0.0]), 1.0, 2.0);
    let warning = "the robot's root moves in 'map': set look_ahead_root_acceleration and \
                   look_ahead_root_angular_acceleration";
    assert!(evaluation.time_to_contact() <= 0.0);
    assert!(evaluation.warnings.iter().any(|found| found.contains(warning)), "{:?}", evaluation.warnings);
}

/// A root at rest may start to move at any time, and one that was placed once may be moving already.
#[test]
fn a_root_at_rest_may_start_to_move() {
    let mut room = Room::new();
    let accelerations = [5.0, 0.1];
    let settings = MonitorSettings { look_ahead_horizon: 2.0, ..settings_of_lookout() };
    room.monitor.set_settings(settings.clone());
    room.monitor.note_transforms(&room.transforms);
    let evaluated = |room: &mut Room, seconds| {
        room.monitor.on_joint_state(moving(seconds, FREE, &[0.0, 0.0]), at(seconds))
    };
    assert!(evaluated(&mut room, 0.0).time_to_contact() >= 2.0, "without limits, it stays");
    room.monitor.set_settings(MonitorSettings { look_ahead_root_accelerations: accelerations, ..settings });
    let unknown = "the speed of the robot's root in 'map' is not known until tf publishes it again";
    let is_unknown = |found: &Evaluation| {
        found.time_to_contact() <= 0.0 && found.warnings.iter().any(|warning| warning.contains(unknown))
    };
    let once = evaluated(&mut room, 0.01);
    assert!(is_unknown(&once), "received once: {:?}", once.warnings);
    room.send(0.0, 0.01);
    room.monitor.note_transforms(&room.transforms);
    let observed_once = evaluated(&mut room, 0.015);
    assert!(is_unknown(&observed_once), "no motion was observed yet: {:?}", observed_once.warnings);
    for i in 1..=20_u32 {
        room.send(0.0, 0.02 * f64::from(i));
        room.monitor.note_transforms(&room.transforms);
    }
    let found = evaluated(&mut room, 0.4).time_to_contact();
    let first = (2.0 * 6.8_f64 / 5.0).sqrt();
    assert!(found > 0.6 * first && found < first, "{found} {first}");
}

/// The root turns on the spot: the tip of the robot, 2 m from it, passes the pillar beside it.
#[test]
fn the_time_to_contact_of_a_root_that_turns_counts_its_reach() {
    let mut room = Room::new();
    let accelerations = [0.01, 0.1];
    let settings = MonitorSettings { look_ahead_horizon: 5.0, ..settings_of_lookout() };
    room.monitor.set_settings(MonitorSettings { look_ahead_root_accelerations: accelerations, ..settings });
    let beside = Pose::translation(0.0, 2.0, 0.0);
    let pillar = ObjectChange { frame: "map".to_owned(), ..ObjectChange::named("pillar", Operation::Add) };
    let ball = clearance_geometry::Shape::Primitive(clearance_geometry::Primitive::sphere(0.1).unwrap());
    let shapes = vec![clearance_scene::ObstacleShape { pose_os: Pose::identity(), shape: ball }];
    room.change(ObjectChange { shapes, pose_fo: beside, ..pillar });
    let rate = 0.2;
    let mut found = 0.0;
    for i in 0..=50_u32 {
        let seconds = 0.02 * f64::from(i);
        let pose_pf = clearance_geometry::math::pose_from_xyz_rpy([0.0; 3], [0.0, 0.0, rate * seconds]);
        let stamp = Some(time(START + seconds));
        room.transforms.insert("base", Transform { parent: "map".to_owned(), pose_pf, stamp });
        room.follow();
        room.monitor.note_transforms(&room.transforms);
        let evaluation = room.monitor.on_joint_state(moving(seconds, FREE, &[0.0, 0.0]), at(seconds));
        found = evaluation.time_to_contact();
    }
    // the chord between the tip's ball and the pillar, at the speed of the tip
    let angle = std::f64::consts::FRAC_PI_2 - rate;
    let gap = 4.0 * (0.5 * angle).sin() - 0.2;
    let straight = gap / (2.1 * rate);
    assert!(found > 0.3 * straight && found < straight, "{found} {straight}");
}

/// Two transforms between root and pillar, each of which may accelerate.
#[test]
fn each_transform_of_a_root_may_accelerate() {
    let time_with = |two: bool| {
        let mut room = Room::new();
        room.transforms = TransformTree::default();
        let accelerations = [4.0, 0.01];
        let settings = MonitorSettings { look_ahead_horizon: 5.0, ..settings_of_lookout() };
        room.monitor
            .set_settings(MonitorSettings { look_ahead_root_accelerations: accelerations, ..settings });
        for i in 0..=50_u32 {
            let seconds = 0.02 * f64::from(i);
            let stamp = two.then(|| time(START + seconds));
            let pose_pf = Pose::identity();
            room.transforms.insert("odom", Transform { parent: "map".to_owned(), pose_pf, stamp });
            let stamp = Some(time(START + seconds));
            room.transforms.insert("base", Transform { parent: "odom".to_owned(), pose_pf, stamp });
            room.follow();
            room.monitor.note_transforms(&room.transforms);
        }
        room.monitor.on_joint_state(moving(1.0, FREE, &[0.0, 0.0]), at(1.0)).time_to_contact()
    };
    let [one, two] = [time_with(false), time_with(true)];
    assert!(two > 0.0 && two < 0.75 * one, "{one} {two}");
}

/// Transforms that the obstacles have not been moved to follow yet: they may be nearer.
#[test]
fn obstacles_that_lag_behind_shorten_the_time_to_contact() {
    let (mut room, before) = drive(
        MonitorSettings {
            look_ahead_root_accelerations: [0.5, 0.1],
            look_ahead_horizon: 2.0,
            ..settings_of_lookout()
        },
        1.0,
        6.0,
    );
    let mut later = None;
    for i in 1..=10_u32 {
        let seconds = 6.0 + 0.03 * f64::from(i);
        room.send(seconds, seconds);
        room.monitor.note_transforms(&room.transforms);
        later = Some(room.monitor.on_joint_state(moving(seconds, FREE, &[0.0, 0.0]), at(seconds)));
    }
    let difference = before.time_to_contact() - later.unwrap().time_to_contact();
    assert!(difference > 0.2, "{difference}");
}

/// Localisation at 5 Hz with stamps in the future, above odometry at 50 Hz: the base moves by the odometry.
#[test]
fn a_localiser_that_comes_slowly_hides_no_drive() {
    let mut room = Room::new();
    room.transforms = TransformTree::default();
    room.monitor.set_settings(settings_of_lookout());
    let told = |parent: &str, x: f64, seconds: f64| Transform {
        parent: parent.to_owned(),
        pose_pf: Pose::translation(x, 0.0, 0.0),
        stamp: Some(time(START + seconds)),
    };
    for i in 0..500_u32 {
        let seconds = 0.004 * f64::from(i);
        if i % 50 == 0 {
            room.transforms.insert("odom", told("map", 0.0, seconds + 1.0));
        }
        if i % 5 == 0 {
            room.transforms.insert("base", told("odom", 0.5 * seconds, seconds));
            room.follow();
        }
        room.monitor.note_transforms(&room.transforms);
        let evaluation = room.monitor.on_joint_state(moving(seconds, FREE, &[0.0, 0.0]), at(seconds));
        if i < 60 {
            continue;
        }
        assert!(evaluation.time_to_contact() <= 0.0, "it drives after {seconds} s");
        let obstacle_motions = &evaluation.checked_state.as_ref().unwrap().obstacle_motions;
        let way = obstacle_motions[0].displacement(&clearance_geometry::math::Point::origin(), 1.0);
        assert!((way.x + 0.5).abs() < 1e-6, "{way}");
    }
}

/// Between two states, the obstacles move by what `tf` shows of the root.
#[test]
fn the_motion_of_the_root_is_a_margin_between_states() {
    for (speed, is_proven) in [(0.0, true), (0.5, true), (2.0, false)] {
        let mut room = Room::new();
        // the obstacle is 2 cm from the ball at the end
        let near = Pose::translation(2.22 + speed * 0.18, 0.0, 0.0);
        let pillar = ObjectChange::named("pillar", Operation::Move);
        room.change(ObjectChange { frame: "map".to_owned(), pose_fo: near, ..pillar });
        for step in 0..10 {
            let seconds = 0.02 * f64::from(step);
            room.send(speed * seconds, seconds);
            room.follow();
            room.monitor.note_transforms(&room.transforms);
            let input = state(seconds, [1e-4 * f64::from(step), 0.0]);
            let evaluation = room.monitor.on_joint_state(input, at(seconds));
            assert_eq!(code(&evaluation), "FREE");
            let motion = &evaluation.motion_since_previous;
            if step == 9 {
                assert_eq!(*motion == MotionSincePrevious::ProvenFree, is_proven, "{speed} m/s: {motion:?}");
                assert!(is_proven || motion.reason().unwrap().contains("root moves in 'map'"), "{motion:?}");
            }
        }
    }
}
