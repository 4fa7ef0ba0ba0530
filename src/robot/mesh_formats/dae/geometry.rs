//! The triangles of one COLLADA geometry.

use nalgebra::Matrix4;
use roxmltree::Node;

use super::{Collada, MOST_TRIANGLES, child, children, decimal};
use crate::math::Point;
use crate::robot::mesh_formats::polygon;
use crate::robot::mesh_formats::tally::TOO_FEW_CORNERS;

/// Polygons by the places of their corners in the positions.
type Polygons = Vec<Vec<usize>>;

impl<'d> Collada<'d> {
    /// Adds the triangles of `geometry`, moved by `to_file`.
    pub(super) fn append(&mut self, geometry: Node<'d, 'd>, to_file: &Matrix4<f64>) -> Result<(), String> {
        let Some(mesh) = self.surface(geometry)? else { return Ok(()) };
        if mesh.has_attribute("convex_hull_of") {
            return Err(self.at(mesh, "convex_hull_of is not read; write the triangles of the hull"));
        }
        let mirrored = to_file.fixed_view::<3, 3>(0, 0).determinant() < 0.0;
        // a file instances few vertex lists, nearly always one for each geometry
        let mut known: Option<(Node, usize, Vec<Point>)> = None;
        for primitive in mesh.children().filter(Node::is_element) {
            let Some((vertices, polygons)) = self.polygons(primitive)? else {
                continue;
            };
            if known.as_ref().is_none_or(|(node, _, _)| *node != vertices) {
                let positions = self.positions(vertices)?;
                let first = self.vertices.len();
                self.vertices.extend(positions.iter().map(|p| to_file.transform_point(p)));
                known = Some((vertices, first, positions));
            }
            let Some((_, first, positions)) = &known else {
                continue;
            };
            for polygon in polygons {
                self.append_polygon(primitive, &polygon, positions, *first, mirrored)?;
            }
        }
        Ok(())
    }

    /// The mesh of a geometry; `None` when it is something else, which is counted.
    fn surface(&mut self, geometry: Node<'d, 'd>) -> Result<Option<Node<'d, 'd>>, String> {
        let meshes: Vec<Node> = (geometry.children().filter(Node::is_element))
            .filter(|part| matches!(part.tag_name().name(), "mesh" | "convex_mesh"))
            .collect();
        for (kind, skipped) in
            [("spline", "splines are skipped"), ("brep", "boundary representations (<brep>) are skipped")]
        {
            for part in children(geometry, kind) {
                self.tally.add(skipped, Some(self.xml.line(part)));
            }
        }
        match meshes[..] {
            [mesh] => Ok(Some(mesh)),
            [] if child(geometry, "spline").or_else(|| child(geometry, "brep")).is_some() => Ok(None),
            [] => Err(self.at(geometry, "has no <mesh>")),
            [_, second, ..] => Err(self.at(second, "<geometry> may have only one mesh")),
        }
    }

    fn append_polygon(
        &mut self,
        primitive: Node,
        polygon: &[usize],
        positions: &[Point],
        first: usize,
        mirrored: bool,
    ) -> Result<(), String> {
        let corner = |&index: &usize| {
            (positions.get(index).copied()).ok_or_else(|| {
                let count = positions.len();
                self.at(primitive, format!("names vertex {index}, but there are {count}"))
            })
        };
        let corners: Vec<Point> = polygon.iter().map(corner).collect::<Result<_, _>>()?;
        if corners.len() < 3 {
            self.tally.add(TOO_FEW_CORNERS, Some(self.xml.line(primitive)));
            return Ok(());
        }
        let triangles = polygon::triangulate(&corners).map_err(|reason| self.at(primitive, reason))?;
        if self.triangles.len() + triangles.len() > MOST_TRIANGLES {
            return Err(format!("the scene shows more than {MOST_TRIANGLES} triangles"));
        }
        for triple in triangles {
            let [a, b, c] = triple.map(|k| u32::try_from(first + polygon[k]).unwrap_or(u32::MAX));
            self.triangles.push(if mirrored { [a, c, b] } else { [a, b, c] });
        }
        Ok(())
    }

    /// The positions that `<vertices>` point at.
    fn positions(&mut self, vertices: Node<'d, 'd>) -> Result<Vec<Point>, String> {
        let position = |n: &Node| n.attribute("semantic") == Some("POSITION");
        let inputs: Vec<Node> = children(vertices, "input").filter(position).take(2).collect();
        let input = match inputs[..] {
            [input] => input,
            [] => return Err(self.at(vertices, "has no input POSITION")),
            _ => return Err(self.at(inputs[1], "<vertices> may have only one input POSITION")),
        };
        let source = self.referenced(input, "source", &["source"])?;
        let technique = self.only_child(source, "technique_common")?;
        let Some(accessor) = technique.map(|t| self.only_child(t, "accessor")).transpose()?.flatten() else {
            return Err(self.at(source, "has no accessor"));
        };
        let array = self.referenced(accessor, "source", &["float_array", "int_array"])?;
        let numbers: Vec<f64> = (self.text(array)?.split_whitespace())
            .map(decimal)
            .collect::<Result<_, _>>()
            .map_err(|reason| self.at(array, reason))?;
        let count = self.whole(accessor, "count", None)?;
        let stride = self.whole(accessor, "stride", Some(1))?;
        let offset = self.whole(accessor, "offset", Some(0))?;
        if stride < 3 {
            return Err(self.at(accessor, format!("positions have 3 numbers, but the stride is {stride}")));
        }
        let positions: Vec<Point> = (numbers.get(offset..).unwrap_or_default())
            .chunks(stride)
            .take(count)
            .filter_map(|p| Some(Point::new(*p.first()?, *p.get(1)?, *p.get(2)?)))
            .collect();
        if positions.len() != count {
            return Err(self
                .at(accessor, format!("the count is {count}, but {} positions are there", positions.len())));
        }
        Ok(positions)
    }

    /// The polygons of a primitive element and the `<vertices>` they index; `None` for lines and other elements.
    fn polygons(&mut self, primitive: Node<'d, 'd>) -> Result<Option<(Node<'d, 'd>, Polygons)>, String> {
        let kind = primitive.tag_name().name();
        match kind {
            "triangles" | "polylist" | "polygons" | "trifans" | "tristrips" => {}
            "lines" | "linestrips" => {
                self.tally.add("lists of lines are skipped", Some(self.xml.line(primitive)));
                return Ok(None);
            }
            _ => return Ok(None),
        }
        let mut stride = 1;
        let mut vertex_input = None;
        for input in children(primitive, "input") {
            let offset = self.whole(input, "offset", Some(0))?;
            stride = stride.max(offset.saturating_add(1));
            if input.attribute("semantic") == Some("VERTEX") {
                if vertex_input.is_some() {
                    return Err(self.at(input, format!("<{kind}> may have only one input VERTEX")));
                }
                vertex_input = Some((input, offset));
            }
        }
        let lists = self.index_lists(primitive)?;
        if lists.iter().all(Vec::is_empty) && child(primitive, "vcount").is_none() && kind != "polygons" {
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
        let polygons = match kind {
            "triangles" => self.equal_polygons(primitive, &lists.concat())?,
            "polylist" => self.counted_polygons(primitive, &lists.concat())?,
            "trifans" | "tristrips" => {
                for _ in lists.iter().filter(|list| list.len() < 3) {
                    self.tally.add(TOO_FEW_CORNERS, Some(self.xml.line(primitive)));
                }
                let triangles = if kind == "trifans" { fan } else { strip };
                lists.iter().flat_map(|list| triangles(list)).collect()
            }
            _ => lists,
        };
        self.compare_count(primitive, kind, polygons.len());
        if polygons.is_empty() {
            return Ok(None);
        }
        Ok(Some((self.referenced(input, "source", &["vertices"])?, polygons)))
    }

    /// The numbers of each `<p>`. A polygon with holes (`<ph>`) is taken by its outline: filled, it hides no contact.
    fn index_lists(&mut self, primitive: Node<'d, 'd>) -> Result<Vec<Vec<usize>>, String> {
        let mut lists = Vec::new();
        for part in primitive.children() {
            if part.is_text() && part.text().is_some_and(|text| !text.trim().is_empty()) {
                return Err(self.at(primitive, "has text outside of <p> and <vcount>"));
            }
            match part.tag_name().name() {
                "p" => lists.push(self.indices(part)?),
                "ph" => {
                    let Some(outline) = self.only_child(part, "p")? else {
                        return Err(self.at(part, "has no <p>"));
                    };
                    lists.push(self.indices(outline)?);
                    self.tally
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

    /// The attribute `count` binds nobody, but a wrong one is told.
    fn compare_count(&mut self, primitive: Node, kind: &str, polygons: usize) {
        let said = primitive.attribute("count").and_then(|c| c.trim().parse::<usize>().ok());
        // fans and strips count lists, not triangles
        if !matches!(kind, "trifans" | "tristrips") && said.is_some_and(|said| said != polygons) {
            let said = said.unwrap_or_default();
            let remark = self.at(primitive, format!("the count is {said}, but {polygons} are there"));
            self.remarks.push(remark);
        }
    }

    fn indices(&self, node: Node<'d, 'd>) -> Result<Vec<usize>, String> {
        (self.text(node)?.split_whitespace())
            .map(|word| word.parse().map_err(|_| self.at(node, "holds something that is no index")))
            .collect()
    }

    /// A whole number from an attribute.
    fn whole(&self, node: Node, attribute: &str, missing: Option<usize>) -> Result<usize, String> {
        match (node.attribute(attribute).map(str::trim), missing) {
            (Some(text), _) => text
                .parse()
                .map_err(|_| self.at(node, format!("the attribute {attribute} is no whole number"))),
            (None, Some(value)) => Ok(value),
            (None, None) => Err(self.at(node, format!("has no attribute {attribute}"))),
        }
    }
}

fn fan(list: &[usize]) -> Polygons {
    let Some((&first, rest)) = list.split_first() else {
        return Vec::new();
    };
    rest.windows(2).map(|pair| vec![first, pair[0], pair[1]]).collect()
}

/// Every second triangle of a strip is wound the other way.
fn strip(list: &[usize]) -> Polygons {
    let turned = |(i, t): (usize, &[usize])| match i % 2 {
        0 => vec![t[0], t[1], t[2]],
        _ => vec![t[1], t[0], t[2]],
    };
    list.windows(3).enumerate().map(turned).collect()
}
