//! Benchmark: time of `is_free` through the C interface and through the Rust library, on one core.

use std::ffi::c_char;
use std::path::Path;
use std::ptr;
use std::sync::Arc;
use std::time::Instant;

use clearance::{CollisionChecker, Configuration, MeshFiles, RobotModel, SceneLoader, Settings, World};
use clearance_c::checker::{clearance_checker, clearance_checker_new};
use clearance_c::robot::{clearance_robot, clearance_robot_from_urdf};
use clearance_c::state_queries::clearance_checker_is_free;
use clearance_c::status::clearance_status;
use clearance_c::structs::clearance_state;
use clearance_c::workspace::{clearance_workspace, clearance_workspace_new};
use clearance_c::world::clearance_world_from_file;

const STATES: usize = 2000;
const ROUNDS: usize = 101;

const URDF: &std::ffi::CStr = c"urdf/demo_arm/demo_arm.urdf";
const SRDF: &std::ffi::CStr = c"urdf/demo_arm/demo_arm.srdf";
const WORLD: &std::ffi::CStr = c"config/demo_world.yaml";

fn main() {
    std::env::set_current_dir(concat!(env!("CARGO_MANIFEST_DIR"), "/../..")).expect("there is a root");
    let robot = RobotModel::load(Path::new("urdf/demo_arm/demo_arm.urdf"), None, &[]).expect("sound");
    for (name, has_world) in [("demo arm in its world", true), ("demo arm alone", false)] {
        measure(name, &robot, has_world);
    }
}

fn measure(name: &str, robot: &RobotModel, has_world: bool) {
    let mut random = fastrand::Rng::with_seed(1);
    let states: Vec<Configuration> = (0..STATES).map(|_| robot.random_configuration(&mut random)).collect();
    let checker = rust_checker(has_world);
    let mut workspace = checker.workspace();
    let (c_checker, c_workspace) = c_checker(has_world);
    let mut of_rust = || states.iter().filter(|q| checker.is_free(q, &mut workspace)).count();
    let of_c = || states.iter().filter(|q| is_free_by_c(c_checker, c_workspace, q.positions())).count();
    assert_eq!(of_rust(), of_c(), "both find the same states free");
    let (mut rust, mut c, mut more) = (Vec::new(), Vec::new(), Vec::new());
    for _ in 0..ROUNDS {
        // alternately, so that both meet the same machine
        rust.push(nanoseconds(&mut of_rust));
        c.push(nanoseconds(of_c));
        more.push(c[c.len() - 1] - rust[rust.len() - 1]);
    }
    let [rust, c, more] = [rust, c, more].map(median);
    println!(
        "{name}: Rust {rust:.0} ns, C {c:.0} ns, {more:+.0} ns a call (medians of {ROUNDS} rounds of {STATES} states)"
    );
}

fn nanoseconds(mut run: impl FnMut() -> usize) -> f64 {
    let begin = Instant::now();
    std::hint::black_box(run());
    #[allow(clippy::cast_precision_loss)] // a few thousand
    let count = STATES as f64;
    begin.elapsed().as_secs_f64() * 1e9 / count
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

fn rust_checker(has_world: bool) -> CollisionChecker {
    let file = |name: &std::ffi::CStr| name.to_str().expect("a path").to_owned();
    let (urdf, srdf) = (file(URDF), file(SRDF));
    let robot = RobotModel::load(Path::new(&urdf), Some(Path::new(&srdf)), &[]).expect("the robot is sound");
    let mut loader = SceneLoader::default();
    if has_world {
        let bytes = std::fs::read(file(WORLD)).expect("there is a world");
        let read = loader.read_file(&bytes, Path::new(&file(WORLD)), None, &robot, &MeshFiles::default());
        read.expect("the world is sound");
    }
    let world: World = loader.into_scene().world;
    CollisionChecker::new(Arc::new(robot), &world, Settings::default()).expect("the settings are sound")
}

fn c_checker(has_world: bool) -> (*const clearance_checker, *mut clearance_workspace) {
    let (mut robot, mut world) = (ptr::null_mut::<clearance_robot>(), ptr::null_mut());
    let (mut checker, mut workspace) = (ptr::null_mut(), ptr::null_mut());
    let no_folders: *const *const c_char = ptr::null();
    check(clearance_robot_from_urdf(URDF.as_ptr(), SRDF.as_ptr(), no_folders, 0, &raw mut robot));
    if has_world {
        check(clearance_world_from_file(WORLD.as_ptr(), robot, 0.0, 0, &raw mut world));
    }
    check(clearance_checker_new(robot, world, ptr::null(), &raw mut checker));
    check(clearance_workspace_new(checker, &raw mut workspace));
    (checker, workspace)
}

fn is_free_by_c(checker: *const clearance_checker, workspace: *mut clearance_workspace, q: &[f64]) -> bool {
    let mut is_free = false;
    let state = clearance_state { positions: q.as_ptr(), n: q.len() };
    check(clearance_checker_is_free(checker, workspace, state, &raw mut is_free));
    is_free
}

fn check(status: clearance_status) {
    assert_eq!(status, clearance_status::Ok);
}
