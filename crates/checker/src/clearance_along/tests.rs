//! Tests of least distances along motions: bounds hold at dense samples and are within the tolerance.

use std::sync::Arc;

use clearance_geometry::math::Pose;
use clearance_geometry::testing::Random;
use clearance_geometry::{Primitive, Shape};
use clearance_motion::{MotionSegment, MovingObstacle, Trajectory};
use clearance_robot::{Configuration, MeshFiles, RobotModel};
use clearance_scene::{Obstacle, Settings, World};

use crate::random_scenes::{checker, curved_motion, robot, state};
use crate::{
    CollisionChecker, LeastClearance, MotionClearance, MotionClearanceOptions, MotionOptions, MotionVerdict,
    PairKind, Question, UndecidedReason, Workspace,
};

/// Error (m) of distances by rounding.
const ROUNDING: f64 = 1e-8;

const SAMPLES: u32 = 100;

fn moved(from: &Configuration, length: f64, robot: &RobotModel, random: &mut Random) -> Configuration {
    let to: Vec<f64> = from.positions().iter().map(|q| q + random.within(length)).collect();
    robot.configuration(&to).unwrap()
}

fn length(random: &mut Random) -> f64 {
    [0.0, 0.01, 0.1, 0.5, 0.5, 3.0, 3.0, 2e4][random.below(8)]
}

/// A straight or curved motion.
fn motion(robot: &RobotModel, random: &mut Random) -> MotionSegment {
    let from = state(robot, random);
    if random.below(5) == 0 {
        return curved_motion(robot, &from, random);
    }
    let length = length(random);
    MotionSegment::straight(robot, &from, &moved(&from, length, robot, random))
}

fn options(random: &mut Random) -> MotionClearanceOptions {
    let absolute_tolerance = [1e-3, 1e-2, 1e-4][random.below(3)];
    MotionClearanceOptions { absolute_tolerance, budget: 100_000, ..MotionClearanceOptions::default() }
}

/// The least distances (m) of self pairs and of world pairs in a state.
fn distances(checker: &CollisionChecker, q: &Configuration, workspace: &mut Workspace) -> [f64; 2] {
    let report = checker.check(q, Question::SelfAndWorldDistance { limit: f64::INFINITY }, workspace);
    PairKind::ALL.map(|kind| report.distance_of(kind))
}

fn by_kind(found: &MotionClearance) -> [Option<LeastClearance>; 2] {
    PairKind::ALL.map(|kind| found.nearest_of(kind).copied())
}

/// The allowed difference of the bounds.
fn allowed(options: &MotionClearanceOptions, upper: f64) -> f64 {
    options.absolute_tolerance.max(options.relative_tolerance * upper) + ROUNDING
}

/// Compares random motions with dense samples; returns how many were finished, and how many bounds were compared.
fn compare(motions: u32, random: &mut Random) -> [u32; 2] {
    let (mut finished, mut compared) = (0, 0);
    for _ in 0..motions {
        let checker = checker(random);
        let mut workspace = checker.workspace();
        let (motion, options) = (motion(checker.robot(), random), options(random));
        let found = checker.clearance_along(&motion, &options, &mut workspace);
        finished += u32::from(found.unfinished.is_none());
        let mut least = [f64::INFINITY; 2];
        for i in 0..=SAMPLES {
            let q = motion.at(f64::from(i) / f64::from(SAMPLES));
            let sample = distances(&checker, &q, &mut workspace);
            least = [0, 1].map(|kind| least[kind].min(sample[kind]));
        }
        for (kind, found_of_kind) in PairKind::ALL.into_iter().zip(by_kind(&found)) {
            let Some(LeastClearance { lower, upper, nearest }) = found_of_kind else { continue };
            let sampled = least[kind as usize];
            assert!(lower <= upper && lower <= sampled + ROUNDING, "{lower} {sampled}");
            if found.unfinished.is_none() {
                compared += 1;
                assert!(upper - lower <= allowed(&options, upper), "{lower} {upper}");
                assert!(sampled >= upper - allowed(&options, upper), "{sampled} {upper}");
            }
            let Some(nearest) = nearest else { continue };
            let there = distances(&checker, &motion.at(nearest.t), &mut workspace)[kind as usize];
            assert!(there <= upper + ROUNDING && nearest.pair.distance == upper, "{there} {upper}");
        }
    }
    [finished, compared]
}

#[test]
fn bounds_hold_at_dense_samples_and_are_within_the_tolerance() {
    let [finished, compared] = compare(400, &mut Random::new(71));
    assert!(finished > 380 && compared > 300, "{finished} {compared}");
}

/// By hand: `cargo test --release -p clearance-checker -- --ignored --nocapture many_motions`.
#[test]
#[ignore = "takes an hour"]
fn many_motions() {
    for seed in 0..1000 {
        let [finished, compared] = compare(1000, &mut Random::new(1000 + seed));
        println!("{} motions: {finished} finished, {compared} compared", 1000 * (seed + 1));
    }
}

#[test]
fn a_motion_without_movement_has_the_distance_of_its_state() {
    let mut random = Random::new(72);
    for _ in 0..200 {
        let checker = checker(&mut random);
        let mut workspace = checker.workspace();
        let q = state(checker.robot(), &mut random);
        let motion = MotionSegment::straight(checker.robot(), &q, &q);
        let found = checker.clearance_along(&motion, &MotionClearanceOptions::default(), &mut workspace);
        let expected = distances(&checker, &q, &mut workspace);
        for (least, expected) in by_kind(&found).into_iter().zip(expected) {
            let Some(least) = least else { continue };
            assert_eq!(least.upper, expected);
        }
        assert_eq!(found.unfinished, None);
    }
}

/// The reverse motion, and the two halves of a motion, have the same least distances.
#[test]
fn bounds_of_reverse_and_divided_motions_agree() {
    let mut random = Random::new(73);
    let options = MotionClearanceOptions { budget: 100_000, ..MotionClearanceOptions::default() };
    for _ in 0..200 {
        let checker = checker(&mut random);
        let (robot, mut workspace) = (checker.robot(), checker.workspace());
        let from = state(robot, &mut random);
        let to = moved(&from, length(&mut random).min(3.0), robot, &mut random);
        let whole = MotionSegment::straight(robot, &from, &to);
        let middle = whole.at(0.5);
        let straight = |a: &Configuration, b: &Configuration| MotionSegment::straight(robot, a, b);
        let mut along = |motion: &MotionSegment| checker.clearance_along(motion, &options, &mut workspace);
        let (found, reverse) = (along(&whole), along(&straight(&to, &from)));
        let halves = [straight(&from, &middle), straight(&middle, &to)];
        let of_halves = halves.each_ref().map(&mut along);
        let trajectory = Trajectory::of_segments(halves.to_vec()).unwrap();
        let joined = checker.clearance_along_trajectory(&trajectory, &options, &mut workspace);
        for kind in PairKind::ALL {
            let Some(whole) = found.nearest_of(kind) else { continue };
            let parts = of_halves.each_ref().map(|half| half.nearest_of(kind).unwrap());
            let [lower, upper] = [parts[0].lower.min(parts[1].lower), parts[0].upper.min(parts[1].upper)];
            let others = [
                *reverse.nearest_of(kind).unwrap(),
                *joined.nearest_of(kind).unwrap(),
                LeastClearance { lower, upper, nearest: None },
            ];
            for other in others {
                assert!(whole.lower <= other.upper + ROUNDING, "{whole:?} {other:?}");
                assert!(other.lower <= whole.upper + ROUNDING, "{whole:?} {other:?}");
            }
        }
    }
}

#[test]
fn a_stopped_search_has_wider_bounds_and_a_reason() {
    let mut random = Random::new(74);
    let mut stopped = 0;
    for _ in 0..200 {
        let checker = checker(&mut random);
        let mut workspace = checker.workspace();
        let motion = motion(checker.robot(), &mut random);
        let options =
            MotionClearanceOptions { budget: random.below(6) as u64, ..MotionClearanceOptions::default() };
        let found = checker.clearance_along(&motion, &options, &mut workspace);
        let full = checker.clearance_along(&motion, &MotionClearanceOptions::default(), &mut workspace);
        for (found, full) in by_kind(&found).into_iter().zip(by_kind(&full)) {
            let (Some(found), Some(full)) = (found, full) else { continue };
            assert!(found.lower <= full.upper && full.lower <= found.upper);
        }
        stopped += u32::from(found.unfinished == Some(UndecidedReason::Budget));
    }
    assert!(stopped > 50, "{stopped}");
    let checker = checker(&mut random);
    let over = MotionClearanceOptions {
        deadline: Some(std::time::Instant::now()),
        ..MotionClearanceOptions::default()
    };
    let motion = motion(checker.robot(), &mut random);
    let found = checker.clearance_along(&motion, &over, &mut checker.workspace());
    for least in by_kind(&found).into_iter().flatten() {
        assert_eq!((least.lower, least.nearest), (0.0, None));
        assert_eq!(found.unfinished, Some(UndecidedReason::Deadline));
    }
}

/// A robot of one link that slides along an axis, from -1 m to 1 m.
fn slider(geometry: &str, axis: &str) -> Arc<RobotModel> {
    let urdf = format!(
        "<robot name='slider'><link name='base'/>
        <link name='arm'><collision><geometry>{geometry}</geometry></collision></link>
        <joint name='slide' type='prismatic'><parent link='base'/><child link='arm'/><axis xyz='{axis}'/>
          <limit lower='-1' upper='1' effort='1' velocity='1'/></joint></robot>"
    );
    Arc::new(RobotModel::from_urdf(&urdf, &MeshFiles::default()).unwrap())
}

/// A ball slides along x past another ball, 0.02 m from it: with a limit, nothing may be known of distances beyond it.
#[test]
fn a_limit_ends_the_search_with_a_proof() {
    let robot = slider("<sphere radius='0.1'/>", "1 0 0");
    for x in [0.0, 0.13, 0.37] {
        let ball = Shape::Primitive(Primitive::sphere(0.1).unwrap());
        let mut world = World::default();
        world.add(Obstacle::of_shape("ball", Pose::translation(x, 0.22, 0.0), ball)).unwrap();
        let checker = CollisionChecker::new(Arc::clone(&robot), &world, Settings::default()).unwrap();
        let [from, to] = [-0.8, 0.9].map(|slide| robot.configuration(&[slide]).unwrap());
        let motion = MotionSegment::straight(&robot, &from, &to);
        for limit in [0.001, 0.01, 0.019, 0.05, 1.0] {
            let options = MotionClearanceOptions { limit, ..MotionClearanceOptions::default() };
            let found = checker.clearance_along(&motion, &options, &mut checker.workspace());
            assert!(found.unfinished.is_none() && found.is_free(), "{x} {limit}: {found:?}");
            assert!(
                found.lower() >= limit.min(0.019) && found.lower() <= 0.02 + ROUNDING,
                "{x} {limit}: {found:?}"
            );
        }
    }
}

/// The base stands above a table; only a far cart moves. The search for this pair has no motion that it could divide.
#[test]
fn a_pair_of_standing_bodies_is_measured_among_moving_obstacles() {
    let urdf = "<robot name='arm'><link name='base'><collision><geometry><box size='1 1 0.01'/></geometry></collision></link>
        <link name='tool'><collision><geometry><box size='0.1 0.1 0.1'/></geometry></collision></link>
        <joint name='turn' type='revolute'><parent link='base'/><child link='tool'/><origin xyz='0 0 0.5'/><axis xyz='0 0 1'/>
          <limit lower='-1' upper='1' effort='1' velocity='1'/></joint></robot>";
    let robot = Arc::new(RobotModel::from_urdf(urdf, &MeshFiles::default()).unwrap());
    for gap in [0.001, 0.049, 0.2] {
        let solid = |size| Shape::Primitive(Primitive::cuboid(size).unwrap());
        let mut world = World::default();
        let table = Pose::translation(0.0, 0.0, -0.01 - gap);
        world.add(Obstacle::of_shape("table", table, solid([1.0, 1.0, 0.01]))).unwrap();
        world.add(Obstacle::of_shape("cart", Pose::translation(30.0, 0.0, 0.0), solid([0.1; 3]))).unwrap();
        let checker = CollisionChecker::new(Arc::clone(&robot), &world, Settings::default()).unwrap();
        let [from, to] = [0.0, 0.5].map(|turn| robot.configuration(&[turn]).unwrap());
        let mover = MovingObstacle {
            name: "cart".to_owned(),
            centre: [30.0, 0.0, 0.0],
            linear: [0.1, 0.0, 0.0],
            angular: [0.0; 3],
            start: None,
        };
        let motion = MotionSegment::straight(&robot, &from, &to);
        let motion = motion.with_obstacles(checker.world(), vec![mover]).unwrap();
        let options = MotionClearanceOptions::default();
        let found = checker.clearance_along(&motion, &options, &mut checker.workspace());
        assert!(found.unfinished.is_none(), "{gap}: {found:?}");
        let LeastClearance { lower, upper, .. } = found.nearest_world.unwrap();
        assert!(
            lower >= gap - allowed(&options, gap).min(0.5 * gap) - ROUNDING && upper <= gap + ROUNDING,
            "{gap}: {found:?}"
        );
    }
}

/// 160,000 turns: their parts would take gigabytes before the budget ends.
#[test]
fn a_search_with_many_waiting_intervals_is_stopped() {
    let arm = "<robot name='arm'><link name='base'/><link name='tool'><collision><origin xyz='0.5 0 0'/>
        <geometry><box size='1 0.1 0.1'/></geometry></collision></link>
        <joint name='turn' type='continuous'><parent link='base'/><child link='tool'/><axis xyz='0 0 1'/></joint></robot>";
    let robot = Arc::new(RobotModel::from_urdf(arm, &MeshFiles::default()).unwrap());
    let mut world = World::default();
    let post = Shape::Primitive(Primitive::sphere(0.1).unwrap());
    world.add(Obstacle::of_shape("post", Pose::translation(0.0, 2.0, 0.0), post)).unwrap();
    let checker = CollisionChecker::new(robot, &world, Settings::default()).unwrap();
    let [from, to] = [0.0, 1e6].map(|turn| checker.robot().configuration(&[turn]).unwrap());
    let motion = MotionSegment::straight(checker.robot(), &from, &to);
    let options = MotionClearanceOptions { budget: u64::MAX, ..MotionClearanceOptions::default() };
    let found = checker.clearance_along(&motion, &options, &mut checker.workspace());
    assert_eq!(found.unfinished, Some(UndecidedReason::Budget));
    let world = found.nearest_world.unwrap();
    let least = 1.9 - 1.0_f64.hypot(0.05);
    assert!(world.lower <= least && world.upper >= least - ROUNDING, "{world:?}");
}

/// With a tracking tolerance, the lower bound holds for states off the motion.
#[test]
fn a_motion_of_another_robot_is_not_free_even_without_pairs() {
    let mut random = Random::new(76);
    let of_length = |random: &mut Random, count: usize| {
        std::iter::repeat_with(|| robot(random)).find(|robot| robot.position_names().len() == count).unwrap()
    };
    let (own, other) = (of_length(&mut random, 2), of_length(&mut random, 3));
    let settings = Settings { check_self: false, check_world: false, ..Settings::default() };
    let checker = CollisionChecker::new(Arc::new(own), &World::default(), settings).unwrap();
    let search = |robot: &RobotModel, random: &mut Random| {
        let motion = motion(robot, random);
        let options = MotionClearanceOptions::default();
        checker.clearance_along(&motion, &options, &mut checker.workspace())
    };
    let own = search(checker.robot(), &mut random);
    assert!(own.is_free() && own.unfinished.is_none());
    let foreign = search(&other, &mut random);
    assert!(!foreign.is_free() && foreign.unfinished == Some(UndecidedReason::Mismatch));
}

#[test]
fn lower_bounds_hold_within_tracking_tolerances_and_for_moving_obstacles() {
    let mut random = Random::new(75);
    for _ in 0..150 {
        let checker = checker(&mut random);
        let (robot, mut workspace) = (checker.robot(), checker.workspace());
        let from = state(robot, &mut random);
        let to = moved(&from, 0.5, robot, &mut random);
        let tube: Vec<f64> = from.positions().iter().map(|_| random.within(0.01).abs()).collect();
        let motion = MotionSegment::straight(robot, &from, &to).with_tube(robot, tube.clone()).unwrap();
        let options = MotionClearanceOptions { budget: 100_000, ..MotionClearanceOptions::default() };
        let found = checker.clearance_along(&motion, &options, &mut workspace);
        for i in 0..=20 {
            let centre = motion.at(f64::from(i) / 20.0);
            let loose: Vec<f64> =
                centre.positions().iter().zip(&tube).map(|(q, tube)| q + random.within(*tube)).collect();
            let there = distances(&checker, &robot.configuration(&loose).unwrap(), &mut workspace);
            for (least, there) in by_kind(&found).into_iter().zip(there) {
                assert!(least.is_none_or(|least| least.lower <= there + ROUNDING));
            }
        }
        moving_obstacle(&checker, &from, &to, &mut random);
    }
}

/// Compares with the obstacle placed at its pose at dense times.
fn moving_obstacle(
    checker: &CollisionChecker,
    from: &Configuration,
    to: &Configuration,
    random: &mut Random,
) {
    let Some(name) = checker.world().obstacles().next().map(|obstacle| obstacle.name.clone()) else { return };
    let mover = MovingObstacle {
        name: name.clone(),
        linear: random.vector(0.4).into(),
        angular: random.vector(0.4).into(),
        centre: [0.0; 3],
        start: None,
    };
    let motion = MotionSegment::straight(checker.robot(), from, to);
    let motion = motion.with_obstacles(checker.world(), vec![mover]).unwrap();
    let options = MotionClearanceOptions { budget: 20_000, ..MotionClearanceOptions::default() };
    let found = checker.clearance_along(&motion, &options, &mut checker.workspace());
    let mover = &motion.obstacles()[0];
    for i in 0..=10 {
        let t = f64::from(i) / 10.0;
        let mut world = World::default();
        for obstacle in checker.world().obstacles() {
            let mut obstacle = obstacle.clone();
            if obstacle.name == name {
                obstacle.pose_ro = mover.displacement(t) * obstacle.pose_ro;
            }
            world.add(obstacle).unwrap();
        }
        for attached in checker.world().attached() {
            world.attach((**attached).clone()).unwrap();
        }
        let there = checker.with_world(&world, checker.settings().clone(), None).unwrap();
        let distances = distances(&there, &motion.at(t), &mut there.workspace());
        for (least, distance) in by_kind(&found).into_iter().zip(distances) {
            let Some(least) = least else { continue };
            assert!(least.lower <= distance + ROUNDING, "{least:?} {distance}");
            if found.unfinished.is_none() {
                assert!(distance >= least.upper - allowed(&options, least.upper));
            }
        }
    }
}

#[test]
fn a_distance_is_first_reached_where_dense_samples_reach_it() {
    let mut random = Random::new(76);
    let mut counts = [0; 3];
    for _ in 0..400 {
        let checker = checker(&mut random);
        let mut workspace = checker.workspace();
        let motion = motion(checker.robot(), &mut random);
        let distance = [0.0, 0.01, 0.1, 0.5][random.below(4)];
        let options = MotionOptions { budget: 100_000, ..MotionOptions::default() };
        let report = checker.event_distance(&motion, distance, &options, &mut workspace);
        let mut least = |t: f64| {
            distances(&checker, &motion.at(t), &mut workspace).into_iter().fold(f64::INFINITY, f64::min)
        };
        let free_until = match report.verdict {
            MotionVerdict::Free => {
                counts[0] += 1;
                2.0
            }
            MotionVerdict::Contact { t: [before, at], .. } => {
                counts[1] += 1;
                assert!(least(at) <= distance + ROUNDING && before <= at);
                before
            }
            MotionVerdict::Undecided { t: [before, _], .. } => {
                counts[2] += 1;
                before
            }
        };
        for t in (0..=SAMPLES).map(|i| f64::from(i) / f64::from(SAMPLES)).filter(|t| *t < free_until) {
            assert!(least(t) > distance - ROUNDING, "{t} {free_until}");
        }
    }
    assert!(counts[0] > 50 && counts[1] > 50 && counts[2] < 40, "{counts:?}");
}

/// Two balls of 5 cm on a palm that is turned by half a radian: one of them moves towards the other.
const FINGERS: &str = "<robot name='hand'><link name='base'/><link name='palm'/>
<joint name='turn' type='continuous'><parent link='base'/><child link='palm'/><origin xyz='1 0 0'/><axis xyz='0 0 1'/></joint>
<link name='left'><collision><geometry><sphere radius='0.05'/></geometry></collision></link>
<joint name='close' type='prismatic'><parent link='palm'/><child link='left'/><origin xyz='0 0.2 0'/><axis xyz='0 -1 0'/>
  <limit lower='-1' upper='1' effort='1' velocity='1'/></joint>
<link name='right'><collision><origin xyz='0 -0.2 0'/><geometry><sphere radius='0.05'/></geometry></collision></link>
<joint name='fixed' type='revolute'><parent link='palm'/><child link='right'/><axis xyz='0 1 0'/>
  <limit lower='-1' upper='1' effort='1' velocity='1'/></joint></robot>";

/// The common ancestor of the pair is the palm.
#[test]
fn witness_points_of_two_links_are_in_the_root_frame() {
    let robot = Arc::new(RobotModel::from_urdf(FINGERS, &MeshFiles::default()).unwrap());
    let checker = CollisionChecker::new(robot, &World::default(), Settings::default()).unwrap();
    let robot = checker.robot();
    for (closed, touches) in [(0.1, false), (0.35, true)] {
        let [from, to] = [0.0, closed].map(|close| robot.configuration(&[0.5, close, 0.0]).unwrap());
        let motion = MotionSegment::straight(robot, &from, &to);
        let found =
            checker.clearance_along(&motion, &MotionClearanceOptions::default(), &mut checker.workspace());
        let nearest = found.nearest_self.unwrap().nearest.unwrap();
        let (left, right) = (0.2 - closed * nearest.t, -0.2);
        assert_eq!(nearest.pair.distance == 0.0, touches, "{nearest:?}");
        let (sin, cos) = 0.5_f64.sin_cos();
        for (point, [centre, towards]) in
            nearest.pair.witness_points.iter().zip([[left, -0.05], [right, 0.05]])
        {
            let in_palm = [point.x - 1.0, point.y];
            let [x, y] = [in_palm[0] * cos + in_palm[1] * sin, in_palm[1] * cos - in_palm[0] * sin];
            if touches {
                assert!(x.hypot(y - centre) <= 0.05 + 1e-9, "{nearest:?}");
            } else {
                assert!(x.abs() < 1e-9 && (y - centre - towards).abs() < 1e-9, "{x} {y}: {nearest:?}");
            }
        }
    }
}

/// A box slides along a wall, 0.1 m from it, by 0.16 m.
#[test]
fn lower_bounds_within_tracking_tolerances_are_near_the_distance() {
    let robot = slider("<box size='0.1 0.1 0.1'/>", "0 1 0");
    let wall = Shape::Primitive(Primitive::Box { half_extents: [1.0, 1.0, 1.0] });
    let mut world = World::default();
    world.add(Obstacle::of_shape("wall", Pose::translation(1.15, 0.0, 0.0), wall)).unwrap();
    let checker = CollisionChecker::new(robot, &world, Settings::default()).unwrap();
    let at = |q: f64| checker.robot().configuration(&[q]).unwrap();
    for tube in [1e-4, 1e-3, 0.01, 0.05] {
        let motion = MotionSegment::straight(checker.robot(), &at(-0.08), &at(0.08));
        let motion = motion.with_tube(checker.robot(), vec![tube]).unwrap();
        let options = MotionClearanceOptions::default();
        let found = checker.clearance_along(&motion, &options, &mut checker.workspace());
        let LeastClearance { lower, upper, .. } = found.nearest_world.unwrap();
        assert!((upper - 0.1).abs() < 1e-9 && lower <= 0.1, "{found:?}");
        assert!(lower > 0.1 - tube - 2.0 * options.absolute_tolerance, "{tube}: {found:?}");
    }
}
