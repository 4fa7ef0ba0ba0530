//! Reader of COLLADA: the triangles in the scene, in metres.
//!
//! Reads the XML tree directly. The crate `dae-parser` requires the whole schema (for example, it rejects a file without a creation
//! date), trusts counts when it allocates, and stores 32-bit floats. Reading the surfaces needs less code than the checks that would have
//! to precede that crate.
//!
//! The file's unit and the transforms of its nodes are applied. Its `up_axis` is not: RViz and `MoveIt` use the axes as in the file, and
//! a checker that rotated them would check another robot than the displayed one.

use std::borrow::Cow;
use std::cell::Cell;
use std::collections::{HashMap, HashSet};
use std::rc::Rc;

use nalgebra::Matrix4;
use roxmltree::{Node, NodeId};

use super::ReadMesh;
use super::mesh_builder::MeshBuilder;
use super::polygon::Triangulator;
use super::remark_counter::RemarkCounter;
use crate::decimal_numbers::{decimal, decimals, shortened};
use crate::xml::{Expected, Xml, own_child, own_children, own_elements, plain_attribute, read_xml, text};

mod accessor;
mod elements_by_id;
mod foreign_names;
mod geometry;
mod scene;
mod skin;

use elements_by_id::ElementsById;

/// Maximum length (bytes) of text that is read, references included: elements may be referenced repeatedly.
const MOST_TEXT: usize = 256 << 20;

/// # Errors
/// If the file is not COLLADA, is contradictory, or contains no triangles; with the line.
pub(super) fn read(text: &str) -> Result<ReadMesh, String> {
    let mut warnings = Vec::new();
    let expected = Expected { file: None, language: "a COLLADA file", root: "COLLADA" };
    let read = read_xml(text, expected, &mut warnings, |xml, _| Collada::new(xml).read());
    let mut read = read.map_err(|fault| fault.to_string())??;
    let warned = warnings.iter().map(ToString::to_string);
    read.remarks.splice(0..0, warned);
    Ok(read)
}

/// A COLLADA document and the data read from it so far.
struct Collada<'d> {
    xml: &'d Xml<'d>,
    ids: ElementsById<'d>,
    /// Geometries read so far, in their own coordinates.
    surfaces: HashMap<NodeId, Rc<MeshBuilder>>,
    shown: MeshBuilder,
    triangulator: Triangulator,
    text_left: Cell<usize>,
    remarks: Vec<String>,
    remark_counts: RemarkCounter,
}

impl<'d> Collada<'d> {
    fn new(xml: &'d Xml<'d>) -> Self {
        Self {
            xml,
            ids: ElementsById::new(xml.root()),
            surfaces: HashMap::new(),
            shown: MeshBuilder::default(),
            triangulator: Triangulator::default(),
            text_left: Cell::new(MOST_TEXT),
            remarks: Vec::new(),
            remark_counts: RemarkCounter::default(),
        }
    }

    fn read(mut self) -> Result<ReadMesh, String> {
        self.note_foreign_names();
        self.note_repeated_ids();
        let metres = self.unit()?;
        self.note_up_axis()?;
        let mut instances = Vec::new();
        let (mut vertices, mut triangles) = (0_usize, 0_usize);
        for shown in self.shown_geometries(Matrix4::new_scaling(metres))? {
            let surface = self.surface(shown.geometry)?;
            vertices = vertices.saturating_add(surface.vertices.len());
            triangles = triangles.saturating_add(surface.triangles.len());
            instances.push((surface, shown.to_file));
        }
        self.shown.reserve(vertices, triangles)?;
        for (surface, to_file) in &instances {
            self.shown.append(surface, to_file)?;
        }
        if self.shown.triangles.is_empty() {
            return Err("the scene shows no triangles".to_owned());
        }
        let mesh = self.shown.finish()?;
        self.remarks.extend(self.remark_counts.remarks());
        let mut told = HashSet::new();
        self.remarks.retain(|remark| told.insert(remark.clone()));
        Ok(ReadMesh { mesh, remarks: self.remarks })
    }

    /// Metres in one unit of the file.
    fn unit(&self) -> Result<f64, String> {
        let asset = self.only_child(self.xml.root(), "asset")?;
        let Some(unit) = asset.map(|a| self.only_child(a, "unit")).transpose()?.flatten() else {
            return Ok(1.0);
        };
        match plain_attribute(unit, "meter").map(decimal) {
            None => Ok(1.0),
            Some(Ok(metres)) if metres > 0.0 => Ok(metres),
            Some(Ok(metres)) => Err(self.at(unit, format!("a unit of {metres} metres"))),
            Some(Err(reason)) => Err(self.at(unit, format!("unit meter {reason}"))),
        }
    }

    fn note_up_axis(&mut self) -> Result<(), String> {
        let asset = own_child(self.xml.root(), "asset");
        let Some(axis) = asset.map(|a| self.only_child(a, "up_axis")).transpose()?.flatten() else {
            return Ok(());
        };
        if let up @ ("X_UP" | "Y_UP") = self.text(axis)?.trim() {
            self.remarks
                .push(format!("says {up}; its axes are taken as they stand in the file, as RViz shows them"));
        }
        Ok(())
    }

    /// The child of that name, of which COLLADA allows one.
    fn only_child(&self, node: Node<'d, 'd>, name: &str) -> Result<Option<Node<'d, 'd>>, String> {
        let mut named = own_children(node, name);
        let first = named.next();
        match named.next() {
            Some(second) => {
                Err(self.at(second, format!("<{}> may have only one of it", node.tag_name().name())))
            }
            None => Ok(first),
        }
    }

    /// References take the first element of a kind with an id.
    fn note_repeated_ids(&mut self) {
        for line in self.ids.repeated.iter().map(|node| self.xml.line(*node)) {
            let what = "elements are skipped, because an earlier one of their kind has the same id";
            self.remark_counts.add(what, Some(line));
        }
    }

    /// The element of one of these kinds that `#id` names; others may have the same id.
    fn referenced(&self, node: Node, attribute: &str, kinds: &[&str]) -> Result<Node<'d, 'd>, String> {
        let url = plain_attribute(node, attribute).unwrap_or_default();
        let Some(id) = url.strip_prefix('#') else {
            let url = shortened(url);
            return Err(self
                .at(node, format!("{attribute} '{url}' is no '#id' of this file, and no other is opened")));
        };
        self.ids.find(id, kinds).ok_or_else(|| {
            let (id, wanted) = (shortened(id), kinds.join("> or <"));
            let other =
                self.ids.any(id.as_str()).map(|kind| format!("; a <{kind}> has it")).unwrap_or_default();
            self.at(node, format!("no <{wanted}> has the id '{id}'{other}"))
        })
    }

    /// A message with the line of `node`.
    fn at(&self, node: Node, message: impl std::fmt::Display) -> String {
        format!("line {}: <{}>: {message}", self.xml.line(node), node.tag_name().name())
    }

    fn text(&self, node: Node<'d, 'd>) -> Result<Cow<'d, str>, String> {
        let text = text(node).map_err(|reason| self.at(node, reason))?;
        let left = self.text_left.get().checked_sub(text.len());
        let left = left.ok_or_else(|| {
            self.at(
                node,
                format!("elements are referenced so often that more than {MOST_TEXT} bytes are read"),
            )
        })?;
        self.text_left.set(left);
        Ok(text)
    }

    /// An affine transform.
    fn affine(&self, node: Node<'d, 'd>) -> Result<Matrix4<f64>, String> {
        let matrix = Matrix4::from_row_slice(&self.numbers::<16>(node)?);
        if matrix.row(3) != Matrix4::identity().row(3) {
            return Err(self.at(node, "the last row of the matrix is not 0 0 0 1"));
        }
        Ok(matrix)
    }

    fn numbers<const N: usize>(&self, node: Node<'d, 'd>) -> Result<[f64; N], String> {
        decimals(&self.text(node)?).map_err(|reason| self.at(node, reason))
    }
}

#[cfg(test)]
mod tests;
