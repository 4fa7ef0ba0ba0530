//! `clearance spheres`: covers links with spheres, capsules or boxes, simplifies meshes, or measures a sphere model.

use std::path::{Path, PathBuf};
use std::time::Instant;

use clap::Args;
use clearance::covers::{
    self, CoverSize, LinkCover, MeasuredCover, MeasuredLink, SearchLimit, ShapeKind, SphereCover,
};
use clearance::geometry::math::Extremes;
use clearance::robot::{LinkId, MeshLog, RobotModel};
use clearance_files::input_files::{self, DESCRIPTION_LIMIT};
use clearance_files::readable_text::on_one_line;
use serde::Serialize;

use super::exit_status::ExitStatus;
use super::failure::Failure;
use super::lint::deadline_in;
use super::meshes;
use super::model_args::RobotArgs;
use super::output_files;
use super::progress::Progress;
use super::rounded_bounds;
use super::run_args::{Format, internal, positive, print_line};
use super::shapes;

/// Cover the links of a robot with spheres, capsules or boxes that are proven to contain them, simplify its collision meshes with a proven
/// error, or measure a model of spheres.
///
/// The spheres of a link contain all triangles of its collision geometry and the inside of closed meshes and primitives. The excess is the
/// largest distance of a point of the spheres from the link: its upper bound is proven.
///
/// Exit codes: 0 done; 1 if --deadline ended the search above --excess or, with --measure, if a part of the surface is certainly in no
/// sphere; 2 bad input.
#[derive(Args)]
pub struct SpheresArgs {
    #[command(flatten)]
    pub robot: RobotArgs,

    /// Kind of the shapes; capsules and boxes need --count, meshes need --count (triangles of a link) or --excess (distance of both
    /// surfaces); all of them have no --curobo and --xrdf
    #[arg(long, value_enum, default_value_t = ShapeArg::Spheres)]
    shape: ShapeArg,

    #[command(flatten)]
    size: SizeArgs,

    /// Spheres inside of the links, instead of spheres around them; --excess is then the depth (m) of points that may be left out
    #[arg(long, conflicts_with_all = ["total", "measure"])]
    inner: bool,

    /// End the search after this time, in seconds, with the best spheres that are proven by then
    #[arg(long, value_name = "SECONDS", conflicts_with = "measure", allow_negative_numbers = true)]
    deadline: Option<f64>,

    /// Write cuRobo's `collision_spheres` to this YAML file
    #[arg(long, value_name = "FILE", conflicts_with = "measure")]
    curobo: Option<PathBuf>,

    /// Write an XRDF file for Isaac; check its limits and tool frames, which URDF does not have
    #[arg(long, value_name = "FILE", conflicts_with = "measure")]
    xrdf: Option<PathBuf>,

    /// Write the URDF with the spheres as collision geometry, as VAMP and foam read it; a capsule is a cylinder and two spheres; simplified
    /// meshes are STL files in a folder beside it, which has its name and `_meshes`
    #[arg(long, visible_alias = "shape-urdf", value_name = "FILE", conflicts_with = "measure")]
    pub sphere_urdf: Option<PathBuf>,

    /// Output format
    #[arg(long, value_enum, default_value_t = Format::Text)]
    pub format: Format,
}

/// Kinds of shapes.
#[derive(clap::ValueEnum, Clone, Copy, Debug, PartialEq, Eq)]
enum ShapeArg {
    Spheres,
    Capsules,
    Boxes,
    /// Simplified collision meshes
    Mesh,
}

/// How many spheres.
#[derive(Args, Clone, Debug)]
#[group(required = true, multiple = false)]
struct SizeArgs {
    /// At most this many spheres for each link; with --shape mesh, triangles
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    count: Option<usize>,

    /// At most this many spheres for the whole robot
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    total: Option<usize>,

    /// As few spheres, or triangles, as are found for this largest excess, in metres
    #[arg(long, value_name = "M", allow_negative_numbers = true)]
    excess: Option<f64>,

    /// As many spheres for each link as in this URDF, whose collision geometry is spheres
    #[arg(long, value_name = "FILE")]
    counts_of: Option<PathBuf>,

    /// Measure the spheres of this URDF, whose collision geometry is spheres
    #[arg(long, value_name = "FILE")]
    measure: Option<PathBuf>,
}

/// Output in JSON format.
#[derive(Serialize)]
struct CoverOutput {
    robot: String,
    /// `outer` or `inner`.
    cover: &'static str,
    spheres: usize,
    /// Proven bound (m): largest excess of an outer cover, largest depth left out of an inner cover.
    largest_error: f64,
    /// True if `--deadline` ended the search of a link.
    ended_by_time: bool,
    seconds: f64,
    links: Vec<LinkOutput>,
}

#[derive(Serialize)]
struct LinkOutput {
    link: String,
    /// Lower and upper bound (m).
    error: [f64; 2],
    ended_by_time: bool,
    /// `[x, y, z, radius]` (m) in the link frame.
    spheres: Vec<[f64; 4]>,
}

/// Measurement in JSON format.
#[derive(Serialize)]
struct MeasureOutput {
    link: String,
    spheres: usize,
    /// Lower and upper bound (m²).
    uncovered_area: [f64; 2],
    surface_area: f64,
    /// Lower and upper bound (m).
    excess: [f64; 2],
}

pub fn run(args: &SpheresArgs) -> Result<ExitStatus, Failure> {
    args.size.excess.map(|m| positive("--excess", m)).transpose()?;
    let deadline = args.deadline.map(|s| positive("--deadline", s)).transpose()?;
    let inputs = [&args.robot.urdf, &args.robot.srdf, &args.size.counts_of, &args.size.measure];
    let outputs = [&args.curobo, &args.xrdf, &args.sphere_urdf].map(Option::as_deref);
    output_files::check(&inputs.map(Option::as_deref), &outputs)?;
    if args.robot.srdf.is_some() && args.xrdf.is_none() {
        log::warn!("--srdf has no effect without --xrdf");
    }
    let meshes = MeshLog::default();
    let robot = args.robot.load_logged(&meshes)?;
    let mesh_files = output_files::mesh_files(&meshes);
    output_files::check_beside_meshes(&mesh_files, &outputs)?;
    if let Some(file) = args.size.measure.as_ref().filter(|_| args.shape == ShapeArg::Spheres) {
        return measure(args, &robot, file);
    }
    let start = Instant::now();
    let limit = deadline.and_then(deadline_in).map_or_else(SearchLimit::default, SearchLimit::until);
    let progress = Progress::new(robot.links().iter().filter(|link| !link.collisions.is_empty()).count());
    let on_link = |_: LinkId| progress.piece_done();
    let kind = match args.shape {
        ShapeArg::Spheres => None,
        ShapeArg::Capsules => Some(ShapeKind::Capsule),
        ShapeArg::Boxes => Some(ShapeKind::Box),
        ShapeArg::Mesh => {
            let size = args.mesh_size()?;
            meshes::check_folder(args, &mesh_files)?;
            let cover = covers::mesh_cover(&robot, &size, &limit, &on_link);
            drop(progress);
            return meshes::write(args, &robot, &size, &cover.map_err(Failure::input)?, &mesh_files);
        }
    };
    if let Some(kind) = kind {
        let count = args.count_of_shapes()?;
        let cover = covers::shape_cover(&robot, kind, count, &limit, &on_link);
        drop(progress);
        return shapes::write(args, &robot, kind, &cover.map_err(Failure::input)?);
    }
    let size = args.cover_size(&robot)?;
    let cover = if args.inner {
        covers::inner_sphere_cover(&robot, &size, &limit, &on_link)
    } else {
        covers::sphere_cover(&robot, &size, &limit, &on_link)
    };
    drop(progress);
    let cover = cover.map_err(Failure::input)?;
    args.write_files(&robot, &cover)?;
    let seconds = start.elapsed().as_secs_f64();
    print_line(&match args.format {
        Format::Text => text(&robot, &cover, args.inner),
        Format::Json => json(&robot, &cover, args.inner, seconds)?,
    })?;
    Ok(args.status_of(cover.is_cut(), cover.largest_error()))
}

impl SpheresArgs {
    /// Exit code 1: the time ended the search before the excess that was requested was reached.
    pub fn status_of(&self, is_cut: bool, largest_error: f64) -> ExitStatus {
        let is_missed = self.size.excess.is_some_and(|requested| largest_error > requested);
        ExitStatus::of_answer(!(is_cut && is_missed))
    }

    fn cover_size(&self, robot: &RobotModel) -> Result<CoverSize, Failure> {
        let SizeArgs { count, total, excess, counts_of, .. } = &self.size;
        Ok(match (count, total, excess, counts_of) {
            (Some(count), ..) => CoverSize::PerLink(*count),
            (_, Some(total), ..) => CoverSize::Total(*total),
            (_, _, Some(excess), _) => CoverSize::Excess(*excess),
            (_, _, _, Some(file)) => CoverSize::Links(counts(robot, &self.model_of_spheres(file)?, file)?),
            _ => return Err(Failure::Input("give --count, --total, --excess or --counts-of".to_owned())),
        })
    }

    /// The number of capsules or boxes for each link; other options of spheres are rejected.
    fn count_of_shapes(&self) -> Result<usize, Failure> {
        let is_for_spheres = self.inner || self.curobo.is_some() || self.xrdf.is_some();
        self.size.count.filter(|_| !is_for_spheres).ok_or_else(|| {
            Failure::Input(
                "capsules and boxes are made with --count, without --inner, --curobo and --xrdf".to_owned(),
            )
        })
    }

    /// The size of simplified meshes; options of spheres are rejected.
    fn mesh_size(&self) -> Result<CoverSize, Failure> {
        let is_for_spheres = self.inner || self.curobo.is_some() || self.xrdf.is_some();
        match (&self.size, is_for_spheres) {
            (SizeArgs { count: Some(count), .. }, false) => Ok(CoverSize::PerLink(*count)),
            (SizeArgs { excess: Some(excess), .. }, false) => Ok(CoverSize::Excess(*excess)),
            _ => Err(Failure::Input(
                "meshes are simplified with --count or --excess, without --inner, --curobo and --xrdf"
                    .to_owned(),
            )),
        }
    }

    fn model_of_spheres(&self, file: &Path) -> Result<RobotModel, Failure> {
        let robot = RobotArgs { urdf: Some(file.to_owned()), srdf: None, ..self.robot.clone() };
        robot.load_quietly(&robot.mesh_files())
    }

    fn write_files(&self, robot: &RobotModel, cover: &SphereCover) -> Result<(), Failure> {
        let write =
            |file: &Path, text: &str| input_files::replace(file, text.as_bytes()).map_err(Failure::input);
        if let Some(file) = &self.curobo {
            write(file, &covers::curobo_yaml(robot, cover))?;
        }
        if let Some(file) = &self.xrdf {
            write(file, &covers::xrdf(robot, cover))?;
        }
        if let (Some(file), Some(urdf)) = (&self.sphere_urdf, &self.robot.urdf) {
            let text = input_files::read_text(urdf, DESCRIPTION_LIMIT).map_err(Failure::input)?;
            write(file, &covers::sphere_urdf(robot, cover, &text).map_err(Failure::input)?)?;
        }
        Ok(())
    }
}

/// The number of spheres of each link. A link without spheres would not be covered.
fn counts(robot: &RobotModel, spheres: &RobotModel, file: &Path) -> Result<Vec<(LinkId, usize)>, Failure> {
    let with_geometry = robot.link_ids().filter(|id| !robot.link(*id).collisions.is_empty());
    let count = |id: LinkId| {
        let name = &robot.link(id).name;
        let link = spheres.link_by_name(name).map(|link| spheres.link(link));
        match link.map_or(0, |link| link.collisions.len()) {
            0 => Err(Failure::Input(format!(
                "--counts-of: {} has no sphere for link '{}', which has collision geometry; use --total, which covers every link",
                file.display(),
                on_one_line(name)
            ))),
            count => Ok((id, count)),
        }
    };
    with_geometry.map(count).collect()
}

/// Bounds (m) in millimetres, rounded to the outside.
pub fn millimetres([lower, upper]: [f64; 2]) -> String {
    format!("{} to {} mm", rounded_bounds::at_least(1e3 * lower, 2), at_most(upper))
}

/// An upper bound (m) in millimetres, rounded up.
pub fn at_most(upper: f64) -> String {
    rounded_bounds::at_most(1e3 * upper, 2)
}

/// A line about the links whose search the time has ended.
pub fn note_of_time(links: usize, what: &str) -> String {
    match links {
        0 => String::new(),
        links => {
            format!("\nthe time ended the search of {links} links: a longer --deadline may reduce the {what}")
        }
    }
}

/// A number of spheres.
fn counted(count: usize) -> String {
    if count == 1 { "1 sphere".to_owned() } else { format!("{count} spheres") }
}

fn text(robot: &RobotModel, cover: &SphereCover, inner: bool) -> String {
    let what = if inner { "depth left out" } else { "excess" };
    let line = |link: &LinkCover| {
        let name = on_one_line(&robot.link(link.link).name);
        format!("{name}: {}, {what} {}\n", counted(link.spheres.len()), millimetres(link.error))
    };
    let lines: String = cover.links.iter().map(line).collect();
    let note = note_of_time(cover.links.iter().filter(|link| link.is_cut).count(), what);
    let proof = if inner { "proven inside of the links" } else { "proven to contain the links" };
    format!(
        "{lines}{}: {}, {proof}; {what} at most {} mm, proven{note}",
        on_one_line(robot.name()),
        counted(cover.count()),
        at_most(cover.largest_error()),
    )
}

fn json(robot: &RobotModel, cover: &SphereCover, inner: bool, seconds: f64) -> Result<String, Failure> {
    let link = |link: &LinkCover| LinkOutput {
        link: robot.link(link.link).name.clone(),
        error: link.error,
        ended_by_time: link.is_cut,
        spheres: link.spheres.iter().map(|s| [s.centre.x, s.centre.y, s.centre.z, s.radius]).collect(),
    };
    let output = CoverOutput {
        robot: robot.name().to_owned(),
        cover: if inner { "inner" } else { "outer" },
        spheres: cover.count(),
        largest_error: cover.largest_error(),
        ended_by_time: cover.is_cut(),
        seconds,
        links: cover.links.iter().map(link).collect(),
    };
    serde_json::to_string(&output).map_err(internal)
}

/// Exit code 1 if a part of the surface is certainly in no sphere.
fn measure(args: &SpheresArgs, robot: &RobotModel, file: &Path) -> Result<ExitStatus, Failure> {
    let MeasuredCover { links, unmeasured } =
        covers::measure_spheres(robot, &args.model_of_spheres(file)?, &SearchLimit::default())
            .map_err(Failure::input)?;
    for name in &unmeasured {
        log::warn!(
            "the spheres of link '{name}' are not measured: the robot has no collision geometry there"
        );
    }
    let name = |link: &MeasuredLink| robot.link(link.link).name.clone();
    match args.format {
        Format::Text => {
            for link in &links {
                let part = |area: f64| {
                    if link.uncovered.total > 0.0 { 100.0 * area / link.uncovered.total } else { 0.0 }
                };
                print_line(&format!(
                    "{}: {} spheres, {} to {} % of the surface in no sphere, excess {}",
                    on_one_line(&name(link)),
                    link.spheres,
                    rounded_bounds::at_least(part(link.uncovered.lower), 1),
                    rounded_bounds::at_most(part(link.uncovered.upper).lesser(100.0), 1),
                    millimetres(link.excess),
                ))?;
            }
        }
        Format::Json => {
            let output = |link: &MeasuredLink| MeasureOutput {
                link: name(link),
                spheres: link.spheres,
                uncovered_area: [link.uncovered.lower, link.uncovered.upper],
                surface_area: link.uncovered.total,
                excess: link.excess,
            };
            let outputs: Vec<MeasureOutput> = links.iter().map(output).collect();
            print_line(&serde_json::to_string(&outputs).map_err(internal)?)?;
        }
    }
    let is_bare = |link: &MeasuredLink| link.uncovered.lower > 0.0 || link.spheres == 0;
    Ok(ExitStatus::of_answer(!links.iter().any(is_bare)))
}
