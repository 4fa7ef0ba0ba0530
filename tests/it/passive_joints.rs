//! Tests of passive joints of the SRDF: neither the planner nor the recovery from a collision moves them.

use std::process::Output;

use crate::command_line::{assert_bad_input, json};
use crate::program::Folder;

/// A ball that `act` moves along x and `pas` along z.
const ROBOT: &str = "<robot name='r'><link name='b'/><link name='s'/><link name='t'><collision><geometry>\
    <sphere radius='0.1'/></geometry></collision></link>\
    <joint name='act' type='prismatic'><parent link='b'/><child link='s'/><axis xyz='1 0 0'/>\
    <limit lower='-2' upper='2' effort='1' velocity='1'/></joint>\
    <joint name='pas' type='prismatic'><parent link='s'/><child link='t'/><axis xyz='0 0 1'/>\
    <limit lower='-2' upper='2' effort='1' velocity='1'/></joint></robot>";

const SRDF: &str = "<robot name='r'><group name='arm'><joint name='act'/><joint name='pas'/></group>\
    <passive_joint name='pas'/></robot>";

/// A wall of 0.1 m along x, 0.3 m high above and below the axis of `act`.
const WALL: &str = "world: {collision_objects: [{id: wall, \
    primitives: [{type: box, dimensions: [0.1, 10, 0.6]}], primitive_poses: [{position: [0, 0, 0]}]}]}\n";

fn folder() -> Folder {
    let folder = Folder::of(ROBOT, WALL);
    folder.write("r.srdf", SRDF);
    folder
}

fn run(folder: &Folder, command: &str, more: &[&str]) -> Output {
    folder.run(&[&[command, "--urdf", "r.urdf", "--world", "w.yaml"], more].concat())
}

#[test]
fn a_path_leaves_them_where_they_are() {
    let folder = folder();
    let plan = |ends: [&str; 2], more: &[&str]| {
        let given = ["--from", ends[0], "--to", ends[1], "--max-edges", "2000", "--format", "json"];
        run(&folder, "plan", &[&given[..], more].concat())
    };
    let (srdf, across) = (["--srdf", "r.srdf"], ["act=-1", "act=1"]);
    assert_eq!(json(&plan(across, &[]))["result"], "found", "above the wall");
    for group in [&[][..], &["--group", "arm"]] {
        let passive = [&srdf[..], group].concat();
        let under = plan(across, &passive);
        assert_eq!(under.status.code(), Some(1), "{under:?}");
        let above = plan(["act=-1 pas=0.5", "act=1"], &passive);
        assert_eq!(above.status.code(), Some(0), "{above:?}");
        assert_bad_input(
            &plan(["act=-1", "act=1 pas=0.5"], &passive),
            &["start and goal differ in pas, a passive joint of the SRDF"],
        );
    }
    assert_eq!(json(&plan(["act=-1 pas=0.5", "act=1"], &srdf))["joints"], serde_json::json!(["act"]));
}

#[test]
fn a_way_out_of_a_collision_leaves_them_where_they_are() {
    let folder = folder();
    let state = |more: &[&str]| {
        let given = ["--state", "act=0 pas=0.35", "--format", "json"];
        let result = json(&run(&folder, "recover", &[&given[..], more].concat()))["results"][0].clone();
        assert_eq!(result["result"], "found", "{result}");
        result["state"][1].as_f64().unwrap()
    };
    assert_ne!(state(&[]), 0.35, "up is nearest");
    assert_eq!(state(&["--srdf", "r.srdf"]), 0.35);
    assert_eq!(state(&["--srdf", "r.srdf", "--group", "arm"]), 0.35);
}

/// A gripper's second finger is often passive and mimics the first one.
#[test]
fn a_passive_joint_follows_the_joint_that_it_mimics() {
    let folder = folder();
    folder.write("r.urdf", &ROBOT.replace("<axis xyz='0 0 1'/>", "<axis xyz='0 0 1'/><mimic joint='act'/>"));
    let found = run(&folder, "recover", &["--srdf", "r.srdf", "--state", "act=0.05"]);
    assert_eq!(found.status.code(), Some(0), "{found:?}");
    let planned = run(&folder, "plan", &["--srdf", "r.srdf", "--from", "act=-1", "--to", "act=-0.8"]);
    assert_eq!(planned.status.code(), Some(0), "{planned:?}");
}

#[test]
fn planar_joints_do_not_move_either() {
    let folder = folder();
    folder.write(
        "r.urdf",
        &ROBOT.replace("<robot name='r'>", "<robot name='r'><link name='odom'/>").replace(
            "</robot>",
            "<joint name='base' type='planar'><parent link='odom'/><child link='b'/><axis xyz='0 0 1'/></joint></robot>",
        ),
    );
    let plan = |to: &str| run(&folder, "plan", &["--from", "act=-1", "--to", to, "--format", "json"]);
    let found = json(&plan("act=-0.8"));
    assert_eq!(found["result"], "found");
    assert_eq!(found["joints"], serde_json::json!(["act", "pas"]));
    assert_bad_input(&plan("act=-0.8 base/x=1"), &["base/x of a planar or floating joint"]);
}
