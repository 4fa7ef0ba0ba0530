use std::collections::HashMap;

use super::*;
use crate::geometry::{Primitive, Shape};
use crate::math::{Vector, pose_from_xyz_rpy};
use crate::robot::{LinkPoses, RobotModel};
use crate::world::testing::robot;

const QUARTER: f64 = std::f64::consts::FRAC_PI_2;

/// A world and all that its frames need, with the arm turned by a quarter.
struct Bench {
    robot: RobotModel,
    poses: LinkPoses,
    others: HashMap<String, Pose>,
    world: World,
}

impl Bench {
    fn new() -> Self {
        let robot = robot();
        let mut poses = LinkPoses::new(&robot);
        let q = robot.configuration(&[QUARTER]).unwrap();
        robot.forward_kinematics(&q, &mut poses);
        let others = HashMap::from([("camera".to_owned(), at(0.0, 0.0, 9.0))]);
        Self { robot, poses, others, world: World::default() }
    }

    fn apply(&mut self, object: SceneObject) -> Result<Vec<String>, ObjectError> {
        let Self { robot, poses, others, world } = self;
        world.apply(object, &Frames { robot, poses, pose_vr: None, others })
    }

    fn attach(&mut self, link: &str, object: SceneObject) -> Result<Vec<String>, ObjectError> {
        let Self { robot, poses, others, world } = self;
        let touch_links = vec!["base".to_owned()];
        let attachment = SceneAttachment { link: link.to_owned(), object, touch_links };
        world.apply_attachment(attachment, &Frames { robot, poses, pose_vr: None, others })
    }

    fn shape_pose(&self, name: &str, i: usize) -> Pose {
        let object = self.world.obstacle_by_name(name).unwrap();
        object.placed_shapes().nth(i).unwrap().0
    }
}

fn at(x: f64, y: f64, z: f64) -> Pose {
    pose_from_xyz_rpy([x, y, z], [0.0; 3])
}

fn ball(pose_os: Pose) -> ObstacleShape {
    ObstacleShape { pose_os, shape: Shape::Primitive(Primitive::sphere(0.1).unwrap()) }
}

fn object(id: &str, operation: Operation, pose_fo: Pose, shapes: Vec<ObstacleShape>) -> SceneObject {
    let (id, frame) = (id.to_owned(), String::new());
    SceneObject {
        id,
        frame,
        pose_fo,
        shapes,
        shape_poses: vec![],
        subframes: vec![("top".to_owned(), at(0.0, 0.0, 1.0))],
        operation,
    }
}

fn in_frame(frame: &str, object: SceneObject) -> SceneObject {
    SceneObject { frame: frame.to_owned(), ..object }
}

fn near(a: &Pose, b: &Pose) {
    assert!((a.to_homogeneous() - b.to_homogeneous()).amax() < 1e-12, "{a} instead of {b}");
}

#[test]
fn frames_are_links_objects_subframes_and_others() {
    let mut bench = Bench::new();
    bench.apply(object("o", Operation::Add, at(0.0, 2.0, 0.0), vec![ball(at(0.0, 0.0, 0.5))])).unwrap();
    bench
        .attach("tool", object("held", Operation::Add, at(1.0, 0.0, 0.0), vec![ball(Pose::identity())]))
        .unwrap();
    for (frame, place, moves) in [
        ("", [0.0, 0.0, 0.0], false),
        ("base", [0.0, 0.0, 0.0], false),
        ("/mount", [0.0, 0.0, 0.5], false),
        ("world", [0.0, 0.0, 0.0], false),
        // the arm turns about z at (0, 0, 1), and the tool is a metre along its x
        ("tool", [0.0, 1.0, 1.0], true),
        ("o", [0.0, 2.0, 0.0], false),
        ("o/top", [0.0, 2.0, 1.0], false),
        ("held/top", [1.0, 0.0, 1.0], true),
        ("camera", [0.0, 0.0, 9.0], false),
    ] {
        let said = bench.apply(in_frame(
            frame,
            object("probe", Operation::Add, Pose::identity(), vec![ball(Pose::identity()); 2]),
        ));
        let found = bench.shape_pose("probe", 0).translation.vector;
        assert!((found - Vector::from(place)).norm() < 1e-12, "{frame}: {found}");
        assert_eq!(!said.unwrap().is_empty(), moves, "{frame}");
    }
    let lost = bench.apply(in_frame(
        "o/bottom",
        object("p", Operation::Add, at(0.0, 0.0, 0.0), vec![ball(at(0.0, 0.0, 0.0))]),
    ));
    assert!(lost.unwrap_err().to_string().contains("'o/bottom'"));
}

#[test]
fn an_only_shape_lends_the_object_its_pose() {
    let mut bench = Bench::new();
    bench.apply(object("o", Operation::Add, Pose::identity(), vec![ball(at(3.0, 0.0, 0.0))])).unwrap();
    near(&bench.world.obstacle_by_name("o").unwrap().pose_ro, &at(3.0, 0.0, 0.0));
    // so that it is where a move puts it
    bench.apply(object("o", Operation::Move, at(0.0, 5.0, 0.0), vec![])).unwrap();
    near(&bench.shape_pose("o", 0), &at(0.0, 5.0, 0.0));
    let two = vec![ball(at(3.0, 0.0, 0.0)), ball(at(4.0, 0.0, 0.0))];
    bench.apply(object("two", Operation::Add, Pose::identity(), two)).unwrap();
    bench.apply(object("two", Operation::Move, at(0.0, 5.0, 0.0), vec![])).unwrap();
    near(&bench.shape_pose("two", 0), &at(3.0, 5.0, 0.0));
}

#[test]
fn appended_shapes_are_in_the_frame_of_the_object() {
    let mut bench = Bench::new();
    let turned = pose_from_xyz_rpy([1.0, 0.0, 0.0], [0.0, 0.0, QUARTER]);
    bench.apply(object("o", Operation::Append, turned, vec![ball(Pose::identity())])).unwrap();
    let said = bench.apply(object("o", Operation::Append, at(9.0, 9.0, 9.0), vec![ball(at(1.0, 0.0, 0.0))]));
    assert!(said.unwrap()[0].contains("pose is not used"));
    near(&bench.shape_pose("o", 1), &(turned * at(1.0, 0.0, 0.0)));
}

#[test]
fn objects_are_attached_moved_with_the_link_and_let_go() {
    let mut bench = Bench::new();
    bench.apply(object("o", Operation::Add, at(0.0, 1.0, 1.25), vec![ball(Pose::identity())])).unwrap();
    bench.attach("tool", object("o", Operation::Add, Pose::identity(), vec![])).unwrap();
    assert!(bench.world.obstacle_by_name("o").is_none());
    near(
        &bench.world.attached_by_name("o").unwrap().pose_lo,
        &pose_from_xyz_rpy([0.0, 0.0, 0.25], [0.0, 0.0, -QUARTER]),
    );
    // the object is held, and there cannot be another
    let again = bench.apply(object("o", Operation::Add, at(1.0, 0.0, 0.0), vec![ball(Pose::identity())]));
    assert_eq!(again, Err(ObjectError::Held("o".to_owned())));
    let q = bench.robot.configuration(&[0.0]).unwrap();
    bench.robot.forward_kinematics(&q, &mut bench.poses);
    let wrong = bench.attach("arm", object("o", Operation::Remove, Pose::identity(), vec![]));
    assert!(matches!(wrong, Err(ObjectError::OtherLink { .. })));
    bench.attach("tool", object("o", Operation::Remove, Pose::identity(), vec![])).unwrap();
    near(&bench.shape_pose("o", 0), &pose_from_xyz_rpy([1.0, 0.0, 1.25], [0.0, 0.0, -QUARTER]));
    assert!(bench.world.attached().is_empty());
}

#[test]
fn attached_objects_given_in_their_link_do_not_ask_for_the_state() {
    let mut bench = Bench::new();
    let part = object("part", Operation::Add, at(0.0, 0.0, 0.3), vec![ball(Pose::identity()); 2]);
    assert!(bench.attach("tool", in_frame("tool", part.clone())).unwrap().is_empty());
    near(&bench.world.attached_by_name("part").unwrap().pose_lo, &at(0.0, 0.0, 0.3));
    // the arm and the tool are one rigid body
    assert!(bench.attach("tool", in_frame("arm", part.clone())).unwrap().is_empty());
    near(&bench.world.attached_by_name("part").unwrap().pose_lo, &at(-1.0, 0.0, 0.3));
    assert!(bench.attach("tool", part).unwrap()[0].contains("state"));
    let more = object("part", Operation::Append, Pose::identity(), vec![ball(at(1.0, 0.0, 0.0))]);
    let before = bench.world.attached_by_name("part").unwrap().pose_lo;
    bench.attach("tool", more).unwrap();
    let part = bench.world.attached_by_name("part").unwrap();
    near(&part.pose_lo, &before);
    assert_eq!((part.shapes.len(), part.touch_links.len()), (3, 2));
}

#[test]
fn all_go_but_the_octomap_when_no_name_is_given() {
    let mut bench = Bench::new();
    let octomap = Obstacle::of_shape(OCTOMAP_NAME, Pose::identity(), ball(Pose::identity()).shape);
    bench.world.add(octomap).unwrap();
    for name in ["a", "b"] {
        bench.apply(object(name, Operation::Add, at(1.0, 0.0, 0.0), vec![ball(Pose::identity())])).unwrap();
        bench
            .attach(
                "tool",
                object(&format!("{name}2"), Operation::Add, at(1.0, 0.0, 0.0), vec![ball(Pose::identity())]),
            )
            .unwrap();
    }
    bench.apply(object("", Operation::Remove, Pose::identity(), vec![])).unwrap();
    assert_eq!(bench.world.len(), 1);
    bench.attach("", object("", Operation::Remove, Pose::identity(), vec![])).unwrap();
    assert_eq!((bench.world.len(), bench.world.attached().len()), (3, 0));
}

#[test]
fn faults_name_the_field_and_change_nothing() {
    let mut bench = Bench::new();
    let one = || vec![ball(Pose::identity())];
    let here = Pose::identity;
    for (given, word) in [
        (object("", Operation::Add, here(), one()), "id"),
        (object(OCTOMAP_NAME, Operation::Add, here(), one()), "octomap"),
        (object("arm", Operation::Add, here(), one()), "'arm'"),
        (object("o", Operation::Add, here(), vec![]), "no shapes"),
        (object("o", Operation::Append, here(), vec![]), "no shapes"),
        (object("o", Operation::Move, here(), vec![]), "'o'"),
        (in_frame("odom", object("o", Operation::Add, here(), one())), "'odom'"),
    ] {
        let error = bench.apply(given).unwrap_err().to_string();
        assert!(error.contains(word), "{error}");
    }
    for (link, given, word) in [
        ("hand", object("o", Operation::Add, here(), one()), "'hand'"),
        ("tool", object("o", Operation::Add, here(), vec![]), "no shapes"),
        ("tool", object("o", Operation::Move, here(), vec![]), "moved"),
        ("tool", object("o", Operation::Remove, here(), vec![]), "'o'"),
        ("tool", object("tool", Operation::Add, here(), one()), "'tool'"),
        ("tool", in_frame("odom", object("o", Operation::Add, here(), one())), "'odom'"),
    ] {
        let error = bench.attach(link, given).unwrap_err().to_string();
        assert!(error.contains(word), "{error}");
    }
    assert!(bench.world.is_empty());
}
