//! `clearance spheres --shape mesh`: files and report of simplified collision meshes.

use std::ffi::OsString;
use std::path::{Path, PathBuf};

use clearance::covers::{self, CoverSize, LinkMeshes, MeshCover, SimplifiedMesh};
use clearance::robot::RobotModel;
use clearance_files::input_files::{self, DESCRIPTION_LIMIT, MESH_LIMIT};
use clearance_files::readable_text::on_one_line;
use serde::Serialize;

use super::exit_status::ExitStatus;
use super::failure::Failure;
use super::output_files;
use super::run_args::{Format, internal, print_line};
use super::spheres::{SpheresArgs, at_most, millimetres, note_of_time};

/// Output in JSON format.
#[derive(Serialize)]
struct MeshesOutput {
    robot: String,
    shape: &'static str,
    triangles: usize,
    original_triangles: usize,
    /// Proven bound (m).
    largest_error: f64,
    /// True if `--deadline` ended the search of a link.
    ended_by_time: bool,
    links: Vec<LinkOutput>,
}

#[derive(Serialize)]
struct LinkOutput {
    link: String,
    triangles: usize,
    original_triangles: usize,
    /// Lower and upper bound (m).
    error: [f64; 2],
    /// A point with the largest distance that was found (m, link frame).
    point: Option<[f64; 3]>,
    ended_by_time: bool,
    meshes: Vec<MeshOutput>,
}

#[derive(Serialize)]
struct MeshOutput {
    /// Number of the collision element in its link, from 1.
    collision: usize,
    /// Relative to the folder of the URDF that is written.
    file: Option<PathBuf>,
    triangles: usize,
    original_triangles: usize,
    /// Lower and upper bound (m).
    error: [f64; 2],
}

/// The folder of the meshes of a URDF.
fn folder_of(urdf: &Path) -> PathBuf {
    let mut name = urdf.file_stem().map_or_else(OsString::new, OsString::from);
    name.push("_meshes");
    urdf.with_file_name(name)
}

/// Rejects, before the search, what cannot become the folder of the meshes. `read` are the meshes of the robot.
pub fn check_folder(args: &SpheresArgs, read: &[PathBuf]) -> Result<(), Failure> {
    let Some(urdf) = &args.sphere_urdf else { return Ok(()) };
    let folder = folder_of(urdf);
    uri_of(&folder)?;
    let parent = urdf.parent().filter(|parent| !parent.as_os_str().is_empty());
    if let Some(parent) = parent.filter(|parent| !parent.is_dir()) {
        return Err(Failure::Input(format!("{}: there is no such folder: make it first", parent.display())));
    }
    if folder.exists() && !folder.is_dir() {
        let message = format!(
            "{}: is there already, and no folder: the meshes need a folder with this name",
            folder.display()
        );
        return Err(Failure::Input(message));
    }
    if let Ok(folder) = folder.canonicalize()
        && let Some(mesh) = read.iter().find(|mesh| mesh.parent() == Some(folder.as_path()))
    {
        let message =
            "is a mesh of the robot, in the folder that is written: choose another name for the URDF";
        return Err(Failure::Input(format!("{}: {message}", mesh.display())));
    }
    Ok(())
}

/// The name of the folder as the start of a mesh name.
fn uri_of(folder: &Path) -> Result<String, Failure> {
    let name =
        folder.file_name().and_then(|name| name.to_str()).filter(|name| !name.contains(char::is_control));
    let name = name.ok_or_else(|| {
        Failure::Input(format!(
            "{}: the name of the URDF must be UTF-8 without control characters",
            folder.display()
        ))
    })?;
    // what would be decoded, cut off, or taken for a scheme or for xacro
    Ok(name.replace('%', "%25").replace(':', "%3A").replace('$', "%24").replace(' ', "%20"))
}

/// Writes the meshes and the URDF, and reports the meshes.
pub fn write(
    args: &SpheresArgs,
    robot: &RobotModel,
    size: &CoverSize,
    cover: &MeshCover,
    read: &[PathBuf],
) -> Result<ExitStatus, Failure> {
    if let (Some(file), Some(urdf)) = (&args.sphere_urdf, &args.robot.urdf) {
        write_files(robot, cover, [urdf, file], read)?;
    }
    let folder = args.sphere_urdf.as_ref().and_then(|file| folder_of(file).file_name().map(PathBuf::from));
    print_line(&match args.format {
        Format::Text => text(robot, size, cover),
        Format::Json => json(robot, cover, folder.as_deref())?,
    })?;
    Ok(args.status_of(cover.is_cut(), cover.error()[1]))
}

/// The meshes first, so that the URDF names existing files at every moment. `read` are the meshes of the robot.
fn write_files(
    robot: &RobotModel,
    cover: &MeshCover,
    [urdf, file]: [&Path; 2],
    read: &[PathBuf],
) -> Result<(), Failure> {
    let text = input_files::read_text(urdf, DESCRIPTION_LIMIT).map_err(Failure::input)?;
    let folder = folder_of(file);
    let text = covers::mesh_urdf(robot, cover, &text, &uri_of(&folder)?).map_err(Failure::input)?;
    let unwritable = |e: std::io::Error| Failure::Input(format!("{}: cannot be made: {e}", folder.display()));
    let meshes = || cover.links.iter().flat_map(|link| &link.meshes);
    let targets: Vec<PathBuf> = meshes().map(|mesh| folder.join(&mesh.file_name)).collect();
    targets.iter().try_for_each(|target| check_target(target))?;
    let outputs: Vec<Option<&Path>> = targets.iter().map(|t| Some(t.as_path())).chain([Some(file)]).collect();
    output_files::check(&[Some(urdf)], &outputs)?;
    output_files::check_beside_meshes(read, &outputs)?;
    if !folder.is_dir() {
        std::fs::create_dir(&folder).map_err(unwritable)?;
    }
    for SimplifiedMesh { mesh, file_name, .. } in meshes() {
        input_files::replace(&folder.join(file_name), &covers::stl(mesh)).map_err(Failure::input)?;
    }
    input_files::replace(file, text.as_bytes()).map_err(Failure::input)
}

/// Rejects a file that is no simplified mesh: it may be the only copy of an original one.
fn check_target(file: &Path) -> Result<(), Failure> {
    if !file.exists()
        || input_files::read(file, MESH_LIMIT).is_ok_and(|bytes| covers::is_simplified_stl(&bytes))
    {
        return Ok(());
    }
    let message = "is there already, and is no simplified mesh: choose another name for the URDF";
    Err(Failure::Input(format!("{}: {message}", file.display())))
}

/// A number with commas between groups of three digits.
fn grouped(number: usize) -> String {
    let digits = number.to_string();
    let is_group_start = |i: usize| i > 0 && (digits.len() - i).is_multiple_of(3);
    digits.char_indices().flat_map(|(i, c)| is_group_start(i).then_some(',').into_iter().chain([c])).collect()
}

fn triangles(kept: usize, of: usize) -> String {
    format!("{} of {} triangles", grouped(kept), grouped(of))
}

fn text(robot: &RobotModel, size: &CoverSize, cover: &MeshCover) -> String {
    let line = |link: &LinkMeshes| {
        let name = on_one_line(&robot.link(link.link).name);
        let triangles = triangles(link.triangles(), link.original_triangles());
        format!("{name}: {triangles}, error {}\n", millimetres(link.error()))
    };
    let lines: String = cover.links.iter().map(line).collect();
    let cut = cover.links.iter().filter(|link| link.is_cut).count();
    format!(
        "{lines}{}: {}; mesh and simplified mesh are at most {} mm apart, proven{}{}",
        on_one_line(robot.name()),
        triangles(cover.triangles(), cover.original_triangles()),
        at_most(cover.error()[1]),
        note_of_count(size, cover),
        note_of_time(cut, "error"),
    )
}

/// A line about the links that have more triangles than requested.
fn note_of_count(size: &CoverSize, cover: &MeshCover) -> String {
    let CoverSize::PerLink(count) = size else { return String::new() };
    match cover.links.iter().filter(|link| !link.is_cut && link.triangles() > *count).count() {
        0 => String::new(),
        links => format!(
            "\n{links} of the links keep more than {} triangles: fewer would tear surfaces or join parts",
            grouped(*count)
        ),
    }
}

fn json(robot: &RobotModel, cover: &MeshCover, folder: Option<&Path>) -> Result<String, Failure> {
    let mesh = |mesh: &SimplifiedMesh| MeshOutput {
        collision: mesh.collision + 1,
        file: folder.map(|folder| folder.join(&mesh.file_name)),
        triangles: mesh.mesh.triangles().len(),
        original_triangles: mesh.original_triangles,
        error: mesh.error,
    };
    let link = |link: &LinkMeshes| LinkOutput {
        link: robot.link(link.link).name.clone(),
        triangles: link.triangles(),
        original_triangles: link.original_triangles(),
        error: link.error(),
        point: link.point().map(|p| [p.x, p.y, p.z]),
        ended_by_time: link.is_cut,
        meshes: link.meshes.iter().map(mesh).collect(),
    };
    let output = MeshesOutput {
        robot: robot.name().to_owned(),
        shape: "mesh",
        triangles: cover.triangles(),
        original_triangles: cover.original_triangles(),
        largest_error: cover.error()[1],
        ended_by_time: cover.is_cut(),
        links: cover.links.iter().map(link).collect(),
    };
    serde_json::to_string(&output).map_err(internal)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_groups_of_three_digits() {
        let numbers = [0, 12, 999, 1000, 12_340, 1_234_567];
        assert_eq!(numbers.map(grouped), ["0", "12", "999", "1,000", "12,340", "1,234,567"]);
    }
}
