//! One state: is it free, how far is the nearest pair apart, and where?

use std::error::Error;
use std::path::Path;
use std::sync::Arc;

use clearance::geometry::math::Pose;
use clearance::{CollisionChecker, Obstacle, Primitive, Question, RobotModel, Settings, Shape, World};

pub fn main() -> Result<(), Box<dyn Error>> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("urdf/demo_arm");
    let srdf = folder.join("demo_arm.srdf");
    let robot = Arc::new(RobotModel::load(&folder.join("demo_arm.urdf"), Some(&srdf), &[])?);

    // a box of 0.2 m, 0.6 m in front of the root link
    let mut world = World::default();
    let shape = Shape::Primitive(Primitive::cuboid([0.2, 0.2, 0.2])?);
    world.add(Obstacle::of_shape("box", Pose::translation(0.6, 0.0, 0.1), shape))?;

    // shared by all threads; the workspace belongs to one thread
    let checker = CollisionChecker::new(Arc::clone(&robot), &world, Settings::default())?;
    let mut workspace = checker.workspace();

    // joints that are not named stay at their defaults (rad)
    let q = robot.configuration_from_names([("joint2", 0.4), ("joint4", -1.8)])?;
    println!("free: {}", checker.is_free(&q, &mut workspace));

    // distances up to 0.5 m
    let report = checker.check(&q, Question::Distance { limit: 0.5 }, &mut workspace);
    let nearest = report.nearest.ok_or("nothing is within 0.5 m")?;
    let [on_a, on_b] = nearest.witness_points;
    let (a, b) = (checker.body_name(nearest.a), checker.body_name(nearest.b));
    println!("{a} and {b} are {:.4} m apart, at {on_a:.3} and {on_b:.3}", nearest.distance);
    Ok(())
}
