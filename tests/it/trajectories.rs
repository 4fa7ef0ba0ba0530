//! Tests of motion and trajectory checks with hand-computed results: contacts, tubes, look-ahead, swept volumes.

use clearance::checker::{
    CollisionChecker, LookAheadState, MotionOptions, MotionOrder, MotionReport, MotionVerdict, PairKind,
    Question, UndecidedReason, Watch,
};
use clearance::geometry::math::{Pose, Vector};
use clearance::geometry::{Primitive, Shape};
use clearance::motion::{
    Certificate, MotionSegment, MovingObstacle, ObstacleLimits, SpeedLimit, Trajectory, TrajectoryPoint,
};
use clearance::robot::{Configuration, MeshFiles, RobotModel};
use clearance::scene::{BodyId, Settings};
use clearance::scene::{Obstacle, World};
use clearance::verifier::{Rejection, verify};
use std::f64::consts::PI;
use std::path::Path;
use std::sync::Arc;
use std::time::Instant;

/// Where, with `joint1` at 0, folding `joint2` brings the ball of `two_link` to the cube (derived in its URDF).
const FOLDED: f64 = 2.836_899_95;

fn two_link() -> Arc<RobotModel> {
    let urdf = Path::new(env!("CARGO_MANIFEST_DIR")).join("urdf/two_link/two_link.urdf");
    Arc::new(RobotModel::load(&urdf, None, &[]).unwrap())
}

fn checker(robot: &Arc<RobotModel>, world: &World, settings: Settings) -> CollisionChecker {
    CollisionChecker::new(robot.clone(), world, settings).unwrap()
}

fn alone(robot: &Arc<RobotModel>) -> CollisionChecker {
    checker(robot, &World::default(), Settings::default())
}

fn at(robot: &RobotModel, q1: f64, q2: f64) -> Configuration {
    robot.configuration_from_names([("joint1", q1), ("joint2", q2)]).unwrap()
}

fn ask(checker: &CollisionChecker, segment: &MotionSegment) -> MotionReport {
    checker.check_motion_with(segment, &MotionOptions::default(), &mut checker.workspace())
}

fn obstacle(name: &str, primitive: Primitive, xyz: [f64; 3]) -> World {
    let pose = Pose::translation(xyz[0], xyz[1], xyz[2]);
    let mut world = World::default();
    world.add(Obstacle::of_shape(name, pose, Shape::Primitive(primitive))).unwrap();
    world
}

/// Where the contact lies, which has to be known within `width`.
fn contact(report: &MotionReport, width: f64) -> f64 {
    let MotionVerdict::Contact { t: [lo, hi], .. } = report.verdict else { panic!("{report:?}") };
    assert!(lo <= hi && hi - lo <= width, "{report:?}");
    0.5 * (lo + hi)
}

#[test]
fn the_first_contact_is_where_it_is() {
    let robot = two_link();
    let checker = alone(&robot);
    let report = checker.check_motion(&at(&robot, 0.0, 0.0), &at(&robot, 0.0, 3.0), &mut checker.workspace());
    assert!((contact(&report, 1e-3) * 3.0 - FOLDED).abs() < 1e-3);
    let free = checker.check_motion(&at(&robot, 0.0, 0.0), &at(&robot, 0.0, 2.83), &mut checker.workspace());
    assert!(free.is_free(), "{free:?}");
    let start = checker.check_motion(&at(&robot, 0.0, 3.0), &at(&robot, 0.0, 0.0), &mut checker.workspace());
    assert!(matches!(start.verdict, MotionVerdict::Contact { t: [0.0, 0.0], .. }), "{start:?}");
}

#[test]
fn padding_brings_contact_forward() {
    let robot = two_link();
    let settings = Settings { padding: 0.01, pad_self: true, ..Settings::default() };
    let checker = checker(&robot, &World::default(), settings);
    let report = checker.check_motion(&at(&robot, 0.0, 0.0), &at(&robot, 0.0, 3.0), &mut checker.workspace());
    // both links are padded: the ball is within 2 cm of the cube where sin q2 = 0.32
    let padded = std::f64::consts::PI - 0.32_f64.asin();
    assert!((contact(&report, 1e-3) * 3.0 - padded).abs() < 1e-3);
}

/// A wall a millimetre thin that no end pose touches, swept by a bar; and a full turn between equal poses.
#[test]
fn a_bullet_does_not_go_through_paper() {
    let urdf =
        "<robot name='bar'><link name='root'/><link name='bar'><collision><origin xyz='0.5 0 0'/><geometry>
        <box size='1 0.002 0.002'/></geometry></collision></link><joint name='spin' type='continuous'>
        <parent link='root'/><child link='bar'/><axis xyz='0 0 1'/></joint></robot>";
    let robot = Arc::new(RobotModel::from_urdf(urdf, &MeshFiles::default()).unwrap());
    let paper = obstacle("paper", Primitive::cuboid([0.001, 0.2, 0.2]).unwrap(), [-0.7, 0.0, 0.0]);
    let checker = checker(&robot, &paper, Settings::default());
    let spin = |turn: f64| robot.configuration(&[turn]).unwrap();
    let tau = std::f64::consts::TAU;
    for order in [MotionOrder::Earliest, MotionOrder::Any] {
        for (from, to) in [(0.0, tau), (-3.0, 3.3), (3.0, 3.3), (0.0, 100.0 * tau)] {
            let segment = MotionSegment::straight(&robot, &spin(from), &spin(to));
            let options = MotionOptions { order, ..MotionOptions::default() };
            let report = checker.check_motion_with(&segment, &options, &mut checker.workspace());
            assert!(matches!(report.verdict, MotionVerdict::Contact { .. }), "{from} {to}: {report:?}");
        }
        assert!(ask(&checker, &MotionSegment::straight(&robot, &spin(-2.9), &spin(2.9))).is_free());
    }
}

#[test]
fn a_tracking_tolerance_leaves_open_what_it_may_touch() {
    let robot = two_link();
    let checker = alone(&robot);
    let way = |until: f64, off: f64| {
        let (from, to) = (at(&robot, 0.0, 0.0), at(&robot, 0.0, until));
        MotionSegment::straight(&robot, &from, &to).with_tube(&robot, vec![off; 2]).unwrap()
    };
    assert!(ask(&checker, &way(2.6, 0.05)).is_free());
    let open = ask(&checker, &way(2.8, 0.05));
    let MotionVerdict::Undecided { t: [lo, _], reason, .. } = open.verdict else { panic!("{open:?}") };
    assert_eq!(reason, UndecidedReason::Tube);
    // both joints may be off, and with them any of the tip by up to 0.1 m or so
    assert!(lo * 2.8 < FOLDED - 0.05 && lo * 2.8 > 2.6, "{open:?}");
    let hit = ask(&checker, &way(3.0, 0.05));
    assert!(
        matches!(hit.verdict, MotionVerdict::Contact { t: [lo, hi], .. } if lo * 3.0 < FOLDED - 0.05 && hi * 3.0 > FOLDED)
    );
}

/// What a tolerance leaves open ends the search, but a contact is told where it is.
#[test]
fn contact_within_a_tracking_tolerance_is_contact() {
    let robot = two_link();
    let checker = alone(&robot);
    let (from, to) = (at(&robot, 0.0, 2.82), at(&robot, 0.0, 2.86));
    let segment = MotionSegment::straight(&robot, &from, &to).with_tube(&robot, vec![0.002; 2]).unwrap();
    let report = ask(&checker, &segment);
    let MotionVerdict::Contact { t: [lo, hi], .. } = report.verdict else { panic!("{report:?}") };
    assert!(!checker.is_free(&segment.at(hi), &mut checker.workspace()), "{report:?}");
    assert!(2.82 + 0.04 * lo < FOLDED - 0.002, "{report:?}");
}

/// Numbers that overflow prove nothing, and what would stand still although it is to move is not free.
#[test]
fn what_cannot_be_computed_is_not_free() {
    let robot = two_link();
    let world = obstacle("ball", Primitive::sphere(0.1).unwrap(), [2.0, 2.0, 0.0]);
    let q = at(&robot, 0.0, 0.0);
    let still = || MotionSegment::straight(&robot, &q, &q);
    let mover = |linear, angular| MovingObstacle {
        name: "ball".to_owned(),
        centre: [2.0, 2.0, 0.0],
        linear,
        angular,
        start: None,
    };
    for (linear, angular) in [([0.0; 3], [1e200, 0.0, 0.0]), ([f64::NAN, 0.0, 0.0], [0.0; 3])] {
        assert!(still().with_obstacles(&world, vec![mover(linear, angular)]).is_err());
    }
    let moving = still().with_obstacles(&world, vec![mover([0.0; 3], [0.0; 3])]).unwrap();
    let report = ask(&alone(&robot), &moving);
    let unknown = UndecidedReason::Mismatch;
    assert!(matches!(report.verdict, MotionVerdict::Undecided { reason, .. } if reason == unknown));
}

/// Work is bounded, whatever is asked.
#[test]
fn no_motion_takes_for_ever() {
    let robot = two_link();
    let checker = alone(&robot);
    let inside = checker.check_motion(&at(&robot, 0.0, 3.0), &at(&robot, 0.0, 3.0), &mut checker.workspace());
    assert!(matches!(inside.verdict, MotionVerdict::Contact { t: [0.0, 0.0], .. }), "{inside:?}");
    assert!(inside.evaluations < 50, "{inside:?}");
    let spin = MotionSegment::straight(&robot, &at(&robot, 0.0, 2.8), &at(&robot, 3e7, 2.8));
    for order in [MotionOrder::Earliest, MotionOrder::Any] {
        let options = MotionOptions { order, budget: 10_000, tolerance: 1e-300, ..MotionOptions::default() };
        let report = checker.check_motion_with(&spin, &options, &mut checker.workspace());
        assert!(!report.is_free() && report.evaluations < 20_000, "{report:?}");
    }
}

/// A ball that comes towards the tip and passes in front of it, or hits it.
#[test]
fn obstacles_move_on_the_same_clock() {
    let robot = two_link();
    let world = obstacle("ball", Primitive::sphere(0.1).unwrap(), [2.0, 2.0, 0.0]);
    let checker = checker(&robot, &world, Settings::default());
    let still = at(&robot, 0.0, 0.0);
    let ball = |linear: [f64; 3]| MovingObstacle {
        name: "ball".to_owned(),
        centre: [2.0, 2.0, 0.0],
        linear,
        angular: [0.0, 0.0, 1.0],
        start: None,
    };
    let motion = |linear| {
        MotionSegment::straight(&robot, &still, &still).with_obstacles(&world, vec![ball(linear)]).unwrap()
    };
    // the tip's ball is at (2, 0): they touch when the centres are 0.2 apart
    let report = ask(&checker, &motion([0.0, -2.0, 0.0]));
    assert!((contact(&report, 1e-3) - 0.9).abs() < 1e-3);
    assert!(ask(&checker, &motion([0.0, -1.75, 0.0])).is_free());
    let unknown = MotionSegment::straight(&robot, &still, &still);
    let nowhere = MovingObstacle { name: "bal".to_owned(), ..ball([0.0; 3]) };
    assert!(unknown.with_obstacles(&world, vec![nowhere]).is_err(), "it would stand where it is");
    // the arm turns out of the way meanwhile
    let away = MotionSegment::straight(&robot, &still, &at(&robot, -1.0, 0.0));
    assert!(ask(&checker, &away.with_obstacles(&world, vec![ball([0.0, -2.0, 0.0])]).unwrap()).is_free());
}

#[test]
fn trajectories_report_segment_and_time() {
    let robot = two_link();
    let checker = alone(&robot);
    let joints = ["joint1", "joint2"].map(str::to_owned);
    let point = |q2: f64, v2: Option<f64>, time: f64| TrajectoryPoint {
        positions: vec![0.0, q2],
        velocities: v2.map_or_else(Vec::new, |v| vec![0.0, v]),
        accelerations: Vec::new(),
        time_from_start: time,
    };
    let rest = robot.default_configuration();
    let ask = |points: &[TrajectoryPoint]| {
        let trajectory = Trajectory::from_points(&robot, &joints, points, &rest).unwrap();
        checker.check_trajectory(&trajectory, &MotionOptions::default(), &mut checker.workspace())
    };
    let straight = ask(&[point(0.0, None, 0.0), point(2.0, None, 2.0), point(3.0, None, 3.0)]);
    assert_eq!(straight.segment, 1);
    let [lo, hi] = straight.time.unwrap();
    assert!(lo <= FOLDED + 1e-6 && FOLDED <= hi + 1e-6 && hi - lo < 1e-3, "{straight:?}");
    // straight pieces stay below, the cubic one overshoots
    assert!(ask(&[point(2.6, None, 0.0), point(2.6, None, 1.0)]).is_free());
    let bent = ask(&[point(2.6, Some(1.5), 0.0), point(2.6, Some(-1.5), 1.0)]);
    assert!(matches!(bent.verdict, MotionVerdict::Contact { .. }), "{bent:?}");
    // at most 2.6 + 1.5/4 · 0.6
    assert!(ask(&[point(2.6, Some(0.9), 0.0), point(2.6, Some(-0.9), 1.0)]).is_free());
}

#[test]
fn who_runs_out_of_time_says_so() {
    let robot = two_link();
    let checker = alone(&robot);
    let segment = MotionSegment::straight(&robot, &at(&robot, 0.0, 0.0), &at(&robot, 0.0, 2.83));
    for (options, wanted) in [
        (
            MotionOptions { deadline: Some(Instant::now()), ..MotionOptions::default() },
            UndecidedReason::Deadline,
        ),
        (MotionOptions { budget: 3, ..MotionOptions::default() }, UndecidedReason::Budget),
    ] {
        let report = checker.check_motion_with(&segment, &options, &mut checker.workspace());
        let MotionVerdict::Undecided { reason, t, .. } = report.verdict else { panic!("{report:?}") };
        assert!(reason == wanted && t[0] < 1.0 && t[1] == 1.0, "{report:?}");
    }
}

#[test]
fn a_watched_search_reports_progress_and_stops_on_request() {
    let robot = two_link();
    let checker = alone(&robot);
    let ends = [0.0, 1.0, 2.0, PI, 2.0].map(|joint2| at(&robot, 0.0, joint2));
    let segments = ends.windows(2).map(|ends| MotionSegment::straight(&robot, &ends[0], &ends[1])).collect();
    let trajectory = Trajectory::of_segments(segments).unwrap();
    let watch = Watch::default();
    let options = MotionOptions { watch: Some(watch.clone()), ..MotionOptions::default() };
    let report = checker.check_trajectory(&trajectory, &options, &mut checker.workspace());
    assert!(matches!(report.verdict, MotionVerdict::Contact { .. }), "{report:?}");
    assert_eq!((report.segment, watch.segments_free()), (2, 2));

    watch.stop();
    let report = checker.check_trajectory(&trajectory, &options, &mut checker.workspace());
    let MotionVerdict::Undecided { reason, t, .. } = report.verdict else { panic!("{report:?}") };
    assert_eq!((reason, t, report.segment), (UndecidedReason::Canceled, [0.0, 1.0], 0));
    let (report, certificate) = checker.certify_trajectory(&trajectory, &options, &mut checker.workspace());
    assert!(!report.is_free() && certificate.is_none());
    // also within a segment
    let long = MotionSegment::straight(&robot, &ends[0], &at(&robot, 0.0, 2.83));
    let report = checker.check_motion_with(&long, &options, &mut checker.workspace());
    let MotionVerdict::Undecided { reason, .. } = report.verdict else { panic!("{report:?}") };
    assert_eq!(reason, UndecidedReason::Canceled);
}

#[test]
fn threads_and_instruction_sets_change_no_answer() {
    let robot = two_link();
    let checker = alone(&robot);
    let segments: Vec<MotionSegment> = (0..200)
        .map(|i| {
            let from = at(&robot, 0.03 * f64::from(i), 2.8 - 0.02 * f64::from(i % 50));
            MotionSegment::straight(&robot, &from, &at(&robot, 1.0, 2.84 - 0.001 * f64::from(i % 7)))
        })
        .collect();
    for order in [MotionOrder::Earliest, MotionOrder::Any] {
        let options = MotionOptions { order, ..MotionOptions::default() };
        let on = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| checker.check_motions(&segments, &options))
        };
        let one = on(1);
        assert!(one == on(2) && one == on(5));
        let mut portable = checker.portable_workspace();
        for (segment, report) in segments.iter().zip(&one) {
            assert_eq!(*report, checker.check_motion_with(segment, &options, &mut portable));
        }
    }
}

/// What the capsules of a swept volume promise: no point of a link ever lies outside.
#[test]
fn swept_volumes_hold_what_is_swept() {
    let robot = two_link();
    let checker = alone(&robot);
    let (from, to) = (at(&robot, -1.0, 0.5), at(&robot, 1.5, -2.0));
    let segment = MotionSegment::straight(&robot, &from, &to);
    let tip = robot.link_by_name("tip").unwrap();
    for intervals in [1, 7, 100] {
        let volumes = checker.swept_volumes(&segment, intervals, &mut checker.workspace());
        for i in 0..=1000 {
            let t = f64::from(i) / 1000.0;
            let mut poses = clearance::robot::LinkPoses::new(&robot);
            robot.forward_kinematics(&segment.at(t), &mut poses);
            for end in [Vector::zeros(), Vector::x()] {
                let ball = poses.pose(tip) * clearance::geometry::math::Point::from(end);
                let holds = volumes
                    .iter()
                    .filter(|v| v.body == BodyId::Link(tip) && v.t[0] <= t && t <= v.t[1])
                    .any(|v| {
                        let axis = v.b - v.a;
                        let along = (axis.dot(&(ball - v.a)) / axis.norm_squared()).clamp(0.0, 1.0);
                        (ball - (v.a + axis * along)).norm() + 0.1 <= v.radius + 1e-9
                    });
                assert!(holds, "{intervals} intervals, t = {t}");
            }
        }
        let widest = volumes.iter().map(|v| v.radius).fold(0.0, f64::max);
        assert!(intervals < 100 || widest < 0.3, "many intervals make tight volumes: {widest}");
    }
}

#[test]
fn nothing_touches_before_the_look_ahead_says() {
    let robot = two_link();
    let checker = alone(&robot);
    let q = at(&robot, 0.0, 2.0);
    let look = |velocities: [f64; 2], accelerations: [f64; 2], horizon| {
        let state = LookAheadState {
            q: &q,
            velocities: &velocities,
            accelerations: &accelerations,
            moving_obstacles: &[],
            obstacle_limits: None,
            obstacle_latency: 0.0,
            only_moving_obstacles: false,
        };
        checker.look_ahead(state, horizon, &mut checker.workspace()).unwrap()
    };
    let still = look([0.0; 2], [0.0; 2], 1.0);
    assert_eq!((still.free_for, still.first), (1.0, None));
    // joint2 closes 0.8369 rad at 1 rad/s, and sooner if it may accelerate by 2 rad/s²
    let coasting = look([0.0, 1.0], [0.0; 2], 2.0);
    let real = FOLDED - 2.0;
    assert!(
        coasting.free_for <= real && coasting.free_for > 0.97 * real && coasting.first.is_some(),
        "{coasting:?}"
    );
    let pushing = look([0.0, 1.0], [0.0, 2.0], 2.0);
    let soonest = 0.5 * ((1.0 + 4.0 * real).sqrt() - 1.0);
    assert!(pushing.free_for <= soonest && pushing.free_for > 0.8 * soonest, "{pushing:?} {soonest}");
}

/// A ball 1 m before the stretched arm, which stands: it comes at 0.5 m/s, or accelerates.
#[test]
fn obstacles_that_move_come_within_the_look_ahead() {
    let robot = two_link();
    let mut world = World::default();
    let q = at(&robot, 0.0, 0.0);
    let ball = |x: f64| {
        Obstacle::of_shape(
            "ball",
            Pose::translation(x, 0.0, 0.0),
            Shape::Primitive(Primitive::Sphere { radius: 0.1 }),
        )
    };
    world.add(ball(4.0)).unwrap();
    let checker = CollisionChecker::new(Arc::clone(&robot), &world, Settings::default()).unwrap();
    let report =
        checker.check(&q, Question::SelfAndWorldDistance { limit: f64::INFINITY }, &mut checker.workspace());
    let distance = report.distance_of(PairKind::WorldPair);
    let look = |speed: f64, acceleration: f64, latency: f64| {
        let by_name = [("ball".to_owned(), SpeedLimit { speed, acceleration })].into();
        let limits = Arc::new(ObstacleLimits { by_name, ..ObstacleLimits::default() });
        let state = LookAheadState {
            q: &q,
            velocities: &[0.0; 2],
            accelerations: &[0.0; 2],
            moving_obstacles: &[],
            obstacle_limits: Some(&limits),
            obstacle_latency: latency,
            only_moving_obstacles: false,
        };
        checker.look_ahead(state, 10.0, &mut checker.workspace()).unwrap()
    };
    let stands = look(0.0, 0.0, 3.0);
    assert_eq!((stands.free_for, stands.first), (10.0, None));
    for (speed, acceleration, latency, soonest) in [
        (0.5, 0.0, 0.0, distance / 0.5),
        (0.5, 0.0, 0.5, distance / 0.5 - 0.5),
        (0.0, 2.0, 0.0, distance.sqrt()),
    ] {
        let found = look(speed, acceleration, latency);
        assert!(found.free_for <= soonest && found.free_for > 0.9 * soonest, "{found:?} {soonest}");
        assert!(matches!(found.first, Some((_, BodyId::Obstacle(_)))));
    }
}

type Change = dyn Fn(&mut Certificate);

/// A digest that fits makes no proof: what is claimed is looked at.
#[test]
fn altered_certificates_are_rejected() {
    let robot = two_link();
    let (settings, world) = (Settings::default(), World::default());
    let checker = checker(&robot, &world, settings.clone());
    let (from, to) = (at(&robot, 0.0, 0.0), at(&robot, 0.3, 2.83));
    let segment = MotionSegment::straight(&robot, &from, &to);
    let options = MotionOptions::default();
    let (_, certificate) = checker.certify_motion(&segment, &options, &mut checker.workspace());
    let certificate = certificate.unwrap();
    let verdict = |c: &Certificate| verify(&robot, &world, &settings, None, c);
    assert_eq!(verdict(&certificate).unwrap().proofs, certificate.segments[0].proofs.len());
    assert_eq!(Certificate::from_json(&certificate.to_json()).unwrap(), certificate);

    let resealed = |change: &dyn Fn(&mut Certificate)| {
        let mut altered = certificate.clone();
        change(&mut altered);
        assert!(matches!(verdict(&altered), Err(Rejection::Digest)), "the old digest");
        altered.motion = altered.motion_hash();
        altered.digest = altered.content_hash();
        altered
    };
    let changes: [(&str, &Change); 8] = [
        ("a goal further on", &|c| c.segments[0].motion.to.as_mut().unwrap()[1] = 2.9),
        ("another start", &|c| c.segments[0].motion.from.as_mut().unwrap()[1] = -2.5),
        ("a proof less", &|c| {
            c.segments[0].proofs.pop();
        }),
        ("a longer interval", &|c| c.segments[0].proofs[0].2 += 0.05),
        ("a larger distance", &|c| c.segments[0].proofs.iter_mut().for_each(|p| p.3 += 0.05)),
        ("a smaller bound", &|c| c.segments[0].proofs.iter_mut().for_each(|p| p.4 *= 0.5)),
        ("another model", &|c| c.model = "0".repeat(64)),
        ("other pairs", &|c| c.pairs[0][1] = "upper".to_owned()),
    ];
    for (name, change) in changes {
        assert!(verdict(&resealed(change)).is_err(), "{name}");
    }
}
