//! Visual geometry of a robot, for comparisons with its collision geometry. No collision query uses it.

use super::mesh_files::MeshFiles;
use super::model::{Collision, RobotModel};
use super::model_error::ModelError;
use super::robot_text::{RobotText, parse};
use super::urdf_reader::{self, LinkGeometries};
use super::urdf_validation::{GeometryKind, check_geometry};
use super::{Fault, Warning};

/// The visual geometry of a robot.
#[derive(Clone, Debug, Default)]
pub struct VisualGeometry {
    /// Visuals of each link, in the order of [`RobotModel::links`], with poses and shapes in the frames that [`Collision`] documents.
    /// Visuals that could not be loaded are left out.
    pub links: Vec<Vec<Collision>>,
    /// Of each visual in [`Self::links`], its place among the `<visual>` elements of its link, from 1.
    pub numbers: Vec<Vec<usize>>,
    /// Visuals that could not be loaded.
    pub faults: Vec<Fault>,
    /// Remarks on the meshes.
    pub warnings: Vec<Warning>,
}

impl VisualGeometry {
    /// Reads `<visual>` of a URDF. Meshes are searched, and their sizes are limited, as those of `<collision>`.
    ///
    /// # Errors
    /// Every error of the XML, and of numbers, shapes and poses of visuals. A mesh that cannot be loaded is no error: it is listed in
    /// [`Self::faults`].
    pub fn from_text(text: &RobotText, files: &MeshFiles) -> Result<Self, ModelError> {
        let sound = check_geometry(text.urdf, text.urdf_name, GeometryKind::Visual)?;
        let robot = parse(&sound, text.urdf_name)?;
        let mut warnings = Vec::new();
        let read = urdf_reader::geometries(&robot, &sound.links, files, &mut warnings);
        let LinkGeometries { links, numbers, faults } = read;
        Ok(Self { links, numbers, faults, warnings })
    }

    /// True if every link of `robot` has an entry in [`Self::links`].
    #[must_use]
    pub fn has_all_links_of(&self, robot: &RobotModel) -> bool {
        self.links.len() == robot.links().len()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use clearance_geometry::{Primitive, Shape};

    fn visuals(urdf: &str) -> Result<VisualGeometry, ModelError> {
        VisualGeometry::from_text(&RobotText { urdf, ..RobotText::default() }, &MeshFiles::default())
    }

    #[test]
    fn visuals_are_read_as_collisions_are() {
        let found = visuals(
            "<robot name='r'><link name='a'><collision><geometry><sphere radius='1'/></geometry></collision>
             <visual name='v'><origin xyz='0 0 2'/><geometry><box size='1 2 3'/></geometry><material name='m'/></visual>
             </link></robot>",
        )
        .unwrap();
        let [visual] = &found.links[0][..] else { panic!("{found:?}") };
        assert_eq!(visual.name.as_deref(), Some("v"));
        assert_eq!(visual.pose_ls.translation.vector.z, 2.0);
        assert!(
            matches!(visual.shape, Shape::Primitive(p) if p == Primitive::cuboid([1.0, 2.0, 3.0]).unwrap())
        );
        assert!(found.faults.is_empty());
    }

    #[test]
    fn a_missing_mesh_leaves_the_other_visuals() {
        let found = visuals(
            "<robot name='r'><link name='a'><visual><geometry><mesh filename='/none.stl'/></geometry></visual>
             <visual><geometry><sphere radius='1'/></geometry></visual></link></robot>",
        )
        .unwrap();
        assert_eq!((found.links[0].len(), &found.numbers[0][..]), (1, &[2][..]));
        assert!(found.faults[0].to_string().contains("link 'a' visual 1"), "{:?}", found.faults);
    }

    #[test]
    fn a_bad_number_is_an_error() {
        let urdf = "<robot name='r'><link name='a'><visual><geometry><sphere radius='x'/></geometry></visual></link></robot>";
        let error = visuals(urdf).unwrap_err().to_string();
        assert!(error.contains("link 'a' visual 1") && error.contains("sphere radius"), "{error}");
    }
}
