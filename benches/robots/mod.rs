//! Bench helper: loads robots, and builds checkers with random obstacles and random states.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use clearance::geometry::math::Vector;
use clearance::{
    AllowedCollisionMatrix, CollisionChecker, Configuration, Obstacle, Primitive, Question, RobotModel,
    Settings, Shape, World,
};

use crate::random::Random;

/// A bundled robot.
pub fn own(name: &str) -> Option<RobotModel> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("urdf").join(name);
    load(&folder.join(format!("{name}.urdf")), &folder.join(format!("{name}.srdf")), &folder)
}

/// A robot of the folder `../shared`, if it is there.
pub fn shared(name: &str) -> Option<RobotModel> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/robots");
    let listing = std::fs::read_to_string(folder.join("robots.json")).ok()?;
    let robots: serde_json::Value = serde_json::from_str(&listing).ok()?;
    let robot = robots.as_array()?.iter().find(|robot| robot["name"] == name)?;
    let path = |key: &str| Some(folder.join(robot[key].as_str()?));
    load(&path("urdf")?, &path("srdf")?, &path("package_root")?)
}

fn load(urdf: &Path, srdf: &Path, packages: &PathBuf) -> Option<RobotModel> {
    RobotModel::load(urdf, Some(srdf), std::slice::from_ref(packages)).ok()
}

/// The bundled arms and, where the folder `../shared` exists, these robots in it.
pub fn all(names: &[&'static str]) -> Vec<(&'static str, Arc<RobotModel>)> {
    let bundled = ["demo_arm", "dual_arm"].map(|name| (name, own(name)));
    let others = names.iter().map(|name| (*name, shared(name)));
    bundled.into_iter().chain(others).filter_map(|(name, robot)| Some((name, Arc::new(robot?)))).collect()
}

/// Boxes, balls and cylinders around a robot, not at its root.
fn surroundings(random: &mut Random) -> World {
    let mut world = World::default();
    for i in 0..8 {
        let shape = match i % 3 {
            0 => Primitive::cuboid([0.1, 0.15, 0.2]),
            1 => Primitive::sphere(0.08),
            _ => Primitive::cylinder(0.06, 0.2),
        };
        let mut pose = random.pose(1.0);
        let (sin, cos) = (f64::from(i) * 0.8).sin_cos();
        pose.translation.vector = Vector::new(0.8 * cos, 0.8 * sin, random.within(0.0, 1.2));
        let shape = Shape::Primitive(shape.expect("valid sizes"));
        world.add(Obstacle::of_shape(format!("obstacle {i}"), pose, shape)).expect("names differ");
    }
    world
}

/// A robot among obstacles. As a setup assistant does, pairs of links that collide in most states are allowed to.
pub fn checker(robot: &Arc<RobotModel>, random: &mut Random) -> CollisionChecker {
    let world = surroundings(random);
    let build = |matrix: Option<&AllowedCollisionMatrix>| {
        CollisionChecker::with_matrix(Arc::clone(robot), &world, Settings::default(), matrix)
            .expect("valid settings")
    };
    let checker = build(None);
    let states: Vec<Configuration> = (0..400).map(|_| random_state(&checker, random)).collect();
    let mut matrix = AllowedCollisionMatrix::from_srdf(robot);
    let reports = checker.check_states(&states, Question::Pairs);
    for &(a, b) in checker.pairs().self_pairs() {
        let count = reports.iter().filter(|report| report.colliding_pairs.contains(&(a, b))).count();
        if 2 * count > states.len() {
            matrix.set(checker.body_name(a), checker.body_name(b), true);
        }
    }
    build(Some(&matrix))
}

/// A state within the joint limits.
pub fn random_state(checker: &CollisionChecker, random: &mut Random) -> Configuration {
    let robot = checker.robot();
    let mut positions = robot.default_configuration().positions().to_vec();
    for joint in robot.joint_ids() {
        let Some(first) = robot.first_position(joint) else { continue };
        let limits = robot.joint(joint).limits;
        let (low, high) = limits.map_or((-3.0, 3.0), |limits| (limits.lower, limits.upper));
        positions[first] = random.within(low, high);
    }
    robot.configuration(&positions).expect("within limits")
}
