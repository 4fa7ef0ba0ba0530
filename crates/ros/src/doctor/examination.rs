//! Runs the checks of `clearance doctor` in order: environment, multicast, received topics, robot and joint states.

use std::time::Duration;

use clearance_robot::{MeshFiles, RobotModel};
use clearance_scene::MeshModel;

use crate::arguments::RosArguments;
use crate::doctor::finding::{Finding, bounded, wrong};
use crate::doctor::network_checks::{check_environment, check_multicast};
use crate::doctor::received_topics::receive_topics;
use crate::doctor::topic_checks::{
    JointStateCheck, check_clock, check_joint_states, check_meshes, check_node, check_robot, robot_model,
};
use crate::names::{NODE_NAME, Names};
use crate::node_error::NodeError;
use crate::parameters::parameter_files;
use crate::parameters::parameter_set::Parameters;

/// Input of the examination.
#[derive(Debug)]
pub struct DoctorOptions {
    pub arguments: RosArguments,
    /// Robot model; if `None`, the model is received from `robot_description`.
    pub robot: Option<RobotModel>,
    pub mesh_files: MeshFiles,
    pub mesh_model: MeshModel,
    /// Time during which the doctor subscribes to topics.
    pub duration: Duration,
}

/// Runs all examinations and returns their findings.
pub fn run_doctor(options: DoctorOptions) -> Result<Vec<Finding>, NodeError> {
    let mut findings = Vec::new();
    let variable = |name: &str| std::env::var(name).ok();
    let environment = match check_environment(variable, &mut findings) {
        Ok(environment) => environment,
        Err(error) => {
            findings.push(wrong("environment", error.to_string()));
            return Ok(findings);
        }
    };
    findings.push(check_multicast(environment.reach));
    let names = Names::new(NODE_NAME, &options.arguments.remaps)?;
    let (parameters, _) =
        parameter_files::initial(Parameters::default(), &options.arguments.parameters, &names)
            .map_err(|fault| NodeError::Input(fault.to_string()))?;
    let robot_is_wanted = options.robot.is_none();
    let received = receive_topics(environment, &names, robot_is_wanted, &parameters, options.duration)?;
    if parameters.use_sim_time {
        findings.push(check_clock(&received, environment));
    }
    findings.push(check_node(&received, &names.full_node_name()));
    findings.extend(received.warnings.iter().map(|text| wrong("peers", text.clone())));
    let robot = match options.robot {
        Some(robot) => Some(robot),
        None => robot_model(&received, &options.mesh_files, environment, &mut findings),
    };
    let robot = robot.map(|robot| robot.with_prefixes(&parameters.joint_prefix, &parameters.link_prefix));
    if let Some(robot) = &robot {
        findings.extend(check_robot(robot));
        findings.extend(check_meshes(robot, options.mesh_model));
    }
    findings.extend(check_joint_states(JointStateCheck {
        received: &received,
        robot,
        mesh_model: options.mesh_model,
        parameters: &parameters,
        environment,
        duration: options.duration,
    }));
    Ok(bounded(findings))
}
