//! Octrees of files beside those of topics, and data that was dropped because it was too old.

use clearance_monitor::Reason;
use clearance_scene::{OCTOMAP, Octomap as Octree, OctomapPlacement, SceneChange, SceneLoader};

use super::*;
use crate::recording::step::SceneSource;
use crate::scene::command_conversion::{clear_octomap, octomap_command};
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
    let data = data.iter().map(|byte| byte.cast_signed()).collect();
    let map = Octomap { id: "OcTree".to_owned(), binary: true, resolution: 0.1, data, ..Octomap::default() };
    octomap_command(SceneSource::OctomapBinary, map, false, received_at)
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
