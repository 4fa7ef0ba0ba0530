//! Tests of `<disable_default_collisions>` of an SRDF: a default entry of the collision matrix, as in `MoveIt`.

use clearance::checker::{CollisionChecker, MotionOptions};
use clearance::geometry::math::Pose;
use clearance::geometry::{Primitive, Shape};
use clearance::motion::{Certificate, MotionSegment};
use clearance::robot::{MeshFiles, RobotModel, RobotText};
use clearance::scene::AllowedCollisionMatrix;
use clearance::scene::{AttachedObject, Obstacle, ObstacleShape, World};
use clearance::scene::{BodyId, Settings, SkipReason};
use clearance::verifier::verify;
use proptest::prelude::*;
use std::path::Path;
use std::sync::Arc;

use crate::program::clearance_in;

const LINKS: [&str; 4] = ["a", "b", "c", "d"];

/// Balls of radius 0.1 m, one metre apart, on slides beside each other.
fn robot(srdf: &str) -> Arc<RobotModel> {
    let link = |name| {
        format!(
            "<link name='{name}'><collision><geometry><sphere radius='0.1'/></geometry></collision></link>"
        )
    };
    let slide = |(i, name): (usize, &&str)| {
        format!(
            "<joint name='j{name}' type='prismatic'><parent link='root'/><child link='{name}'/>\
             <origin xyz='0 {i} 0'/><axis xyz='1 0 0'/><limit lower='-9' upper='9' velocity='1'/></joint>"
        )
    };
    let links: String = LINKS.into_iter().map(link).collect();
    let joints: String = LINKS.iter().enumerate().map(slide).collect();
    let urdf = format!("<robot name='r'><link name='root'/>{links}{joints}</robot>");
    let srdf = format!("<robot name='r'>{srdf}</robot>");
    let text = RobotText { urdf: &urdf, srdf: Some(&srdf), ..RobotText::default() };
    Arc::new(RobotModel::from_text(&text, &MeshFiles::default()).unwrap_or_else(|e| panic!("{e}: {srdf}")))
}

fn ball() -> Shape {
    Shape::Primitive(Primitive::sphere(0.1).unwrap())
}

/// An obstacle, and an object that link a holds; neither touches anything.
fn world() -> World {
    let mut world = World::default();
    world.add(Obstacle::of_shape("ball", Pose::translation(0.0, 0.0, 3.0), ball())).unwrap();
    world
        .attach(AttachedObject {
            name: "held".to_owned(),
            link: "a".to_owned(),
            pose_lo: Pose::translation(0.0, 0.0, 1.0),
            shapes: vec![ObstacleShape { pose_os: Pose::identity(), shape: ball() }].into(),
            touch_links: vec!["a".to_owned()],
            subframes: Vec::new(),
        })
        .unwrap();
    world
}

fn checker(srdf: &str) -> CollisionChecker {
    CollisionChecker::new(robot(srdf), &world(), Settings::default()).unwrap()
}

fn checked(checker: &CollisionChecker) -> Vec<[String; 2]> {
    let pairs = checker.pairs();
    let of_world = pairs.world_pairs().map(|(part, obstacle)| (part, BodyId::Obstacle(obstacle)));
    let named = |(a, b)| {
        let mut names = [a, b].map(|body| checker.body_name(body).to_owned());
        names.sort();
        names
    };
    let mut names: Vec<_> = pairs.self_pairs().iter().copied().chain(of_world).map(named).collect();
    names.sort();
    names
}

fn count(checker: &CollisionChecker, reason: SkipReason) -> usize {
    checker.pairs().skipped().find(|(r, _)| *r == reason).map_or(0, |(_, count)| count)
}

#[test]
fn a_default_entry_holds_for_links_obstacles_and_attached_objects_now_and_later() {
    let mut checker =
        checker("<disable_default_collisions link='b'/><enable_collisions link1='b' link2='c'/>");
    let expected = [
        ["a", "ball"],
        ["a", "c"],
        ["a", "d"],
        ["b", "c"],
        ["ball", "c"],
        ["ball", "d"],
        ["ball", "held"],
        ["c", "d"],
        ["c", "held"],
        ["d", "held"],
    ];
    assert_eq!(checked(&checker), expected);
    assert_eq!(count(&checker, SkipReason::DisabledByDefault), 4);
    let later = Obstacle::of_shape("later", Pose::translation(0.0, 0.0, 5.0), ball());
    let mut world = checker.world().clone();
    world.add(later).unwrap();
    checker.set_world(&world).unwrap();
    assert!(!checked(&checker).contains(&["b".to_owned(), "later".to_owned()]));
    assert_eq!(count(&checker, SkipReason::DisabledByDefault), 5);
}

#[test]
fn a_matrix_of_a_scene_replaces_the_default_entries() {
    let robot = robot("<disable_default_collisions link='b'/>");
    let matrix = AllowedCollisionMatrix::default();
    let checker = CollisionChecker::with_matrix(robot.clone(), &world(), Settings::default(), Some(&matrix));
    assert_eq!(checker.unwrap().pairs().len(), 6 + 3 + 5);
    let entries = AllowedCollisionMatrix::of_robot(&robot).to_entries();
    assert_eq!(entries.default_entry_names, ["b"]);
    assert_eq!(entries.default_entry_values, [true]);
    let same = AllowedCollisionMatrix::from_entries(&entries).unwrap();
    let of_scene = CollisionChecker::with_matrix(robot.clone(), &world(), Settings::default(), Some(&same));
    let of_srdf = CollisionChecker::new(robot, &world(), Settings::default());
    assert_eq!(checked(&of_scene.unwrap()), checked(&of_srdf.unwrap()));
}

/// An obstacle and an object that link d holds have names of links. What the SRDF, or a matrix, says of a link is not said of them.
#[test]
fn entries_of_a_link_do_not_hold_for_an_object_with_its_name() {
    let srdf = "<disable_collisions link1='a' link2='b'/><disable_collisions link1='c' link2='b'/>\
                <disable_default_collisions link='c'/>";
    let robot = robot(srdf);
    let mut world = World::default();
    world.add(Obstacle::of_shape("a", Pose::translation(0.0, 1.0, 0.0), ball())).unwrap();
    world
        .attach(AttachedObject {
            name: "c".to_owned(),
            link: "d".to_owned(),
            pose_lo: Pose::translation(0.0, 0.0, 1.0),
            shapes: vec![ObstacleShape { pose_os: Pose::identity(), shape: ball() }].into(),
            touch_links: Vec::new(),
            subframes: Vec::new(),
        })
        .unwrap();
    let matrix = AllowedCollisionMatrix::of_robot(&robot);
    for matrix in [None, Some(&matrix)] {
        let checker =
            CollisionChecker::with_matrix(Arc::clone(&robot), &world, Settings::default(), matrix).unwrap();
        let pairs = checker.pairs();
        // all but link c, which the SRDF leaves out by default
        let obstacle: Vec<BodyId> = pairs.world_pairs().map(|(part, _)| part).collect();
        let named = |name: &str| BodyId::Link(robot.link_by_name(name).unwrap());
        let held = BodyId::Attached(clearance::scene::AttachedId(0));
        assert_eq!(obstacle, [named("a"), named("b"), named("d"), held]);
        let with_held = pairs.self_pairs().iter().filter(|(_, b)| *b == held).map(|(a, _)| *a);
        assert_eq!(with_held.collect::<Vec<_>>(), [named("a"), named("b")]);
        let state = robot.default_configuration();
        assert!(!checker.is_free(&state, &mut checker.workspace()), "link b is in the obstacle");
    }
}

/// A certificate of a short motion of all links.
fn certificate(checker: &CollisionChecker) -> Certificate {
    let robot = checker.robot();
    let [from, to] = [0.0, 0.3].map(|x| robot.configuration(&[x; 4]).unwrap());
    let motion = MotionSegment::straight(robot, &from, &to);
    let (_, certificate) =
        checker.certify_motion(&motion, &MotionOptions::default(), &mut checker.workspace());
    certificate.expect("the motion is free")
}

/// The number of pairs that the verifier proves, if it accepts.
fn verified(checker: &CollisionChecker, certificate: &Certificate) -> Option<usize> {
    let (robot, world, settings) = (checker.robot(), checker.world(), checker.settings());
    verify(robot, world, settings, None, certificate).ok().map(|verified| verified.pairs)
}

#[test]
fn a_certificate_with_fewer_pairs_proves_nothing_where_more_are_checked() {
    let [default, explicit] = ["<disable_default_collisions link='b'/>", ""].map(checker);
    let [of_default, of_explicit] = [&default, &explicit].map(certificate);
    assert_eq!(verified(&default, &of_default), Some(9));
    assert_eq!(verified(&explicit, &of_explicit), Some(14));
    assert_eq!(verified(&explicit, &of_default), None);
    assert_eq!(verified(&default, &of_explicit), None);
}

#[test]
fn the_program_names_the_links_that_are_not_checked() {
    let folder =
        Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/cases/reports/srdfdom-97-default-collisions");
    if !folder.is_dir() {
        println!("skipped: {} is missing", folder.display());
        return;
    }
    let check = |arguments: &[&str]| clearance_in(&folder, &[&["check"], arguments].concat());
    let model = |urdf: &'static str| ["--urdf", urdf, "--srdf", "r.srdf", "--state", ""];
    let free = check(&[&model("r.urdf")[..], &["--world", "wm.yaml"]].concat());
    assert_eq!(free.status.code(), Some(0), "{free:?}");
    assert!(String::from_utf8_lossy(&free.stderr).contains("link 'hand_sc' is not checked"), "{free:?}");
    // the hand itself is checked against the cup
    let hit = check(&[&model("r.urdf")[..], &["--world", "w.yaml", "--query", "pairs"]].concat());
    assert_eq!(hit.status.code(), Some(1), "{hit:?}");
    assert!(String::from_utf8_lossy(&hit.stdout).contains("  cup – hand\n"), "{hit:?}");
    // and an enabled pair is checked
    let hit = check(&[&model("r2.urdf")[..], &["--query", "pairs"]].concat());
    assert!(String::from_utf8_lossy(&hit.stdout).contains("  arm – hand_sc\n"), "{hit:?}");
}

/// The rule of `MoveIt`'s `AllowedCollisionMatrix`, written down again: the last element about a pair in the order default,
/// enabled, disabled decides.
fn is_checked(elements: &[(usize, usize, usize)], a: &str, b: &str) -> bool {
    let of_pair = |kind: usize| {
        elements
            .iter()
            .any(|&(k, i, j)| k == kind && i != j && [[a, b], [b, a]].contains(&[LINKS[i], LINKS[j]]))
    };
    let by_default = elements.iter().any(|&(k, i, _)| k == 0 && [a, b].contains(&LINKS[i]));
    if of_pair(2) { false } else { of_pair(1) || !by_default }
}

proptest! {
    #[test]
    fn pairs_are_those_of_moveits_rule_and_the_verifier_agrees(
        elements in prop::collection::vec((0usize..3, 0usize..4, 0usize..4), 0..8),
    ) {
        let srdf: String = elements.iter().map(|&(kind, i, j)| {
            let (a, b) = (LINKS[i], LINKS[j]);
            match kind {
                0 => format!("<disable_default_collisions link='{a}'/>"),
                1 => format!("<enable_collisions link1='{a}' link2='{b}'/>"),
                _ => format!("<disable_collisions link1='{a}' link2='{b}'/>"),
            }
        }).collect();
        let checker = checker(&srdf);
        let bodies = ["a", "b", "ball", "c", "d", "held"];
        let mut expected = Vec::new();
        for (i, a) in bodies.iter().enumerate() {
            for b in &bodies[i + 1..] {
                if [*a, *b] != ["a", "held"] && is_checked(&elements, a, b) {
                    expected.push([(*a).to_owned(), (*b).to_owned()]);
                }
            }
        }
        expected.sort();
        prop_assert_eq!(checked(&checker), expected);
        let skipped: usize = checker.pairs().skipped().map(|(_, count)| count).sum();
        prop_assert_eq!(skipped + checker.pairs().len(), 15);
        prop_assert_eq!(verified(&checker, &certificate(&checker)), Some(checker.pairs().len()));
    }
}
