//! `clearance` without a command: runs the node with a built-in robot, world and motion, and shows a live table.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, mpsc};

use clearance::robot::{MeshFiles, RobotModel, RobotText};
use clearance::scene::SceneLoader;
use clearance_ros::{
    CommandLineInputs, Environment, Motion, NodeOptions, Parameters, Reach, RosArguments, Startup,
    Surroundings, ThreadPriority, Trajectory, View,
};
use log::LevelFilter;

use super::demo_table::{Latest, Table};
use super::exit_status::ExitStatus;
use super::failure::Failure;
use super::node::{announce, failure};
use super::view_args::ViewArgs;

const URDF: &str = include_str!("../../urdf/demo_arm/demo_arm.urdf");
const SRDF: &str = include_str!("../../urdf/demo_arm/demo_arm.srdf");
const WORLD: &str = include_str!("../../config/demo_world.yaml");
const MOTION: &str = include_str!("../../config/demo_motion.yaml");

macro_rules! meshes {
    ($($name:literal)*) => {
        &[$(($name, include_bytes!(concat!("../../urdf/demo_arm/", $name)))),*]
    };
}

const MESHES: &[(&str, &[u8])] = meshes! {
    "meshes/base.stl" "meshes/link1.stl" "meshes/link2.stl" "meshes/link3.stl" "meshes/link4.stl"
    "meshes/link5.stl" "meshes/link6.stl" "meshes/link7.stl" "meshes/hand.stl" "meshes/finger.stl"
};

/// Runs the demo until it is stopped.
pub fn run(view: ViewArgs, level: LevelFilter) -> Result<ExitStatus, Failure> {
    clearance_ros::start_logging(level);
    let startup = Startup::begin(Parameters::default().memory_limit).map_err(failure)?;
    // the demo must be invisible to other machines and must not disturb them
    let environment =
        Environment { reach: Reach::Localhost, ..Environment::of_process().map_err(Failure::input)? };
    let announcement = announce(environment, ThreadPriority::Normal)?;
    let robot = robot().map_err(Failure::Internal)?;
    let motion = Trajectory::from_yaml(MOTION)
        .map_err(|e| Failure::Internal(format!("config/demo_motion.yaml: {e}")))?;

    let domain = announcement.environment().domain;
    let opened = view.open()?;
    let announce_view = view.announcement(opened.as_ref());
    let mut show = opened.as_ref().map(View::observer);
    let latest = Latest::default();
    let ended = Arc::new(AtomicBool::new(false));
    let (started, table) = mpsc::channel();
    let on_start = {
        let (latest, ended) = (latest.clone(), Arc::clone(&ended));
        move || {
            announce_view();
            // cannot fail: the receiver exists below
            let _ = started.send(Table::start(latest, ended, domain));
        }
    };
    let result = clearance_ros::run(NodeOptions {
        startup,
        announcement,
        arguments: RosArguments::default(),
        parameters: Parameters::default(),
        robot: Some(robot),
        mesh_files: MeshFiles::default(),
        surroundings: surroundings(),
        mesh_model: clearance::scene::MeshModel::Surface,
        motion: Some(Motion::Trajectory(motion)),
        observer: Some(Box::new(move |evaluation, settings| {
            latest.note(evaluation);
            if let Some(show) = &mut show {
                show(evaluation, settings);
            }
        })),
        on_start: Some(Box::new(on_start)),
        command_line: CommandLineInputs::default(),
    });
    ended.store(true, Ordering::Relaxed);
    if let Ok(table) = table.try_recv() {
        table.finish();
    }
    result.map_err(failure)?;
    Ok(ExitStatus::SUCCESS)
}

fn robot() -> Result<RobotModel, String> {
    let text = RobotText {
        urdf: URDF,
        urdf_name: Some("urdf/demo_arm/demo_arm.urdf"),
        srdf: Some(SRDF),
        srdf_name: Some("urdf/demo_arm/demo_arm.srdf"),
    };
    RobotModel::from_text(&text, &MeshFiles::embedded(MESHES)).map_err(|e| e.to_string())
}

fn surroundings() -> Surroundings {
    Box::new(|robot| {
        let file = "config/demo_world.yaml";
        let loader = SceneLoader::from_yaml(WORLD, file, robot, &MeshFiles::default());
        Ok(loader.map_err(|e| e.to_string())?.into_scene())
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_the_program_carries_is_sound() {
        let robot = robot().unwrap();
        assert_eq!(robot.warnings(), []);
        assert!(!surroundings()(&robot).unwrap().world.is_empty());
        Trajectory::from_yaml(MOTION).unwrap();
    }
}
