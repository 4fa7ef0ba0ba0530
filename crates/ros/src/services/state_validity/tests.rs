//! Tests of `check_state_validity`: contacts, partial states, groups and attached objects.

use std::time::Duration;

use clearance_geometry::{Primitive, Shape};
use clearance_monitor::{JointStateInput, Monitor, MonitorSettings, Observation, Time, WorldSource};
use clearance_robot::MeshFiles;
use clearance_scene::{Obstacle, World};
use ros2_interfaces_jazzy_serde::geometry_msgs::msg::{Point, Pose as PoseMessage, Transform};
use ros2_interfaces_jazzy_serde::moveit_msgs::msg::{
    AttachedCollisionObject, CollisionObject, JointConstraint,
};
use ros2_interfaces_jazzy_serde::shape_msgs::msg::SolidPrimitive;

use super::*;
use crate::scene::tests::{
    FOLDED, ON_BASE, STRETCHED, at, ball, difference, in_force, in_force_of, now, part, scene, solid,
};

/// The evaluation of the robot at these positions.
fn evaluation(scene: &ActiveScene, positions: &[f64]) -> Evaluation {
    let mut monitor = Monitor::new(MonitorSettings::default(), || Duration::ZERO);
    monitor.set_checker(Arc::clone(&scene.revision));
    let names = ["joint1", "joint2"][..positions.len()].iter().map(|name| (*name).to_owned()).collect();
    let input = JointStateInput { names, positions: positions.to_vec(), ..JointStateInput::default() };
    monitor.on_joint_state(input, now())
}

fn question(positions: &[(&str, f64)]) -> GetStateValidityRequest {
    let mut request = GetStateValidityRequest::default();
    request.robot_state.is_diff = true;
    request.robot_state.joint_state.name = positions.iter().map(|(name, _)| (*name).to_owned()).collect();
    request.robot_state.joint_state.position = positions.iter().map(|(_, position)| *position).collect();
    request
}

fn whole([joint1, joint2]: [f64; 2]) -> GetStateValidityRequest {
    question(&[("joint1", joint1), ("joint2", joint2)])
}

fn ask(
    scene: &ActiveScene,
    current: &[f64],
    request: &GetStateValidityRequest,
) -> Result<GetStateValidityResponse, String> {
    let evaluation = evaluation(scene, current);
    let transforms = TransformTree::default();
    let situation =
        ValidityContext { scene, evaluation: Some(&evaluation), transforms: &transforms, now: now() };
    state_validity(request, &situation).map(|found| found.response)
}

#[test]
fn states_are_valid_where_nothing_touches() {
    let scene = in_force(scene(&[difference(vec![ball("a", at(0.2, 0.0, 0.3), 0.15, "")], vec![])]), vec![]);
    let answer = ask(&scene, &STRETCHED, &whole(ON_BASE)).unwrap();
    assert!(!answer.valid);
    let bodies = |c: &ros2_interfaces_jazzy_serde::moveit_msgs::msg::ContactInformation| {
        (c.contact_body_1.clone(), c.contact_body_2.clone(), c.body_type_2)
    };
    let told: Vec<_> = answer.contacts.iter().map(bodies).collect();
    assert!(told.contains(&("base".to_owned(), "tip".to_owned(), 0)), "{told:?}");
    assert!(told.contains(&("base".to_owned(), "a".to_owned(), 1)), "{told:?}");
    for contact in &answer.contacts {
        let n = &contact.normal;
        assert!(((n.x * n.x + n.y * n.y + n.z * n.z) - 1.0).abs() < 1e-9);
        assert_eq!(contact.header.frame_id, "base");
    }
}

fn cuboid(id: &str, pose: PoseMessage, size: [f64; 3]) -> CollisionObject {
    let primitives = vec![solid(SolidPrimitive::BOX, &size)];
    CollisionObject { primitives, ..ball(id, pose, 1.0, "base") }
}

/// A scene in which the tip holds a box 5 mm deep in a table.
fn box_on_table() -> Arc<ActiveScene> {
    let table = cuboid("table", at(2.0, 0.0, 0.855), [2.0, 2.0, 0.1]);
    let object = cuboid("part", at(2.0, 0.1, 0.95), [0.4, 0.2, 0.1]);
    let part = AttachedCollisionObject { object, ..part() };
    in_force(scene(&[difference(vec![table], vec![part])]), vec![])
}

/// A box flat on a table has a contact at each corner.
#[test]
fn one_pair_has_several_contacts() {
    let answer = ask(&box_on_table(), &STRETCHED, &whole(STRETCHED)).unwrap();
    assert!((4..=8).contains(&answer.contacts.len()), "{:?}", answer.contacts);
    for contact in &answer.contacts {
        let bodies = (contact.contact_body_1.as_str(), contact.contact_body_2.as_str());
        assert_eq!((bodies, contact.body_type_1, contact.body_type_2), (("part", "table"), 2, 1));
        assert!((contact.normal.z + 1.0).abs() < 1e-6 && (contact.depth - 0.005).abs() < 1e-6, "{contact:?}");
    }
    for (x, y) in [(1.8, 0.0), (2.2, 0.0), (1.8, 0.2), (2.2, 0.2)] {
        let is_corner = |p: &Point| (p.x - x).hypot(p.y - y) < 1e-6;
        assert!(answer.contacts.iter().any(|contact| is_corner(&contact.position)), "{:?}", answer.contacts);
    }
}

/// When the time for contacts is over, each pair still has one, and the remark says what is missing.
#[test]
fn contacts_after_their_time_have_a_point_only() {
    let scene = box_on_table();
    let checker = &scene.revision.checker;
    let (robot, mut workspace) = (checker.robot(), checker.workspace());
    let q = robot.configuration(&STRETCHED).unwrap();
    let mut poses = LinkPoses::new(robot);
    robot.forward_kinematics(&q, &mut poses);
    let report = checker.check(&q, Question::Pairs, &mut workspace);
    let search = ContactsOfState { checker, q: &q, poses: &poses, now: now() };
    let found = search.contacts(&report.colliding_pairs, Instant::now(), &mut workspace);
    assert_eq!((found.messages.len(), report.colliding_pairs.len()), (1, 1));
    assert!(found.remark.unwrap().contains("1 have no normal and depth"));
    let contact = &found.messages[0];
    assert!(contact.depth == 0.0 && (0.89..0.92).contains(&contact.position.z), "{contact:?}");
}

#[test]
fn a_partial_state_overlays_the_current_one() {
    let scene = in_force(Scene::default(), vec![]);
    assert!(!ask(&scene, &ON_BASE, &question(&[("joint1", 0.3)])).unwrap().valid);
    assert!(ask(&scene, &ON_BASE, &question(&[("joint2", 0.0)])).unwrap().valid);
    assert!(!ask(&scene, &ON_BASE, &question(&[])).unwrap().valid);
    let fault = ask(&scene, &[0.0], &question(&[("joint1", 0.0)])).unwrap_err();
    assert!(fault.contains("no position of 'joint2'"), "{fault}");
    assert!(ask(&scene, &[0.0], &whole(STRETCHED)).unwrap().valid);
    for (broken, named) in [
        (question(&[("joint2", f64::NAN)]), "'joint2'"),
        (question(&[("gripper", 0.0)]), "'gripper'"),
        (question(&[("joint1", 0.0), ("joint1", 0.0)]), "twice"),
    ] {
        let fault = ask(&scene, &STRETCHED, &broken).unwrap_err();
        assert!(fault.contains(named), "{fault}");
    }
    let mut moved = whole(STRETCHED);
    moved.robot_state.multi_dof_joint_state.joint_names.push("floating".to_owned());
    assert!(ask(&scene, &STRETCHED, &moved).unwrap_err().contains("1 joint_names and 0 transforms"));
    moved.robot_state.multi_dof_joint_state.transforms.push(moved_by([1.0, 0.0, 0.0]));
    assert!(ask(&scene, &STRETCHED, &moved).unwrap_err().contains("no joint 'floating'"));
    let mut uneven = whole(STRETCHED);
    uneven.robot_state.joint_state.position.pop();
    assert!(ask(&scene, &STRETCHED, &uneven).unwrap_err().contains("2 names and 1 positions"));
}

fn moved_by([x, y, z]: [f64; 3]) -> Transform {
    let mut transform = Transform::default();
    (transform.translation.x, transform.translation.y, transform.translation.z) = (x, y, z);
    transform.rotation.w = 1.0;
    transform
}

/// A ball on a planar joint with its origin at x = 1 m, and an arm on it with a ball at 0.5 m.
const ROVER: &str = "<robot name='two_link'><link name='odom'/>\
<link name='base'><collision><geometry><sphere radius='0.1'/></geometry></collision></link>\
<link name='arm'><collision><origin xyz='0.5 0 0'/><geometry><sphere radius='0.1'/></geometry></collision></link>\
<joint name='drive' type='planar'><parent link='odom'/><child link='base'/><origin xyz='1 0 0'/><axis xyz='0 0 1'/></joint>\
<joint name='lift' type='prismatic'><parent link='base'/><child link='arm'/><axis xyz='1 0 0'/>\
<limit lower='-1' upper='1' effort='1' velocity='1'/></joint></robot>";

#[test]
fn planar_joints_are_read_from_transforms() {
    let rover = Arc::new(RobotModel::from_urdf(ROVER, &MeshFiles::default()).unwrap());
    let mut world = World::default();
    let pillar = Shape::Primitive(Primitive::Sphere { radius: 0.1 });
    world.add(Obstacle::of_shape("pillar", Pose::translation(3.0, 2.0, 0.0), pillar)).unwrap();
    let scene = in_force_of(&rover, Scene::new(world), vec![]);
    let place = |name: &str, [x, y, z]: [f64; 3], turn: f64| {
        let mut request = question(&[("lift", 0.0)]);
        let given = &mut request.robot_state.multi_dof_joint_state;
        given.joint_names.push(name.to_owned());
        given.transforms.push(moved_by([x, y, z]));
        (given.transforms[0].rotation.z, given.transforms[0].rotation.w) =
            ((0.5 * turn).sin(), (0.5 * turn).cos());
        request
    };
    let ask = |request: &GetStateValidityRequest| ask(&scene, &[], request);
    assert!(ask(&place("drive", [0.0; 3], 0.0)).unwrap().valid);
    // the base is in the pillar; the arm is in it once the base is turned
    assert!(!ask(&place("drive", [2.0, 2.0, 0.0], 0.0)).unwrap().valid);
    assert!(ask(&place("drive", [2.0, 1.5, 0.0], 0.0)).unwrap().valid);
    assert!(!ask(&place("drive", [2.0, 1.5, 0.0], std::f64::consts::FRAC_PI_2)).unwrap().valid);
    let refused = |request: &GetStateValidityRequest, words: &[&str]| {
        let why = ask(request).unwrap_err();
        assert!(words.iter().all(|word| why.contains(word)), "{why}");
    };
    refused(&place("drive", [2.0, 2.0, 0.1], 0.0), &["multi_dof_joint_state", "'drive'", "0.1 (m, rad)"]);
    refused(&place("lift", [0.0; 3], 0.0), &["'lift' is neither planar nor floating"]);
    refused(&place("wheel", [0.0; 3], 0.0), &["'wheel'", "drive"]);
    let mut twice = place("drive", [0.0; 3], 0.0);
    twice.robot_state.joint_state.name.push("drive/x".to_owned());
    twice.robot_state.joint_state.position.push(0.0);
    refused(&twice, &["'drive/x' is given twice"]);
    let mut elsewhere = place("drive", [0.0; 3], 0.0);
    elsewhere.robot_state.multi_dof_joint_state.header.frame_id = "map".to_owned();
    refused(&elsewhere, &["frame_id", "'map'", "'odom'"]);
    refused(&question(&[("lift", 0.0)]), &["'drive/x'"]);
    let mut broken = place("drive", [f64::NAN, 0.0, 0.0], 0.0);
    refused(&broken, &["'drive'", "finite"]);
    broken.robot_state.multi_dof_joint_state.transforms.clear();
    refused(&broken, &["1 joint_names and 0 transforms"]);
}

#[test]
fn a_group_is_evaluated_by_the_links_that_it_moves() {
    // an obstacle on the bar of the upper link
    let scene = in_force(scene(&[difference(vec![ball("a", at(0.5, 0.0, 0.06), 0.05, "")], vec![])]), vec![]);
    let of = |group: &str, positions| {
        ask(&scene, &STRETCHED, &GetStateValidityRequest { group_name: group.to_owned(), ..whole(positions) })
    };
    assert!(!of("", STRETCHED).unwrap().valid);
    assert!(!of("arm", STRETCHED).unwrap().valid);
    assert!(of("wrist", STRETCHED).unwrap().valid);
    assert!(!of("wrist", ON_BASE).unwrap().valid);
    assert!(
        of("elbow", STRETCHED)
            .unwrap_err()
            .contains("no group 'elbow'; the SRDF has 'arm', 'wrist' and 'empty'")
    );
    assert!(of("empty", STRETCHED).unwrap_err().contains("group 'empty' has no joint and no link"));
}

#[test]
fn attached_objects_of_a_request_are_honoured() {
    let free = in_force(Scene::default(), vec![]);
    let mut with_part = whole(FOLDED);
    with_part.robot_state.attached_collision_objects.push(part());
    assert!(ask(&free, &STRETCHED, &whole(FOLDED)).unwrap().valid);
    let answer = ask(&free, &STRETCHED, &with_part).unwrap();
    assert!(!answer.valid && answer.contacts.iter().any(|c| c.body_type_1 == 2 || c.body_type_2 == 2));

    let holding = in_force(scene(&[difference(vec![], vec![part()])]), vec![]);
    assert!(!ask(&holding, &STRETCHED, &whole(FOLDED)).unwrap().valid);
    let mut empty_handed = whole(FOLDED);
    empty_handed.robot_state.is_diff = false;
    assert!(ask(&holding, &STRETCHED, &empty_handed).unwrap().valid);

    with_part.robot_state.attached_collision_objects[0].link_name = "hand".to_owned();
    assert!(ask(&free, &STRETCHED, &with_part).unwrap_err().contains("no link 'hand'"));
}

#[test]
fn what_is_not_looked_at_is_not_valid() {
    let scene = in_force(Scene::default(), vec![]);
    let mut constrained = whole(STRETCHED);
    constrained.constraints.joint_constraints.push(JointConstraint::default());
    assert!(!ask(&scene, &STRETCHED, &constrained).unwrap().valid);
    let camera = |seen| WorldSource { name: "/camera".to_owned(), seen, ttl: 1.0 };
    let unseen = in_force(Scene::default(), vec![camera(None)]);
    assert!(ask(&unseen, &STRETCHED, &whole(STRETCHED)).unwrap_err().contains("'/camera'"));
    let seen = Some(Observation { stamp: Time::from_nanoseconds(5), at: Duration::ZERO });
    let seen = in_force(Scene::default(), vec![camera(seen)]);
    assert!(ask(&seen, &STRETCHED, &whole(STRETCHED)).unwrap().valid);
}
