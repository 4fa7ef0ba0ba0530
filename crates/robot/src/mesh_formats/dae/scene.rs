//! Geometries in a COLLADA scene, with their transforms.

use std::collections::HashMap;

use nalgebra::{Matrix4, Unit, Vector3};
use roxmltree::Node;

use super::{Collada, own_children, own_elements};
use crate::mesh_formats::mesh_builder::check_nodes;
use crate::mesh_formats::mesh_memory::Growth;
use crate::xml::is_foreign;

/// Maximum number of elements in the visited nodes; instances count.
const MOST_PARTS: usize = 10_000_000;

/// Elements of a node that neither move nor show anything.
const WITHOUT_EFFECT: [&str; 4] = ["asset", "extra", "instance_camera", "instance_light"];

/// An instance of a geometry in the scene.
pub(super) struct Shown<'d> {
    pub geometry: Node<'d, 'd>,
    /// Transform from the geometry's coordinates to the file's, in metres.
    pub to_file: Matrix4<f64>,
}

/// A node to visit.
struct Visit<'d> {
    node: Node<'d, 'd>,
    /// Transform from its parent's coordinates to the file's, in metres.
    to_file: Matrix4<f64>,
    /// Number of nodes that contain it, by instances too.
    level: usize,
}

impl<'d> Collada<'d> {
    /// The geometries in the scene, with all node transforms; `base` is applied last.
    pub(super) fn shown_geometries(&mut self, base: Matrix4<f64>) -> Result<Vec<Shown<'d>>, String> {
        let mut shown = Vec::new();
        let at_top = |node| Visit { node, to_file: base, level: 0 };
        let mut pending: Vec<Visit> = self
            .visual_scene()?
            .map(|scene| own_children(scene, "node").map(at_top).collect())
            .unwrap_or_default();
        // the stack returns the last element first; the file's order is easier to follow
        pending.reverse();
        let (mut visited, mut parts) = (0, 0);
        let mut bind_poses = HashMap::new();
        // the nodes from the scene to the visited one
        let mut path = Vec::new();
        let mut memory = Growth::default();
        while let Some(Visit { node, to_file, level }) = pending.pop() {
            visited += 1;
            check_nodes(level, visited).map_err(|reason| self.at(node, reason))?;
            path.truncate(level);
            path.push(node.id());
            let to_file = to_file * self.node_transform(node)?;
            let first = pending.len();
            for part in node.children() {
                parts += 1;
                if parts > MOST_PARTS {
                    let reason = format!("nodes have more than {MOST_PARTS} elements, instances counted");
                    return Err(self.at(node, reason));
                }
                let below = |node| Visit { node, to_file, level: level + 1 };
                match part.tag_name().name() {
                    _ if is_foreign(part) => {}
                    "node" => pending.push(below(part)),
                    "instance_node" => {
                        let instanced = self.referenced(part, "url", &["node"])?;
                        if path.contains(&instanced.id()) {
                            return Err(self.at(part, "it is in the node that it names: nodes without end"));
                        }
                        pending.push(below(instanced));
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
            let growth = memory.check::<Visit>(pending.len() + 2 * shown.len());
            growth.map_err(|reason| self.at(node, format!("its nodes {reason}")))?;
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
        let mut scenes = own_children(self.xml.root(), "library_visual_scenes")
            .flat_map(|library| own_children(library, "visual_scene"));
        let only = scenes.next();
        Ok(only.filter(|_| scenes.next().is_none()))
    }

    /// The product of a node's transform elements, in the order of the file: the last one is applied to points first.
    fn node_transform(&mut self, node: Node<'d, 'd>) -> Result<Matrix4<f64>, String> {
        let mut product = Matrix4::identity();
        for part in own_elements(node) {
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
                "node" | "instance_node" | "instance_geometry" | "instance_controller" => continue,
                kind if WITHOUT_EFFECT.contains(&kind) => continue,
                _ => {
                    let line = self.xml.line(part);
                    self.remark_counts.add("unknown elements of a node are skipped", Some(line));
                    continue;
                }
            };
        }
        Ok(product)
    }
}
