//! Loads a robot model from the texts or files of its URDF and SRDF, with its mesh files.

use std::path::{Path, PathBuf};

use clearance_files::input_files::{self, DESCRIPTION_LIMIT};

use super::mesh_files::MeshFiles;
use super::model::RobotModel;
use super::model_error::ModelError;
use super::urdf_validation::ValidUrdf;
use super::{Fault, Place, srdf_reader, urdf_reader, urdf_validation};

/// The texts that describe a robot; names are the names of their files, for messages.
#[derive(Clone, Copy, Debug, Default)]
pub struct RobotText<'t> {
    /// Text of the URDF.
    pub urdf: &'t str,
    /// File name of the URDF.
    pub urdf_name: Option<&'t str>,
    /// Text of the SRDF.
    pub srdf: Option<&'t str>,
    /// File name of the SRDF.
    pub srdf_name: Option<&'t str>,
}

impl RobotModel {
    /// A robot without SRDF.
    ///
    /// # Errors
    /// Every error found in the URDF and its meshes, with line, link and joint.
    pub fn from_urdf(text: &str, files: &MeshFiles) -> Result<Self, ModelError> {
        let text = RobotText { urdf: text, ..RobotText::default() };
        Self::from_text(&text, files)
    }

    /// A robot from its texts.
    ///
    /// # Errors
    /// Every error found in the URDF and its meshes, or, if these have none, in the SRDF.
    pub fn from_text(text: &RobotText, files: &MeshFiles) -> Result<Self, ModelError> {
        let sound = urdf_validation::check(text.urdf, text.urdf_name)?;
        let robot = parse(&sound, text.urdf_name)?;
        let mut model = urdf_reader::build(&robot, sound, files)?;
        if let Some(srdf_text) = text.srdf {
            srdf_reader::apply(&mut model, srdf_text, text.srdf_name)?;
        }
        Ok(model)
    }

    /// A robot from files. Packages are searched in `package_paths`, then beside the URDF and in its parents, then in the ROS
    /// environment; files of other folders are never opened.
    ///
    /// # Errors
    /// As [`Self::from_text`], and when a file cannot be read.
    pub fn load(
        urdf_path: &Path,
        srdf_path: Option<&Path>,
        package_paths: &[PathBuf],
    ) -> Result<Self, ModelError> {
        let folder = urdf_path.parent().filter(|p| !p.as_os_str().is_empty());
        let files = (package_paths.iter())
            .fold(MeshFiles::default(), MeshFiles::with_package_path)
            .beside_urdf(folder.unwrap_or(Path::new(".")))
            .with_environment();
        Self::load_with(urdf_path, srdf_path, &files)
    }

    /// Loads a robot from files; meshes are looked up by `files`.
    ///
    /// # Errors
    /// As [`Self::load`].
    pub fn load_with(
        urdf_path: &Path,
        srdf_path: Option<&Path>,
        files: &MeshFiles,
    ) -> Result<Self, ModelError> {
        let urdf = read_text(urdf_path)?;
        let srdf = srdf_path.map(read_text).transpose()?;
        let text = RobotText {
            urdf: &urdf,
            urdf_name: urdf_path.to_str(),
            srdf: srdf.as_deref(),
            srdf_name: srdf_path.and_then(Path::to_str),
        };
        Self::from_text(&text, files)
    }
}

/// The links and joints of a validated text.
pub(super) fn parse(sound: &ValidUrdf, file: Option<&str>) -> Result<urdf_rs::Robot, ModelError> {
    urdf_rs::read_from_string(&sound.text).map_err(|e| {
        ModelError::from(Fault {
            place: Place { file: file.map(str::to_owned), ..Place::default() },
            message: format!("bad URDF: {e}"),
        })
    })
}

fn read_text(path: &Path) -> Result<String, Fault> {
    input_files::read_text(path, DESCRIPTION_LIMIT).map_err(|error| Fault {
        place: Place { file: Some(path.display().to_string()), ..Place::default() },
        message: error.reason,
    })
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::LinkPoses;
    use clearance_geometry::Shape;
    use clearance_geometry::math::{Point, Vector};

    static MESHES: [(&str, &[u8]); 1] = [(
        "p/t.stl",
        b"solid s\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\n\
          endloop\nendfacet\nendsolid",
    )];

    /// A root with one child joint of each kind, and a finger that mimics the prismatic joint.
    const ALL_KINDS: &str = "<robot name='r'><link name='root'/>
        <link name='turn'><collision><geometry><mesh filename='package://p/t.stl'/></geometry></collision></link>
        <link name='slide'><collision><geometry><mesh filename='package://p/t.stl'/></geometry></collision></link>
        <link name='fly'/><link name='roam'/>
        <link name='finger'><collision><geometry>
            <mesh filename='package://p/t.stl' scale='2 2 2'/></geometry></collision></link>
        <joint name='follow' type='prismatic'><parent link='slide'/><child link='finger'/><axis xyz='0 0 1'/>
            <limit lower='-9' upper='9' velocity='1'/><mimic joint='s' multiplier='-2' offset='0.5'/></joint>
        <joint name='t' type='continuous'><origin xyz='0 0 1' rpy='0 0 1.5707963267948966'/><parent link='root'/>
            <child link='turn'/><axis xyz='1 0 0'/></joint>
        <joint name='s' type='prismatic'><parent link='root'/><child link='slide'/><axis xyz='0 1 0'/>
            <limit lower='1' upper='3' velocity='1'/></joint>
        <joint name='f' type='floating'><parent link='root'/><child link='fly'/></joint>
        <joint name='p' type='planar'><parent link='root'/><child link='roam'/><axis xyz='0 0 1'/></joint></robot>";

    fn all_kinds() -> RobotModel {
        RobotModel::from_urdf(ALL_KINDS, &MeshFiles::embedded(&MESHES)).unwrap_or_else(|e| panic!("{e}"))
    }

    #[test]
    fn positions_follow_the_joints_of_the_urdf() {
        let model = all_kinds();
        assert_eq!(
            model.position_names(),
            [
                "t",
                "s",
                "f/trans_x",
                "f/trans_y",
                "f/trans_z",
                "f/rot_x",
                "f/rot_y",
                "f/rot_z",
                "f/rot_w",
                "p/x",
                "p/y",
                "p/theta"
            ]
        );
        assert_eq!(model.degrees_of_freedom(), 11);
        // the middle of limits that exclude zero, and the identity rotation
        let q = model.default_configuration();
        assert_eq!(q.positions(), [0.0, 2.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0]);
    }

    #[test]
    fn every_kind_of_joint_moves_its_link() {
        let model = all_kinds();
        let quarter = std::f64::consts::FRAC_PI_2;
        let q = model
            .configuration_from_names([
                ("t", quarter),
                ("s", 2.5),
                ("f/trans_z", 7.0),
                ("f/rot_x", 1.0),
                ("f/rot_w", 0.0),
                ("p/x", 3.0),
                ("p/theta", quarter),
            ])
            .unwrap();
        let mut poses = LinkPoses::new(&model);
        model.forward_kinematics(&q, &mut poses);
        let point = |link: &str, x: f64, y: f64, z: f64| {
            poses.pose(model.link_by_name(link).unwrap()) * Point::new(x, y, z)
        };
        for (found, expected) in [
            // y turned about x to z
            (point("turn", 0.0, 1.0, 0.0), Point::new(0.0, 0.0, 2.0)),
            (point("turn", 1.0, 0.0, 0.0), Point::new(0.0, 1.0, 1.0)),
            (point("slide", 0.0, 0.0, 0.0), Point::new(0.0, 2.5, 0.0)),
            (point("finger", 0.0, 0.0, 0.0), Point::new(0.0, 2.5, -4.5)),
            (point("fly", 0.0, 1.0, 0.0), Point::new(0.0, -1.0, 7.0)),
            (point("roam", 1.0, 0.0, 0.0), Point::new(3.0, 1.0, 0.0)),
        ] {
            assert!((found - expected).norm() < 1e-12, "{found} instead of {expected}");
        }
    }

    #[test]
    fn a_follower_of_a_fixed_joint_stays_at_its_offset() {
        let fixed = ALL_KINDS.replace("<joint name='s' type='prismatic'>", "<joint name='s' type='fixed'>");
        let model = RobotModel::from_urdf(&fixed, &MeshFiles::embedded(&MESHES)).unwrap();
        assert!(!model.position_names().iter().any(|name| name == "s" || name == "follow"));
        let warnings: Vec<String> = model.warnings().iter().map(ToString::to_string).collect();
        assert!(warnings[0].contains("joint 'follow': mimics joint 's', which is fixed"), "{warnings:?}");
        let q = model.configuration_from_names([("follow", 0.5), ("t", 1.0)]).unwrap();
        assert_eq!(model.joint_position(&q, model.joint_by_name("follow").unwrap()), Some(0.5));
        let error = model.configuration_from_names([("follow", 0.6)]).unwrap_err().to_string();
        assert!(error.contains("'follow' is given position 0.6, but it mimics 's'"), "{error}");
        let mut poses = LinkPoses::new(&model);
        model.forward_kinematics(&q, &mut poses);
        let [slide, finger] = ["slide", "finger"].map(|link| model.link_by_name(link).unwrap());
        assert_eq!(poses.pose(finger).translation.vector, Vector::new(0.0, 0.0, 0.5));
        assert!(model.same_rigid_body(slide, finger));
    }

    #[test]
    fn equal_meshes_are_shared() {
        let model = all_kinds();
        let mesh = |link: &str| {
            let link = model.link(model.link_by_name(link).unwrap());
            match &link.collisions[0].shape {
                Shape::Mesh(mesh) => mesh.clone(),
                _ => panic!("no mesh"),
            }
        };
        assert!(Arc::ptr_eq(&mesh("turn"), &mesh("slide")));
        assert!(!Arc::ptr_eq(&mesh("turn"), &mesh("finger")));
        assert_eq!(mesh("finger").bounds().1 - Point::origin(), Vector::new(2.0, 2.0, 0.0));
    }

    #[test]
    fn files_that_are_no_text_are_named() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("r.urdf");
        let message = |bytes: &[u8]| {
            std::fs::write(&file, bytes).unwrap();
            RobotModel::load(&file, None, &[]).unwrap_err().to_string()
        };
        assert!(message(b"\x1f\x8b\x08").contains("gzip"));
        assert!(message(b"<robot name='\xe4'/>").contains("UTF-8"));
        assert!(message(b"<robot name='r'/>").contains("r.urdf:1: "));
        let missing = RobotModel::load(&folder.path().join("none"), None, &[]).unwrap_err();
        assert!(missing.to_string().contains("none"));
        assert!(RobotModel::load(folder.path(), None, &[]).unwrap_err().to_string().contains("a directory"));
    }
}
