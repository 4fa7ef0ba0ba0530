//! Tests of world sources: octrees of files and of topics, and data that was dropped because it was too old.

use clearance_monitor::Reason;
use clearance_scene::{OCTOMAP, Octomap as Octree, OctomapPlacement, SceneChange, SceneLoader};

use super::*;
use crate::recording::step::SceneSource;
use crate::scene::command_conversion::{clear_octomap, octomap_command, scene_command, unreceivable_command};
use crate::scene::file_obstacles::FileObstacles;
use crate::scene::loader_scene::LoaderScene;
use crate::scene::scene_command::SceneCommand;
use crate::scene::scene_update_context::SceneUpdateContext;

/// A tree whose only leaf is occupied.
const LEAF: [u8; 2] = [0b10, 0];

fn octree() -> Octree {
    Octree::from_binary(0.1, &LEAF).unwrap()
}

/// The scene of world files: an octree and a ball.
fn files() -> Scene {
    let mut loader = SceneLoader::default();
    loader.add_octomap(&octree(), "map.bt", &robot()).unwrap();
    let mut scene = loader.into_scene();
    let ball = Shape::Primitive(Primitive::sphere(0.1).unwrap());
    scene.world.add(Obstacle::of_shape("shelf", Pose::identity(), ball)).unwrap();
    scene
}

/// A map from a topic, received at `received_at`.
fn map(data: &[u8], received_at: Now) -> SceneCommand {
    octomap_command(SceneSource::OctomapBinary, message(data), false, received_at)
}

fn message(data: &[u8]) -> Octomap {
    let data = data.iter().map(|byte| byte.cast_signed()).collect();
    Octomap { id: "OcTree".to_owned(), binary: true, resolution: 0.1, data, ..Octomap::default() }
}

/// The fault of a rejected obstacle that makes the state UNKNOWN.
fn rejected(scene: &LoaderScene) -> Option<String> {
    match scene.incomplete(&Parameters::default())? {
        Reason::RejectedObstacle { fault, .. } => Some(fault),
        other => panic!("{other:?}"),
    }
}

#[test]
fn an_older_map_is_rejected_unless_the_clock_was_set_back() {
    let (robot, parameters) = (robot(), Parameters::default());
    let at = |seconds: i32| Now {
        ros: Some(Time::from_nanoseconds(i64::from(seconds) * 1_000_000_000)),
        steady: Duration::from_secs(5),
    };
    // whether a map with this stamp (s) is taken at this time (s)
    let taken = |scene: &mut LoaderScene, stamp: i32, now: i32| {
        let mut map = message(&LEAF);
        map.header.stamp.sec = stamp;
        let command = octomap_command(SceneSource::OctomapFull, map, false, at(now));
        scene.apply(command, &robot, &SceneUpdateContext::first(&parameters, at(now)))
    };
    let mut scene = LoaderScene::default();
    assert!(taken(&mut scene, 100, 100));
    for late in [99, 70] {
        assert!(!taken(&mut scene, late, 101));
        let fault = rejected(&scene).unwrap();
        assert!(
            fault.starts_with("octomap_full") && fault.contains("older than that of the last"),
            "{fault}"
        );
        assert!(scene.octomap.is_some());
    }
    assert!(taken(&mut scene, 100, 102) && rejected(&scene).is_none(), "the same stamp");
    assert!(taken(&mut scene, 5, 5) && rejected(&scene).is_none(), "the clock was set back");
    assert!(!taken(&mut scene, 4, 6));

    // a map of a scene has no stamp
    let context = SceneUpdateContext::first(&parameters, at(7));
    let mut whole = PlanningScene::default();
    whole.world.octomap.octomap = message(&LEAF);
    let whole = scene_command(SceneSource::PlanningScene, whole, false, at(7));
    assert!(scene.apply(whole, &robot, &context));
    assert!(taken(&mut scene, 3, 8) && rejected(&scene).is_none());
    scene.apply(clear_octomap(), &robot, &context);
    assert!(taken(&mut scene, 2, 9), "there was none");
    // a blind map is the last one, too
    let mut blank = message(&[]);
    blank.header.stamp.sec = 10;
    let blank = octomap_command(SceneSource::OctomapFull, blank, false, at(10));
    assert!(!scene.apply(blank, &robot, &SceneUpdateContext::first(&parameters, at(10))));
    assert!(!taken(&mut scene, 9, 11));
}

#[test]
fn maps_of_several_publishers_in_turn_are_rejected() {
    let (robot, parameters) = (robot(), Parameters::default());
    let context = SceneUpdateContext::first(&parameters, now());
    let mut scene = LoaderScene::default();
    assert!(scene.apply(map(&LEAF, now()).of_shared_topic(false), &robot, &context));
    assert!(!scene.apply(map(&LEAF, now()).of_shared_topic(true), &robot, &context));
    let fault = rejected(&scene).unwrap();
    assert!(fault.starts_with("octomap_binary") && fault.contains("several publishers send"), "{fault}");
    assert!(fault.contains("ros2 topic info -v octomap_binary") && scene.octomap.is_some(), "{fault}");
    assert!(scene.apply(map(&LEAF, now()).of_shared_topic(false), &robot, &context));
    assert_eq!(rejected(&scene), None);
}

#[test]
fn an_empty_map_is_blind_after_the_octree_of_a_file() {
    let (robot, parameters) = (robot(), Parameters::default());
    let context = SceneUpdateContext::first(&parameters, now());
    let mut scene = LoaderScene::default();
    scene.apply(map(&[], now()), &robot, &context);
    assert!(scene.incomplete(&parameters).is_none());

    let mut scene = LoaderScene::default();
    scene.replace_scene(files(), &robot, &context);
    assert!(!scene.apply(map(&[], now()), &robot, &context));
    assert!(matches!(scene.incomplete(&parameters), Some(Reason::BlindCloud { .. })));
    assert!(scene.state.file_octree().is_some());
    // it does not expire
    let expiring = Parameters { octomap_ttl: 1.0, ..Parameters::default() };
    assert_eq!(scene.sources(&expiring), []);

    assert!(scene.apply(map(&LEAF, now()), &robot, &context));
    assert!(scene.incomplete(&parameters).is_none() && scene.state.file_octree().is_none());
    assert_eq!(scene.sources(&expiring).len(), 1);
}

#[test]
fn publishers_from_which_the_node_cannot_receive_are_warnings_while_they_exist() {
    let (robot, parameters) = (robot(), Parameters::default());
    let context = SceneUpdateContext::first(&parameters, now());
    let warning = ["a publisher of /collision_object is incompatible".to_owned()];
    let mut scene = LoaderScene::default();
    // before there is a robot
    scene.store(unreceivable_command(warning.to_vec()));
    assert_eq!((scene.faults(), scene.take_waiting().count()), (warning.to_vec(), 0));
    scene.apply(map(&LEAF, now()), &robot, &context);
    assert_eq!(scene.faults(), warning);
    assert!(scene.incomplete(&parameters).is_none());
    assert!(!scene.apply(unreceivable_command(Vec::new()), &robot, &context));
    assert_eq!(scene.faults(), [""; 0]);
}

/// A whole scene, with an octomap or without one.
fn whole_scene(by: SceneSource, octomap: Option<Octomap>) -> SceneCommand {
    let mut whole = PlanningScene::default();
    whole.world.octomap.octomap = octomap.unwrap_or_default();
    scene_command(by, whole, false, now())
}

#[test]
fn a_whole_scene_without_an_octomap_keeps_that_of_a_sensor_or_file() {
    let (robot, parameters) = (robot(), Parameters::default());
    let context = SceneUpdateContext::first(&parameters, now());
    let expiring = Parameters { octomap_ttl: 1.0, ..Parameters::default() };
    let has_map = |scene: &LoaderScene| scene.state.world.id(OCTOMAP).is_some();
    let whole = || whole_scene(SceneSource::PlanningScene, None);

    let mut scene = LoaderScene::default();
    scene.apply(map(&LEAF, now()), &robot, &context);
    scene.apply(whole(), &robot, &context);
    assert!(has_map(&scene) && scene.octomap.is_some());
    assert_eq!(scene.sources(&expiring).len(), 1);
    // a rejected map of the sensor is missing until the sensor sends another one
    scene.apply(map(&[0b01], now()), &robot, &context);
    scene.apply(whole(), &robot, &context);
    assert!(rejected(&scene).is_some());
    scene.apply(map(&LEAF, now()), &robot, &context);
    assert_eq!(rejected(&scene), None);
    // a rejected map of a scene does not make the sensor's map one of a scene
    scene.apply(whole_scene(SceneSource::PlanningScene, Some(message(&[0b01]))), &robot, &context);
    scene.apply(whole(), &robot, &context);
    assert!(has_map(&scene));

    // as in MoveIt, an octomap of a scene is a part of that scene
    scene.apply(whole_scene(SceneSource::PlanningScene, Some(message(&LEAF))), &robot, &context);
    assert!(has_map(&scene));
    scene.apply(whole(), &robot, &context);
    assert!(!has_map(&scene) && scene.octomap.is_none());

    let mut scene = LoaderScene::default();
    scene.replace_scene(files(), &robot, &context);
    scene.apply(whole(), &robot, &context);
    assert!(scene.state.file_octree().is_some() && scene.state.world.id("shelf").is_none());
    // a client that applies a scene sets all of it
    scene.apply(whole_scene(SceneSource::ApplyPlanningScene, None), &robot, &context);
    assert!(!has_map(&scene));
}

#[test]
fn messages_that_remove_obstacles_of_files_are_reported() {
    let (robot, transforms, files) = (robot(), TransformTree::default(), files());
    let context = SceneContext::new(&robot, None, &transforms, None, 1.0);
    let of_files = FileObstacles::of(&files);
    let removed = |update: &SceneUpdate| {
        let mut scene = files.clone();
        let before = of_files.exposed_to(update, &scene);
        assert_eq!(scene.apply(update, &context).refusals, []);
        before.removed_from(&scene, "topic")
    };
    let octree_is = |verb: &str| format!("topic: the message {verb} the octree of the world files");
    let placed = OctomapPlacement::of(&octree(), String::new(), Pose::identity(), false).unwrap();
    assert_eq!(removed(&SceneUpdate::Octomap(None)), [octree_is("removes")]);
    assert_eq!(removed(&SceneUpdate::Octomap(Some(placed))), [octree_is("replaces")]);
    let all = "topic: the scene removes 1 obstacles of world files: 'shelf'".to_owned();
    assert_eq!(removed(&SceneUpdate::Scene(Box::default())), [octree_is("removes"), all]);

    let mut change = SceneChange { keeps_octomap: true, ..SceneChange::default() };
    change.world.objects.push(object_change(&ball("shelf", at(3.0, 0.0, 0.0), 0.1, "")).unwrap());
    assert_eq!(removed(&SceneUpdate::Scene(Box::new(change.clone()))), [""; 0]);
    change.is_diff = true;
    change.world.objects = vec![];
    assert_eq!(removed(&SceneUpdate::Scene(Box::new(change))), [""; 0]);
}

#[test]
fn dropped_data_is_missing_once_stale_sources_make_the_state_unknown() {
    let robot = robot();
    let dropping = Parameters { stale_source_policy: "drop", octomap_ttl: 1.0, ..Parameters::default() };
    let context = SceneUpdateContext::first(&dropping, now());
    let later = Now { ros: Some(Time::from_nanoseconds(5_000_000_000)), steady: Duration::from_secs(5) };
    let mut scene = LoaderScene::default();
    scene.apply(map(&LEAF, now()), &robot, &context);
    assert!(!scene.drop_stale(now(), &dropping) && scene.drop_stale(later, &dropping));
    assert!(scene.state.world.is_empty() && scene.sources(&dropping).is_empty());

    let unknown = |octomap_ttl| Parameters { octomap_ttl, ..Parameters::default() };
    assert!(scene.drop_stale(later, &unknown(100.0)) && !scene.drop_stale(later, &unknown(100.0)));
    for parameters in [unknown(100.0), unknown(0.0), dropping.clone()] {
        scene.drop_stale(later, &parameters);
        let sources = scene.sources(&parameters);
        assert_eq!(sources.iter().map(|source| source.name.as_str()).collect::<Vec<_>>(), [OCTOMAP]);
        assert!(sources[0].freshness(later).is_err(), "{sources:?}");
    }
    scene.apply(map(&LEAF, later), &robot, &context);
    assert!(scene.sources(&unknown(100.0))[0].freshness(later).is_ok());
    scene.apply(clear_octomap(), &robot, &context);
    assert_eq!(scene.sources(&unknown(100.0)), []);
}

#[test]
fn the_octree_of_a_file_is_reported_and_can_be_applied_again() {
    let (robot, mut before) = (robot(), files());
    before.world.move_to(OCTOMAP, Pose::translation(1.0, 2.0, 3.0)).unwrap();
    let told =
        SceneMessages { robot: &robot, scene: &before, padding: 0.0, configuration: None, octomap: None };
    let after = scene(&[scene_message(&told, C::OCTOMAP)]);
    let maps = [&before, &after].map(|scene| scene.world.obstacle_by_name(OCTOMAP).unwrap());
    assert_eq!(maps[0].pose_ro, maps[1].pose_ro);
    let cells = maps.map(|map| match &map.shapes[0].shape {
        Shape::Voxels(voxels) => voxels.cubes().to_vec(),
        other => panic!("{other:?}"),
    });
    assert_eq!(cells[0], cells[1]);
    assert!(after.file_octree().is_none());
}

#[test]
fn paddings_of_links_that_the_robot_lacks_have_no_effect() {
    let (robot, mut scene) = (robot(), Scene::default());
    scene.link_padding.insert("gone".to_owned(), 0.1);
    scene.link_scale.insert("gone".to_owned(), 2.0);
    checker_of(&robot, &scene, MeshModel::Surface, &Parameters::default(), None).unwrap();
}
