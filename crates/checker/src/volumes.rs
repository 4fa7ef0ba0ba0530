//! Boxes around the robot's parts at one level of their hierarchies, for visualisation.

use clearance_geometry::math::{Extremes, Pose, Vector};
use clearance_robot::{LinkId, LinkPoses};

use super::CollisionChecker;
use super::bodies::{RobotBody, pose};
use clearance_scene::BodyId;

/// A box of the hierarchy of a part.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LinkVolume {
    pub body: BodyId,
    /// The link that is or carries the part.
    pub link: LinkId,
    /// The box in the frame of that link.
    pub pose_lv: Pose,
    pub half_extents: Vector,
}

impl CollisionChecker {
    /// The boxes around links and their attached objects, at a given depth below the roots of their hierarchies
    /// ([`CollisionBody::volumes`](clearance_proximity::CollisionBody::volumes)); without padding.
    pub fn link_volumes(&self, level: usize) -> impl Iterator<Item = LinkVolume> {
        self.robot_bodies.iter().flat_map(move |robot_body| {
            let pose_lb = pose(&robot_body.seat().place).inverse();
            robot_body.solid.volumes(level).into_iter().map(move |volume| LinkVolume {
                body: robot_body.id,
                link: robot_body.link,
                pose_lv: pose_lb * volume.pose_bv,
                half_extents: volume.half_extents,
            })
        })
    }

    /// Upper bound (m) on the distance of any point of the robot and its attached objects from its root, padding included.
    #[must_use]
    pub fn extent(&self, poses: &LinkPoses) -> f64 {
        let of_part = |robot_body: &RobotBody| {
            let pose_rb = poses.pose(robot_body.link) * pose(&robot_body.seat().place).inverse();
            let ends = [robot_body.capsule.a, robot_body.capsule.b].map(|end| (pose_rb * end).coords.norm());
            ends[0].greater(ends[1]) + robot_body.capsule.radius + robot_body.padding
        };
        self.robot_bodies.iter().map(of_part).fold(0.0, f64::greater)
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use clearance_geometry::{Primitive, Shape};
    use clearance_robot::{MeshFiles, RobotModel};
    use clearance_scene::Settings;
    use clearance_scene::{Obstacle, World};

    /// The bar is attached to the base by a fixed joint; the box is rotated in the frame of the bar.
    const URDF: &str = r#"<robot name="bars">
      <link name="base"><collision><geometry><sphere radius="0.1"/></geometry></collision></link>
      <link name="bar"><collision><origin xyz="0 0 1" rpy="0.5 0 0"/><geometry><box size="2 0.4 0.2"/></geometry></collision></link>
      <link name="hand"><collision><geometry><sphere radius="0.2"/></geometry></collision></link>
      <joint name="fixed" type="fixed"><parent link="base"/><child link="bar"/><origin xyz="3 0 0" rpy="0 1 0"/></joint>
      <joint name="turn" type="continuous"><parent link="bar"/><child link="hand"/><origin xyz="9 0 0"/><axis xyz="0 0 1"/></joint>
    </robot>"#;

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
            (checker.robot().link(found.link).name.as_str(), *found)
        };
        let (link, bar) = of("bar");
        assert_eq!(link, "bar");
        assert!((bar.pose_lv.translation.vector - Vector::z()).norm() < 1e-6, "{bar:?}");
        // in either order of the axes
        let mut sizes: Vec<f64> = bar.half_extents.iter().copied().collect();
        sizes.sort_by(f64::total_cmp);
        assert!(
            sizes.iter().zip([0.1, 0.2, 1.0]).all(|(size, wanted)| (size - wanted).abs() < 1e-5),
            "{bar:?}"
        );
        let (link, tool) = of("tool");
        assert_eq!(link, "hand");
        assert!((tool.pose_lv.translation.vector - Vector::new(0.0, 7.0, 0.0)).norm() < 1e-6, "{tool:?}");
        assert!((tool.half_extents - Vector::repeat(0.3)).amax() < 1e-5);
    }
}
