//! Skinned and morphed meshes of a COLLADA file, in the pose in which they were bound.

use nalgebra::Matrix4;
use roxmltree::Node;

use super::{Collada, own_child};

/// Maximum number of controllers of which each deforms the output of the next.
const MOST_CONTROLLERS: usize = 100;

impl<'d> Collada<'d> {
    /// The geometry that a `<controller>` deforms, with its undeformed pose: skins and morphs are not applied.
    pub(super) fn bind_pose(
        &mut self,
        controller: Node<'d, 'd>,
    ) -> Result<(Node<'d, 'd>, Matrix4<f64>), String> {
        let (mut controller, mut to_mesh) = (controller, Matrix4::identity());
        let mut seen = Vec::new();
        while seen.len() < MOST_CONTROLLERS {
            if seen.contains(&controller.id()) {
                return Err(self.at(controller, "controllers deform each other without end"));
            }
            seen.push(controller.id());
            let (skin, morph) = (own_child(controller, "skin"), own_child(controller, "morph"));
            let Some(deformer) = skin.or(morph) else {
                return Err(self.at(controller, "has neither <skin> nor <morph>"));
            };
            let what = if skin.is_some() {
                "the mesh is skinned: it is taken as it was bound"
            } else {
                "the mesh is morphed: it is taken without"
            };
            self.remarks.push(self.at(controller, what));
            if let Some(matrix) = self.only_child(deformer, "bind_shape_matrix")? {
                to_mesh *= self.affine(matrix)?;
            }
            let source = self.referenced(deformer, "source", &["geometry", "controller"])?;
            if source.tag_name().name() == "geometry" {
                return Ok((source, to_mesh));
            }
            controller = source;
        }
        let message = format!("more than {MOST_CONTROLLERS} controllers deform the output of one another");
        Err(self.at(controller, message))
    }
}
