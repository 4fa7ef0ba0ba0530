//! Tests of options of the program: unnamed joints, options without effect, limits, misspelt options.

use std::process::Output;

use crate::command_line::{TWO_LINK, assert_bad_input, json};
use crate::program::{Folder, clearance};

const ROBOT: &str = include_str!("../../urdf/two_link/two_link.urdf");

/// A ball far from the robot.
const WORLD: &str = "world: {collision_objects: [{id: o, pose: {position: [5, 0, 0]}, \
    primitives: [{type: sphere, dimensions: [0.1]}]}]}\n";

/// A ball at the end of an arm that turns by `j` and is `p` long.
const ARM: &str = "<robot name='r'><link name='b'/><link name='s'/><link name='t'><collision><geometry>\
    <sphere radius='0.1'/></geometry></collision></link>\
    <joint name='j' type='revolute'><parent link='b'/><child link='s'/><axis xyz='0 0 1'/>\
    <limit lower='-3' upper='3' effort='1' velocity='1'/></joint>\
    <joint name='p' type='prismatic'><parent link='s'/><child link='t'/><axis xyz='1 0 0'/>\
    <limit lower='0' upper='2' effort='1' velocity='1'/></joint></robot>";

/// A ball at `j` = 1 rad, `p` = 1 m.
const POST: &str = "world: {collision_objects: [{id: post, header: {frame_id: b}, \
    primitives: [{type: sphere, dimensions: [0.1]}], \
    primitive_poses: [{position: [0.5403023058681398, 0.8414709848078965, 0]}]}]}\n";

fn warnings(output: &Output) -> String {
    assert_eq!(output.status.code(), Some(0), "{output:?}");
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// The help of a command, on one line.
fn help(command: &str) -> String {
    let output = clearance(&[command, "--help"]);
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

#[test]
fn joints_that_the_end_does_not_name_stay_where_the_start_has_them() {
    let folder = Folder::of(ARM, POST);
    let way = ["--urdf", "r.urdf", "--world", "w.yaml", "--from", "p=1 j=0", "--to"];
    let run = |command: &str, more: &[&str]| folder.run(&[&[command], &way[..], more].concat());
    let result = |to: &str| json(&run("motion", &[to, "--format", "json"]))["results"][0].clone();
    let extended = result("j=1.5");
    assert_eq!(extended["verdict"], "contact", "{extended}");
    // the balls touch where they are 0.2 m apart on a circle of radius 1 m
    let touch = (1.0 - 2.0 * 0.1_f64.asin()) / 1.5;
    assert!((extended["t"][1].as_f64().unwrap() - touch).abs() < 0.01, "{extended}");
    assert_eq!(extended, result("p=1 j=1.5"));
    assert_eq!(result("p=0 j=1.5")["verdict"], "free");
    // a certificate of the motion to the default is none of this motion
    let written = run("motion", &["p=0 j=1.5", "--certificate", "c.json"]);
    assert_eq!(written.status.code(), Some(0), "{written:?}");
    let verified = |to: &str| run("verify", &[to, "c.json"]).status.code();
    assert_eq!([verified("p=0 j=1.5"), verified("j=1.5")], [Some(0), Some(1)]);
    for command in ["motion", "verify"] {
        assert!(help(command).contains("joints that are not named stay where --from has them"));
    }
    assert!(help("plan").contains("take 0, or the middle of limits that exclude 0"));
}

#[test]
fn paddings_without_effect_are_warned_of() {
    let folder = Folder::of(ROBOT, WORLD);
    let check = |more: &[&str]| {
        let output = folder.run(&[&["check", "--urdf", "r.urdf", "--state", ""], more].concat());
        warnings(&output)
    };
    let (world, padding) = (["--world", "w.yaml"], ["--padding", "0.001"]);
    let padded = |more: &[&str]| check(&[&world[..], &padding, more].concat());
    assert!(
        padded(&["--no-world"])
            .contains("--padding has no effect: --no-world is given, and --pad-self is not given")
    );
    let without_self = check(&[&padding[..], &["--pad-self", "--no-self"]].concat());
    assert!(
        without_self.contains("--pad-self has no effect with --no-self")
            && without_self.contains("--padding has no effect: there is no world, and --no-self is given"),
        "{without_self}"
    );
    assert!(padded(&["--no-self", "--pad-self"]).contains("--pad-self has no effect with --no-self"));
    assert!(check(&["--pad-self"]).contains("--pad-self has no effect without --padding"));
    for (options, kept) in
        [(&[][..], "world"), (&["--no-self"], "world"), (&["--pad-self", "--no-world"], "self")]
    {
        assert_eq!(padded(options), "", "pairs of the {kept} are padded");
    }
    folder.write("w.yaml", &format!("link_padding: [{{link_name: tip, padding: 0.001}}]\n{WORLD}"));
    assert_eq!(check(&[&world[..], &["--pad-self"]].concat()), "");
}

#[test]
fn options_that_exclude_each_other_are_rejected() {
    let folder = Folder::of(ROBOT, WORLD);
    folder.write("m.yaml", "moving_obstacles: [{name: o, linear: [0, 1, 0]}]\n");
    folder.write("c.json", "{}");
    let in_world = ["--urdf", "r.urdf", "--world", "w.yaml"];
    let run = |command: &str, more: &[&str]| folder.run(&[&[command], &in_world[..], more].concat());
    let moving = ["--from", "", "--to", "joint1=0.1", "--moving", "m.yaml"];
    assert_eq!(run("motion", &moving).status.code(), Some(0));
    for (command, more) in [("motion", &["--no-world"][..]), ("verify", &["--no-world", "c.json"])] {
        let output = run(command, &[&moving[..], more].concat());
        assert_bad_input(&output, &["--moving has no effect with --no-world"]);
    }
    assert_bad_input(&run("bench", &["--obstacles", "5", "--states", "2"]), &["--obstacles has no effect"]);
    folder.write("w.yaml", "world: {collision_objects: []}\n");
    assert_eq!(run("bench", &["--obstacles", "5", "--states", "2"]).status.code(), Some(0));
}

#[test]
fn an_srdf_that_is_written_nowhere_is_warned_of() {
    let folder = Folder::of(ROBOT, WORLD);
    folder.write("r.srdf", "<robot name='two_link'/>");
    let cover = |more: &[&str]| {
        let given = ["spheres", "--urdf", "r.urdf", "--srdf", "r.srdf", "--count", "1"];
        warnings(&folder.run(&[&given, more].concat()))
    };
    assert!(cover(&[]).contains("--srdf has no effect without --xrdf"));
    assert!(!cover(&["--xrdf", "r.xrdf"]).contains("has no effect"));
}

#[test]
fn states_beyond_limits_are_warned_of_by_every_command_that_takes_one() {
    let outside = "'joint1' is at 90, outside its limits";
    let run = |command: &str, more: &[&str]| {
        let output = clearance(&[&[command], &TWO_LINK[..], &["--state", "joint1=90"], more].concat());
        String::from_utf8_lossy(&output.stderr).into_owned()
    };
    assert!(run("recover", &[]).contains(outside));
    // an address of no machine: the command ends
    assert!(run("view", &["--address", "192.0.2.1:8642"]).contains(outside));
}

#[test]
fn a_joint_beyond_limits_outside_of_the_group_is_warned_of() {
    let folder = Folder::of(ROBOT, WORLD);
    folder.write("r.srdf", "<robot name='two_link'><group name='arm'><joint name='joint2'/></group></robot>");
    let ends = ["--group", "arm", "--from", "joint1=90", "--to", "joint2=0.1"];
    let planned = folder.run(&[&["plan", "--urdf", "r.urdf", "--srdf", "r.srdf"], &ends[..]].concat());
    let message = String::from_utf8_lossy(&planned.stderr);
    assert!(message.contains("'joint1' is at 90, outside its limits"), "{planned:?}");
}

#[test]
fn a_motion_within_the_margin_is_called_so() {
    let folder = Folder::of(ROBOT, WORLD);
    let motion = ["motion", "--urdf", "r.urdf", "--from", "", "--to", "joint1=0.1"];
    let output = folder.run(&[&motion[..], &["--margin", "1", "--certificate", "c.json"]].concat());
    let message = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{message}");
    assert!(message.contains("the way is within the margin: no certificate"), "{message}");
}

#[test]
fn a_misspelt_option_after_a_state_is_not_a_part_of_the_state() {
    let output = clearance(&[&["check"], &TWO_LINK[..], &["--state", "", "--threds", "2"]].concat());
    assert_bad_input(&output, &["'--threds'", "--threads"]);
    assert!(!String::from_utf8_lossy(&output.stderr).contains("quote"), "{output:?}");
}
