//! Functions of the fuzz targets, one for each input format: each reads arbitrary bytes and uses the result.
//!
//! The functions must not panic, and their work and memory must stay proportional to the input. They read no file and use
//! no network. `recording` writes one file to the folder for temporary files, because recordings are read from a path.

use std::path::{Path, PathBuf};
use std::sync::{Arc, LazyLock};

use clearance::checker::MotionOptions;
use clearance::geometry::Shape;
use clearance::geometry::math::Vector;
use clearance::lint::{HausdorffOptions, LintOptions, html_report};
use clearance::motion::{Certificate, Trajectory, model_fingerprint, world_fingerprint};
use clearance::robot::{LinkPoses, MeshUse, RecordedMeshes, RobotText, VisualGeometry};
use clearance::scene::{AllowedCollisionMatrix, MeshModel, NamedState, Scene, SceneLoader};
use clearance::verifier::{MatrixCertificate, MatrixVerifier, Verifier, matrix_fingerprint, verify};
use clearance::{CollisionChecker, MeshFiles, Question, RobotModel, Settings, World};
use clearance_ros::fuzzing::{MessageKind, OfflineNode, respond_in_memory};
use clearance_ros::{Archive, Prepared, replay};

/// A fuzz target: reads an input.
pub type Target = fn(&[u8]);

/// All fuzz targets, by the names of their corpora.
pub const TARGETS: [(&str, Target); 20] = [
    ("urdf", urdf),
    ("srdf", srdf),
    ("stl", stl),
    ("obj", obj),
    ("dae", dae),
    ("ply", ply),
    ("gltf", gltf),
    ("lint", lint),
    ("pcd", pcd),
    ("ply_cloud", ply_cloud),
    ("octree", octree),
    ("scene_yaml", scene_yaml),
    ("scene_text", scene_text),
    ("trajectory", trajectory),
    ("states", states),
    ("certificate", certificate),
    ("matrix_certificate", matrix_certificate),
    ("recording", recording),
    ("message", message),
    ("http_request", http_request),
];

/// The robot of all targets that need one: a box, a bar, and a tip of three solids, on two hinges.
const URDF: &str = include_str!("../../urdf/two_link/two_link.urdf");

/// More triangles take too long to check with each input.
const MOST_TRIANGLES: usize = 2000;

/// More points of a search for the largest distance take too long.
const MOST_SAMPLES: usize = 500;

/// More obstacles take too long to check with each input.
const MOST_SHAPES: usize = 100;

/// Radius (m) of a point of a cloud.
const POINT_RADIUS: f64 = 0.01;

/// Pairs that one motion may be evaluated for, in place of minutes.
const BUDGET: u64 = 1000;

static ROBOT: LazyLock<Arc<RobotModel>> = LazyLock::new(|| {
    Arc::new(RobotModel::from_urdf(URDF, &MeshFiles::default()).expect("the URDF of the repository is valid"))
});

/// A robot description; it may name the mesh `package://p/t.obj`.
pub fn urdf(data: &[u8]) {
    let Ok(text) = std::str::from_utf8(data) else { return };
    let triangle = b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    let files = in_memory("package://p/t.obj", "/p/t.obj", triangle);
    if let Ok(robot) = RobotModel::from_urdf(text, &files) {
        check_robot(robot, MeshModel::Surface);
    }
}

/// A semantic description of the two-link robot.
pub fn srdf(data: &[u8]) {
    let Ok(text) = std::str::from_utf8(data) else { return };
    let text = RobotText { urdf: URDF, srdf: Some(text), ..RobotText::default() };
    if let Ok(robot) = RobotModel::from_text(&text, &MeshFiles::default()) {
        let _ = AllowedCollisionMatrix::from_srdf(&robot);
        check_robot(robot, MeshModel::Surface);
    }
}

pub fn stl(data: &[u8]) {
    mesh(data, "m.stl");
}

pub fn obj(data: &[u8]) {
    mesh(data, "m.obj");
}

/// COLLADA.
pub fn dae(data: &[u8]) {
    mesh(data, "m.dae");
}

pub fn ply(data: &[u8]) {
    mesh(data, "m.ply");
}

/// JSON or binary; the content decides.
pub fn gltf(data: &[u8]) {
    mesh(data, "m.gltf");
}

/// An OBJ file as collision geometry beside a visual box: its defects, and its distances from the box.
pub fn lint(data: &[u8]) {
    let files = in_memory("m.obj", "m.obj", data);
    let Ok(loaded) = files.load("m.obj", Vector::from_element(1.0)) else { return };
    if loaded.mesh.triangles().len() > MOST_TRIANGLES {
        return;
    }
    let urdf = "<robot name='r'><link name='base'>
        <collision><geometry><mesh filename='m.obj'/></geometry></collision>
        <visual><geometry><box size='1 1 1'/></geometry></visual></link></robot>";
    let text = RobotText { urdf, ..RobotText::default() };
    let (robot, visuals) = (RobotModel::from_urdf(urdf, &files), VisualGeometry::from_text(&text, &files));
    let (Ok(robot), Ok(visuals)) = (robot, visuals) else { return };
    let hausdorff = HausdorffOptions { most_samples: MOST_SAMPLES, ..HausdorffOptions::default() };
    let report =
        clearance::lint::lint(&robot, &visuals, &LintOptions { hausdorff, ..LintOptions::default() });
    let is_finite = |bounds: [f64; 2]| bounds[0] <= bounds[1] && bounds.iter().all(|bound| bound.is_finite());
    for distance in report.links.iter().flat_map(|link| [link.unprotected, link.excess]).flatten() {
        assert!(is_finite([distance.lower, distance.upper]), "{distance:?}");
    }
    assert!(html_report(&report, &robot, &visuals).starts_with('<'));
}

/// A cloud of points.
pub fn pcd(data: &[u8]) {
    scene(data, "cloud.pcd");
}

pub fn ply_cloud(data: &[u8]) {
    scene(data, "cloud.ply");
}

/// An octree of OctoMap: `.bt` or `.ot`.
pub fn octree(data: &[u8]) {
    scene(data, "map.bt");
}

/// A `moveit_msgs/PlanningScene` in YAML.
pub fn scene_yaml(data: &[u8]) {
    scene(data, "scene.yaml");
}

/// MoveIt's `.scene` text.
pub fn scene_text(data: &[u8]) {
    scene(data, "room.scene");
}

/// A trajectory in YAML or JSON, for a check and for the demonstration.
pub fn trajectory(data: &[u8]) {
    let Ok(text) = std::str::from_utf8(data) else { return };
    let _ = clearance_ros::Trajectory::from_yaml(text);
    let Ok(trajectory) = Trajectory::from_yaml(&ROBOT, text, &ROBOT.default_configuration()) else { return };
    let options = MotionOptions { budget: BUDGET, ..MotionOptions::default() };
    let checker = checker(ROBOT.clone(), &World::default(), Settings::default());
    let _ = checker.map(|checker| checker.check_trajectory(&trajectory, &options, &mut checker.workspace()));
}

/// Robot states in YAML or JSON.
pub fn states(data: &[u8]) {
    if let Ok(text) = std::str::from_utf8(data) {
        let _ = NamedState::list_from_text(text, &ROBOT);
    }
}

/// A certificate, as it is, and with hashes that fit, so that its proofs are verified.
pub fn certificate(data: &[u8]) {
    let Ok(text) = std::str::from_utf8(data) else { return };
    let (world, settings) = (World::default(), Settings::default());
    if let Ok(certificate) = Certificate::from_json(text) {
        let _ = verify(&ROBOT, &world, &settings, None, &certificate);
    }
    let Ok(mut certificate) = serde_json::from_str::<Certificate>(text) else { return };
    certificate.model = model_fingerprint(&ROBOT, &settings, None);
    certificate.world = world_fingerprint(&world);
    certificate.motion = certificate.motion_hash();
    certificate.digest = certificate.content_hash();
    if let Ok(verifier) = Verifier::new(&ROBOT, &world, &settings, None) {
        let _ = verifier.verify(&certificate);
    }
}

/// A certificate of a collision matrix, as it is, and with hashes that fit, so that its proofs are verified.
pub fn matrix_certificate(data: &[u8]) {
    let Ok(text) = std::str::from_utf8(data) else { return };
    let Ok(mut certificate) = serde_json::from_str::<MatrixCertificate>(text) else { return };
    let settings = Settings::default();
    let verifier = MatrixVerifier::new(&ROBOT, &settings).expect("the settings are the default ones");
    let _ = verifier.check_subject(&certificate);
    certificate.model = matrix_fingerprint(&ROBOT, &settings);
    certificate.digest = certificate.computed_digest();
    let _ = verifier.check_subject(&certificate);
    for proof in &certificate.pairs {
        let _ = verifier.verify_pair(proof);
    }
    for proof in &certificate.always {
        let _ = verifier.verify_always(proof);
    }
}

/// A recording in MCAP, replayed as `clearance replay` does.
pub fn recording(data: &[u8]) {
    let file = std::env::temp_dir().join(format!("clearance-fuzz-{}.mcap", std::process::id()));
    std::fs::write(&file, data).expect("the folder for temporary files is writable");
    replay_file(&file);
    let _ = std::fs::remove_file(&file);
}

fn replay_file(file: &Path) {
    let Ok(archive) = Archive::read(file) else { return };
    let robot = robot_of(&archive).or_else(|| Some(RobotModel::clone(&ROBOT)));
    let prepared = Prepared {
        robot,
        mesh_files: archive.meshes(),
        surroundings: Box::new(|_| Ok(Scene::default())),
        mesh_model: MeshModel::Surface,
    };
    let _ = replay(file, prepared);
}

/// The robot that a recording holds.
fn robot_of(archive: &Archive) -> Option<RobotModel> {
    let file = archive.file(Path::new(archive.given["urdf"].as_str()?)).ok()?;
    RobotModel::from_urdf(std::str::from_utf8(&file).ok()?, &archive.meshes()).ok()
}

/// Messages of the network: each is a byte for its kind, its length in two bytes (little-endian), and its CDR.
pub fn message(data: &[u8]) {
    let Ok(mut node) = OfflineNode::new(Some(RobotModel::clone(&ROBOT))) else { return };
    let mut left = data;
    // the state is evaluated after every message
    for _ in 0..MOST_MESSAGES {
        let [kind, low, high, rest @ ..] = left else { return };
        let length = rest.len().min(usize::from(u16::from_le_bytes([*low, *high])));
        let (bytes, rest) = rest.split_at(length);
        let _ = node.receive(MessageKind::ALL[usize::from(*kind) % MessageKind::ALL.len()], bytes);
        left = rest;
    }
}

/// Messages of one input at most.
const MOST_MESSAGES: usize = 8;

/// Bytes of one HTTP request to the live view.
pub fn http_request(data: &[u8]) {
    let _ = respond_in_memory(data);
}

/// Reads a mesh file and checks a robot of which it is one link, as a surface and as a solid.
fn mesh(data: &[u8], name: &str) {
    let files = in_memory(name, name, data);
    let Ok(loaded) = files.load(name, Vector::from_element(1.0)) else { return };
    if loaded.mesh.triangles().len() > MOST_TRIANGLES {
        return;
    }
    let urdf = format!(
        "<robot name='r'><link name='base'><collision><geometry><mesh filename='{name}'/></geometry></collision></link>
        <link name='ball'><collision><geometry><sphere radius='0.5'/></geometry></collision></link>
        <link name='between'/><joint name='i' type='fixed'><parent link='base'/><child link='between'/></joint>
        <joint name='j' type='continuous'><parent link='between'/><child link='ball'/></joint></robot>"
    );
    if let Ok(robot) = RobotModel::from_urdf(&urdf, &files) {
        check_robot(robot.clone(), MeshModel::Surface);
        check_robot(robot, MeshModel::Solid);
    }
}

/// Reads a file of obstacles and checks the two-link robot among them.
fn scene(data: &[u8], name: &str) {
    let mut loader = SceneLoader::default();
    loader.unknown_is_occupied = data.len() % 2 == 1;
    let read = loader.read_file(data, Path::new(name), Some(POINT_RADIUS), &ROBOT, &MeshFiles::default());
    let scene = loader.into_scene();
    if read.is_err() || !is_small(&scene.world) {
        return;
    }
    let settings = Settings::default().with_scene(&scene);
    if let Some(checker) = checker(ROBOT.clone(), &scene.world, settings) {
        evaluate(&checker);
    }
}

fn is_small(world: &World) -> bool {
    let shapes: Vec<&Shape> =
        world.obstacles().flat_map(|obstacle| obstacle.shapes.iter()).map(|placed| &placed.shape).collect();
    let triangles = shapes.iter().map(|shape| match shape {
        Shape::Mesh(mesh) => mesh.triangles().len(),
        _ => 0,
    });
    shapes.len() <= MOST_SHAPES && triangles.sum::<usize>() <= MOST_TRIANGLES
}

/// Files that hold one mesh, and the buffer `b.bin` beside it.
fn in_memory(uri: &str, file: &str, content: &[u8]) -> MeshFiles {
    let mut meshes = RecordedMeshes::default();
    let found = MeshUse { folder: None, uri: uri.to_owned(), file: PathBuf::from(file) };
    meshes.insert(found, content.into());
    let buffer =
        MeshUse { folder: Some(PathBuf::from(file)), uri: "b.bin".to_owned(), file: PathBuf::from("b.bin") };
    meshes.insert(buffer, content.into());
    MeshFiles::recorded(Arc::new(meshes))
}

fn check_robot(robot: RobotModel, mesh_model: MeshModel) {
    let settings = Settings { mesh_model, ..Settings::default() };
    if let Some(checker) = checker(Arc::new(robot), &World::default(), settings) {
        evaluate(&checker);
    }
}

fn checker(robot: Arc<RobotModel>, world: &World, settings: Settings) -> Option<CollisionChecker> {
    CollisionChecker::new(robot, world, settings).ok()
}

/// The kinematics and two queries on the default state.
fn evaluate(checker: &CollisionChecker) {
    let robot = checker.robot();
    let state = robot.default_configuration();
    robot.forward_kinematics(&state, &mut LinkPoses::new(robot));
    let mut workspace = checker.workspace();
    let is_free = checker.check(&state, Question::Free, &mut workspace).is_free();
    let report = checker.check(&state, Question::Distance { limit: 10.0 }, &mut workspace);
    assert_eq!(is_free, report.is_free(), "two queries on one state contradict each other");
}
