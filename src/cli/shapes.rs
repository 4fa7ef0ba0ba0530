//! `clearance spheres --shape capsules` and `--shape boxes`: files and report of shapes that contain the links.

use clearance::covers::{self, CoverShape, LinkShapes, ShapeCover, ShapeKind, ShapeSize};
use clearance::robot::RobotModel;
use clearance_files::input_files::{self, DESCRIPTION_LIMIT};
use clearance_files::readable_text::on_one_line;
use serde::Serialize;

use super::exit_status::ExitStatus;
use super::failure::Failure;
use super::run_args::{Format, internal, print_line};
use super::spheres::{SpheresArgs, at_most, millimetres, note_of_time};

/// Output in JSON format.
#[derive(Serialize)]
struct ShapesOutput {
    robot: String,
    shape: &'static str,
    shapes: usize,
    /// Proven bound (m).
    largest_excess: f64,
    /// True if `--deadline` ended the search of a link.
    ended_by_time: bool,
    links: Vec<LinkOutput>,
}

#[derive(Serialize)]
struct LinkOutput {
    link: String,
    /// Lower and upper bound (m).
    excess: [f64; 2],
    ended_by_time: bool,
    shapes: Vec<ShapeOutput>,
}

/// Lengths (m) and coordinates (m, rad) in the link frame.
#[derive(Serialize)]
#[serde(untagged)]
enum ShapeOutput {
    Capsule { ends: [[f64; 3]; 2], radius: f64 },
    Box { centre: [f64; 3], rpy: [f64; 3], size: [f64; 3] },
}

impl From<&CoverShape> for ShapeOutput {
    fn from(shape: &CoverShape) -> Self {
        let xyz = |p: clearance::geometry::math::Point| [p.x, p.y, p.z];
        match shape.size {
            ShapeSize::Capsule { radius, .. } => {
                Self::Capsule { ends: [-1.0, 1.0].map(|side| xyz(shape.end(side))), radius }
            }
            ShapeSize::Box { half_extents } => {
                let size = half_extents.map(|half| 2.0 * half);
                Self::Box { centre: xyz(shape.centre), rpy: shape.rpy, size }
            }
        }
    }
}

/// Writes the URDF, and reports the shapes.
pub fn write(
    args: &SpheresArgs,
    robot: &RobotModel,
    kind: ShapeKind,
    cover: &ShapeCover,
) -> Result<ExitStatus, Failure> {
    if let (Some(file), Some(urdf)) = (&args.sphere_urdf, &args.robot.urdf) {
        let text = input_files::read_text(urdf, DESCRIPTION_LIMIT).map_err(Failure::input)?;
        let text = covers::shape_urdf(robot, cover, &text).map_err(Failure::input)?;
        input_files::replace(file, text.as_bytes()).map_err(Failure::input)?;
    }
    print_line(&match args.format {
        Format::Text => text(robot, kind, cover),
        Format::Json => json(robot, plural(kind), cover)?,
    })?;
    Ok(ExitStatus::SUCCESS)
}

fn plural(kind: ShapeKind) -> &'static str {
    match kind {
        ShapeKind::Capsule => "capsules",
        ShapeKind::Box => "boxes",
    }
}

/// A number of shapes with their name.
fn counted(count: usize, kind: ShapeKind) -> String {
    match (count, kind) {
        (1, ShapeKind::Capsule) => "1 capsule".to_owned(),
        (1, ShapeKind::Box) => "1 box".to_owned(),
        _ => format!("{count} {}", plural(kind)),
    }
}

fn text(robot: &RobotModel, kind: ShapeKind, cover: &ShapeCover) -> String {
    let line = |link: &LinkShapes| {
        let name = on_one_line(&robot.link(link.link).name);
        format!("{name}: {}, excess {}\n", counted(link.shapes.len(), kind), millimetres(link.excess))
    };
    let lines: String = cover.links.iter().map(line).collect();
    let note = note_of_time(cover.links.iter().filter(|link| link.is_cut).count(), "excess");
    format!(
        "{lines}{}: {}, proven to contain the links; excess at most {} mm, proven{note}",
        on_one_line(robot.name()),
        counted(cover.count(), kind),
        at_most(cover.largest_excess()),
    )
}

fn json(robot: &RobotModel, what: &'static str, cover: &ShapeCover) -> Result<String, Failure> {
    let link = |link: &LinkShapes| LinkOutput {
        link: robot.link(link.link).name.clone(),
        excess: link.excess,
        ended_by_time: link.is_cut,
        shapes: link.shapes.iter().map(|(shape, _)| ShapeOutput::from(shape)).collect(),
    };
    let output = ShapesOutput {
        robot: robot.name().to_owned(),
        shape: what,
        shapes: cover.count(),
        largest_excess: cover.largest_excess(),
        ended_by_time: cover.is_cut(),
        links: cover.links.iter().map(link).collect(),
    };
    serde_json::to_string(&output).map_err(internal)
}
