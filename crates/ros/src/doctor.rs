//! `clearance doctor`: listens to the ROS network for a limited time and reports the causes that keep the node from working.

mod finding;
mod hearing;
mod judging;
mod network;

use std::time::Duration;

use clearance_robot::{MeshFiles, RobotModel};
use clearance_scene::MeshModel;

use super::arguments::RosArguments;
use super::names::Names;
use super::parameter_files;
use super::parameters::Parameters;
use super::run::{NODE_NAME, NodeError};
pub use finding::{Finding, Verdict};
use finding::{bounded, wrong};
use hearing::listen;
use judging::{about_clock, about_joint_states, about_meshes, about_node, about_robot, described};
use network::{multicast, network};

/// Input of the examination.
#[derive(Debug)]
pub struct Patient {
    pub arguments: RosArguments,
    /// Robot model; if `None`, the model is received from `robot_description`.
    pub robot: Option<RobotModel>,
    pub mesh_files: MeshFiles,
    pub mesh_model: MeshModel,
    /// Time during which the doctor subscribes to topics.
    pub patience: Duration,
}

/// Runs all examinations and returns their findings.
pub fn examine(patient: Patient) -> Result<Vec<Finding>, NodeError> {
    let mut findings = Vec::new();
    let variable = |name: &str| std::env::var(name).ok();
    let environment = match network(variable, &mut findings) {
        Ok(environment) => environment,
        Err(error) => {
            findings.push(wrong("environment", error.to_string()));
            return Ok(findings);
        }
    };
    findings.push(multicast(environment.reach));
    let names = Names::new(NODE_NAME, &patient.arguments.remaps)?;
    let (parameters, _) =
        parameter_files::initial(Parameters::default(), &patient.arguments.parameters, &names)
            .map_err(|fault| NodeError::Input(fault.to_string()))?;
    let robot_is_wanted = patient.robot.is_none();
    let heard = listen(environment, &names, (robot_is_wanted, parameters.use_sim_time), patient.patience)?;
    if parameters.use_sim_time {
        findings.push(about_clock(&heard, environment));
    }
    findings.push(about_node(&heard, &names.full_node_name()));
    findings.extend(heard.complaints.iter().map(|text| wrong("peers", text.clone())));
    let robot = match patient.robot {
        Some(robot) => Some(robot),
        None => described(&heard, &patient.mesh_files, environment, &mut findings),
    };
    let robot = robot.map(|robot| robot.with_prefixes(&parameters.joint_prefix, &parameters.link_prefix));
    if let Some(robot) = &robot {
        findings.extend(about_robot(robot));
        findings.extend(about_meshes(robot, patient.mesh_model));
    }
    findings.extend(about_joint_states(
        &heard,
        (robot, patient.mesh_model),
        &parameters,
        (environment, patient.patience),
    ));
    Ok(bounded(findings))
}
