//! Geometries in a COLLADA scene, with their transforms.

use std::collections::HashMap;

use nalgebra::{Matrix4, Unit, Vector3};
use roxmltree::Node;

use super::{Collada, children};

/// Maximum nesting depth of nodes: a deeper one is a loop of `instance_node`.
const MOST_LEVELS: usize = 100;

/// Maximum number of visited nodes, and of elements in them; instances count.
const MOST_NODES: usize = 100_000;
const MOST_PARTS: usize = 10_000_000;

/// An instance of a geometry in the scene.
pub(super) struct Shown<'d> {
    pub geometry: Node<'d, 'd>,
    /// Transform from the geometry's coordinates to the file's, in metres.
    pub to_file: Matrix4<f64>,
}

impl<'d> Collada<'d> {
    /// The geometries in the scene, with all node transforms; `base` is applied last.
    pub(super) fn shown_geometries(&mut self, base: Matrix4<f64>) -> Result<Vec<Shown<'d>>, String> {
        let mut shown = Vec::new();
        let mut pending: Vec<(Node, Matrix4<f64>, usize)> = self
            .visual_scene()?
            .map(|scene| children(scene, "node").map(|n| (n, base, 0)).collect())
            .unwrap_or_default();
        // the stack returns the last element first; the file's order is easier to follow
        pending.reverse();
        let (mut visited, mut parts) = (0, 0);
        let mut bind_poses = HashMap::new();
        while let Some((node, to_file, level)) = pending.pop() {
            visited += 1;
            if level > MOST_LEVELS || visited > MOST_NODES {
                return Err(self.at(node, "nodes instance each other without end, or nearly so"));
            }
            let to_file = to_file * self.node_transform(node)?;
            let first = pending.len();
            for part in node.children() {
                parts += 1;
                if parts > MOST_PARTS {
                    return Err(self.at(node, "nodes with many elements are instanced too often"));
                }
                match part.tag_name().name() {
                    "node" => pending.push((part, to_file, level + 1)),
                    "instance_node" => {
                        pending.push((self.referenced(part, "url", &["node"])?, to_file, level + 1));
                    }
                    "instance_geometry" => {
                        shown.push(Shown { geometry: self.referenced(part, "url", &["geometry"])?, to_file });
                    }
                    "instance_controller" => {
                        let controller = self.referenced(part, "url", &["controller"])?;
                        let bound = match bind_poses.get(&controller.id()) {
                            Some(known) => *known,
                            None => self.bind_pose(controller)?,
                        };
                        bind_poses.insert(controller.id(), bound);
                        let (geometry, to_node) = bound;
                        shown.push(Shown { geometry, to_file: to_file * to_node });
                    }
                    _ => {}
                }
            }
            pending[first..].reverse();
        }
        Ok(shown)
    }

    /// The scene that the file instantiates, or its only one.
    fn visual_scene(&self) -> Result<Option<Node<'d, 'd>>, String> {
        let scene = self.only_child(self.xml.root(), "scene")?;
        let instance = scene.map(|s| self.only_child(s, "instance_visual_scene")).transpose()?.flatten();
        if let Some(instance) = instance {
            return self.referenced(instance, "url", &["visual_scene"]).map(Some);
        }
        let mut scenes = children(self.xml.root(), "library_visual_scenes")
            .flat_map(|library| children(library, "visual_scene"));
        let only = scenes.next();
        Ok(only.filter(|_| scenes.next().is_none()))
    }

    /// The product of a node's transform elements, in the order of the file: the last one is applied to points first.
    fn node_transform(&self, node: Node<'d, 'd>) -> Result<Matrix4<f64>, String> {
        let mut product = Matrix4::identity();
        for part in node.children().filter(Node::is_element) {
            product *= match part.tag_name().name() {
                "matrix" => self.affine(part)?,
                "translate" => Matrix4::new_translation(&self.numbers::<3>(part)?.into()),
                "scale" => Matrix4::new_nonuniform_scaling(&self.numbers::<3>(part)?.into()),
                "rotate" => {
                    let [x, y, z, degrees] = self.numbers(part)?;
                    match Unit::try_new(Vector3::new(x, y, z), 1e-12) {
                        Some(axis) => Matrix4::from_axis_angle(&axis, degrees.to_radians()),
                        None => return Err(self.at(part, "a rotation axis without length")),
                    }
                }
                "lookat" | "skew" => return Err(self.at(part, "this transform is not read")),
                _ => continue,
            };
        }
        Ok(product)
    }
}
