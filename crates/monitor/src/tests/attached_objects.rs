//! Tests of attached objects in the speed scale and the time to contact: they count like a shape of the link.

use clearance_geometry::math::Pose;
use clearance_geometry::{Primitive, Shape};
use clearance_scene::{AttachedObject, Obstacle};

use super::*;

/// The folding robot; its ball is a shape of the link or an attached object.
fn folder(held: bool) -> Arc<Revision> {
    const BALL: &str =
        r#"<collision><origin xyz="1 0 0"/><geometry><sphere radius="0.1"/></geometry></collision>"#;
    let urdf = if held { URDF.replace(BALL, "") } else { URDF.to_owned() };
    let robot = RobotModel::from_urdf(&urdf, &MeshFiles::default()).unwrap();
    let mut world = World::default();
    let ball = || Shape::Primitive(Primitive::sphere(0.1).unwrap());
    if held {
        let part = Obstacle::of_shape("part", Pose::translation(1.0, 0.0, 0.0), ball());
        world.attach(AttachedObject::grasped(&part, "ball", &Pose::identity(), vec![])).unwrap();
    }
    world.add(Obstacle::of_shape("post", Pose::translation(0.0, 1.5, 0.0), ball())).unwrap();
    let checker = CollisionChecker::new(Arc::new(robot), &world, Settings::default()).unwrap();
    Arc::new(Revision::new(checker, 1, 0))
}

#[test]
fn what_a_link_holds_is_slowed_down_for_and_looked_ahead_for_as_its_own_shapes() {
    let distances = SpeedDistances { slowdown: 0.5, stop: 0.1 };
    let [mut own, mut held] = [false, true].map(|held| {
        let mut monitor = Monitor::new(settings_of_lookout(), stopwatch);
        let speed = SpeedSettings {
            own: distances,
            world: distances,
            reaction_time: 0.1,
            trigger_count: 1,
            release_count: 1,
            separation: None,
        };
        monitor.set_settings(MonitorSettings { speed, ..settings_of_lookout() });
        monitor.set_checker(folder(held));
        monitor
    });
    let (mut slowed, mut contacts) = (0, 0);
    for i in 0..200 {
        let seconds = f64::from(i) * 0.05;
        let positions = [1.5 * (1.3 * seconds).sin(), 2.9 * (0.7 * seconds).sin()];
        let velocities = [1.95 * (1.3 * seconds).cos(), 2.03 * (0.7 * seconds).cos()];
        let [by_link, by_part] = [&mut own, &mut held]
            .map(|monitor| monitor.on_joint_state(moving(seconds, positions, &velocities), at(seconds)));
        assert_eq!(code(&by_link), code(&by_part));
        let close = |a: f64, b: f64| (a - b).abs() < 1e-9;
        assert!(close(by_link.speed_scale, by_part.speed_scale), "after {seconds} s");
        assert!(close(by_link.time_to_contact(), by_part.time_to_contact()), "after {seconds} s");
        assert_eq!(by_link.distance().is_nan(), by_part.distance().is_nan());
        assert!(by_link.distance().is_nan() || close(by_link.distance(), by_part.distance()));
        slowed += u32::from((0.01..0.99).contains(&by_part.speed_scale));
        contacts += u32::from((0.01..0.49).contains(&by_part.time_to_contact()));
    }
    assert!(slowed > 10 && contacts > 10, "{slowed} slowed down, {contacts} with a contact ahead");
}
