//! Tests of rejected output files, certificates of another kind, and input files that would be read wrongly.

use clearance::collision_matrix::{Decision, MatrixDocument};
use clearance::robot::{MeshFiles, RobotModel};
use clearance::scene::Settings;
use std::process::Output;

use crate::program::Folder;

const ROBOT: &str = include_str!("../../urdf/two_link/two_link.urdf");
const TO: &str = "joint1=0.2";

fn folder() -> Folder {
    Folder::of(ROBOT, "world: {collision_objects: []}\n")
}

fn assert_fails(output: &Output, code: i32, words: &str) {
    let text = [&output.stdout[..], &output.stderr].concat();
    let text = String::from_utf8_lossy(&text);
    assert_eq!(output.status.code(), Some(code), "{text}");
    assert!(text.contains(words), "no '{words}' in: {text}");
}

#[test]
fn a_certificate_of_a_matrix_proves_no_motion() {
    let folder = folder();
    let made = folder.run(&["acm", "--urdf", "r.urdf", "--certificate", "m.json"]);
    assert_eq!(made.status.code(), Some(0));
    assert_eq!(folder.run(&["verify", "--urdf", "r.urdf", "m.json"]).status.code(), Some(0));
    for arguments in [
        &["--from", "joint1=0", "--to", TO][..],
        &["--tube", "0.1"],
        &["--deviation", "0.1"],
        &["--margin", "0.1"],
        &["--tolerance", "0.1"],
        &["--world", "w.yaml"],
        &["--no-self"],
        &["--moving-obstacles"],
        &["--format", "json", "--margin", "0"],
    ] {
        let verified = folder.run(&[&["verify", "--urdf", "r.urdf", "m.json"], arguments].concat());
        assert_fails(&verified, 1, "it proves nothing about a motion");
    }
}

#[test]
fn only_certificates_are_replaced_by_certificates() {
    let folder = folder();
    folder.write("thesis.txt", "my work\n");
    let motion = ["motion", "--urdf", "r.urdf", "--from", "joint1=0", "--to", TO, "--certificate"];
    let plan = ["plan", "--urdf", "r.urdf", "--from", "", "--to", TO, "--certificate"];
    for (name, content) in [("thesis.txt", "my work\n"), ("r.urdf", ROBOT)] {
        for command in [&motion[..], &plan, &["acm", "--urdf", "r.urdf", "--certificate"]] {
            let output = folder.run(&[command, &[name]].concat());
            assert_fails(&output, 2, "is no certificate: choose another name");
            assert_eq!(std::fs::read_to_string(folder.path(name)).unwrap(), content);
        }
    }
    for _ in 0..2 {
        assert_eq!(folder.run(&[&motion[..], &["c.json"]].concat()).status.code(), Some(0));
        assert_eq!(
            folder.run(&["acm", "--urdf", "r.urdf", "--certificate", "c.json"]).status.code(),
            Some(0)
        );
    }
}

#[test]
fn outputs_are_no_inputs_and_differ() {
    let folder = folder();
    for arguments in [
        &["spheres", "--urdf", "r.urdf", "--count", "2", "--curobo", "r.urdf"][..],
        &["spheres", "--urdf", "r.urdf", "--count", "2", "--sphere-urdf", "./r.urdf"],
        &["spheres", "--urdf", "r.urdf", "--shape", "boxes", "--count", "2", "--shape-urdf", "r.urdf"],
        &["spheres", "--urdf", "r.urdf", "--shape", "mesh", "--count", "9", "--shape-urdf", "r.urdf"],
        &["lint", "--urdf", "r.urdf", "--html", "r.urdf"],
    ] {
        assert_fails(&folder.run(arguments), 2, "it is read, too: write to another file");
        assert_eq!(std::fs::read_to_string(folder.path("r.urdf")).unwrap(), ROBOT);
    }
    let same = ["acm", "--urdf", "r.urdf", "--write-srdf", "x", "--resume", "./x", "--certificate", "y"];
    assert_fails(&folder.run(&same), 2, "two outputs would be written to it");
    assert!(!folder.path("x").exists());
}

/// A tetrahedron, as collision geometry and as visual geometry of another link.
#[test]
fn a_mesh_of_the_robot_is_no_output() {
    let folder = folder();
    let mesh = "solid\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\nendsolid\n";
    folder.write("seen.stl", mesh);
    folder.write("hit.stl", mesh);
    let of =
        |kind: &str, file: &str| format!("<{kind}><geometry><mesh filename='{file}'/></geometry></{kind}>");
    folder.write(
        "m.urdf",
        &format!(
            "<robot name='m'><link name='a'>{}{}</link></robot>",
            of("collision", "hit.stl"),
            of("visual", "seen.stl")
        ),
    );
    for arguments in [
        &["spheres", "--urdf", "m.urdf", "--count", "1", "--curobo", "hit.stl"][..],
        &["spheres", "--urdf", "m.urdf", "--count", "1", "--sphere-urdf", "./hit.stl"],
        &["lint", "--urdf", "m.urdf", "--html", "seen.stl"],
        &["lint", "--urdf", "m.urdf", "--html", "hit.stl"],
    ] {
        assert_fails(&folder.run(arguments), 2, "it is a mesh of the robot: write to another file");
    }
    for file in ["seen.stl", "hit.stl"] {
        assert_eq!(std::fs::read_to_string(folder.path(file)).unwrap(), mesh);
    }
}

/// `<disable_default_collisions>` hides every pair of a link.
#[test]
fn an_audit_includes_pairs_that_are_hidden_by_default() {
    let folder = folder();
    let link = |name: &str, x: f64| {
        format!(
            "<link name='{name}'><collision><origin xyz='{x} 0 0'/><geometry><sphere radius='0.1'/></geometry></collision></link>"
        )
    };
    let joint = |name: &str, parent: &str, child: &str| {
        format!(
            "<joint name='{name}' type='revolute'><parent link='{parent}'/><child link='{child}'/><axis xyz='0 0 1'/>\
             <limit lower='-3' upper='3' effort='1' velocity='1'/></joint>"
        )
    };
    let links = [link("a", 1.0), link("b", 0.0), link("c", 1.0)].concat();
    folder.write(
        "h.urdf",
        &format!("<robot name='h'>{links}{}{}</robot>", joint("ab", "a", "b"), joint("bc", "b", "c")),
    );
    folder.write("h.srdf", "<robot name='h'><disable_default_collisions link='c'/></robot>");
    let output = folder.run(&["acm", "--urdf", "h.urdf", "--audit", "h.srdf", "--list"]);
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(
        text.contains("1 can collide and are hidden") && text.contains("disable_default_collisions"),
        "{text}"
    );
}

#[cfg(unix)]
#[test]
fn no_file_beside_an_output_is_touched() {
    let folder = folder();
    folder.write("victim.txt", "precious\n");
    for name in ["out.srdf.part", ".out.srdf.part"] {
        std::os::unix::fs::symlink(folder.path("victim.txt"), folder.path(name)).unwrap();
    }
    let output = folder.run(&["acm", "--urdf", "r.urdf", "--write-srdf", "out.srdf"]);
    assert_eq!(output.status.code(), Some(0));
    assert_eq!(std::fs::read_to_string(folder.path("victim.txt")).unwrap(), "precious\n");
    assert!(folder.path("out.srdf").symlink_metadata().unwrap().is_file());
    let left = std::fs::read_dir(folder.path(".")).unwrap();
    assert_eq!(left.count(), 6, "nothing is left over: robot, world, victim, two links, SRDF");
}

/// A decision with a digest that fits, whose proof proves nothing.
#[test]
fn a_file_to_resume_from_is_no_proof() {
    let folder = folder();
    let resume = ["acm", "--urdf", "r.urdf", "--resume", "d.json", "--write-srdf", "out.srdf"];
    assert_eq!(folder.run(&resume).status.code(), Some(0));
    let robot = RobotModel::from_urdf(ROBOT, &MeshFiles::default()).unwrap();
    let (text, settings) = (std::fs::read_to_string(folder.path("d.json")).unwrap(), Settings::default());
    let mut pairs = MatrixDocument::from_json(&text, &robot, &settings).unwrap().pairs;
    let sometimes =
        pairs.iter_mut().find(|pair| matches!(pair.decision, Decision::Sometimes { .. })).unwrap();
    sometimes.decision = Decision::Never { proof: ".".to_owned(), least_distance: None };
    folder.write("d.json", &MatrixDocument::new(&robot, &settings, pairs).to_json());
    std::fs::remove_file(folder.path("out.srdf")).unwrap();
    assert_fails(&folder.run(&resume), 2, "d.json: a decision is not proven");
    assert!(!folder.path("out.srdf").exists());
}

/// With a bare name, the folder of a world is the working directory: nothing outside of it is read.
#[test]
fn a_bare_name_of_a_world_opens_no_other_folder() {
    let folder = folder();
    let outside = Folder::new();
    let mesh = outside.write("t.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    for resource in
        [format!("file://{mesh}"), "file:///etc/passwd".to_owned(), "file:///proc/self/environ".to_owned()]
    {
        let object = format!("{{id: a, meshes: [{{resource: '{resource}'}}], mesh_poses: [{{}}]}}");
        folder.write("w.yaml", &format!("world: {{collision_objects: [{object}]}}\n"));
        for world in ["w.yaml", "./w.yaml"] {
            let output = folder.run(&["check", "--urdf", "r.urdf", "--world", world, "--state", ""]);
            let text = String::from_utf8_lossy(&output.stderr).into_owned();
            assert_eq!(output.status.code(), Some(2), "{text}");
            assert!(text.contains("outside") || text.contains("system"), "{world}: {text}");
        }
    }
}

#[test]
fn short_lists_of_coordinates_are_rejected() {
    let folder = folder();
    for (pose, words) in [
        ("position: [0.65, 0]", "three numbers"),
        ("position: []", "three numbers"),
        ("position: [0.65, 0, 0.3, 1]", "three numbers"),
        ("orientation: [0.1, 0.2, 0.3]", "four numbers"),
        ("orientation: []", "four numbers"),
    ] {
        let object = format!(
            "{{id: a, primitives: [{{type: box, dimensions: [1, 1, 1]}}], primitive_poses: [{{{pose}}}]}}"
        );
        folder.write("w.yaml", &format!("world: {{collision_objects: [{object}]}}\n"));
        let output = folder.run(&["check", "--urdf", "r.urdf", "--world", "w.yaml", "--state", ""]);
        assert_fails(&output, 2, words);
    }
    let named =
        "{id: a, primitives: [{type: box, dimensions: [1, 1, 1]}], primitive_poses: [{position: {x: 9}}]}";
    folder.write("w.yaml", &format!("world: {{collision_objects: [{named}]}}\n"));
    let output = folder.run(&["check", "--urdf", "r.urdf", "--world", "w.yaml", "--state", ""]);
    assert_eq!(output.status.code(), Some(0), "a missing component is zero, as in a message");
}

#[test]
fn an_excess_that_the_time_does_not_reach_is_no_success() {
    let folder = folder();
    let arguments = ["spheres", "--urdf", "r.urdf", "--excess", "0.0001", "--deadline", "0.01"];
    assert_eq!(folder.run(&arguments).status.code(), Some(1));
    let reached = ["spheres", "--urdf", "r.urdf", "--excess", "0.1"];
    assert_eq!(folder.run(&reached).status.code(), Some(0));
}

#[test]
fn an_end_without_a_start_is_rejected() {
    let folder = folder();
    folder.write("e.json", r#"{"joints": ["joint1", "joint2"], "edges": [[[0, 0], [0.1, 0]]]}"#);
    let output = folder.run(&["motion", "--urdf", "r.urdf", "--edges", "e.json", "--to", TO]);
    assert_fails(&output, 2, "--to belongs to --from");
}

#[cfg(unix)]
#[test]
fn a_limit_of_file_sizes_is_an_error_and_no_signal() {
    use std::process::{Command, Stdio};
    let folder = folder();
    let limited = |arguments: &[&str], stdout: Stdio| {
        Command::new("sh")
            .args(["-c", "ulimit -f 0; exec \"$@\"", "sh", env!("CARGO_BIN_EXE_clearance")])
            .args(arguments)
            .current_dir(folder.path("."))
            .stdout(stdout)
            .output()
            .unwrap()
    };
    let motion = ["motion", "--urdf", "r.urdf", "--from", "joint1=0", "--to", TO, "--certificate", "c.json"];
    assert_fails(&limited(&motion, Stdio::piped()), 2, "c.json: cannot be written: File too large");
    let file = std::fs::File::create(folder.path("out.txt")).unwrap();
    let check = ["check", "--urdf", "r.urdf", "--state", TO];
    assert_fails(&limited(&check, file.into()), 3, "File too large");
}
