//! `clearance lint`: defects of the geometry of a robot model, and distances between its collision and visual geometry.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use clap::Args;
use clearance::lint::{
    HausdorffOptions, LargestDistance, LintOptions, LintReport, Severity, html_report, lint,
};
use clearance::robot::{MeshFiles, MeshLog, RobotModel, RobotText, VisualGeometry};
use clearance_files::input_files::{self, DESCRIPTION_LIMIT};
use clearance_files::readable_text::on_one_line;

use super::exit_status::ExitStatus;
use super::failure::Failure;
use super::model_args::RobotArgs;
use super::output_files;
use super::run_args::{internal, positive, print_line};

/// Find defects of the geometry of a robot model, and measure how well its collision geometry covers its visual geometry.
///
/// Distances are proven bounds of the largest distance of one geometry from the other. Closed meshes and primitives are solid.
///
/// Exit codes: 0 no error; 1 at least one error, or with --strict a warning; 2 bad input.
#[derive(Args)]
pub struct LintArgs {
    /// URDF file of the robot
    #[arg(long, value_name = "FILE")]
    urdf: PathBuf,

    /// Folder in which package://NAME/path is searched, as DIR/NAME/path; may be given more than once
    #[arg(long, value_name = "DIR")]
    package_path: Vec<PathBuf>,

    /// Report visual geometry farther than this out of the collision geometry, in metres
    #[arg(long, value_name = "M", default_value_t = 0.005, allow_negative_numbers = true)]
    unprotected: f64,

    /// Report collision geometry farther than this out of the visual geometry, in metres
    #[arg(long, value_name = "M", default_value_t = 0.05, allow_negative_numbers = true)]
    excess: f64,

    /// Relative gap between the bounds of a distance
    #[arg(long, value_name = "FRACTION", default_value_t = 0.001, allow_negative_numbers = true)]
    gap: f64,

    /// Time limit in seconds; the bounds of the remaining distances are valid, but wide
    #[arg(long, value_name = "S", default_value_t = 600.0, allow_negative_numbers = true)]
    deadline: f64,

    /// Exit code 1 for warnings, too
    #[arg(long)]
    strict: bool,

    /// Print JSON
    #[arg(long)]
    json: bool,

    /// Also write a page with pictures; it loads nothing from the network
    #[arg(long, value_name = "FILE")]
    html: Option<PathBuf>,
}

pub fn run(args: &LintArgs) -> Result<ExitStatus, Failure> {
    let options = args.options()?;
    output_files::check(&[Some(&args.urdf)], &[args.html.as_deref()])?;
    let robot_args = RobotArgs {
        urdf: Some(args.urdf.clone()),
        package_path: args.package_path.clone(),
        ..RobotArgs::default()
    };
    // a link without collision geometry is a finding; the warning about it would repeat that
    let meshes = MeshLog::default();
    let robot = robot_args.load_quietly(&robot_args.mesh_files().with_log(meshes.clone()))?;
    let visuals = visual_geometry(&args.urdf, &robot_args.mesh_files().with_log(meshes.clone()))?;
    output_files::check_beside_meshes(&output_files::mesh_files(&meshes), &[args.html.as_deref()])?;
    for warning in &visuals.warnings {
        log::warn!("{warning}");
    }
    let report = lint(&robot, &visuals, &options);
    if let Some(file) = &args.html {
        write_page(file, &report, &robot, &visuals)?;
    }
    if args.json {
        print_line(&serde_json::to_string_pretty(&report).map_err(internal)?)?;
    } else {
        text(&report).iter().try_for_each(|line| print_line(line))?;
    }
    let is_wrong = report.count(Severity::Error) > 0 || (args.strict && report.count(Severity::Warning) > 0);
    Ok(ExitStatus::of_answer(!is_wrong))
}

impl LintArgs {
    fn options(&self) -> Result<LintOptions, Failure> {
        Ok(LintOptions {
            unprotected: positive("--unprotected", self.unprotected)?,
            excess: positive("--excess", self.excess)?,
            hausdorff: HausdorffOptions {
                relative_gap: positive("--gap", self.gap)?,
                deadline: deadline_in(positive("--deadline", self.deadline)?),
                ..HausdorffOptions::default()
            },
        })
    }
}

/// The time in so many seconds; a time that no clock reaches is no deadline.
pub fn deadline_in(seconds: f64) -> Option<Instant> {
    Instant::now().checked_add(Duration::try_from_secs_f64(seconds).ok()?)
}

/// The visual geometry of a robot whose collision geometry is loaded.
pub fn visual_geometry(urdf: &Path, files: &MeshFiles) -> Result<VisualGeometry, Failure> {
    let text = input_files::read_text(urdf, DESCRIPTION_LIMIT).map_err(Failure::input)?;
    let text = RobotText { urdf: &text, urdf_name: urdf.to_str(), ..RobotText::default() };
    VisualGeometry::from_text(&text, files)
        .map_err(|error| Failure::Faults(error.faults.iter().map(ToString::to_string).collect()))
}

fn write_page(
    file: &Path,
    report: &LintReport,
    robot: &RobotModel,
    visuals: &VisualGeometry,
) -> Result<(), Failure> {
    let page = html_report(report, robot, visuals);
    input_files::replace(file, page.as_bytes()).map_err(Failure::input)
}

fn text(report: &LintReport) -> Vec<String> {
    let width = report.links.iter().map(|link| link.link.chars().count()).max().unwrap_or(0).max(4);
    let mut lines = vec![format!(
        "{:width$}  {:>20}  {:>20}  {:>9}  {:>9}",
        "link", "unprotected (mm)", "excess (mm)", "collision", "visual"
    )];
    let bounds = |distance: &Option<LargestDistance>| {
        distance.map_or("-".to_owned(), |distance| distance.in_millimetres(3))
    };
    for link in &report.links {
        lines.push(format!(
            "{:width$}  {:>20}  {:>20}  {:>9}  {:>9}",
            on_one_line(&link.link),
            bounds(&link.unprotected),
            bounds(&link.excess),
            link.collision_triangles,
            link.visual_triangles
        ));
    }
    for finding in &report.findings {
        let severity = match finding.severity {
            Severity::Error => "ERROR  ",
            Severity::Warning => "warning",
            Severity::Note => "note   ",
        };
        lines.push(format!("{severity}  {}", on_one_line(&finding.to_string())));
    }
    let [errors, warnings, notes] =
        [Severity::Error, Severity::Warning, Severity::Note].map(|severity| report.count(severity));
    lines
        .push(format!("{}: {errors} errors, {warnings} warnings, {notes} notes", on_one_line(&report.robot)));
    lines
}
