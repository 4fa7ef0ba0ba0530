//! User settings of collision checking.

use std::collections::HashMap;

use super::{Scene, VolumeSelection};
use clearance_geometry::math::Extremes;

/// Settings for every check of one collision checker.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    /// Safety distance (m) by which every link is enlarged, unless `link_padding` names it.
    pub padding: f64,
    /// Safety distance (m) of individual links, by name.
    pub link_padding: HashMap<String, f64>,
    /// Scale factors of the shapes of individual links, by name (`Shape::scaled`).
    pub link_scale: HashMap<String, f64>,
    /// Safety distance (m) of individual objects against the robot, by name, in addition to the safety distance of its links.
    pub object_padding: HashMap<String, f64>,
    /// Scale factors of the shapes of individual objects, by name.
    pub object_scale: HashMap<String, f64>,
    /// True if padding also applies between links of the robot. As in MoveIt, by default it applies against the world only.
    pub pad_self: bool,
    /// Check links against links.
    pub check_self: bool,
    /// Check links against obstacles.
    pub check_world: bool,
    /// Model of a mesh: surface or solid.
    pub mesh_model: MeshModel,
    /// Kinds of bounding volumes; no collision or distance depends on them.
    pub volumes: VolumeSelection,
}

impl Settings {
    /// These settings with the link paddings and scales of a scene. A scene padding below `padding` does not reduce it: MoveIt lists all
    /// links, most of them with no padding.
    #[must_use]
    pub fn with_scene(mut self, scene: &Scene) -> Self {
        let padded = scene.link_padding.iter().filter(|(_, padding)| **padding > 0.0);
        let padding = self.padding;
        self.link_padding.extend(padded.map(|(link, own)| (link.clone(), own.greater(padding))));
        let scaled = scene.link_scale.iter().filter(|(_, scale)| **scale != 1.0);
        self.link_scale.extend(scaled.map(|(link, scale)| (link.clone(), *scale)));
        self
    }
}

/// Whether an object wholly inside a closed mesh touches it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum MeshModel {
    /// A mesh is a surface, as in FCL, Coal and MoveIt.
    #[default]
    Surface,
    /// A closed mesh is a solid; an open one stays a surface.
    Solid,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            padding: 0.0,
            link_padding: HashMap::new(),
            link_scale: HashMap::new(),
            object_padding: HashMap::new(),
            object_scale: HashMap::new(),
            pad_self: false,
            check_self: true,
            check_world: true,
            mesh_model: MeshModel::Surface,
            volumes: VolumeSelection::default(),
        }
    }
}
