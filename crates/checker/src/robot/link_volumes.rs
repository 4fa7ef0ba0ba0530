//! Bounding volumes of the robot's parts, for visualisation.

use clearance_geometry::math::Pose;
use clearance_proximity::VolumeShape;
use clearance_robot::LinkId;
use clearance_scene::BodyId;

use super::robot_geometry::RobotGeometry;

/// A volume of the hierarchy of a part.
#[derive(Clone, Debug, PartialEq)]
pub struct LinkVolume {
    /// The link or attached object.
    pub body: BodyId,
    /// The link that is or carries the part.
    pub link: LinkId,
    /// Pose of the volume in the frame of that link.
    pub pose_lv: Pose,
    /// Its shape.
    pub shape: VolumeShape,
}

/// The volumes around the parts, at a depth below the roots of their hierarchies.
pub fn link_volumes(robot: &RobotGeometry, level: usize) -> impl Iterator<Item = LinkVolume> {
    robot.parts().iter().flat_map(move |robot_body| {
        let pose_lb = robot_body.pose_bl().inverse();
        robot_body.solid().volumes(level).into_iter().map(move |volume| LinkVolume {
            body: robot_body.id(),
            link: robot_body.link(),
            pose_lv: pose_lb * volume.pose_bv,
            shape: volume.shape,
        })
    })
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::CollisionChecker;
    use clearance_geometry::VolumeKind;
    use clearance_geometry::math::Vector;
    use clearance_geometry::{Primitive, Shape};
    use clearance_robot::{MeshFiles, RobotModel};
    use clearance_scene::{Obstacle, World};
    use clearance_scene::{Settings, VolumeSelection};

    /// The bar is attached to the base by a fixed joint; the box is rotated in the frame of the bar.
    const URDF: &str = r#"<robot name="bars">
      <link name="base"><collision><geometry><sphere radius="0.1"/></geometry></collision></link>
      <link name="bar"><collision><origin xyz="0 0 1" rpy="0.5 0 0"/><geometry><box size="2 0.4 0.2"/></geometry></collision></link>
      <link name="hand"><collision><geometry><sphere radius="0.2"/></geometry></collision></link>
      <joint name="fixed" type="fixed"><parent link="base"/><child link="bar"/><origin xyz="3 0 0" rpy="0 1 0"/></joint>
      <joint name="turn" type="continuous"><parent link="bar"/><child link="hand"/><origin xyz="9 0 0"/><axis xyz="0 0 1"/></joint>
    </robot>"#;

    fn half_extents(volume: &LinkVolume) -> Vector {
        let VolumeShape::Box { half_extents } = &volume.shape else { panic!("{volume:?} is no box") };
        *half_extents
    }

    /// Each link shows its own kind; a link that does not exist is rejected with those that do.
    #[test]
    fn volumes_are_of_the_selected_kinds() {
        let robot = Arc::new(RobotModel::from_urdf(URDF, &MeshFiles::default()).unwrap());
        let checker = |volumes: &str| {
            let volumes: VolumeSelection = volumes.parse().unwrap();
            let settings = Settings { volumes, ..Settings::default() };
            CollisionChecker::new(Arc::clone(&robot), &World::default(), settings)
        };
        let shown = checker("pss,bar=lss").unwrap();
        for volume in shown.link_volumes(0) {
            let is_bar = shown.body_name(volume.body) == "bar";
            assert_eq!(matches!(volume.shape, VolumeShape::Triangles(_)), is_bar, "{volume:?}");
            assert_eq!(matches!(volume.shape, VolumeShape::Ball { .. }), !is_bar, "{volume:?}");
        }
        assert_eq!(shown.settings().volumes.all, VolumeKind::Pss);
        let error = checker("obb,tip=rss").unwrap_err().to_string();
        let expected =
            "volumes: the robot has no link 'tip'; its links with collision geometry are base, bar, hand";
        assert_eq!(error, expected);
    }

    #[test]
    fn volumes_lie_where_the_shapes_are_in_the_frames_of_their_links() {
        let robot = Arc::new(RobotModel::from_urdf(URDF, &MeshFiles::default()).unwrap());
        let mut world = World::default();
        let tool = Shape::Primitive(Primitive::Sphere { radius: 0.3 });
        let tool = Obstacle::of_shape("tool", Pose::translation(0.0, 7.0, 0.0), tool);
        let held = clearance_scene::AttachedObject::grasped(&tool, "hand", &Pose::identity(), vec![]);
        world.attach(held).unwrap();
        let checker = CollisionChecker::new(robot, &world, Settings::default()).unwrap();
        let volumes: Vec<LinkVolume> = checker.link_volumes(0).collect();
        let of = |name: &str| {
            let found = volumes.iter().find(|volume| checker.body_name(volume.body) == name).unwrap();
            (checker.robot().link(found.link).name.as_str(), found)
        };
        let (link, bar) = of("bar");
        assert_eq!(link, "bar");
        assert!((bar.pose_lv.translation.vector - Vector::z()).norm() < 1e-6, "{bar:?}");
        // in either order of the axes
        let mut sizes: Vec<f64> = half_extents(bar).iter().copied().collect();
        sizes.sort_by(f64::total_cmp);
        assert!(
            sizes.iter().zip([0.1, 0.2, 1.0]).all(|(size, wanted)| (size - wanted).abs() < 1e-5),
            "{bar:?}"
        );
        let (link, tool) = of("tool");
        assert_eq!(link, "hand");
        assert!((tool.pose_lv.translation.vector - Vector::new(0.0, 7.0, 0.0)).norm() < 1e-6, "{tool:?}");
        assert!((half_extents(tool) - Vector::repeat(0.3)).amax() < 1e-5);
    }
}
