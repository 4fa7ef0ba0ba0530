//! Tests of mesh defects: each is found in a small mesh that has it, and none in a clean mesh.

use clearance_geometry::TriangleMesh;
use clearance_geometry::math::Point;
use clearance_lint::MeshDefects;

const FACES: [[u32; 3]; 4] = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];

fn corners(shift: f64) -> Vec<Point> {
    let corner = |x: f64, y: f64, z: f64| Point::new(x + shift, y + 0.4 * shift, z + 0.3 * shift);
    vec![corner(0.0, 0.0, 0.0), corner(1.0, 0.0, 0.0), corner(0.0, 1.0, 0.0), corner(0.0, 0.0, 1.0)]
}

fn defects(vertices: Vec<Point>, faces: &[[u32; 3]]) -> MeshDefects {
    MeshDefects::find(&TriangleMesh::new(vertices, faces.to_vec()).unwrap(), None)
}

fn clean() -> MeshDefects {
    MeshDefects { triangles: 4, components: 1, ..MeshDefects::default() }
}

#[test]
fn a_tetrahedron_is_clean() {
    assert_eq!(defects(corners(0.0), &FACES), clean());
    // also as a soup of triangles, as in an STL
    let vertices: Vec<Point> = FACES.iter().flatten().map(|&v| corners(0.0)[v as usize]).collect();
    let faces: Vec<[u32; 3]> = (0..4).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
    assert_eq!(defects(vertices, &faces), clean());
}

#[test]
fn open_edges_are_counted() {
    let found = defects(corners(0.0), &FACES[..3]);
    assert_eq!(found.open_edges.unwrap().count, 3);
    assert_eq!(MeshDefects { open_edges: None, ..found }, MeshDefects { triangles: 3, ..clean() });
}

#[test]
fn inward_faces_are_found() {
    let found = defects(corners(0.0), &FACES.map(|[a, b, c]| [a, c, b]));
    assert_eq!(found.inverted.unwrap().count, 1);
    assert_eq!(MeshDefects { inverted: None, ..found }, clean());
}

/// Two tetrahedra: the second is beside the first one, or a cavity of it, and smaller, of equal size or larger.
#[test]
fn a_part_that_is_wound_inward_is_found_unless_it_is_a_cavity() {
    let inward = FACES.map(|[a, b, c]| [a + 4, c + 4, b + 4]);
    for (size, shift, count) in
        [(0.5, 3.0, Some(1)), (1.0, 3.0, Some(1)), (2.0, 3.0, Some(1)), (0.2, 0.1, None)]
    {
        let second = corners(0.0)
            .into_iter()
            .map(|p| Point::from(p.coords * size) + Point::new(shift, 0.1, 0.1).coords);
        let vertices: Vec<Point> = corners(0.0).into_iter().chain(second).collect();
        let found = defects(vertices, &[&FACES[..], &inward].concat());
        assert_eq!(found.inverted.map(|inverted| inverted.count), count, "size {size}");
        assert_eq!(found.components, 2);
    }
}

#[test]
fn a_face_of_the_other_winding_is_found() {
    let mut faces = FACES;
    faces[3].swap(0, 1);
    let found = defects(corners(0.0), &faces);
    assert_eq!(found.mixed_orientation.unwrap().count, 3);
    assert_eq!(MeshDefects { mixed_orientation: None, ..found }, clean());
}

#[test]
fn repeated_faces_are_found() {
    let [a, b, c] = FACES[0];
    let found = defects(corners(0.0), &[&FACES[..], &[[b, c, a]]].concat());
    assert_eq!(found.duplicate_faces.unwrap().count, 1);
    assert_eq!(MeshDefects { duplicate_faces: None, ..found }, MeshDefects { triangles: 5, ..clean() });
    let found = defects(corners(0.0), &[&FACES[..], &[[b, a, c]]].concat());
    assert_eq!(found.double_sided_faces.unwrap().count, 1);
    assert_eq!(MeshDefects { double_sided_faces: None, ..found }, MeshDefects { triangles: 5, ..clean() });
}

#[test]
fn faces_that_cross_are_found() {
    let two = |shift: f64| {
        let vertices = [corners(0.0), corners(shift)].concat();
        defects(vertices, &[FACES, FACES.map(|face| face.map(|v| v + 4))].concat())
    };
    let found = two(0.3);
    let crossings = found.self_intersections.unwrap();
    assert!(crossings.count >= 3, "{found:?}");
    assert!((0.3..=1.0).contains(&crossings.point.x), "{found:?}");
    assert_eq!(found.components, 2);
    assert_eq!(two(2.0), MeshDefects { triangles: 8, components: 2, ..clean() });
}

#[test]
fn triangles_without_area_are_found() {
    let vertices = [corners(0.0), vec![Point::new(0.5, 0.0, 0.0)]].concat();
    let found = defects(vertices, &[&FACES[..], &[[0, 1, 4], [2, 2, 3]]].concat());
    assert_eq!(found.degenerate_triangles.unwrap().count, 2);
}

#[test]
fn a_mesh_of_lines_has_no_component() {
    let found = defects(corners(0.0), &[[0, 1, 1]]);
    assert_eq!((found.components, found.degenerate_triangles.unwrap().count), (0, 1));
}

/// A box around the origin with edges of these lengths.
fn box_of(size: [f64; 3]) -> (Vec<Point>, Vec<[u32; 3]>) {
    let corner = |i: usize, axis: usize| size[axis] * if i >> axis & 1 == 0 { -0.5 } else { 0.5 };
    let vertices = (0..8).map(|i| Point::new(corner(i, 0), corner(i, 1), corner(i, 2))).collect();
    let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    (vertices, quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect())
}

#[test]
fn boxes_that_cross_at_edges_are_found() {
    // edges of the long box pass through the diagonals of the faces of the cube
    let (mut vertices, mut faces) = box_of([1.0, 1.0, 1.0]);
    let (long, long_faces) = box_of([0.5, 0.5, 3.0]);
    vertices.extend(long);
    faces.extend(long_faces.iter().map(|face| face.map(|v| v + 8)));
    let found = defects(vertices, &faces);
    assert!(found.self_intersections.unwrap().count >= 4, "{found:?}");
    let (vertices, faces) = box_of([1.0, 1.0, 1.0]);
    assert_eq!(defects(vertices, &faces).self_intersections, None);
}

#[test]
fn a_mesh_with_a_small_hole_can_be_inward() {
    // a fan of many faces around an axis: one is missing
    let steps = 60_u32;
    let around = |i: u32| f64::from(i) / f64::from(steps) * std::f64::consts::TAU;
    let mut vertices: Vec<Point> =
        (0..steps).map(|i| Point::new(around(i).cos(), around(i).sin(), 0.0)).collect();
    vertices.extend([Point::new(0.0, 0.0, -1.0), Point::new(0.0, 0.0, 1.0)]);
    let mut faces: Vec<[u32; 3]> =
        (0..steps).flat_map(|i| [[i, (i + 1) % steps, steps + 1], [(i + 1) % steps, i, steps]]).collect();
    faces.pop();
    let found = defects(vertices.clone(), &faces);
    assert_eq!((found.inverted, found.open_edges.unwrap().count), (None, 3));
    let inward: Vec<[u32; 3]> = faces.iter().map(|&[a, b, c]| [a, c, b]).collect();
    assert_eq!(defects(vertices, &inward).inverted.unwrap().count, 1);
}
