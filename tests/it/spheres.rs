//! Tests of the command `clearance spheres`: covers, files for other programs, measurement.

use std::collections::BTreeMap;

use clearance::geometry::math::Point;
use clearance::robot::RobotModel;
use clearance::{CoverSize, Primitive, SearchLimit, Shape, covers, sphere_cover};
use clearance_files::yaml;
use serde::Deserialize;
use serde_json::Value;

use crate::program::Folder;

/// Two boxes and a bare link; what looks like a collision is none.
const ROBOT: &str = r#"<robot name="two">
  <!-- <link name="no"><collision/></link> -->
  <link name="base">
    <visual><geometry><box size="0.1 0.1 0.1"/></geometry></visual>
    <collision><geometry><box size="0.2 0.2 0.1"/></geometry></collision>
    <collision><origin xyz="0 0 0.1"/><geometry><cylinder radius="0.05" length="0.2"/></geometry></collision>
  </link>
  <link name="a &amp; b">
    <collision><geometry><sphere radius="0.1"/></geometry></collision>
  </link>
  <link name="tip"/>
  <joint name="j" type="revolute"><parent link="base"/><child link="a &amp; b"/><origin xyz="0 0 0.4"/>
    <axis xyz="0 0 1"/><limit lower="-1" upper="1" effort="1" velocity="1"/></joint>
  <joint name="f" type="fixed"><parent link="a &amp; b"/><child link="tip"/></joint>
</robot>"#;

#[derive(Deserialize)]
struct YamlSphere {
    center: [f64; 3],
    radius: f64,
}

#[derive(Deserialize)]
struct CuroboFile {
    collision_spheres: BTreeMap<String, Vec<YamlSphere>>,
}

#[derive(Deserialize)]
struct XrdfFile {
    format: String,
    format_version: f64,
    cspace: Cspace,
    tool_frames: Vec<String>,
    collision: Collision,
    self_collision: Collision,
    geometry: BTreeMap<String, Group>,
}

#[derive(Deserialize)]
struct Cspace {
    joint_names: Vec<String>,
    acceleration_limits: Vec<f64>,
    jerk_limits: Vec<f64>,
}

#[derive(Deserialize)]
struct Collision {
    geometry: String,
}

#[derive(Deserialize)]
struct Group {
    spheres: BTreeMap<String, Vec<YamlSphere>>,
}

fn folder() -> Folder {
    Folder::of(ROBOT, "")
}

/// Spheres by link: x, y, z, radius.
fn of_yaml(spheres: &BTreeMap<String, Vec<YamlSphere>>) -> BTreeMap<String, Vec<[f64; 4]>> {
    let flat = |s: &YamlSphere| [s.center[0], s.center[1], s.center[2], s.radius];
    spheres.iter().map(|(link, spheres)| (link.clone(), spheres.iter().map(flat).collect())).collect()
}

#[test]
fn files_hold_the_spheres_that_are_reported() {
    let folder = folder();
    let output = folder.run(&[
        "spheres",
        "--urdf",
        "r.urdf",
        "--count",
        "3",
        "--curobo",
        "c.yaml",
        "--xrdf",
        "r.xrdf",
        "--sphere-urdf",
        "s.urdf",
        "--format",
        "json",
    ]);
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    let report: Value = serde_json::from_slice(&output.stdout).unwrap();
    let links = report["links"].as_array().unwrap();
    let reported: BTreeMap<String, Vec<[f64; 4]>> = links
        .iter()
        .map(|link| {
            let spheres = serde_json::from_value(link["spheres"].clone()).unwrap();
            (link["link"].as_str().unwrap().to_owned(), spheres)
        })
        .collect();
    assert_eq!(reported.keys().collect::<Vec<_>>(), ["a & b", "base"]);
    assert!(reported.values().all(|spheres| (1..=3).contains(&spheres.len())));

    let text = |name: &str| std::fs::read_to_string(folder.path(name)).unwrap();
    let curobo: CuroboFile = yaml::from_text(&text("c.yaml")).unwrap();
    assert_eq!(of_yaml(&curobo.collision_spheres), reported);
    let xrdf: XrdfFile = yaml::from_text(&text("r.xrdf")).unwrap();
    assert_eq!((xrdf.format.as_str(), xrdf.format_version), ("xrdf", 1.0));
    assert_eq!(xrdf.cspace.joint_names, ["j"]);
    assert_eq!((xrdf.cspace.acceleration_limits.len(), xrdf.cspace.jerk_limits.len()), (1, 1));
    assert_eq!(xrdf.tool_frames, ["tip"]);
    for group in [xrdf.collision.geometry, xrdf.self_collision.geometry] {
        assert_eq!(of_yaml(&xrdf.geometry[&group].spheres), reported);
    }

    let robot = RobotModel::load(&folder.path("s.urdf"), None, &[]).unwrap();
    for link in robot.links() {
        let spheres = link.collisions.iter().map(|collision| {
            let Shape::Primitive(Primitive::Sphere { radius }) = collision.shape else { panic!("no sphere") };
            let centre = collision.pose_ls.translation;
            [centre.x, centre.y, centre.z, radius]
        });
        assert_eq!(reported.get(&link.name).cloned().unwrap_or_default(), spheres.collect::<Vec<_>>());
    }
    assert!(text("s.urdf").contains("<visual><geometry><box"), "what is no collision stays");
}

#[test]
fn covers_leave_no_surface_out_and_smaller_spheres_do() {
    let folder = folder();
    let made = folder.run(&["spheres", "--urdf", "r.urdf", "--excess", "0.03", "--sphere-urdf", "s.urdf"]);
    let text = String::from_utf8_lossy(&made.stdout).into_owned();
    assert!(text.contains("proven to contain the links"), "{text}");
    let measured = folder.run(&["spheres", "--urdf", "r.urdf", "--measure", "s.urdf", "--format", "json"]);
    assert_eq!(measured.status.code(), Some(0));
    let links: Value = serde_json::from_slice(&measured.stdout).unwrap();
    for link in links.as_array().unwrap() {
        assert_eq!(link["uncovered_area"][0], 0.0, "{link}");
        assert!(link["excess"][1].as_f64().unwrap() <= 0.031, "{link}");
    }
    let urdf = std::fs::read_to_string(folder.path("s.urdf")).unwrap();
    folder.write("t.urdf", &urdf.replace("sphere radius=\"0.", "sphere radius=\"0.0"));
    let measured = folder.run(&["spheres", "--urdf", "r.urdf", "--measure", "t.urdf"]);
    assert_eq!(measured.status.code(), Some(1));
    let as_many = folder.run(&["spheres", "--urdf", "r.urdf", "--counts-of", "s.urdf"]);
    assert_eq!(as_many.status.code(), Some(0));
    // a link without spheres would not be covered
    folder.write("n.urdf", &urdf.replace("a &amp; b", "c"));
    let without = folder.run(&["spheres", "--urdf", "r.urdf", "--counts-of", "n.urdf"]);
    let text = String::from_utf8_lossy(&without.stderr);
    assert!(without.status.code() == Some(2) && text.contains("'a & b'"), "{text}");
}

#[test]
fn a_total_is_kept_and_shared() {
    let robot = RobotModel::load(&folder().path("r.urdf"), None, &[]).unwrap();
    let with_geometry = robot.links().iter().filter(|link| !link.collisions.is_empty()).count();
    let cover = |total| sphere_cover(&robot, &CoverSize::Total(total), &SearchLimit::default(), &|_| ());
    let found = cover(3 * with_geometry).unwrap();
    assert!(found.count() <= 3 * with_geometry && found.links.len() == with_geometry);
    assert!(found.links.iter().all(|link| link.error[0] <= link.error[1]));
    let error = cover(with_geometry - 1).unwrap_err().to_string();
    assert!(error.contains("too few"), "{error}");
}

#[test]
fn bad_sizes_are_rejected() {
    let folder = folder();
    for (arguments, message) in [
        (["--count", "0"], "at least one sphere"),
        (["--excess", "0"], "--excess must be a finite number above zero"),
        (["--excess", "nan"], "--excess must be a finite number above zero"),
        (["--total", "1"], "too few"),
        (["--count=1", "--deadline=0"], "--deadline must be a finite number above zero"),
        (["--measure", "r.urdf"], "must be spheres"),
    ] {
        let output = folder.run(&[&["spheres", "--urdf", "r.urdf"], arguments.as_slice()].concat());
        let text = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(output.status.code() == Some(2) && text.contains(message), "{arguments:?}: {text}");
    }
}

#[test]
fn a_depth_that_is_not_reached_is_an_error() {
    let folder = folder();
    let link = r#"<link name="cube"><collision><geometry><box size="0.001 0.001 0.001"/></geometry></collision></link>"#;
    folder.write("t.urdf", &format!("<robot name='r'>{link}</robot>"));
    let output = folder.run(&["spheres", "--urdf", "t.urdf", "--inner", "--excess", "0.000001"]);
    let text = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(
        output.status.code() == Some(2) && text.contains("link 'cube': no cover with an excess"),
        "{text}"
    );
}

#[test]
fn a_cover_does_not_depend_on_the_number_of_threads() {
    let robot = RobotModel::load(&folder().path("r.urdf"), None, &[]).unwrap();
    for size in [CoverSize::PerLink(3), CoverSize::Total(5), CoverSize::Excess(0.04)] {
        let files = [1, 4].map(|threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            let cover =
                pool.install(|| sphere_cover(&robot, &size, &SearchLimit::default(), &|_| ())).unwrap();
            assert!(!cover.is_cut());
            (covers::curobo_yaml(&robot, &cover), covers::sphere_urdf(&robot, &cover, ROBOT).unwrap())
        });
        assert!(files[0] == files[1], "{size:?}");
    }
}

#[test]
fn a_deadline_keeps_the_proof() {
    let folder = folder();
    let run = |deadline: &str| {
        let size = ["spheres", "--urdf", "r.urdf", "--count", "2", "--deadline", deadline];
        let output = folder.run(&[&size[..], &["--format", "json", "--sphere-urdf", "s.urdf"]].concat());
        assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
        let report: Value = serde_json::from_slice(&output.stdout).unwrap();
        let measured =
            folder.run(&["spheres", "--urdf", "r.urdf", "--measure", "s.urdf", "--format", "json"]);
        let links: Value = serde_json::from_slice(&measured.stdout).unwrap();
        assert!(links.as_array().unwrap().iter().all(|link| link["uncovered_area"][0] == 0.0), "{links}");
        report
    };
    let (short, long) = (run("1e-9"), run("1e9"));
    let ended = [&short, &long].map(|report| report["ended_by_time"].as_bool());
    assert_eq!(ended, [Some(true), Some(false)]);
    let error = |report: &Value| report["largest_error"].as_f64().unwrap();
    assert!(error(&short) > error(&long), "{short} {long}");
    let text = folder.run(&["spheres", "--urdf", "r.urdf", "--excess", "0.001", "--deadline", "1e-9"]);
    let text = String::from_utf8_lossy(&text.stdout).into_owned();
    assert!(text.contains("proven to contain the links") && text.contains("the time ended"), "{text}");
}

/// Points of the collision geometry of `ROBOT`, by link.
fn points_of_robot() -> BTreeMap<String, Vec<Point>> {
    let robot = RobotModel::load(&folder().path("r.urdf"), None, &[]).unwrap();
    let mut random = fastrand::Rng::with_seed(2);
    let mut points = BTreeMap::new();
    for link in robot.links() {
        for collision in &link.collisions {
            let Shape::Primitive(primitive) = &collision.shape else { panic!("a primitive") };
            let own: &mut Vec<Point> = points.entry(link.name.clone()).or_default();
            let random_point =
                || Point::new(random.f64() - 0.5, random.f64() - 0.5, random.f64() - 0.5) * 0.4;
            let inside = std::iter::repeat_with(random_point).filter(|p| primitive.signed_distance(p) <= 0.0);
            own.extend(inside.take(3000).map(|p| collision.pose_ls * p));
        }
    }
    points
}

#[test]
fn capsules_and_boxes_contain_the_links() {
    let (folder, points) = (folder(), points_of_robot());
    for (shape, count) in [("capsules", "1"), ("capsules", "3"), ("boxes", "1"), ("boxes", "3")] {
        let arguments = ["spheres", "--urdf", "r.urdf", "--shape", shape, "--count", count];
        let files = ["--shape-urdf", "s.urdf", "--format", "json"];
        let output = folder.run(&[&arguments[..], &files[..]].concat());
        assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
        let report: Value = serde_json::from_slice(&output.stdout).unwrap();
        let excess = report["largest_excess"].as_f64().unwrap();
        let robot = RobotModel::load(&folder.path("s.urdf"), None, &[]).unwrap();
        for (name, points) in &points {
            let collisions = &robot.link(robot.link_by_name(name).unwrap()).collisions;
            let distance = |p: &Point, collision: &clearance::robot::Collision| match &collision.shape {
                Shape::Primitive(primitive) => primitive.signed_distance(&(collision.pose_ls.inverse() * p)),
                _ => panic!("a primitive"),
            };
            for p in points {
                assert!(
                    collisions.iter().any(|c| distance(p, c) <= 0.0),
                    "{shape} {name}: {p:?} is in no shape"
                );
            }
            for collision in collisions {
                let centre = Point::from(collision.pose_ls.translation.vector);
                let nearest = points.iter().map(|p| (p - centre).norm()).fold(f64::INFINITY, f64::min);
                assert!(nearest <= excess + 0.03, "{shape} {name}: a centre is {nearest} m away");
            }
        }
        let shapes = report["links"][0]["shapes"].as_array().unwrap();
        assert!((1..=count.parse().unwrap()).contains(&shapes.len()), "{report}");
    }
}

#[test]
fn one_shape_is_not_several() {
    let folder = folder();
    for (shape, singular) in [("capsules", "1 capsule,"), ("boxes", "1 box,"), ("spheres", "1 sphere,")] {
        let output = folder.run(&["spheres", "--urdf", "r.urdf", "--shape", shape, "--count", "1"]);
        let text = String::from_utf8_lossy(&output.stdout).into_owned();
        assert!(text.contains(singular) && !text.contains(&format!(" 1 {shape}")), "{text}");
    }
}

#[test]
fn options_of_spheres_are_rejected_for_other_shapes() {
    let folder = folder();
    for arguments in [["--total", "9"], ["--excess", "0.1"], ["--measure", "r.urdf"]] {
        let shape = ["spheres", "--urdf", "r.urdf", "--shape", "boxes"];
        let output = folder.run(&[&shape[..], &arguments[..]].concat());
        let text = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(output.status.code() == Some(2) && text.contains("with --count"), "{text}");
    }
    let text = folder.run(&["spheres", "--urdf", "r.urdf", "--shape", "boxes", "--count", "2"]);
    let text = String::from_utf8_lossy(&text.stdout).into_owned();
    assert!(text.contains("boxes, proven to contain the links"), "{text}");
}
