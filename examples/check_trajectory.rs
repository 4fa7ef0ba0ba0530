//! A timed trajectory through three points: until when is it free, and what does it hit then?

use std::error::Error;
use std::path::Path;
use std::sync::Arc;

use clearance::geometry::math::Pose;
use clearance::{
    CollisionChecker, MotionOptions, MotionVerdict, Obstacle, Primitive, RobotModel, Settings, Shape,
    Trajectory, TrajectoryPoint, World,
};

pub fn main() -> Result<(), Box<dyn Error>> {
    let urdf = Path::new(env!("CARGO_MANIFEST_DIR")).join("urdf/two_link/two_link.urdf");
    let robot = Arc::new(RobotModel::load(&urdf, None, &[])?);
    let mut world = World::default();
    let ball = Shape::Primitive(Primitive::sphere(0.1)?);
    world.add(Obstacle::of_shape("ball", Pose::translation(0.0, 2.0, 0.0), ball))?;
    let checker = CollisionChecker::new(Arc::clone(&robot), &world, Settings::default())?;

    // positions in rad, times in seconds; as in trajectory_msgs/JointTrajectory, velocities and accelerations are optional
    let joints = ["joint1".to_owned(), "joint2".to_owned()];
    let points =
        [(0.0, [0.0, 0.0]), (1.0, [0.5, 0.0]), (3.0, [1.6, 0.0])].map(|(time_from_start, positions)| {
            TrajectoryPoint { positions: positions.into(), time_from_start, ..TrajectoryPoint::default() }
        });
    let trajectory = Trajectory::from_points(&robot, &joints, &points, &robot.default_configuration())?;

    let report = checker.check_trajectory(&trajectory, &MotionOptions::default(), &mut checker.workspace());
    match (report.verdict, report.time) {
        (MotionVerdict::Contact { pair: (a, b), .. }, Some([before, _])) => {
            let (a, b) = (checker.body_name(a), checker.body_name(b));
            println!("free until {before:.3} s, then {a} hits {b}");
            Ok(())
        }
        (verdict, _) => Err(format!("expected a contact with the ball, got {verdict:?}").into()),
    }
}
