//! `clearance doctor`: reports the faults of this machine and its ROS network, one line each.

use std::time::Duration;

use clap::Args;
use clearance_ros::{DoctorOptions, Finding, RosArguments, Verdict};
use log::LevelFilter;

use super::exit_status::ExitStatus;
use super::failure::Failure;
use super::model_args::RobotArgs;
use super::node::failure;
use super::run_args::{Format, internal, print_line};

/// Without --urdf the robot description is received from the topic `robot_description`.
///
/// Exit codes: 0 no fault; 1 at least one fault; 2 bad input.
#[derive(Args)]
pub struct DoctorArgs {
    #[command(flatten)]
    robot: RobotArgs,

    /// Duration of listening to topics, in seconds
    #[arg(long, value_name = "S", default_value_t = 5.0)]
    wait: f64,

    /// How the findings are written
    #[arg(long, value_enum, default_value_t = Format::Text)]
    format: Format,

    /// ROS arguments up to `--`, as of the node: -r from:=to, -p name:=value, --params-file FILE
    #[arg(long, value_name = "ARGUMENT", num_args = 0.., allow_hyphen_values = true, value_terminator = "--")]
    ros_args: Vec<String>,
}

pub fn run(args: &DoctorArgs, level: LevelFilter) -> Result<ExitStatus, Failure> {
    let duration = (Duration::try_from_secs_f64(args.wait).ok())
        .filter(|wait| (Duration::from_millis(100)..=Duration::from_secs(3600)).contains(wait))
        .ok_or_else(|| Failure::Input(format!("--wait: must be from 0.1 to 3600 s, but is {}", args.wait)))?;
    clearance_ros::start_logging(level);
    let mesh_files = args.robot.mesh_files();
    let robot = args.robot.urdf.as_ref().map(|_| args.robot.load_quietly(&mesh_files)).transpose()?;
    let arguments = RosArguments::parse(&args.ros_args).map_err(Failure::input)?;
    let mesh_model = args.robot.mesh_model();
    let options = DoctorOptions { arguments, robot, mesh_files, mesh_model, duration };
    let findings = clearance_ros::run_doctor(options).map_err(failure)?;
    match args.format {
        Format::Json => print_line(&serde_json::to_string(&findings).map_err(internal)?)?,
        Format::Text => findings.iter().try_for_each(print_finding)?,
    }
    let is_wrong = findings.iter().any(|finding| finding.verdict == Verdict::Wrong);
    Ok(ExitStatus::from(u8::from(is_wrong)))
}

fn print_finding(Finding { verdict, about, text }: &Finding) -> Result<(), Failure> {
    let verdict = match verdict {
        Verdict::Good => "ok   ",
        Verdict::Note => "note ",
        Verdict::Wrong => "WRONG",
    };
    print_line(&format!("{verdict}  {about}: {text}"))
}
