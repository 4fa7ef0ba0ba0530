//! Test helper: robots, worlds and certificates that the tests in `mutations` alter.

use std::sync::Arc;

use clearance::geometry::math::{Point, Pose};
use clearance::geometry::{Primitive, Shape};
use clearance::motion::{
    Certificate, MotionSegment, MovingObstacle, ObstacleTrajectory, Trajectory, TrajectoryPoint,
};
use clearance::robot::RobotModel;
use clearance::scene::Settings;
use clearance::scene::{AttachedObject, World};

use super::{Scene, obstacle, sheet, wall};
use crate::random::Random;

/// A document to alter, and the motion that it is about; none if it is forged from the start.
pub struct Base {
    pub name: &'static str,
    pub scene: Scene,
    pub certificate: Certificate,
    pub motion: Option<Trajectory>,
}

fn joint(name: &str, kind: &str, [parent, child]: [&str; 2], origin: &str, axis: &str, more: &str) -> String {
    format!(
        "<joint name='{name}' type='{kind}'><parent link='{parent}'/><child link='{child}'/><origin xyz='{origin}'/>
         <axis xyz='{axis}'/><limit lower='-9' upper='9' effort='1' velocity='1'/>{more}</joint>"
    )
}

fn ball_link(name: &str, x: f64, radius: f64) -> String {
    format!(
        "<link name='{name}'><collision><origin xyz='{x} 0 0'/><geometry><sphere radius='{radius}'/></geometry></collision></link>"
    )
}

/// Three links with balls, of which the first and the last may meet.
fn arm() -> String {
    [
        "<robot name='arm'><link name='base'/>".to_owned(),
        ball_link("a", 0.3, 0.12),
        ball_link("b", 0.25, 0.05),
        ball_link("c", 0.3, 0.05),
        joint("j1", "revolute", ["base", "a"], "0 0 0", "0 0 1", ""),
        joint("j2", "revolute", ["a", "b"], "0.5 0 0", "0 0.1 1", ""),
        joint(
            "j3",
            "revolute",
            ["b", "c"],
            "0.5 0 0",
            "0 0 1",
            "<mimic joint='j2' multiplier='-1.5' offset='0.2'/>",
        ),
        "</robot>".to_owned(),
    ]
    .concat()
}

/// A slide with a ball that follows another a thousand times as fast.
fn fast_follower() -> String {
    [
        "<robot name='follower'><link name='base'/><link name='leader'/>".to_owned(),
        ball_link("tool", 0.0, 0.05),
        joint("lead", "prismatic", ["base", "leader"], "0 0 0", "0 1 0", ""),
        joint(
            "follow",
            "prismatic",
            ["base", "tool"],
            "0 0 0",
            "1 0 0",
            "<mimic joint='lead' multiplier='1e9'/>",
        ),
        "</robot>".to_owned(),
    ]
    .concat()
}

fn shapes() -> World {
    let mut world = World::default();
    let ball = |radius: f64| Shape::Primitive(Primitive::sphere(radius).unwrap());
    let cube = Shape::Primitive(Primitive::cuboid([0.1, 0.2, 0.3]).unwrap());
    world.add(obstacle("ball", ball(0.1), [0.9, 0.9, 0.0])).unwrap();
    world.add(obstacle("box", cube, [0.2, -1.1, 0.1])).unwrap();
    world.add(obstacle("sheet", sheet(), [1.45, -0.3, 0.0])).unwrap();
    world
}

/// The free trajectory of some that comes nearest to something: the one whose proof has most intervals.
fn nearest(
    scene: &Scene,
    random: &mut Random,
    way: impl Fn(&mut Random) -> Trajectory,
) -> (Certificate, Trajectory) {
    let found = (0..300).filter_map(|_| {
        let way = way(random);
        Some((scene.certify(&way)?, way))
    });
    let size = |c: &Certificate| c.segments.iter().map(|s| s.proofs.len()).sum::<usize>();
    found.filter(|(c, _)| size(c) < 400).take(30).max_by_key(|(c, _)| size(c)).expect("one of them is free")
}

fn points(random: &mut Random, extent: f64, bent: bool) -> Vec<TrajectoryPoint> {
    (0..4)
        .map(|i| TrajectoryPoint {
            positions: (0..2).map(|_| random.within(-extent, extent)).collect(),
            velocities: if bent && i > 0 {
                (0..2).map(|_| random.within(-0.3, 0.3)).collect()
            } else {
                vec![]
            },
            accelerations: vec![],
            time_from_start: f64::from(i),
        })
        .collect()
}

fn way_of_arm(robot: &Arc<RobotModel>, random: &mut Random, bent: bool) -> Trajectory {
    let joints = ["j1", "j2"].map(str::to_owned);
    let points = points(random, 0.9, bent);
    Trajectory::from_points(robot, &joints, &points, &robot.default_configuration()).unwrap()
}

pub fn bases() -> Vec<Base> {
    let mut random = Random::new(20);
    let mut all = vec![];
    let mut add = |name, scene: Scene, (certificate, way): (Certificate, Trajectory)| {
        scene.verify(&certificate).unwrap();
        all.push(Base { name, scene, certificate, motion: Some(way) });
    };
    let scene = Scene::new(&arm(), shapes());
    let robot = scene.robot.clone();
    let found = nearest(&scene, &mut random, |random| way_of_arm(&robot, random, true));
    add("polynomials", scene, found);

    let scene = Scene::with_settings(&arm(), shapes(), Settings { padding: 0.02, ..Settings::default() });
    let tube = |way: Trajectory| way.map(|s| s.with_tube(&robot, vec![0.01, 0.02])).unwrap();
    let found = nearest(&scene, &mut random, |random| tube(way_of_arm(&robot, random, false)));
    add("straight, with a tube and a padding", scene, found);

    let scene = Scene::new(&arm(), shapes());
    let movers = |random: &mut Random| {
        let even = ObstacleTrajectory::even(
            "sheet",
            Point::new(1.45, -0.3, 0.0),
            [-0.05, 0.1, 0.0],
            [0.0, 0.0, 0.3],
        );
        let pose = |x: f64| Pose::translation(0.9 + x, 0.9, 0.0);
        let stops = [(0.0, pose(0.0)), (1.5, pose(random.within(-0.3, 0.1))), (3.0, pose(0.1))];
        [even, ObstacleTrajectory::through("ball", &stops).unwrap()]
    };
    let moving = |random: &mut Random| {
        let way = way_of_arm(&robot, random, true);
        way.with_obstacles(&shapes(), &movers(random)).unwrap()
    };
    let found = nearest(&scene, &mut random, moving);
    add("moving obstacles", scene, found);

    let mut world = shapes();
    let held = obstacle("held", Shape::Primitive(Primitive::sphere(0.08).unwrap()), [0.55, 0.0, 0.0]);
    world.attach(AttachedObject::grasped(&held, "c", &Pose::identity(), vec!["b".into()])).unwrap();
    let scene = Scene::new(&arm(), world);
    let found = nearest(&scene, &mut random, |random| way_of_arm(&robot, random, false));
    add("a held object", scene, found);
    all.extend([floating(&mut random), jumping()]);
    all.extend(followers());
    all
}

fn floating(random: &mut Random) -> Base {
    let urdf = [
        "<robot name='floats'><link name='base'/>".to_owned(),
        ball_link("body", 0.4, 0.05),
        "<joint name='free' type='floating'><parent link='base'/><child link='body'/></joint></robot>"
            .to_owned(),
    ];
    let scene = Scene::new(&urdf.concat(), shapes());
    let way = |random: &mut Random| {
        let mut state = || {
            let q = random.rotation().coords;
            let at = random.vector(0.8);
            [at.x, at.y, 0.3 * at.z, q.x, q.y, q.z, q.w]
        };
        let states = [state(), state(), state()];
        let straight = states.windows(2).map(|two| scene.straight(&two[0], &two[1])).collect();
        Trajectory::of_segments(straight).unwrap()
    };
    let (certificate, way) = nearest(&scene, random, way);
    Base { name: "a floating body", scene, certificate, motion: Some(way) }
}

/// An honest motion up to the wall and back, and a forged one that is past it after a gap of 1e-9.
pub fn followers() -> [Base; 2] {
    let scene = || Scene::new(&fast_follower(), wall());
    let honest = scene();
    let stops = [-1.0e-9, 0.399e-9, -0.2e-9, 0.3999e-9, 0.0];
    let straight = stops.windows(2).map(|two| honest.straight(&[two[0]], &[two[1]])).collect();
    let way = Trajectory::of_segments(straight).unwrap();
    let certificate = honest.certify(&way).unwrap();
    let forged = scene();
    let segments = [forged.straight(&[-1e-9], &[0.3e-9]), forged.straight(&[0.7e-9], &[1.5e-9])];
    let torn = forged.spliced(&segments);
    assert!(forged.verify(&torn).is_err());
    [
        Base { name: "a fast follower", scene: honest, certificate, motion: Some(way) },
        Base { name: "a fast follower through a wall", scene: forged, certificate: torn, motion: None },
    ]
}

/// A far sheet that jumps over the arm by what is little beside its way.
fn jumping() -> Base {
    let mut world = World::default();
    world.add(obstacle("sheet", sheet(), [-1e6, 0.0, 0.0])).unwrap();
    let urdf = [
        "<robot name='grain'>".to_owned(),
        ball_link("base", 0.0, 1e-5),
        "<link name='other'/>".to_owned(),
        joint("j", "revolute", ["base", "other"], "0 0 0", "0 0 1", ""),
        "</robot>".to_owned(),
    ];
    let scene = Scene::new(&urdf.concat(), world);
    let shifted = |x: f64| Pose::translation(x, 0.0, 0.0);
    let moving = |from: f64, to: f64| -> MotionSegment {
        let mover = MovingObstacle::between("sheet", Point::origin(), &shifted(from), &shifted(to));
        scene.straight(&[0.0], &[0.0]).with_obstacles(&scene.world, vec![mover]).unwrap()
    };
    let certificate = scene.spliced(&[moving(0.0, 1e6 - 4e-4), moving(1e6 + 4e-4, 1.1e6)]);
    assert!(scene.verify(&certificate).is_err());
    Base { name: "an obstacle that jumps", scene, certificate, motion: None }
}
