//! A world that changes: obstacles are added, moved and removed; hierarchies of obstacles that stay are kept.

use std::error::Error;
use std::path::Path;
use std::sync::Arc;

use clearance::geometry::math::Pose;
use clearance::{CollisionChecker, Obstacle, Primitive, RobotModel, Settings, Shape, World};

pub fn main() -> Result<(), Box<dyn Error>> {
    let urdf = Path::new(env!("CARGO_MANIFEST_DIR")).join("urdf/two_link/two_link.urdf");
    let robot = Arc::new(RobotModel::load(&urdf, None, &[])?);
    let mut world = World::default();
    let mut checker = CollisionChecker::new(Arc::clone(&robot), &world, Settings::default())?;
    let q = robot.default_configuration();

    // the arm is stretched along x: its tip is a ball of radius 0.1 m around (2, 0, 0)
    let ball = Shape::Primitive(Primitive::sphere(0.1)?);
    let is_free = |checker: &CollisionChecker| checker.is_free(&q, &mut checker.workspace());
    let mut found = vec![("empty", is_free(&checker))];

    world.add(Obstacle::of_shape("ball", Pose::translation(2.1, 0.0, 0.0), ball))?;
    checker.set_world(&world)?;
    found.push(("a ball at the tip", is_free(&checker)));

    world.move_to("ball", Pose::translation(2.5, 0.0, 0.0))?;
    checker.set_world(&world)?;
    found.push(("the ball 0.4 m farther", is_free(&checker)));

    world.remove("ball")?;
    checker.set_world(&world)?;
    found.push(("empty again", is_free(&checker)));

    let free: Vec<bool> = found.iter().map(|(_, free)| *free).collect();
    assert_eq!(free, [true, false, true, true]);
    for (world, free) in &found {
        println!("{world}: {}", if *free { "free" } else { "colliding" });
    }
    Ok(())
}
