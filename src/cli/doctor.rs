//! `clearance doctor`: reports the faults of this machine and its ROS network, one line each.

use std::time::Duration;

use clap::Args;
use clearance::lint::{HausdorffOptions, LintOptions, LintReport, Severity, lint};
use clearance::robot::RobotModel;
use clearance_files::readable_text::on_one_line;
use clearance_ros::{DoctorOptions, Finding, RosArguments, Verdict};
use log::LevelFilter;

use super::exit_status::ExitStatus;
use super::failure::Failure;
use super::lint::{deadline_in, visual_geometry};
use super::model_args::RobotArgs;
use super::node::failure;
use super::run_args::{Format, internal, print_line};

/// Without --urdf the robot description is received from the topic `robot_description`. With --urdf, the geometry of the robot is checked, too,
/// for at most 10 s: `clearance lint` lists the findings.
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
    let geometry = robot.as_ref().and_then(|robot| geometry_finding(robot, &args.robot));
    let arguments = RosArguments::parse(&args.ros_args).map_err(Failure::input)?;
    let mesh_model = args.robot.mesh_model();
    let options = DoctorOptions { arguments, robot, mesh_files, mesh_model, duration };
    let mut findings = clearance_ros::run_doctor(options).map_err(failure)?;
    findings.extend(geometry);
    match args.format {
        Format::Json => print_line(&serde_json::to_string(&findings).map_err(internal)?)?,
        Format::Text => findings.iter().try_for_each(print_finding)?,
    }
    let is_wrong = findings.iter().any(|finding| finding.verdict == Verdict::Wrong);
    Ok(ExitStatus::of_answer(!is_wrong))
}

/// Time limit (s) of the checks of a robot's geometry.
const GEOMETRY_DEADLINE: f64 = 10.0;

/// Summary of the checks of a robot's geometry; `clearance lint` lists them.
fn geometry_finding(robot: &RobotModel, args: &RobotArgs) -> Option<Finding> {
    let urdf = args.urdf.as_ref()?;
    let hausdorff =
        HausdorffOptions { deadline: deadline_in(GEOMETRY_DEADLINE), ..HausdorffOptions::default() };
    let options = LintOptions { hausdorff, ..LintOptions::default() };
    let visuals = match visual_geometry(urdf, &args.mesh_files()) {
        Ok(visuals) => visuals,
        Err(failure) => {
            let text = on_one_line(&format!("visual geometry: {failure}")).into_owned();
            return Some(Finding { verdict: Verdict::Wrong, about: "geometry".to_owned(), text });
        }
    };
    let report: LintReport = lint(robot, &visuals, &options);
    let [errors, warnings] = [Severity::Error, Severity::Warning].map(|severity| report.count(severity));
    let verdict = match (errors, warnings) {
        (0, 0) => Verdict::Good,
        (0, _) => Verdict::Note,
        _ => Verdict::Wrong,
    };
    let first = match report.findings.first().filter(|_| verdict != Verdict::Good) {
        Some(first) => format!(", the first: {first}; `clearance lint --urdf {}` lists all", urdf.display()),
        None => String::new(),
    };
    let text = on_one_line(&format!("{errors} errors, {warnings} warnings{first}")).into_owned();
    Some(Finding { verdict, about: "geometry".to_owned(), text })
}

fn print_finding(Finding { verdict, about, text }: &Finding) -> Result<(), Failure> {
    let verdict = match verdict {
        Verdict::Good => "ok   ",
        Verdict::Note => "note ",
        Verdict::Wrong => "WRONG",
    };
    print_line(&format!("{verdict}  {about}: {text}"))
}
