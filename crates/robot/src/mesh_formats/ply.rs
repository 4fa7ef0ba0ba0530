//! Reader of PLY meshes: vertices with x, y and z, and faces or triangle strips that index them. Other properties, such as colours and
//! normals, are ignored. Other elements are ignored with a remark; elements that index vertices are an error. Coordinates are in metres,
//! as in RViz.

use clearance_files::ply_format::words::quoted;
use clearance_files::ply_format::{Element, Numbers, PlyError, PlyFile, Property};
use clearance_geometry::math::Point;

use super::ReadMesh;
use super::mesh_builder::{MOST_TRIANGLES, MeshBuilder};
use super::polygon::Triangulator;
use super::remark_counter::{RemarkCounter, TOO_FEW_CORNERS};

/// Names of elements that are surfaces, in lower case and without plural s; of these, face and tristrips are read.
const SURFACES: [&str; 8] =
    ["face", "tristrip", "trifan", "triangle", "quad", "polygon", "patch", "range_grid"];

/// Maximum number of indices of faces and strips: three per triangle, times two.
const MOST_INDICES: usize = 6 * MOST_TRIANGLES;

/// Lists of vertex indices in sequence; -1 in a strip starts a new strip.
#[derive(Default)]
struct Lists {
    indices: Vec<i32>,
    /// End of each list in `indices`.
    ends: Vec<usize>,
    /// Number of lists of fewer than three indices, which are skipped.
    short: usize,
}

/// # Errors
/// If the file is truncated, is contradictory, or has no faces.
pub(super) fn read(bytes: &[u8]) -> Result<ReadMesh, String> {
    let PlyFile { elements, mut numbers } = PlyFile::open(bytes).map_err(bad)?;
    let (mut vertices, mut faces, mut strips) = (None, Lists::default(), Lists::default());
    let mut remarks = Vec::new();
    for element in &elements {
        match element.name.as_str() {
            "vertex" if vertices.is_some() => {
                return Err("bad PLY: the header has more than one element vertex".to_owned());
            }
            "vertex" => vertices = Some(positions(element, &mut numbers)?),
            "face" => faces.read(element, &mut numbers).map_err(bad)?,
            "tristrips" => strips.read(element, &mut numbers).map_err(bad)?,
            _ => {
                remarks.extend(skipped(element)?);
                numbers.skip(element).map_err(bad)?;
            }
        }
    }
    remarks.extend(numbers.end().map_err(bad)?);
    let mut surface = vertices.ok_or("bad PLY: the header has no element vertex")?;
    let mut triangulator = Triangulator::default();
    for face in faces.lists() {
        append_polygon(&corners(face, surface.vertices.len())?, &mut surface, &mut triangulator)?;
    }
    for strip in strips.lists() {
        for part in strip.split(|&index| index == -1) {
            append_strip(&corners(part, surface.vertices.len())?, &mut surface)?;
        }
    }
    if surface.triangles.is_empty() {
        return Err("the file has no faces: it is a point cloud, or lacks its surface".to_owned());
    }
    let mesh = surface.finish()?;
    let mut remark_counts = RemarkCounter::default();
    for _ in 0..faces.short + strips.short {
        remark_counts.add(TOO_FEW_CORNERS, None);
    }
    remarks.extend(remark_counts.remarks());
    Ok(ReadMesh { mesh, remarks })
}

/// The remark on an element that is ignored, if it has any record.
fn skipped(element: &Element) -> Result<Option<String>, String> {
    let Element { name, count, properties } = element;
    if *count == 0 {
        return Ok(None);
    }
    let name = quoted(name);
    let plain = element.name.to_ascii_lowercase();
    let is_surface = SURFACES.contains(&plain.trim_end_matches('s')) || properties.iter().any(is_indices);
    if is_surface {
        return Err(format!(
            "bad PLY: the surface in element {name} ({count} records) is not read; write it as element face"
        ));
    }
    Ok(Some(format!("element {name} ({count} records) is not read")))
}

/// Whether a property lists vertices.
fn is_indices(property: &Property) -> bool {
    property.list.is_some() && matches!(property.name.as_str(), "vertex_indices" | "vertex_index")
}

#[allow(clippy::needless_pass_by_value)] // for map_err
fn bad(error: PlyError) -> String {
    format!("bad PLY: {error}")
}

fn positions(element: &Element, numbers: &mut Numbers) -> Result<MeshBuilder, String> {
    let xyz = element.coordinates().map_err(bad)?;
    let mut surface = MeshBuilder::default();
    surface.reserve(element.count, 0)?;
    for i in 0..element.count {
        surface.vertices.push(numbers.point(element, xyz, i).map_err(bad)?.into());
    }
    Ok(surface)
}

impl Lists {
    fn read(&mut self, element: &Element, numbers: &mut Numbers) -> Result<(), PlyError> {
        let place = element.properties.iter().position(is_indices);
        if element.properties.iter().filter(|p| is_indices(p)).count() > 1 {
            let name = quoted(&element.name);
            return Err(PlyError(format!("element {name} has more than one list of vertices")));
        }
        let Some(place) = place.filter(|_| element.count > 0) else {
            let missing = format!("element {} has no list vertex_indices", element.name);
            return if element.count == 0 { numbers.skip(element) } else { Err(PlyError(missing)) };
        };
        for record in 0..element.count {
            let named =
                |e: PlyError| PlyError(format!("{} {record} of {}: {e}", element.name, element.count));
            for (p, property) in element.properties.iter().enumerate() {
                match property.list {
                    Some(length) if p == place => {
                        let length = numbers.length(length).map_err(named)?;
                        self.reserve(length).map_err(named)?;
                        for _ in 0..length {
                            self.indices
                                .push(index(numbers.next(property.kind).map_err(named)?).map_err(named)?);
                        }
                        self.end_list(length);
                    }
                    _ => numbers.skip_property(property).map_err(named)?,
                }
            }
        }
        Ok(())
    }

    fn reserve(&mut self, length: usize) -> Result<(), PlyError> {
        if self.indices.len().saturating_add(length) > MOST_INDICES {
            return Err(PlyError(format!("the file names more than {MOST_INDICES} vertices")));
        }
        let no_memory = |_| PlyError("there is no memory for its indices".to_owned());
        // a list may declare any length: only the available data counts
        self.indices.try_reserve(length.min(1 << 20)).map_err(no_memory)?;
        self.ends.try_reserve(1).map_err(no_memory)
    }

    /// Ends a list of this number of indices, the last ones; a short list is skipped and counted.
    fn end_list(&mut self, length: usize) {
        if length < 3 {
            self.short += 1;
            self.indices.truncate(self.indices.len() - length);
        } else {
            self.ends.push(self.indices.len());
        }
    }

    fn lists(&self) -> impl Iterator<Item = &[i32]> {
        let starts = std::iter::once(0).chain(self.ends.iter().copied());
        starts.zip(&self.ends).map(|(start, &end)| &self.indices[start..end])
    }
}

/// -1 and below are no vertices, but end a strip.
#[allow(clippy::cast_possible_truncation)] // checked to be a whole number of 32 bits
fn index(number: f64) -> Result<i32, PlyError> {
    let is_whole = number.fract() == 0.0 && number.abs() <= f64::from(i32::MAX);
    if is_whole { Ok(number as i32) } else { Err(PlyError(format!("{number} is no vertex number"))) }
}

fn corners(indices: &[i32], vertices: usize) -> Result<Vec<usize>, String> {
    let corner = |&index: &i32| usize::try_from(index).ok().filter(|&i| i < vertices).ok_or(index);
    (indices.iter().map(corner).collect::<Result<_, _>>()).map_err(|index: i32| {
        format!("bad PLY: a face names vertex {index}, but there are {vertices}, counted from 0")
    })
}

fn append_polygon(
    corners: &[usize],
    surface: &mut MeshBuilder,
    triangulator: &mut Triangulator,
) -> Result<(), String> {
    let points: Vec<Point> = corners.iter().map(|&corner| surface.vertices[corner]).collect();
    for triple in triangulator.triangulate(&points)? {
        surface.push(triple.map(|k| corners[k]))?;
    }
    Ok(())
}

/// Every second triangle of a strip has the opposite winding.
fn append_strip(corners: &[usize], surface: &mut MeshBuilder) -> Result<(), String> {
    for (i, t) in corners.windows(3).enumerate() {
        surface.push(if i % 2 == 0 { [t[0], t[1], t[2]] } else { [t[1], t[0], t[2]] })?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    const HEAD: &str = "ply\nformat ascii 1.0\ncomment by hand\nelement vertex 4\nproperty float x\nproperty float y\n\
        property float z\nproperty uchar red\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n";
    const SQUARE: &str = "0 0 0 9\n1 0 0 9\n1 1 0 9\n0 1 0 9\n";

    /// The square in binary, as one polygon of `length` corners.
    fn binary(order: &str, count: u32, length: u8) -> Vec<u8> {
        let head = HEAD.replace("ascii", order).replace("vertex 4", &format!("vertex {count}"));
        let mut bytes = head.into_bytes();
        let is_big = order.contains("big");
        for [x, y] in [[0.0f32, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]] {
            let number = |c: f32| if is_big { c.to_be_bytes() } else { c.to_le_bytes() };
            bytes.extend([x, y, 0.0].iter().flat_map(|&c| number(c)));
            bytes.push(9);
        }
        bytes.push(length);
        bytes.extend((0..4i32).flat_map(|i| if is_big { i.to_be_bytes() } else { i.to_le_bytes() }));
        bytes
    }

    fn fault(text: &str) -> String {
        let message = read(text.as_bytes()).unwrap_err();
        assert!(!message.contains('\n'), "{message}");
        message
    }

    #[test]
    fn polygons_in_every_storage() {
        for bytes in [
            format!("{HEAD}{SQUARE}4 0 1 2 3").into_bytes(),
            format!("{HEAD}{SQUARE}4 0 1 2 3\n").replace('\n', "\r\n").into_bytes(),
            binary("binary_little_endian", 4, 4),
            binary("binary_big_endian", 4, 4),
        ] {
            let read = read(&bytes).unwrap();
            assert_eq!(read.mesh.triangles().len(), 2);
            assert_eq!(read.mesh.bounds(), (Point::origin(), Point::new(1.0, 1.0, 0.0)));
            assert!(read.remarks.is_empty() && read.mesh.triangle(0).normal().z > 0.0);
        }
    }

    #[test]
    fn faces_may_come_first_and_in_strips() {
        let xyz = "property double x\nproperty double y\nproperty double z\n";
        let text = format!(
            "ply\nformat ascii 1.0\nelement tristrips 1\nproperty list int int vertex_indices\n\
             element edge 1\nproperty int a\nelement vertex 4\n{xyz}end_header\n9 0 1 3 2 -1 0 1 2 -1\n7\n\
             0 0 0 1 0 0 1 1 0 0 1 0"
        );
        let read = read(text.as_bytes()).unwrap();
        assert_eq!(read.mesh.triangles().len(), 3);
        for i in 0..3 {
            assert!(read.mesh.triangle(i).normal().z > 0.0);
        }
    }

    #[test]
    fn points_and_lines_are_skipped_and_counted() {
        let text = HEAD.replace("face 1", "face 4");
        let read = read(format!("{text}{SQUARE}0\n1 2\n2 0 1\n3 0 1 2").as_bytes()).unwrap();
        assert_eq!(read.mesh.triangles().len(), 1);
        assert!(read.remarks[0].starts_with("3 polygons of fewer"), "{:?}", read.remarks);
    }

    #[test]
    fn data_that_the_header_does_not_announce_is_rejected() {
        let ascii = format!("{HEAD}{SQUARE}4 0 1 2 3\n");
        assert!(fault(&format!("{ascii}3 0 1 2\n")).contains("4 more words follow"));
        assert!(fault(&format!("{ascii}x")).contains("1 more word follows"));
        assert!(fault(&format!("{ascii}{ascii}")).contains("the first is 'ply'"));
        assert!(read(format!("{ascii}\n \n").as_bytes()).unwrap().remarks.is_empty());
        for order in ["binary_little_endian", "binary_big_endian"] {
            let whole = binary(order, 4, 4);
            let with = |more: &[u8]| read(&[&whole[..], more].concat());
            assert!(with(&[0; 17]).unwrap_err().contains("17 more bytes follow"));
            assert!(with(b"x").unwrap_err().contains("1 more byte follows"));
            assert!(with(b"\r\n").unwrap().remarks[0].contains("2 more bytes follow"));
        }
    }

    #[test]
    fn surfaces_that_are_not_read_are_rejected() {
        let list = "property list uchar int ";
        for (element, words) in [
            (format!("element polygon 1\n{list}vertices\n"), "'polygon'"),
            (format!("element Face 1\n{list}v\n"), "'Face'"),
            (format!("element patches 1\n{list}vertex_index\n"), "'patches'"),
            (format!("{list}vertex_index\n"), "more than one list"),
            (format!("{list}vertex_indices\n"), "more than one list"),
        ] {
            let head = HEAD.replace("end_header", &format!("{element}end_header"));
            let message = fault(&format!("{head}{SQUARE}4 0 1 2 3 3 0 1 2"));
            assert!(message.contains(words), "{message}");
        }
        let twice = HEAD.replace("element face", "element vertex 1\nproperty float x\nelement face");
        assert!(fault(&format!("{twice}{SQUARE}7 4 0 1 2 3")).contains("more than one element vertex"));
        let other = HEAD
            .replace("end_header", "element edge 1\nproperty int vertex1\nproperty int vertex2\nend_header");
        let found = read_text(&format!("{other}{SQUARE}4 0 1 2 3 0 1"));
        assert_eq!(found.remarks, ["element 'edge' (1 records) is not read"]);
        let none = HEAD.replace("end_header", &format!("element polygon 0\n{list}vertices\nend_header"));
        assert!(read_text(&format!("{none}{SQUARE}4 0 1 2 3")).remarks.is_empty());
    }

    fn read_text(text: &str) -> ReadMesh {
        read(text.as_bytes()).unwrap()
    }

    #[test]
    fn faults_are_named() {
        let of = |faces: &str| fault(&format!("{HEAD}{SQUARE}{faces}"));
        assert!(of("3 0 1 4").contains("vertex 4, but there are 4"));
        assert!(of("3 0 1 -1").contains("vertex -1"));
        assert!(of("3 0 1 1.5").contains("no vertex number"));
        assert!(of("3 0 1").contains("face 0 of 1"));
        assert!(of("2 0 1").contains("no faces"));
        assert!(fault(&HEAD.replace("face 1", "face 0")).contains("records"));
        assert!(fault(&format!("{}{SQUARE}", HEAD.replace("face 1", "face 0"))).contains("no faces"));
        assert!(fault(&HEAD.replace("vertex_indices", "other")).contains("records"));
        assert!(
            fault(&format!("{}{SQUARE}3 0 1 2", HEAD.replace("vertex_indices", "o")))
                .contains("vertex_indices")
        );
        assert!(fault(&format!("{HEAD}{}3 0 1 2", SQUARE.replace("1 1", "nan 1"))).contains("not finite"));
        assert!(fault("ply\nformat ascii 1.0\nend_header\n").contains("vertex"));
        assert!(fault("ply\n").contains("end_header"));
        for bytes in [binary("binary_little_endian", u32::MAX, 4), binary("binary_little_endian", 5, 4)] {
            assert!(!read(&bytes).unwrap_err().is_empty());
        }
        assert!(read(&binary("binary_little_endian", 4, 255)).unwrap_err().contains("ends here"));
        let text = format!("{}{SQUARE}3 0 1 2", HEAD.replace("face 1", "face 18446744073709551615"));
        assert!(fault(&text).contains("records"));
    }

    proptest! {
        #[test]
        fn mutations_never_panic(flips in prop::collection::vec(any::<(u16, u8)>(), 0..6), cut in 0usize..400) {
            let ascii = format!("{HEAD}{SQUARE}4 0 1 2 3").into_bytes();
            for mut bytes in [ascii, binary("binary_little_endian", 4, 4), binary("binary_big_endian", 4, 4)] {
                for &(at, bits) in &flips {
                    let at = usize::from(at) % bytes.len();
                    bytes[at] ^= bits;
                }
                bytes.truncate(bytes.len().saturating_sub(cut / 4));
                let _ = read(&bytes);
            }
        }
    }
}
