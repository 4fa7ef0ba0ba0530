//! Warnings about names in a scene that match nothing and so have no effect.

use std::collections::BTreeSet;

use clearance_robot::{RobotModel, quoted, quoted_list};

use super::{AllowedCollisionMatrix, OCTOMAP, Scene};

impl Scene {
    /// Warnings about touch links that the robot does not have, and about entries of the allowed collision matrix that name neither a
    /// link nor an object.
    #[must_use]
    pub fn names_without_effect(&self, robot: &RobotModel) -> Vec<String> {
        let is_link = |name: &str| robot.link_by_name(name).is_some();
        let of_attached = self.world.attached().iter().filter_map(|object| {
            let unknown: Vec<String> =
                object.touch_links.iter().filter(|name| !is_link(name)).cloned().collect();
            let (object, links) = (quoted(&object.name), quoted_list(&unknown));
            (!unknown.is_empty())
                .then(|| format!("object {object}: touch_links: the robot has no link {links}"))
        });
        of_attached.take(MOST_OBJECTS).chain(self.matrix_without_effect(robot)).collect()
    }

    /// A warning about entries of the allowed collision matrix that name neither a link nor an object.
    pub(super) fn matrix_without_effect(&self, robot: &RobotModel) -> Option<String> {
        let is_known = |name: &str| {
            robot.link_by_name(name).is_some()
                || name == OCTOMAP
                || self.world.obstacle_by_name(name).is_some()
                || self.world.attached_by_name(name).is_some()
        };
        let names = self.matrix.iter().flat_map(AllowedCollisionMatrix::names);
        let unknown: BTreeSet<&str> = names.filter(|name| !is_known(name)).collect();
        let unknown: Vec<String> = unknown.into_iter().map(str::to_owned).collect();
        (!unknown.is_empty()).then(|| {
            let names = quoted_list(&unknown);
            format!(
                "allowed_collision_matrix: entries of {names} have no effect: there is no such link or object"
            )
        })
    }
}

/// Maximum number of attached objects named in warnings.
const MOST_OBJECTS: usize = 20;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{AttachedObject, MatrixEntries};
    use clearance_geometry::math::Pose;
    use clearance_robot::MeshFiles;

    const URDF: &str = r#"<robot name="one"><link name="tip"/></robot>"#;

    fn scene(touch_links: &[&str], names: &[&str], defaults: &[&str]) -> Vec<String> {
        let robot = RobotModel::from_urdf(URDF, &MeshFiles::default()).unwrap();
        let owned = |names: &[&str]| names.iter().map(|&name| name.to_owned()).collect::<Vec<String>>();
        let mut scene = Scene::default();
        let part = AttachedObject {
            name: "part".to_owned(),
            link: "tip".to_owned(),
            pose_lo: Pose::identity(),
            shapes: vec![].into(),
            subframes: Vec::new(),
            touch_links: owned(touch_links),
        };
        let shape = clearance_geometry::Shape::Primitive(clearance_geometry::Primitive::sphere(0.1).unwrap());
        let shapes = vec![crate::ObstacleShape { pose_os: Pose::identity(), shape }];
        scene.world.attach(AttachedObject { shapes: shapes.into(), ..part }).unwrap();
        let entries = MatrixEntries {
            entry_names: owned(names),
            entry_values: names.iter().map(|_| vec![true; names.len()]).collect(),
            default_entry_names: owned(defaults),
            default_entry_values: vec![true; defaults.len()],
        };
        scene.matrix = Some(AllowedCollisionMatrix::from_entries(&entries).unwrap());
        scene.names_without_effect(&robot)
    }

    #[test]
    fn names_of_nothing_are_warned_of() {
        assert!(scene(&["tip"], &["tip", "part", OCTOMAP], &["part"]).is_empty());
        let [touch_links, matrix] =
            scene(&["tip", "finger"], &["tip", "gone"], &["away"]).try_into().unwrap();
        assert!(touch_links.contains("'part'") && touch_links.contains("'finger'"), "{touch_links}");
        assert!(matrix.contains("'away' and 'gone'"), "{matrix}");
    }
}
