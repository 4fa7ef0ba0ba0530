//! Tests with faults that are planted in meshes of real robots: all are found.

use std::path::{Path, PathBuf};

use clearance_geometry::math::{Point, Vector};
use clearance_geometry::{Shape, TriangleMesh};
use clearance_lint::{Check, LintOptions, MeshDefects, Severity, lint};
use clearance_robot::{RobotModel, VisualGeometry};

/// Robots with their folders.
const ROBOTS: [&str; 2] =
    ["moveit_resources_panda_description/urdf/panda.urdf", "ur_description/urdf/ur5e.urdf"];

fn shared_robots() -> Option<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/robots");
    if folder.is_dir() {
        return Some(folder);
    }
    eprintln!("NOT TESTED: the shared folder {} is not here", folder.display());
    None
}

/// Vertices and faces of a mesh.
#[derive(Clone)]
struct Faces {
    vertices: Vec<Point>,
    faces: Vec<[u32; 3]>,
}

impl Faces {
    fn defects(&self) -> MeshDefects {
        MeshDefects::find(&TriangleMesh::new(self.vertices.clone(), self.faces.clone()).unwrap(), None)
    }

    fn corners(&self, face: usize) -> [Point; 3] {
        self.faces[face].map(|v| self.vertices[v as usize])
    }
}

/// Closed meshes without defects.
fn clean_meshes(folder: &Path) -> Vec<Faces> {
    let robots = ROBOTS.map(|urdf| RobotModel::load(&folder.join(urdf), None, &[folder.to_owned()]).unwrap());
    let shapes = robots.iter().flat_map(RobotModel::links).flat_map(|link| &link.collisions);
    let meshes = shapes.filter_map(|collision| match &collision.shape {
        Shape::Mesh(mesh) => {
            Some(Faces { vertices: mesh.vertices().to_vec(), faces: mesh.triangles().to_vec() })
        }
        _ => None,
    });
    let is_clean = |mesh: &Faces| {
        let found = mesh.defects();
        found == MeshDefects { triangles: found.triangles, components: 1, ..MeshDefects::default() }
    };
    meshes.filter(is_clean).collect()
}

#[test]
fn planted_faults_of_faces_are_found() {
    let Some(folder) = shared_robots() else { return };
    let meshes = clean_meshes(&folder);
    assert!(meshes.len() >= 5, "{} clean meshes", meshes.len());
    for (number, clean) in meshes.iter().enumerate() {
        for face in [0, clean.faces.len() / 2, clean.faces.len() - 1] {
            let corners = clean.corners(face);
            let at_face = |p: &Point| corners.iter().any(|corner| (corner - p).norm() < 1e-12);
            let planted = |change: &dyn Fn(&mut Faces)| {
                let mut mesh = clean.clone();
                change(&mut mesh);
                mesh.defects()
            };
            let hole = planted(&|mesh| mesh.faces.retain(|corners| *corners != clean.faces[face]))
                .open_edges
                .unwrap();
            assert!(hole.count == 3, "mesh {number}: {hole:?}");
            let inverted = planted(&|mesh| mesh.faces[face].swap(0, 1)).mixed_orientation.unwrap();
            assert!(inverted.count == 3, "mesh {number}: {inverted:?}");
            let duplicate = planted(&|mesh| mesh.faces.push(mesh.faces[face])).duplicate_faces.unwrap();
            let [a, b, c] = corners.map(|p| p.coords);
            let from_centre = (duplicate.point.coords - (a + b + c) / 3.0).norm();
            assert!(duplicate.count == 1 && from_centre < 1e-12, "mesh {number}: {duplicate:?}");
            let degenerate = planted(&|mesh| {
                let [a, b, _] = mesh.faces[face];
                mesh.faces.push([a, b, b]);
            });
            let degenerate = degenerate.degenerate_triangles.unwrap();
            assert!(degenerate.count == 1 && at_face(&degenerate.point), "mesh {number}: {degenerate:?}");
        }
    }
}

#[test]
fn a_vertex_behind_the_other_side_is_a_self_intersection() {
    let Some(folder) = shared_robots() else { return };
    for (number, clean) in clean_meshes(&folder).iter().enumerate() {
        let sum: Vector = clean.vertices.iter().map(|p| p.coords).sum();
        #[expect(clippy::cast_precision_loss, reason = "few vertices")]
        let centre = Point::from(sum / clean.vertices.len() as f64);
        let mut mesh = clean.clone();
        let moved = mesh.faces[0][0];
        let from = mesh.vertices[moved as usize];
        let extent = mesh.vertices.iter().map(|p| (p - centre).norm()).fold(0.0, f64::max);
        // all corners at one place move together
        for p in mesh.vertices.iter_mut().filter(|p| **p == from) {
            *p = centre + (centre - from).normalize() * (2.0 * extent);
        }
        assert!(mesh.defects().self_intersections.is_some(), "mesh {number}");
    }
}

#[test]
fn a_mesh_in_millimetres_is_found() {
    let Some(folder) = shared_robots() else { return };
    let urdf = folder.join(ROBOTS[0]);
    let text = std::fs::read_to_string(&urdf).unwrap();
    let collision = "collision/link3.stl\"";
    assert_eq!(text.matches(collision).count(), 1);
    let wrong_units = |text: &str| {
        let file = Path::new(env!("CARGO_TARGET_TMPDIR")).join("millimetres.urdf");
        std::fs::write(&file, text).unwrap();
        let robot = RobotModel::load(&file, None, std::slice::from_ref(&folder)).unwrap();
        let report = lint(&robot, &VisualGeometry::default(), &LintOptions::default());
        let errors = report.findings.iter().filter(|finding| finding.severity == Severity::Error);
        errors.map(|finding| (finding.check, finding.link.clone())).collect::<Vec<_>>()
    };
    assert_eq!(wrong_units(&text), []);
    let scaled = text.replace(collision, &format!("{collision} scale=\"1000 1000 1000\""));
    let found = wrong_units(&scaled);
    assert!(!found.is_empty());
    assert!(found.iter().all(|found| *found == (Check::WrongUnit, "panda_link3".to_owned())), "{found:?}");
}
