//! CPU time of state checks in Rust, for `benches/planning/run.py`: `states URDF SRDF PACKAGES WORLD STATES`.
//!
//! `STATES` has positions of all joints of the robot, native `f64`, row by row. Output: the number of free states, then
//! CPU time (s) of the process for a batch on one thread, on all threads, for one call a state, and for a batch on one
//! thread with the validation of the rows; the fastest of some passes. The others begin with validated states.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use clearance::{CollisionChecker, Configuration, MeshFiles, RobotModel, SceneLoader, Settings};
use cpu_time::ProcessTime;

const PASSES: usize = 5;

/// Number of rows that are validated at a time.
const BLOCK: usize = 256;

fn main() {
    let arguments: Vec<PathBuf> =
        std::env::args_os().skip(1).filter(|a| a != "--bench").map(Into::into).collect();
    let [urdf, srdf, packages, world, states] = &arguments[..] else {
        eprintln!("states URDF SRDF PACKAGES WORLD STATES; see benches/planning/README.md");
        return;
    };
    let checker = checker([urdf, srdf, packages, world]);
    let rows = rows(checker.robot(), states);
    let states: Vec<Configuration> =
        rows.iter().map(|row| checker.robot().configuration(row).expect("valid positions")).collect();
    let mut workspace = checker.workspace();
    let mut free = vec![false; states.len()];
    let one_thread = fastest(|| checker.are_free_with(&states, &mut workspace, &mut free));
    let all_threads = fastest(|| free = checker.are_free(&states));
    let single = fastest(|| {
        free = states.iter().map(|q| checker.is_free(q, &mut workspace)).collect();
    });
    let mut block = states[..BLOCK.min(states.len())].to_vec();
    let from_rows = fastest(|| {
        for (rows, free) in rows.chunks(BLOCK).zip(free.chunks_mut(BLOCK)) {
            for (row, q) in rows.iter().zip(&mut block) {
                checker.robot().configuration_into(row, q).expect("valid positions");
            }
            checker.are_free_with(&block[..rows.len()], &mut workspace, free);
        }
    });
    let count = free.iter().filter(|is_free| **is_free).count();
    println!("{count} {one_thread} {all_threads} {single} {from_rows}");
}

fn checker([urdf, srdf, packages, world]: [&PathBuf; 4]) -> CollisionChecker {
    let packages = std::slice::from_ref(packages);
    let robot = RobotModel::load(urdf, Some(srdf), packages).expect("the robot is sound");
    let mut loader = SceneLoader::default();
    let bytes = std::fs::read(world).expect("there is a world");
    let folder: &Path = world;
    loader.read_file(&bytes, folder, None, &robot, &MeshFiles::default()).expect("the world is sound");
    CollisionChecker::new(Arc::new(robot), &loader.into_scene().world, Settings::default())
        .expect("sound settings")
}

fn rows(robot: &RobotModel, file: &Path) -> Vec<Vec<f64>> {
    let bytes = std::fs::read(file).expect("there are states");
    let number = |b: &[u8]| f64::from_ne_bytes(b.try_into().expect("8 bytes"));
    let row_size = 8 * robot.default_configuration().positions().len();
    bytes.chunks_exact(row_size).map(|row| row.chunks_exact(8).map(number).collect()).collect()
}

/// CPU time (s) of the process.
fn fastest(mut run: impl FnMut()) -> f64 {
    let times = (0..PASSES).map(|_| {
        let begin = ProcessTime::now();
        run();
        begin.elapsed().as_secs_f64()
    });
    times.fold(f64::INFINITY, f64::min)
}
