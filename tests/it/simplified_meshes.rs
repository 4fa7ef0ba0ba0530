//! Tests of `clearance spheres --shape mesh`: written meshes, report, deadline and rejected input.

use std::f64::consts::{PI, TAU};

use clearance::geometry::TriangleMesh;
use clearance::geometry::math::{Point, Vector};
use clearance::robot::RobotModel;
use clearance::{CoverSize, SearchLimit, Shape, covers};
use serde_json::Value;

use crate::program::{Folder, clearance};
use crate::tally::shared_folder;

/// Two meshes and a primitive in one link, a mesh with a mirror in its scale in another.
const ROBOT: &str = r#"<robot name="two">
  <link name="base">
    <visual><geometry><mesh filename="ball.stl"/></geometry></visual>
    <collision name="first"><origin xyz="0 0 0.1" rpy="0 0.5 0"/><geometry><mesh filename="ball.stl"/></geometry></collision>
    <collision><geometry><box size="0.2 0.2 0.1"/></geometry></collision>
    <collision><!-- <mesh/> --><geometry><mesh scale="2 1 1" filename='ball.stl'></mesh></geometry></collision>
  </link>
  <link name="a &amp; b">
    <collision><origin xyz="1 0 0"/><geometry><mesh filename="ball.stl" scale="-0.5 0.5 0.5"/></geometry></collision>
  </link>
  <link name="tip"/>
  <joint name="j" type="revolute"><parent link="base"/><child link="a &amp; b"/><origin xyz="0 0 0.4"/>
    <axis xyz="0 0 1"/><limit lower="-1" upper="1" effort="1" velocity="1"/></joint>
  <joint name="f" type="fixed"><parent link="a &amp; b"/><child link="tip"/></joint>
</robot>"#;

const ROWS: u32 = 12;
const COLUMNS: u32 = 20;

/// A closed mesh of 480 triangles.
fn ball() -> TriangleMesh {
    let (last, at) = (ROWS * COLUMNS, |i: u32, j: u32| i * COLUMNS + j % COLUMNS);
    let mut vertices = vec![];
    for i in 0..ROWS {
        let (down, out) = (PI * f64::from(i + 1) / f64::from(ROWS + 1)).sin_cos();
        for j in 0..COLUMNS {
            let (sin, cos) = (TAU * f64::from(j) / f64::from(COLUMNS)).sin_cos();
            vertices.push(Point::new(down * cos, down * sin, out) * 0.1);
        }
    }
    vertices.extend([Point::new(0.0, 0.0, 0.1), Point::new(0.0, 0.0, -0.1)]);
    let mut faces: Vec<[u32; 3]> = vec![];
    for j in 0..COLUMNS {
        faces.extend([[last, at(0, j), at(0, j + 1)], [last + 1, at(ROWS - 1, j + 1), at(ROWS - 1, j)]]);
        for i in 0..ROWS - 1 {
            let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            faces.extend([[a, b, c], [a, c, d]]);
        }
    }
    TriangleMesh::new(vertices, faces).unwrap()
}

fn folder() -> Folder {
    let folder = Folder::of(ROBOT, "");
    std::fs::write(folder.path("ball.stl"), covers::stl(&ball())).unwrap();
    folder
}

fn run(folder: &Folder, arguments: &[&str]) -> (Option<i32>, String, String) {
    let output = folder.run(&[&["spheres", "--urdf", "r.urdf", "--shape", "mesh"], arguments].concat());
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    (output.status.code(), text(&output.stdout), text(&output.stderr))
}

/// The collision meshes of a link: number of triangles, pose, signed volume.
fn meshes(robot: &RobotModel, link: &str) -> Vec<(usize, Vector, f64)> {
    let link = robot.link(robot.link_by_name(link).unwrap());
    let mesh = |collision: &clearance::robot::Collision| match &collision.shape {
        Shape::Mesh(mesh) => {
            Some((mesh.triangles().len(), collision.pose_ls.translation.vector, mesh.signed_volume()))
        }
        _ => None,
    };
    link.collisions.iter().filter_map(mesh).collect()
}

#[test]
fn the_files_hold_the_meshes_that_are_reported() {
    let folder = folder();
    // a name that is no plain word
    let out = "s 50%:.urdf";
    let (code, report, errors) = run(&folder, &["--count", "200", "--shape-urdf", out, "--format", "json"]);
    assert_eq!(code, Some(0), "{errors}");
    let report: Value = serde_json::from_str(&report).unwrap();
    let [old, new] = ["r.urdf", out].map(|name| RobotModel::load(&folder.path(name), None, &[]).unwrap());
    let mut total = 0;
    for link in report["links"].as_array().unwrap() {
        let name = link["link"].as_str().unwrap();
        let [old, new] = [&old, &new].map(|robot| meshes(robot, name));
        let reported = link["meshes"].as_array().unwrap();
        assert!(old.len() == new.len() && new.len() == reported.len(), "{name}");
        for ((old, new), mesh) in old.iter().zip(&new).zip(reported) {
            assert_eq!(mesh["triangles"], new.0);
            assert_eq!((mesh["original_triangles"].as_u64(), old.0), (Some(480), 480));
            assert!(folder.path(mesh["file"].as_str().unwrap()).is_file(), "{mesh}");
            assert!(old.1 == new.1, "the pose stays");
            assert!((new.2 / old.2 - 1.0).abs() < 0.1, "{name}: volume {} was {}", new.2, old.2);
            let [lower, upper] = [0, 1].map(|i| mesh["error"][i].as_f64().unwrap());
            assert!(0.0 < lower && lower <= upper && upper < 0.01, "{mesh}");
        }
        let triangles: usize = new.iter().map(|mesh| mesh.0).sum();
        assert!(triangles <= 200 && link["triangles"] == triangles, "{link}");
        total += triangles;
    }
    assert_eq!(report["triangles"], total);
    assert_eq!(report["links"].as_array().unwrap().len(), 2, "links with meshes");
    let text = std::fs::read_to_string(folder.path(out)).unwrap();
    for kept in
        ["<visual><geometry><mesh filename=\"ball.stl\"/>", "<box size=\"0.2 0.2 0.1\"/>", "name=\"first\""]
    {
        assert!(text.contains(kept), "{kept}: {text}");
    }
    let checked = folder.run(&["check", "--urdf", out, "--state", "j=0.1"]);
    assert!(matches!(checked.status.code(), Some(0 | 1)), "{}", String::from_utf8_lossy(&checked.stderr));
    // existing files are replaced
    let (code, text, errors) = run(&folder, &["--excess", "0.002", "--shape-urdf", out]);
    assert_eq!(code, Some(0), "{errors}");
    assert!(text.contains("of 960 triangles, error ") && text.ends_with(" mm apart, proven\n"), "{text}");
    let again = RobotModel::load(&folder.path(out), None, &[]).unwrap();
    assert_ne!(meshes(&again, "a & b"), meshes(&new, "a & b"));
}

#[test]
fn meshes_do_not_depend_on_the_number_of_threads() {
    let robot = RobotModel::load(&folder().path("r.urdf"), None, &[]).unwrap();
    for size in [CoverSize::PerLink(150), CoverSize::Excess(0.003)] {
        let covers = [1, 4].map(|threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| covers::mesh_cover(&robot, &size, &SearchLimit::default(), &|_| ())).unwrap()
        });
        assert!(covers[0] == covers[1] && !covers[0].is_cut(), "{size:?}");
    }
}

#[test]
fn a_link_that_keeps_more_triangles_is_counted() {
    let (code, text, _) = run(&folder(), &["--count", "4"]);
    assert_eq!(code, Some(0));
    assert!(
        text.contains("base: 8 of 960 triangles") && text.contains("a & b: 4 of 480 triangles"),
        "{text}"
    );
    assert!(text.contains("1 of the links keep more than 4 triangles"), "{text}");
}

#[test]
fn a_deadline_ends_the_search_with_bounds_that_hold() {
    let (code, text, _) = run(&folder(), &["--excess", "0.001", "--deadline", "1e-9"]);
    assert!(code == Some(0) && text.contains("the time ended the search of 2 links"), "{text}");
    let (code, text, _) = run(&folder(), &["--count", "100", "--deadline", "1e9"]);
    assert!(code == Some(0) && !text.contains("the time ended"), "{text}");
}

#[test]
fn bad_input_is_rejected() {
    let folder = folder();
    folder.write("t_meshes", "");
    for (arguments, message) in [
        (&["--count", "3"][..], "at least 4 triangles per link, not 3"),
        (&["--excess", "0"], "--excess must be a finite number above zero"),
        (&["--total", "90"], "with --count or --excess"),
        (&["--counts-of", "r.urdf"], "with --count or --excess"),
        (&["--measure", "r.urdf"], "with --count or --excess"),
        (&["--count", "90", "--inner"], "without --inner"),
        (&["--count", "90", "--curobo", "c.yaml"], "without --inner, --curobo"),
        (&["--count", "90", "--xrdf", "c.xrdf"], "without --inner, --curobo"),
        (&["--count", "90", "--shape-urdf", "t.urdf"], "t_meshes: is there already, and no folder"),
        (&["--count", "90", "--shape-urdf", "no/t.urdf"], "no: there is no such folder"),
    ] {
        let (code, _, errors) = run(&folder, arguments);
        assert!(code == Some(2) && errors.contains(message), "{arguments:?}: {errors}");
    }
    assert!(!folder.path("no").exists() && !folder.path("t.urdf").exists());
    let primitives = r#"<robot name="r"><link name="l"><collision><geometry><sphere radius="0.1"/></geometry></collision></link></robot>"#;
    folder.write("r.urdf", primitives);
    let (code, _, errors) = run(&folder, &["--count", "90"]);
    assert!(code == Some(2) && errors.contains("no link has a collision mesh"), "{errors}");
}

#[test]
fn real_robots_are_simplified() {
    let Some(shared) = shared_folder("robots") else { return };
    let folder = Folder::new();
    for (urdf, links) in [
        ("ur_description/urdf/ur5e.urdf", 7),
        ("moveit_resources_panda_description/urdf/panda.urdf", 11),
        ("baxter_description/urdf/baxter.urdf", 2),
    ] {
        let urdf = shared.join(urdf).display().to_string();
        let (packages, out) = (shared.display().to_string(), folder.path("out.urdf").display().to_string());
        let robot = ["spheres", "--urdf", &urdf, "--package-path", &packages, "--shape", "mesh"];
        let size = ["--count", "100", "--shape-urdf", &out, "--format", "json"];
        let output = clearance(&[&robot[..], &size[..]].concat());
        assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
        let report: Value = serde_json::from_slice(&output.stdout).unwrap();
        let of_links = report["links"].as_array().unwrap();
        assert_eq!(of_links.len(), links);
        let new = RobotModel::load(&folder.path("out.urdf"), None, std::slice::from_ref(&shared)).unwrap();
        for link in of_links {
            let read: usize = meshes(&new, link["link"].as_str().unwrap()).iter().map(|mesh| mesh.0).sum();
            assert_eq!(link["triangles"], read, "{link}");
        }
    }
}

#[test]
fn a_mesh_that_is_read_is_not_replaced() {
    let folder = folder();
    let (code, _, errors) = run(&folder, &["--count", "200", "--shape-urdf", "out.urdf"]);
    assert_eq!(code, Some(0), "{errors}");
    std::fs::copy(folder.path("out.urdf"), folder.path("r.urdf")).unwrap();
    let mut written = std::fs::read_dir(folder.path("out_meshes")).unwrap();
    let mesh = written.next().unwrap().unwrap().path();
    let before = std::fs::read(&mesh).unwrap();
    let (code, _, errors) = run(&folder, &["--count", "100", "--shape-urdf", "out.urdf"]);
    assert!(
        code == Some(2) && errors.contains("is a mesh of the robot, in the folder that is written"),
        "{errors}"
    );
    assert_eq!(std::fs::read(&mesh).unwrap(), before);
    // the same file by a link in another folder
    std::fs::create_dir(folder.path("far_meshes")).unwrap();
    let link = folder.path("far_meshes").join(mesh.file_name().unwrap());
    std::os::unix::fs::symlink(&mesh, &link).unwrap();
    let (code, _, errors) = run(&folder, &["--count", "100", "--shape-urdf", "far.urdf"]);
    assert!(code == Some(2) && errors.contains("it is a mesh of the robot"), "{errors}");
    assert_eq!(std::fs::read(&mesh).unwrap(), before);
    let (code, _, errors) = run(&folder, &["--count", "100", "--shape-urdf", "new.urdf"]);
    assert_eq!(code, Some(0), "{errors}");
}

/// It may be an original mesh, as where the names of files are those of links.
#[test]
fn a_file_that_is_no_simplified_mesh_stays() {
    let folder = folder();
    let arguments = ["--count", "200", "--shape-urdf", "out.urdf", "--format", "json"];
    let (code, report, errors) = run(&folder, &arguments);
    assert_eq!(code, Some(0), "{errors}");
    let report: Value = serde_json::from_str(&report).unwrap();
    let file = folder.path(report["links"][1]["meshes"][0]["file"].as_str().unwrap());
    let urdf = std::fs::read(folder.path("out.urdf")).unwrap();
    std::fs::write(&file, "solid original").unwrap();
    let (code, _, errors) = run(&folder, &arguments);
    assert_eq!(code, Some(2), "{errors}");
    assert!(errors.contains("is no simplified mesh"), "{errors}");
    assert_eq!(std::fs::read(&file).unwrap(), b"solid original");
    assert_eq!(std::fs::read(folder.path("out.urdf")).unwrap(), urdf);
}
