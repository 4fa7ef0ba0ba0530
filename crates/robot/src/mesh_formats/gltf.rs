//! Reader of glTF 2.0, as text (`.gltf`) and binary (`.glb`): the triangles in the scene, in metres.
//!
//! Only positions, faces and the transforms of nodes are read. Skins and morph targets are not applied: such a mesh is used with its
//! stored positions, placed by its node, with a remark. Axes are used as in the file, although +Y is up in glTF: `MoveIt` does so
//! (`geometric_shapes`), and RViz up to Kilted; newer versions turn +Y to +Z (ros2/rviz pull request 1482). This also causes a remark.
//!
//! The document is read with `serde_json`. The crate `gltf` panics on indices out of range unless it validates; its validation rejects
//! all files that require an unknown extension; and its iterators over accessors panic on wrong strides and sparse elements.

use std::collections::HashMap;
use std::rc::Rc;

use clearance_geometry::math::{Extremes, Point};
use nalgebra::{Matrix4, Quaternion, Translation3, UnitQuaternion};

use super::mesh_builder::{MOST_TRIANGLES, MeshBuilder, check_nodes};
use super::mesh_memory::Growth;
use super::remark_counter::{RemarkCounter, TOO_FEW_CORNERS};
use super::{Parts, ReadMesh, mesh_memory};
use crate::decimal_numbers::shortened;

mod buffers;
mod document;
mod elements;
mod glb;

use buffers::Buffers;
use document::{Asset, Document, Node, Primitive};
use elements::Elements;
use glb::Glb;

pub(super) use glb::MAGIC;

/// Maximum number of visited elements in all instances: the corners of the maximum number of triangles, times two. A primitive counts as
/// a few elements, even if it has none.
const MOST_ELEMENTS: usize = 6 * MOST_TRIANGLES;
const PRIMITIVE_COST: usize = 16;

/// Maximum memory (bytes) of a JSON value, per comma or bracket.
const VALUE_BYTES: usize = 512;

/// Required extensions that do not change positions and faces; others start with one of the prefixes.
const HARMLESS: [&str; 6] = [
    "KHR_mesh_quantization",
    "KHR_lights_punctual",
    "KHR_animation_pointer",
    "KHR_node_visibility",
    "KHR_xmp_json_ld",
    "EXT_lights_image_based",
];
const HARMLESS_PREFIXES: [&str; 4] = ["KHR_materials_", "KHR_texture_", "EXT_texture_", "MSFT_texture_"];

/// # Errors
/// If the file is truncated, is contradictory, needs an unsupported extension, or contains no triangles.
pub(super) fn read_text(text: &[u8], parts: Parts) -> Result<ReadMesh, String> {
    read(text, None, parts)
}

/// # Errors
/// As for [`read_text`].
pub(super) fn read_binary(bytes: &[u8], parts: Parts) -> Result<ReadMesh, String> {
    let Glb { json, buffer, surplus } = Glb::open(bytes)?;
    let mut read = read(json, buffer, parts)?;
    if surplus > 0 {
        read.remarks.push(format!("{surplus} bytes follow the end that its header gives"));
    }
    Ok(read)
}

fn read(json: &[u8], buffer: Option<&[u8]>, parts: Parts) -> Result<ReadMesh, String> {
    mesh_memory::check(values(json).saturating_mul(VALUE_BYTES))
        .map_err(|e| bad(&format!("its values {e}")))?;
    let document: Document = serde_json::from_slice(json).map_err(|e| bad(&shortened(&e.to_string())))?;
    check_version(&document)?;
    let surface = Surface {
        document: &document,
        buffers: Buffers::new(&document, buffer, parts),
        builder: MeshBuilder::default(),
        accessors: HashMap::new(),
        elements: 0,
        remark_counts: RemarkCounter::default(),
    };
    surface.read().map_err(|reason| bad(&reason))
}

/// Maximum number of JSON values; strings, which may hold buffers, count as one.
fn values(json: &[u8]) -> usize {
    let (mut count, mut in_string, mut is_escaped) = (0, false, false);
    for &byte in json {
        match byte {
            _ if is_escaped => is_escaped = false,
            b'\\' if in_string => is_escaped = true,
            b'"' => in_string = !in_string,
            b'{' | b'[' | b',' if !in_string => count += 1,
            _ => {}
        }
    }
    count
}

fn bad(reason: &str) -> String {
    format!("bad glTF: {reason}")
}

fn check_version(document: &Document) -> Result<(), String> {
    let Asset { version, min_version } = &document.asset;
    // a later 2.x adds what a reader of 2.0 may skip, unless it is the least version that the file needs
    let is_later = |version: &str| version == "2" || version.starts_with("2.");
    let is_read = match min_version {
        Some(least) => is_later(version.trim()) && matches!(least.trim(), "2" | "2.0"),
        None => is_later(version.trim()),
    };
    if !is_read {
        let version = shortened(min_version.as_ref().unwrap_or(version));
        return Err(bad(&format!("version '{version}' is not read; 2.0 is")));
    }
    let is_harmless = |name: &String| {
        HARMLESS.contains(&name.as_str()) || HARMLESS_PREFIXES.iter().any(|prefix| name.starts_with(prefix))
    };
    // compression extensions are reported where they are used, with instructions
    let is_told_later = |name: &String| name.contains("draco") || name.contains("meshopt");
    let unknown = document.extensions_required.iter().find(|name| !is_harmless(name) && !is_told_later(name));
    match unknown {
        Some(name) => Err(bad(&format!("it requires the extension {}, which is not read", shortened(name)))),
        None => Ok(()),
    }
}

/// Meaning of the elements of an accessor.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
enum Use {
    Positions,
    Indices,
}

/// A node to visit.
struct Visit {
    node: usize,
    /// Transform from its parent's coordinates to the file's.
    to_file: Matrix4<f64>,
    /// Number of nodes that contain it.
    level: usize,
}

/// The triangles collected so far.
struct Surface<'d> {
    document: &'d Document,
    buffers: Buffers<'d>,
    builder: MeshBuilder,
    /// Validated positions and indices, by accessor; cached, since sparse ones take time.
    accessors: HashMap<(Use, usize), Rc<Elements>>,
    /// Number of elements visited so far.
    elements: usize,
    remark_counts: RemarkCounter,
}

/// The corners of a primitive's triangles: `count` vertices, by index if there are indices, in the topology `mode`.
struct Corners<'e> {
    mode: u32,
    count: usize,
    indices: Option<&'e Elements>,
}

impl Surface<'_> {
    fn read(mut self) -> Result<ReadMesh, String> {
        for (mesh, to_file) in self.shown_meshes()? {
            let found = self.document.meshes.get(mesh);
            let count = self.document.meshes.len();
            let found = found.ok_or_else(|| format!("a node names mesh {mesh}, but there are {count}"))?;
            for (i, primitive) in found.primitives.iter().enumerate() {
                let named = |reason: String| format!("mesh {mesh}, primitive {i}: {reason}");
                self.append(primitive, &to_file).map_err(named)?;
            }
        }
        if self.builder.triangles.is_empty() {
            return Err("the scene shows no triangles".to_owned());
        }
        let mut remarks: Vec<String> = self.remark_counts.remarks().collect();
        remarks.push(
            "+Y is up in glTF, but its axes are taken as they stand in the file, as MoveIt does and RViz up to Kilted"
                .to_owned(),
        );
        if self.document.scenes.len() > 1 {
            let (count, shown) = (self.document.scenes.len(), self.document.scene.unwrap_or_default());
            remarks.push(format!("it has {count} scenes, of which scene {shown} is read"));
        }
        Ok(ReadMesh { mesh: self.builder.finish()?, remarks })
    }

    /// The meshes of the scene, each with the transform from its coordinates to the file's.
    fn shown_meshes(&mut self) -> Result<Vec<(usize, Matrix4<f64>)>, String> {
        let at_top = |node| Visit { node, to_file: Matrix4::identity(), level: 0 };
        let mut pending: Vec<Visit> = self.roots()?.into_iter().rev().map(at_top).collect();
        let (mut shown, mut visited) = (Vec::new(), 0);
        // the nodes from the scene to the visited one
        let mut path = Vec::new();
        let mut memory = Growth::default();
        while let Some(Visit { node: index, to_file, level }) = pending.pop() {
            visited += 1;
            check_nodes(level, visited + pending.len())?;
            let growth = memory.check::<Visit>(pending.len() + shown.len());
            growth.map_err(|reason| format!("its nodes {reason}"))?;
            path.truncate(level);
            if path.contains(&index) {
                return Err(format!("node {index} contains itself: nodes without end"));
            }
            path.push(index);
            let Some(node) = self.document.nodes.get(index) else {
                return Err(format!("names node {index}, but there are {}", self.document.nodes.len()));
            };
            let named = |reason: String| format!("node {index}: {reason}");
            if node.extensions.contains_key("EXT_mesh_gpu_instancing") {
                return Err(named("EXT_mesh_gpu_instancing is not read; save the file without".to_owned()));
            }
            let to_file: Matrix4<f64> = to_file * transform(node).map_err(named)?;
            if let Some(mesh) = node.mesh {
                if node.skin.is_some() {
                    self.remark_counts.add("skinned meshes are taken without their skin, where their node is; glTF viewers place them by their joints", None);
                }
                shown.push((mesh, to_file));
            }
            let below = |&node: &usize| Visit { node, to_file, level: level + 1 };
            pending.extend(node.children.iter().rev().map(below));
        }
        Ok(shown)
    }

    /// The nodes of the scene to read; without any scene, all nodes that are no children.
    fn roots(&self) -> Result<Vec<usize>, String> {
        let Document { scene, scenes, nodes, .. } = self.document;
        if scenes.is_empty() && scene.is_none() {
            let children: std::collections::HashSet<usize> =
                nodes.iter().flat_map(|node| node.children.iter().copied()).collect();
            return Ok((0..nodes.len()).filter(|index| !children.contains(index)).collect());
        }
        let shown = scene.unwrap_or_default();
        match scenes.get(shown) {
            Some(scene) => Ok(scene.nodes.clone()),
            None => Err(format!("names scene {shown}, but there are {}", scenes.len())),
        }
    }

    fn append(&mut self, primitive: &Primitive, to_file: &Matrix4<f64>) -> Result<(), String> {
        self.charge(PRIMITIVE_COST)?;
        let mode = primitive.mode.unwrap_or(4);
        match mode {
            4..=6 => {}
            0 => self.remark_counts.add("lists of points are skipped", None),
            1..=3 => self.remark_counts.add("lists of lines are skipped", None),
            other => return Err(format!("mode {other} is none of glTF")),
        }
        if mode < 4 {
            return Ok(());
        }
        if primitive.extensions.contains_key("KHR_draco_mesh_compression") {
            let name = "KHR_draco_mesh_compression";
            return Err(format!("is compressed by {name}, which is not read; save the file without"));
        }
        if !primitive.targets.is_empty() {
            self.remark_counts.add("meshes with morph targets are taken without them", None);
        }
        let Some(&positions) = primitive.attributes.get("POSITION") else {
            return Err("has no attribute POSITION".to_owned());
        };
        let positions = self.accessor(Use::Positions, positions)?;
        let indices = primitive.indices.map(|i| self.accessor(Use::Indices, i)).transpose()?;
        let count = indices.as_ref().map_or(positions.count, |indices| indices.count);
        self.charge(count)?;
        let corners = Corners { mode, count, indices: indices.as_deref() };
        self.append_triangles(corners, &positions, to_file)
    }

    /// Checks an accessor, once.
    fn accessor(&mut self, of: Use, index: usize) -> Result<Rc<Elements>, String> {
        if let Some(known) = self.accessors.get(&(of, index)) {
            return Ok(Rc::clone(known));
        }
        let sparse = self.document.accessors.get(index).and_then(|accessor| accessor.sparse.as_ref());
        self.charge(sparse.map_or(0, |sparse| sparse.count))?;
        let elements = match of {
            Use::Positions => Elements::positions(self.document, index, &mut self.buffers)?,
            Use::Indices => Elements::indices(self.document, index, &mut self.buffers)?,
        };
        let elements = Rc::new(elements);
        self.accessors.insert((of, index), Rc::clone(&elements));
        Ok(elements)
    }

    /// Counts visited elements.
    fn charge(&mut self, elements: usize) -> Result<(), String> {
        self.elements = self.elements.saturating_add(elements);
        if self.elements > MOST_ELEMENTS {
            return Err(format!("the scene shows more than {MOST_ELEMENTS} elements, instances counted"));
        }
        Ok(())
    }

    fn append_triangles(
        &mut self,
        Corners { mode, count, indices }: Corners,
        positions: &Elements,
        to_file: &Matrix4<f64>,
    ) -> Result<(), String> {
        if count < 3 {
            self.remark_counts.add(TOO_FEW_CORNERS, None);
            return Ok(());
        }
        if mode == 4 && !count.is_multiple_of(3) {
            return Err(format!("{count} corners are no triangles"));
        }
        let is_mirrored = to_file.fixed_view::<3, 3>(0, 0).determinant() < 0.0;
        let mut known = HashMap::new();
        let triangles = if mode == 4 { count / 3 } else { count - 2 };
        self.builder.reserve(positions.count.min(count), triangles)?;
        for i in 0..triangles {
            let mut corners = [0; 3];
            for (corner, place) in corners.iter_mut().zip(places(mode, i)) {
                let vertex = match indices {
                    Some(indices) => indices.index(place, &self.buffers).ok_or("the indices are cut")?,
                    None => place,
                };
                *corner = self.vertex(vertex, positions, to_file, &mut known)?;
            }
            let [a, b, c] = corners;
            self.builder.push(if is_mirrored { [a, c, b] } else { [a, b, c] })?;
        }
        Ok(())
    }

    /// The index of a vertex in the mesh; it is added at its first use.
    fn vertex(
        &mut self,
        vertex: usize,
        positions: &Elements,
        to_file: &Matrix4<f64>,
        known: &mut HashMap<usize, usize>,
    ) -> Result<usize, String> {
        if let Some(&number) = known.get(&vertex) {
            return Ok(number);
        }
        let position = positions.get(vertex, &self.buffers).ok_or_else(|| {
            format!("a triangle names vertex {vertex}, but there are {}, counted from 0", positions.count)
        })?;
        let number = self.builder.vertices.len();
        self.builder.vertices.push(to_file.transform_point(&Point::from(position)));
        known.insert(vertex, number);
        Ok(number)
    }
}

/// Indices of the corners of triangle `i`: of a list, of a strip, in which every second triangle has the opposite winding, or of a fan.
fn places(mode: u32, i: usize) -> [usize; 3] {
    match mode {
        5 if i % 2 == 1 => [i + 1, i, i + 2],
        5 => [i, i + 1, i + 2],
        6 => [0, i + 1, i + 2],
        _ => [3 * i, 3 * i + 1, 3 * i + 2],
    }
}

/// Transform from a node's coordinates to its parent's.
fn transform(node: &Node) -> Result<Matrix4<f64>, String> {
    let numbers = [
        node.matrix.as_ref().map(<[f64; 16]>::as_slice),
        node.translation.as_ref().map(<[f64; 3]>::as_slice),
        node.rotation.as_ref().map(<[f64; 4]>::as_slice),
        node.scale.as_ref().map(<[f64; 3]>::as_slice),
    ];
    if numbers.into_iter().flatten().flatten().any(|number| !number.is_finite()) {
        return Err("its transform is not finite".to_owned());
    }
    if let Some(matrix) = node.matrix {
        let matrix = Matrix4::from_column_slice(&matrix);
        if [matrix[(3, 0)], matrix[(3, 1)], matrix[(3, 2)], matrix[(3, 3)]] != [0.0, 0.0, 0.0, 1.0] {
            return Err("the last row of its matrix is not 0 0 0 1".to_owned());
        }
        return match composed(node)? {
            Some(other) if other != Matrix4::identity() && !agree(&matrix, &other) => {
                Err("its matrix contradicts its translation, rotation and scale: leave out either".to_owned())
            }
            _ => Ok(matrix),
        };
    }
    Ok(composed(node)?.unwrap_or_else(Matrix4::identity))
}

/// The transform of a node's translation, rotation and scale, if it has any of them.
fn composed(node: &Node) -> Result<Option<Matrix4<f64>>, String> {
    if node.translation.is_none() && node.rotation.is_none() && node.scale.is_none() {
        return Ok(None);
    }
    let [x, y, z, w] = node.rotation.unwrap_or([0.0, 0.0, 0.0, 1.0]);
    let rotation = UnitQuaternion::try_new(Quaternion::new(w, x, y, z), 1e-9);
    let rotation = rotation.ok_or("its rotation is a quaternion without length")?;
    let translation = Translation3::from(node.translation.unwrap_or_default()).to_homogeneous();
    let scale = Matrix4::new_nonuniform_scaling(&node.scale.unwrap_or([1.0; 3]).into());
    Ok(Some(translation * rotation.to_homogeneous() * scale))
}

/// True if two transforms differ by no more than the rounding of 32-bit numbers.
fn agree(a: &Matrix4<f64>, b: &Matrix4<f64>) -> bool {
    const ROUNDING: f64 = 1e-5;
    let size = a.amax().greater(b.amax()).greater(1.0);
    (a - b).amax() <= ROUNDING * size
}

#[cfg(test)]
mod tests;
