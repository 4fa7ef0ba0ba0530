//! Command line arguments for states: `--states FILE` or `--state "J=X ..."`.

use std::path::PathBuf;

use clap::Args;
use clearance::robot::{Configuration, RobotModel};

use super::failure::Failure;
use super::states;

#[derive(Args)]
#[group(required = true, multiple = false)]
pub struct StateArgs {
    /// States: JSON {"joints": [...], "states": [[...]]}, the YAML of a sensor_msgs/JointState or moveit_msgs/RobotState, or CSV with a
    /// header of joint names
    #[arg(long, value_name = "FILE")]
    states: Option<PathBuf>,

    /// One state, such as "j1=0.1 j2=-1.2"; other joints take 0, or the middle of limits that exclude 0
    #[arg(long, value_name = "J=X ...", allow_hyphen_values = true)]
    state: Option<String>,
}

impl StateArgs {
    /// The given states of a robot, at least one.
    pub fn read(&self, robot: &RobotModel) -> Result<Vec<Configuration>, Failure> {
        match (&self.states, &self.state) {
            (Some(path), _) => states::from_file(path, robot),
            (None, Some(text)) => Ok(vec![states::from_text("--state", text, robot)?]),
            (None, None) => Err(Failure::Input("give --states or --state".to_owned())),
        }
    }
}
