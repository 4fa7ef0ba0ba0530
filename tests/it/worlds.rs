//! Tests of changing worlds and attached objects, against rebuilt worlds and against robots with the object as a link.

use clearance::checker::{
    CollisionChecker, CollisionReport, MotionOptions, MotionOrder, MotionVerdict, Question, Workspace,
};
use clearance::geometry::math::{Pose, Vector};
use clearance::geometry::{Primitive, Shape};
use clearance::motion::MotionSegment;
use clearance::robot::{Configuration, LinkPoses, MeshFiles, RobotModel};
use clearance::scene::AllowedCollisionMatrix;
use clearance::scene::{AttachedObject, Obstacle, ObstacleShape, World, WorldError};
use clearance::scene::{BodyId, Settings};
use clearance::verifier::verify;
use std::path::Path;
use std::sync::Arc;

use crate::random::Random;

pub fn demo_arm() -> Arc<RobotModel> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("urdf/demo_arm");
    let srdf = folder.join("demo_arm.srdf");
    Arc::new(RobotModel::load(&folder.join("demo_arm.urdf"), Some(&srdf), &[]).unwrap())
}

pub fn state(robot: &RobotModel, random: &mut Random) -> Configuration {
    let within = |joint| {
        let limits = robot.joint(joint).limits;
        limits.map_or([-3.0, 3.0], |limits| [limits.lower.max(-3.0), limits.upper.min(3.0)])
    };
    let mut positions = robot.default_configuration().positions().to_vec();
    for joint in robot.joint_ids() {
        if let Some(i) = robot.first_position(joint) {
            let [lo, hi] = within(joint);
            positions[i] = random.within(lo, hi);
        }
    }
    robot.configuration(&positions).unwrap()
}

pub fn obstacle(name: String, random: &mut Random, reach: f64, size: f64) -> Obstacle {
    let pose = Pose::from_parts(random.vector(reach).into(), random.rotation());
    let mut edge = || random.within(0.1, 1.0) * size;
    let (x, y, z) = (edge(), edge(), edge());
    let primitive = match random.below(3) {
        0 => Primitive::cuboid([x, y, z]),
        1 => Primitive::sphere(0.5 * x),
        _ => Primitive::cylinder(0.5 * x, y),
    };
    Obstacle::of_shape(name, pose, Shape::Primitive(primitive.unwrap()))
}

#[test]
fn a_batch_asks_every_state_about_what_hits_another() {
    let robot = demo_arm();
    let mut random = Random::new(17);
    for objects in [3, 30, 300] {
        let mut world = World::default();
        for i in 0..objects {
            world.add(obstacle(format!("o{i}"), &mut random, 1.0, 1.2 / f64::from(objects).cbrt())).unwrap();
        }
        let checker = CollisionChecker::new(robot.clone(), &world, Settings::default()).unwrap();
        // neighbours mostly hit the same obstacle
        let mut states = Vec::new();
        for _ in 0..60 {
            let q = state(&robot, &mut random);
            states.extend((0..8).map(|_| {
                let near = q.positions().iter().map(|x| x + random.within(-0.02, 0.02)).collect::<Vec<_>>();
                robot.configuration(&near).unwrap()
            }));
        }
        let mut workspace = checker.workspace();
        let expected: Vec<_> = states.iter().map(|q| checker.is_free(q, &mut workspace)).collect();
        assert_eq!(checker.are_free(&states), expected);
    }
}

/// The same answers, about this state and the way to the next.
fn assert_agree(
    (changed, anew): (&CollisionChecker, &CollisionChecker),
    (q, r): (&Configuration, &Configuration),
    (mine, theirs): (&mut Workspace, &mut Workspace),
) {
    assert_eq!(changed.pairs().len(), anew.pairs().len());
    let named = |checker: &CollisionChecker, workspace: &mut Workspace| {
        let report = checker.check(q, Question::PairDistances { limit: 0.1 }, workspace);
        let name = |body| checker.body_name(body).to_owned();
        let mut pairs: Vec<_> =
            report.pair_distances.iter().map(|p| (name(p.a), name(p.b), p.distance.to_bits())).collect();
        pairs.sort();
        let free = checker.is_free(q, workspace);
        assert_eq!(free, report.is_free());
        (free, pairs)
    };
    assert_eq!(named(changed, mine), named(anew, theirs));
    let segment = MotionSegment::straight(changed.robot(), q, r);
    let any = MotionOptions { order: MotionOrder::Any, ..MotionOptions::default() };
    let free = |checker: &CollisionChecker, options: &MotionOptions, workspace: &mut Workspace| {
        checker.check_motion_with(&segment, options, workspace).is_free()
    };
    assert_eq!(free(changed, &any, mine), free(anew, &any, theirs));
}

/// A primitive, a mesh, a cloud or an octree.
fn of_any_shape(name: String, random: &mut Random) -> Obstacle {
    let shape = match random.below(12) {
        0 => Shape::Mesh(random.blob(4, 0.1).into()),
        1 => Shape::Mesh(random.soup(20, 0.1, 0.05).into()),
        2 => random.points(50, 0.1, 0.01),
        3 => random.voxels(30, 0.1, 0.02),
        _ => return obstacle(name, random, 1.0, 0.2),
    };
    Obstacle::of_shape(name, random.pose(1.0), shape)
}

#[test]
fn random_edits_agree_with_a_world_built_anew() {
    let robot = demo_arm();
    let mut random = Random::new(11);
    let mut world = World::default();
    let settings = Settings::default();
    let alone = CollisionChecker::new(robot.clone(), &world, settings.clone()).unwrap();
    let mut changed = alone.clone();
    let (mut mine, edits) = (changed.workspace(), crate::soundness::share(1500, 100_000));
    for edit in 0..edits {
        let name = format!("o{}", random.below(40));
        let known = world.id(&name).is_some();
        match random.below(5) {
            0 if known => drop(world.remove(&name).unwrap()),
            1 if known => {
                let pose = Pose::from_parts(random.vector(1.0).into(), random.rotation());
                world.move_to(&name, pose).unwrap();
            }
            2 if known => {
                let more = obstacle(name.clone(), &mut random, 0.3, 0.2);
                world
                    .append(&name, [ObstacleShape { pose_os: more.pose_ro, ..more.shapes[0].clone() }])
                    .unwrap();
            }
            3 if edit % 10 == 0 => {
                let mut object = obstacle(format!("held{}", random.below(2)), &mut random, 0.1, 0.1);
                if random.below(4) == 0 {
                    object.shapes =
                        [ObstacleShape { pose_os: Pose::identity(), shape: random.plane(0.5) }].into();
                }
                let link = &robot.links()[robot.links().len() - 1].name;
                world.attach(AttachedObject::grasped(&object, link, &Pose::identity(), vec![])).unwrap();
            }
            4 if edit % 10 == 0 && !world.attached().is_empty() => {
                let name = world.attached()[0].name.clone();
                world.detach(&name, &Pose::from_parts(random.vector(1.0).into(), random.rotation())).unwrap();
            }
            _ => drop(world.replace(of_any_shape(name, &mut random)).unwrap()),
        }
        changed.set_world(&world).unwrap();
        let anew = alone.with_world(&world, settings.clone(), None).unwrap();
        let (q, r) = (state(&robot, &mut random), state(&robot, &mut random));
        assert_agree((&changed, &anew), (&q, &r), (&mut mine, &mut anew.workspace()));
    }
}

#[test]
fn what_no_joint_moves_is_asked_anew_when_the_world_changes() {
    let robot = demo_arm();
    let mut random = Random::new(3);
    let states: Vec<_> = (0..50).map(|_| state(&robot, &mut random)).collect();
    let free_in = |checker: &CollisionChecker, workspace: &mut Workspace| -> Vec<bool> {
        let one_by_one: Vec<_> = states.iter().map(|q| checker.is_free(q, workspace)).collect();
        let reports = checker.check_states(&states, Question::Pairs);
        assert_eq!(one_by_one, reports.iter().map(CollisionReport::is_free).collect::<Vec<_>>());
        assert_eq!(one_by_one, checker.are_free(&states));
        one_by_one
    };
    let mut world = World::default();
    let mut checker = CollisionChecker::new(robot, &world, Settings::default()).unwrap();
    let mut workspace = checker.workspace();
    let alone = free_in(&checker, &mut workspace);
    assert!(alone.contains(&true));
    let socket = Shape::Primitive(Primitive::cuboid([0.05; 3]).unwrap());
    world.add(Obstacle::of_shape("socket".to_owned(), Pose::identity(), socket)).unwrap();
    for (place, free) in [(0.0, false), (5.0, true), (0.0, false)] {
        world.move_to("socket", Pose::translation(0.0, 0.0, place)).unwrap();
        checker.set_world(&world).unwrap();
        let expected = if free { alone.clone() } else { vec![false; states.len()] };
        assert_eq!(free_in(&checker, &mut workspace), expected, "the socket is at {place}");
    }
    world.remove("socket").unwrap();
    checker.set_world(&world).unwrap();
    assert_eq!(free_in(&checker, &mut workspace), alone);
}

#[test]
fn an_edit_leaves_what_others_hold_as_it_was() {
    let robot = demo_arm();
    let mut random = Random::new(2);
    let mut world = World::default();
    for i in 0..20 {
        world.add(obstacle(format!("o{i}"), &mut random, 1.0, 0.2)).unwrap();
    }
    let before = CollisionChecker::new(robot.clone(), &world, Settings::default()).unwrap();
    let q = state(&robot, &mut random);
    let report = before.check(&q, Question::PairDistances { limit: 0.5 }, &mut before.workspace());
    let mut after = before.clone();
    world.clear();
    after.set_world(&world).unwrap();
    assert_eq!(before.check(&q, Question::PairDistances { limit: 0.5 }, &mut before.workspace()), report);
    assert_eq!(after.pairs().world_len(), 0);
}

/// `two_link` with a box at the end, as a link of its own or to be attached.
fn with_tool(tool: bool) -> Arc<RobotModel> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("urdf/two_link");
    let text = std::fs::read_to_string(folder.join("two_link.urdf")).unwrap();
    let link = r#"<link name="tool"><collision><origin xyz="0.05 0.1 0"/>
        <geometry><box size="0.3 0.2 0.1"/></geometry></collision></link>
        <joint name="grip" type="fixed"><parent link="tip"/><child link="tool"/><origin xyz="1.2 0 0" rpy="0 0 0.4"/></joint>
        </robot>"#;
    let text = if tool { text.replace("</robot>", link) } else { text };
    Arc::new(RobotModel::from_urdf(&text, &MeshFiles::under(&folder)).unwrap())
}

fn tool() -> AttachedObject {
    let shape = Shape::Primitive(Primitive::cuboid([0.3, 0.2, 0.1]).unwrap());
    let placed = ObstacleShape { pose_os: Pose::translation(0.05, 0.1, 0.0), shape };
    let turn = nalgebra::UnitQuaternion::from_axis_angle(&Vector::z_axis(), 0.4);
    AttachedObject {
        name: "tool".to_owned(),
        link: "tip".to_owned(),
        pose_lo: Pose::from_parts(Vector::new(1.2, 0.0, 0.0).into(), turn),
        shapes: vec![placed].into(),
        subframes: Vec::new(),
        touch_links: Vec::new(),
    }
}

#[test]
fn what_is_attached_is_as_a_link_that_is_fixed_there() {
    let mut random = Random::new(4);
    let mut world = World::default();
    for i in 0..12 {
        world.add(obstacle(format!("o{i}"), &mut random, 2.0, 0.3)).unwrap();
    }
    let link = CollisionChecker::new(with_tool(true), &world, Settings::default()).unwrap();
    let robot = with_tool(false);
    world.attach(tool()).unwrap();
    // adjacent links are not checked, but what upper may hit of the tool is not adjacent to it
    let mut matrix = AllowedCollisionMatrix::default();
    for (a, b) in [("base", "upper"), ("upper", "tip"), ("upper", "tool")] {
        matrix.set(a, b, true);
    }
    let held =
        CollisionChecker::with_matrix(robot.clone(), &world, Settings::default(), Some(&matrix)).unwrap();
    assert_eq!(link.pairs().len(), held.pairs().len());
    let (mut one, mut other) = (link.workspace(), held.workspace());
    let named = |checker: &CollisionChecker, q: &Configuration, workspace: &mut Workspace| {
        let report = checker.check(q, Question::PairDistances { limit: 5.0 }, workspace);
        let name = |body| checker.body_name(body).to_owned();
        let mut pairs: Vec<_> =
            report.pair_distances.iter().map(|p| (name(p.a), name(p.b), p.distance)).collect();
        pairs.sort_by(|p, q| (&p.0, &p.1).cmp(&(&q.0, &q.1)));
        (report.self_collision, report.world_collision, pairs)
    };
    let (mut contacts, mut free) = (0, 0);
    for _ in 0..200 {
        let (q, r) = (state(&robot, &mut random), state(&robot, &mut random));
        let same = |q: &Configuration| link.robot().configuration(q.positions()).unwrap();
        let (a, b) = (named(&link, &same(&q), &mut one), named(&held, &q, &mut other));
        assert_eq!((a.0, a.1), (b.0, b.1));
        for ((p, d), (s, e)) in
            a.2.iter().map(|p| ((&p.0, &p.1), p.2)).zip(b.2.iter().map(|p| ((&p.0, &p.1), p.2)))
        {
            assert!(p == s && (d - e).abs() < 1e-6, "{p:?} {d} {s:?} {e}");
        }
        let segment = MotionSegment::straight(&robot, &q, &r);
        let (report, certificate) = held.certify_motion(&segment, &MotionOptions::default(), &mut other);
        let expected = link.check_motion(&same(&q), &same(&r), &mut one);
        assert_eq!(report.is_free(), expected.is_free());
        match report.verdict {
            MotionVerdict::Free => {
                free += 1;
                let certificate = certificate.unwrap();
                verify(&robot, &world, &Settings::default(), Some(&matrix), &certificate).unwrap();
            }
            MotionVerdict::Contact { .. } => contacts += 1,
            MotionVerdict::Undecided { .. } => {}
        }
    }
    assert!(contacts > 20 && free > 20, "{contacts} contacts, {free} free");
}

#[test]
fn attach_move_and_detach_bring_an_object_along() {
    let robot = with_tool(false);
    let mut world = World::default();
    let shape = Shape::Primitive(Primitive::sphere(0.05).unwrap());
    world.add(Obstacle::of_shape("part", Pose::translation(2.2, 0.0, 0.0), shape)).unwrap();
    let at = |q1: f64| robot.configuration_from_names([("joint1", q1), ("joint2", 0.0)]).unwrap();
    let pose = |q: &Configuration| {
        let mut poses = LinkPoses::new(&robot);
        robot.forward_kinematics(q, &mut poses);
        *poses.pose(robot.link_by_name("tip").unwrap())
    };
    let part = world.obstacle_by_name("part").unwrap().clone();
    world.attach(AttachedObject::grasped(&part, "tip", &pose(&at(0.0)), vec![])).unwrap();
    assert!(world.obstacle_by_name("part").is_none());
    assert_eq!(world.remove("part").unwrap_err(), WorldError::Unknown("part".to_owned()));
    world.detach("part", &pose(&at(std::f64::consts::FRAC_PI_2))).unwrap();
    let lies = world.obstacle_by_name("part").unwrap().pose_ro.translation.vector;
    assert!((lies - Vector::new(0.0, 2.2, 0.0)).norm() < 1e-12, "{lies}");
    assert!(world.attached().is_empty());
}

#[test]
fn touch_links_may_touch_and_others_may_not() {
    let robot = with_tool(false);
    let ball =
        Obstacle::of_shape("ball", Pose::identity(), Shape::Primitive(Primitive::sphere(0.3).unwrap()));
    let folded = robot.configuration_from_names([("joint1", 0.0), ("joint2", 3.0)]).unwrap();
    let collides = |touch_links: &[&str]| {
        let mut world = World::default();
        let touch = touch_links.iter().map(|&l| l.to_owned()).collect();
        let mut object = AttachedObject::grasped(&ball, "tip", &Pose::identity(), touch);
        object.pose_lo = Pose::translation(0.9, 0.4, 0.0);
        world.attach(object).unwrap();
        let settings = Settings::default();
        let checker = CollisionChecker::new(robot.clone(), &world, settings).unwrap();
        let report = checker.check(&folded, Question::Pairs, &mut checker.workspace());
        let attached = report.colliding_pairs.iter().filter(|(_, b)| matches!(b, BodyId::Attached(_)));
        attached.map(|(a, _)| checker.body_name(*a).to_owned()).collect::<Vec<_>>()
    };
    let all = collides(&[]);
    assert!(all.contains(&"base".to_owned()) && !all.contains(&"tip".to_owned()), "{all:?}");
    assert!(!collides(&["base"]).contains(&"base".to_owned()));
}
