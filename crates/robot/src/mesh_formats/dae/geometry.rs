//! The triangles of one COLLADA geometry.

use std::collections::HashMap;
use std::ops::Range;
use std::rc::Rc;

use roxmltree::{Node, NodeId};

use super::{Collada, own_child, own_children, own_elements, plain_attribute};
use crate::mesh_formats::mesh_builder::MeshBuilder;
use crate::mesh_formats::mesh_memory;
use crate::mesh_formats::remark_counter::TOO_FEW_CORNERS;
use crate::xml::is_foreign;

/// Polygons, as indices of their corners in the positions.
type Polygons = Vec<Vec<usize>>;

/// Maximum memory (bytes) of indices and polygons per byte of their text.
const INDEX_BYTES: usize = 32;

/// Elements of a mesh that are not primitives.
const NO_PRIMITIVES: [&str; 4] = ["source", "vertices", "extra", "asset"];

impl<'d> Collada<'d> {
    /// The triangles of a geometry, in its own coordinates. They are read once, for any number of instances.
    pub(super) fn surface(&mut self, geometry: Node<'d, 'd>) -> Result<Rc<MeshBuilder>, String> {
        if let Some(known) = self.surfaces.get(&geometry.id()) {
            return Ok(Rc::clone(known));
        }
        let mut surface = MeshBuilder::default();
        if let Some(mesh) = self.mesh_of(geometry)? {
            if plain_attribute(mesh, "convex_hull_of").is_some() {
                return Err(self.at(mesh, "convex_hull_of is not read; write the triangles of the hull"));
            }
            // by <vertices> element: the range of its positions in the surface
            let mut known = HashMap::new();
            for primitive in own_elements(mesh) {
                if let Some((vertices, polygons)) = self.polygons(primitive)? {
                    let range = self.positions_once(vertices, &mut known, &mut surface)?;
                    for polygon in polygons {
                        self.append_polygon(primitive, &polygon, &range, &mut surface)?;
                    }
                }
            }
        }
        let surface = Rc::new(surface);
        self.surfaces.insert(geometry.id(), Rc::clone(&surface));
        Ok(surface)
    }

    /// The mesh of a geometry; `None` when it has only curves, which are counted.
    fn mesh_of(&mut self, geometry: Node<'d, 'd>) -> Result<Option<Node<'d, 'd>>, String> {
        if let Some(brep) = own_child(geometry, "brep") {
            return Err(self.at(brep, "boundary representations are not read; save the surface as triangles"));
        }
        let splines = own_children(geometry, "spline").count();
        for _ in 0..splines {
            self.remark_counts.add("splines are skipped", Some(self.xml.line(geometry)));
        }
        let is_mesh = |part: &Node| matches!(part.tag_name().name(), "mesh" | "convex_mesh");
        let mut meshes = own_elements(geometry).filter(is_mesh);
        match (meshes.next(), meshes.next()) {
            (Some(_), Some(second)) => Err(self.at(second, "<geometry> may have only one mesh")),
            (Some(mesh), None) => Ok(Some(mesh)),
            (None, _) if splines > 0 => Ok(None),
            (None, _) => Err(self.at(geometry, "has no <mesh>")),
        }
    }

    /// The positions of a `<vertices>` in the surface; they are added at the first use.
    fn positions_once(
        &mut self,
        vertices: Node<'d, 'd>,
        known: &mut HashMap<NodeId, Range<usize>>,
        surface: &mut MeshBuilder,
    ) -> Result<Range<usize>, String> {
        if let Some(range) = known.get(&vertices.id()) {
            return Ok(range.clone());
        }
        let positions = self.positions(vertices)?;
        let first = surface.vertices.len();
        let range = first..first + positions.len();
        surface.reserve(positions.len(), 0)?;
        surface.vertices.extend(positions);
        known.insert(vertices.id(), range.clone());
        Ok(range)
    }

    fn append_polygon(
        &mut self,
        primitive: Node,
        polygon: &[usize],
        vertices: &Range<usize>,
        surface: &mut MeshBuilder,
    ) -> Result<(), String> {
        if let Some(index) = polygon.iter().find(|&&index| index >= vertices.len()) {
            return Err(self.at(primitive, format!("names vertex {index}, but there are {}", vertices.len())));
        }
        if polygon.len() < 3 {
            self.remark_counts.add(TOO_FEW_CORNERS, Some(self.xml.line(primitive)));
            return Ok(());
        }
        let corners: Vec<_> = polygon.iter().map(|&index| surface.vertices[vertices.start + index]).collect();
        let triangles = self.triangulator.triangulate(&corners);
        let triangles = triangles.map_err(|reason| self.at(primitive, reason))?;
        surface.reserve(0, triangles.len())?;
        for triple in triangles {
            surface.push(triple.map(|k| vertices.start + polygon[k]))?;
        }
        Ok(())
    }

    /// The polygons of a primitive element and the `<vertices>` they index; `None` for lines and other elements.
    fn polygons(&mut self, primitive: Node<'d, 'd>) -> Result<Option<(Node<'d, 'd>, Polygons)>, String> {
        let kind = primitive.tag_name().name();
        match kind {
            "triangles" | "polylist" | "polygons" | "trifans" | "tristrips" => {}
            "lines" | "linestrips" => {
                self.remark_counts.add("lists of lines are skipped", Some(self.xml.line(primitive)));
                return Ok(None);
            }
            _ if NO_PRIMITIVES.contains(&kind) => return Ok(None),
            _ => {
                self.remark_counts
                    .add("unknown elements of a mesh are skipped", Some(self.xml.line(primitive)));
                return Ok(None);
            }
        }
        let mut stride = 1;
        let mut vertex_input = None;
        for input in own_children(primitive, "input") {
            let offset = self.whole(input, "offset", Some(0))?;
            stride = stride.max(offset.saturating_add(1));
            if plain_attribute(input, "semantic") == Some("VERTEX") {
                if vertex_input.is_some() {
                    return Err(self.at(input, format!("<{kind}> may have only one input VERTEX")));
                }
                vertex_input = Some((input, offset));
            }
        }
        let lists = self.index_lists(primitive)?;
        // fans and strips count lists, not triangles
        let counts_lists = matches!(kind, "trifans" | "tristrips");
        if lists.iter().all(Vec::is_empty) && own_child(primitive, "vcount").is_none() && kind != "polygons" {
            self.compare_count(primitive, if counts_lists { lists.len() } else { 0 });
            return Ok(None);
        }
        let Some((input, offset)) = vertex_input else {
            return Err(self.at(primitive, "has no input VERTEX"));
        };
        let corners = |list: &Vec<usize>| -> Result<Vec<usize>, String> {
            if !list.len().is_multiple_of(stride) {
                return Err(self.at(primitive, format!("{} indices are no multiple of {stride}", list.len())));
            }
            Ok(list.iter().skip(offset).step_by(stride).copied().collect())
        };
        let lists = lists.iter().map(corners).collect::<Result<Vec<_>, _>>()?;
        let list_count = lists.len();
        let polygons = match kind {
            "triangles" => self.equal_polygons(primitive, &lists.concat())?,
            "polylist" => self.counted_polygons(primitive, &lists.concat())?,
            "trifans" | "tristrips" => {
                for _ in lists.iter().filter(|list| list.len() < 3) {
                    self.remark_counts.add(TOO_FEW_CORNERS, Some(self.xml.line(primitive)));
                }
                let triangles = if kind == "trifans" { fan } else { strip };
                lists.iter().flat_map(|list| triangles(list)).collect()
            }
            _ => lists,
        };
        self.compare_count(primitive, if counts_lists { list_count } else { polygons.len() });
        if polygons.is_empty() {
            return Ok(None);
        }
        Ok(Some((self.referenced(input, "source", &["vertices"])?, polygons)))
    }

    /// The numbers of each `<p>`. A polygon with holes (`<ph>`) is replaced by its outline: filled holes hide no contact.
    fn index_lists(&mut self, primitive: Node<'d, 'd>) -> Result<Vec<Vec<usize>>, String> {
        let mut lists = Vec::new();
        for part in primitive.children() {
            if part.is_text() && part.text().is_some_and(|text| !text.trim().is_empty()) {
                return Err(self.at(primitive, "has text outside of <p> and <vcount>"));
            }
            match part.tag_name().name() {
                _ if is_foreign(part) => {}
                "p" => lists.push(self.indices(part)?),
                "ph" => {
                    let Some(outline) = self.only_child(part, "p")? else {
                        return Err(self.at(part, "has no <p>"));
                    };
                    lists.push(self.indices(outline)?);
                    self.remark_counts
                        .add("polygons have holes, which are taken as filled", Some(self.xml.line(part)));
                }
                _ => {}
            }
        }
        Ok(lists)
    }

    fn equal_polygons(&self, primitive: Node, corners: &[usize]) -> Result<Polygons, String> {
        if !corners.len().is_multiple_of(3) {
            return Err(self.at(primitive, format!("{} corners are no triangles", corners.len())));
        }
        Ok(corners.chunks(3).map(<[usize]>::to_vec).collect())
    }

    fn counted_polygons(&self, primitive: Node<'d, 'd>, corners: &[usize]) -> Result<Polygons, String> {
        let counts = match self.only_child(primitive, "vcount")? {
            Some(vcount) => self.indices(vcount)?,
            None => Vec::new(),
        };
        let mut rest = corners;
        let mut polygons = Vec::new();
        for count in counts {
            let Some((polygon, others)) = rest.split_at_checked(count) else {
                return Err(self.at(primitive, "vcount asks for more corners than <p> has"));
            };
            polygons.push(polygon.to_vec());
            rest = others;
        }
        if rest.is_empty() {
            Ok(polygons)
        } else {
            Err(self.at(primitive, format!("vcount leaves {} corners of <p> over", rest.len())))
        }
    }

    /// The attribute `count` of a primitive or an array is not used, but a wrong value causes a remark.
    pub(super) fn compare_count(&mut self, element: Node, there: usize) {
        let said = plain_attribute(element, "count").and_then(|c| c.trim().parse::<usize>().ok());
        if let Some(said) = said.filter(|&said| said != there) {
            let remark = self.at(element, format!("the count is {said}, but {there} are there"));
            self.remarks.push(remark);
        }
    }

    fn indices(&self, node: Node<'d, 'd>) -> Result<Vec<usize>, String> {
        let text = self.text(node)?;
        mesh_memory::check(text.len().saturating_mul(INDEX_BYTES))
            .map_err(|e| self.at(node, format!("its indices {e}")))?;
        (text.split_whitespace())
            .map(|word| word.parse().map_err(|_| self.at(node, "holds something that is no index")))
            .collect()
    }
}

fn fan(list: &[usize]) -> Polygons {
    let Some((&first, rest)) = list.split_first() else {
        return Vec::new();
    };
    rest.windows(2).map(|pair| vec![first, pair[0], pair[1]]).collect()
}

/// Every second triangle of a strip has the opposite winding.
fn strip(list: &[usize]) -> Polygons {
    let turned = |(i, t): (usize, &[usize])| match i % 2 {
        0 => vec![t[0], t[1], t[2]],
        _ => vec![t[1], t[0], t[2]],
    };
    list.windows(3).enumerate().map(turned).collect()
}
