//! Command line arguments for the robot and the world, and functions to load them.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use clap::Args;
use clearance::checker::CollisionChecker;
use clearance::robot::{LinkId, MeshFiles, MeshLog, RobotModel, check_package_path};
use clearance::scene::{AllowedCollisionMatrix, MeshModel, Settings, VolumeSelection};
use clearance::scene::{Scene, SceneLoader, World, WorldFileKind};
use clearance_files::input_files::{self, WORLD_LIMIT};

use super::failure::Failure;

/// A robot, and its safety distance.
#[derive(Args, Clone, Debug, Default)]
pub struct ModelArgs {
    #[command(flatten)]
    pub robot: RobotArgs,

    /// Safety distance around every link, in metres
    #[arg(long, value_name = "M", allow_negative_numbers = true)]
    pub padding: Option<f64>,

    /// Apply the padding between links of the robot, too, not only against the world
    #[arg(long)]
    pub pad_self: bool,

    /// Kind of bounding volumes of all bodies (obb, rss, lss, pss, aabb, kdop18, kios), and of individual links as LINK=KIND, separated
    /// by commas; they change the time of a check, but no collision and no distance
    #[arg(long, value_name = "KIND")]
    pub volumes: Option<VolumeSelection>,
}

/// A robot.
#[derive(Args, Clone, Debug, Default)]
pub struct RobotArgs {
    /// URDF file of the robot; its meshes are STL, OBJ, COLLADA, PLY or glTF (.gltf, .glb)
    #[arg(long, value_name = "FILE")]
    pub urdf: Option<PathBuf>,

    /// SRDF file of the robot: pairs of links that need no check
    #[arg(long, value_name = "FILE", requires = "urdf")]
    pub srdf: Option<PathBuf>,

    /// Folder in which package://NAME/path is searched, as DIR/NAME/path; symbolic links in DIR are followed; may be given more than once
    #[arg(long, value_name = "DIR")]
    pub package_path: Vec<PathBuf>,

    /// Meaning of a mesh: a surface, or a solid if it is closed
    #[arg(long, value_name = "MODEL")]
    pub mesh: Option<MeshArg>,
}

#[derive(clap::ValueEnum, Clone, Copy, Debug, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum MeshArg {
    Surface,
    Solid,
}

/// A world.
#[derive(Args, Clone, Debug, Default)]
pub struct WorldArgs {
    /// File with obstacles: the YAML of a MoveIt planning scene, a MoveIt .scene file, an octree (.bt, .ot) or a cloud (.pcd, .ply);
    /// may be given more than once
    #[arg(long, value_name = "FILE")]
    pub world: Vec<PathBuf>,

    /// Point cloud in the root frame: PCD or PLY; may be given more than once
    #[arg(long, value_name = "FILE", requires = "point_radius")]
    pub cloud: Vec<PathBuf>,

    /// Radius of the ball around every point of a cloud, in metres
    #[arg(long, value_name = "M", allow_negative_numbers = true)]
    pub point_radius: Option<f64>,

    /// Treatment of unknown space of an octree, within the bounding box of its known cells
    #[arg(long, value_name = "SPACE", default_value = "free")]
    pub unknown_space: UnknownSpace,

    /// Two links that are not checked against each other, as if an SRDF disabled the pair: for quick trials; may be given more than once
    #[arg(long, value_name = "A,B")]
    pub ignore: Vec<String>,
}

#[derive(
    clap::ValueEnum, Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize,
)]
#[serde(rename_all = "snake_case")]
pub enum UnknownSpace {
    #[default]
    Free,
    Occupied,
}

impl RobotArgs {
    /// Loads the robot; warnings are logged.
    pub fn load(&self) -> Result<RobotModel, Failure> {
        self.load_logged(&MeshLog::default())
    }

    /// The same; records the files of its meshes.
    pub fn load_logged(&self, meshes: &MeshLog) -> Result<RobotModel, Failure> {
        let robot = self.load_quietly(&self.mesh_files().with_log(meshes.clone()))?;
        for warning in robot.warnings() {
            log::warn!("{warning}");
        }
        Ok(robot)
    }

    /// Loads the robot. The caller must report its warnings.
    pub fn load_quietly(&self, files: &MeshFiles) -> Result<RobotModel, Failure> {
        let urdf =
            (self.urdf.as_deref()).ok_or_else(|| Failure::Input("no robot: give --urdf FILE".to_owned()))?;
        for dir in &self.package_path {
            check_package_path(dir).map_err(|why| Failure::Input(format!("--package-path: {why}")))?;
        }
        RobotModel::load_with(urdf, self.srdf.as_deref(), files).map_err(|error| {
            let mut faults: Vec<String> = error.faults.iter().map(ToString::to_string).collect();
            let Some(message) = faults.first_mut() else { return Failure::Input(error.to_string()) };
            for (path, option) in [(Some(urdf), "--urdf"), (self.srdf.as_deref(), "--srdf")] {
                let Some(path) = path else { continue };
                if let Some(kind) = other_kind(path)
                    && message.starts_with(&path.display().to_string())
                {
                    *message = format!("{message} ({kind} is no file for {option})");
                }
            }
            Failure::Faults(faults)
        })
    }

    /// Lookup of the meshes of scene files.
    pub fn mesh_files(&self) -> MeshFiles {
        let files = (self.package_path.iter())
            .fold(MeshFiles::default(), MeshFiles::with_package_path)
            .with_environment();
        match self.urdf.as_deref().and_then(Path::parent) {
            Some(folder) if folder.as_os_str().is_empty() => files.beside_urdf(Path::new(".")),
            Some(folder) => files.beside_urdf(folder),
            None => files,
        }
    }

    /// Meaning of meshes.
    pub fn mesh_model(&self) -> MeshModel {
        match self.mesh {
            Some(MeshArg::Solid) => MeshModel::Solid,
            Some(MeshArg::Surface) | None => MeshModel::Surface,
        }
    }
}

impl ModelArgs {
    /// Settings of the checker from these arguments.
    pub fn settings(&self) -> Settings {
        Settings {
            padding: self.padding.unwrap_or(0.0),
            pad_self: self.pad_self,
            mesh_model: self.robot.mesh_model(),
            volumes: self.volumes.clone().unwrap_or_default(),
            ..Settings::default()
        }
    }
}

impl WorldArgs {
    /// Loads all files into one world; warnings are logged.
    pub fn load(&self, robot: &RobotModel, files: &MeshFiles) -> Result<Scene, Failure> {
        let mut kinds = Vec::new();
        let read = |path: &Path| input_files::read(path, WORLD_LIMIT).map_err(|error| error.to_string());
        let scene = self.load_with(robot, files, &read, &mut kinds)?;
        self.check_effect(&kinds)?;
        Ok(scene)
    }

    /// Like [`Self::load`], but reads files with `read`, and adds their kinds to `kinds` instead of rejecting options without effect.
    pub fn load_with(
        &self,
        robot: &RobotModel,
        files: &MeshFiles,
        read: &dyn Fn(&Path) -> Result<Vec<u8>, String>,
        kinds: &mut Vec<WorldFileKind>,
    ) -> Result<Scene, Failure> {
        let mut loader = SceneLoader::default();
        loader.unknown_is_occupied = self.unknown_space == UnknownSpace::Occupied;
        for path in self.world.iter().chain(&self.cloud) {
            let file = path.display();
            let bytes = read(path).map_err(Failure::Input)?;
            let kind = WorldFileKind::of(&bytes, path);
            kinds.push(kind);
            if kind == WorldFileKind::Yaml
                && let Some(why) = not_a_world(&bytes, path)
            {
                return Err(Failure::Input(format!("{file}: {why}{WORLDS}")));
            }
            if kind == WorldFileKind::Cloud && self.point_radius.is_none() {
                return Err(Failure::Input(format!("{file}: a cloud needs --point-radius M")));
            }
            if kind != WorldFileKind::Cloud && self.cloud.contains(path) {
                return Err(Failure::Input(format!("{file}: --cloud takes PCD and PLY; give it as --world")));
            }
            let files = files.clone().with_folder(path.parent().unwrap_or(Path::new(".")));
            let is_named_otherwise = kind == WorldFileKind::Yaml && !is_yaml(path);
            loader.read_file(&bytes, path, self.point_radius, robot, &files).map_err(|error| {
                let hint = if is_named_otherwise { WORLDS } else { "" };
                Failure::Input(format!("{error}{hint}"))
            })?;
            for warning in loader.warnings.drain(..) {
                log::warn!("{warning}");
            }
        }
        let mut scene = loader.into_scene();
        if !self.ignore.is_empty() {
            let mut matrix = scene.matrix.take().unwrap_or_else(|| AllowedCollisionMatrix::of_robot(robot));
            for pair in &self.ignore {
                let [a, b] = link_pair(robot, "--ignore", pair)?;
                if let Some(why) = why_unchecked(robot, &matrix, [a, b]) {
                    log::warn!("--ignore {pair} has no effect: {why}");
                }
                matrix.set(&robot.link(a).name, &robot.link(b).name, true);
            }
            scene.matrix = Some(matrix);
        }
        Ok(scene)
    }

    /// Rejects options about clouds and octrees if there are none.
    fn check_effect(&self, kinds: &[WorldFileKind]) -> Result<(), Failure> {
        let without_effect =
            |option, of| Err(Failure::Input(format!("{option} has no effect: no file is {of}")));
        if self.point_radius.is_some() && !kinds.contains(&WorldFileKind::Cloud) {
            return without_effect("--point-radius", "a cloud (.pcd, .ply)");
        }
        if self.unknown_space == UnknownSpace::Occupied && !kinds.contains(&WorldFileKind::Octomap) {
            return without_effect("--unknown-space occupied", "an octree (.bt, .ot)");
        }
        Ok(())
    }
}

/// Why two links are not checked against each other, if they are not.
fn why_unchecked(
    robot: &RobotModel,
    matrix: &AllowedCollisionMatrix,
    links: [LinkId; 2],
) -> Option<&'static str> {
    let [a, b] = links.map(|link| robot.link(link));
    if robot.same_rigid_body(links[0], links[1]) {
        Some("the links never move relative to each other, and are not checked")
    } else if a.collisions.is_empty() || b.collisions.is_empty() {
        Some("one of the links has no collision geometry")
    } else if matrix.allows(&a.name, &b.name) {
        Some("the pair is not checked without it either")
    } else {
        None
    }
}

/// The two links that an option names as `A,B`.
pub fn link_pair(robot: &RobotModel, option: &str, pair: &str) -> Result<[LinkId; 2], Failure> {
    let Some((a, b)) = pair.split_once(',').map(|(a, b)| (a.trim(), b.trim())) else {
        return Err(Failure::Input(format!("{option} {pair}: name two links, as {option} A,B")));
    };
    let link = |name: &str| {
        let unknown = || Failure::Input(format!("{option} {pair}: the robot has no link '{name}'"));
        robot.link_by_name(name).ok_or_else(unknown)
    };
    let links = [link(a)?, link(b)?];
    if links[0] == links[1] {
        return Err(Failure::Input(format!("{option} {pair}: name two different links")));
    }
    Ok(links)
}

/// Required content of a file, for error messages about other content.
const WORLDS: &str = " (a world is the YAML of a MoveIt planning scene, MoveIt's .scene text, an octomap in .bt or .ot, or a PCD or PLY)";

/// Kind of a file by its extension, if it is not a robot description.
fn other_kind(path: &Path) -> Option<&'static str> {
    let extension = path.extension()?.to_str()?.to_ascii_lowercase();
    Some(match extension.as_str() {
        "stl" | "dae" | "obj" | "glb" | "gltf" => "a mesh",
        "ply" | "pcd" => "a cloud or mesh",
        "bt" | "ot" => "an octomap",
        "yaml" | "yml" | "json" | "csv" | "scene" => "a world, or states,",
        _ => return None,
    })
}

/// Kind of a file that was wrongly given as a world: a robot or a mesh.
fn not_a_world(bytes: &[u8], path: &Path) -> Option<&'static str> {
    let is_mesh = ["stl", "dae", "obj", "glb", "gltf"];
    let extension = path.extension().unwrap_or_default();
    if is_mesh.iter().any(|known| extension.eq_ignore_ascii_case(known)) {
        return Some("it is a mesh: place it with a planning scene, as mesh resource of an object");
    }
    let text = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes).trim_ascii_start();
    if !text.starts_with(b"<") {
        return None;
    }
    let holds = |word: &[u8]| text.windows(word.len()).any(|w| w == word);
    Some(if holds(b"<COLLADA") {
        "it is a mesh: place it with a planning scene, as mesh resource of an object"
    } else if holds(b"<link") {
        "it is a URDF: give it with --urdf"
    } else if holds(b"<robot") {
        "it is an SRDF: give it with --srdf"
    } else {
        "it is XML"
    })
}

fn is_yaml(path: &Path) -> bool {
    let extension = path.extension().unwrap_or_default();
    ["yaml", "yml", "json"].iter().any(|known| extension.eq_ignore_ascii_case(known))
}

/// Checker from the arguments. Logs defects of meshes that should be solid.
pub fn checker(robot: RobotModel, scene: &Scene, settings: Settings) -> Result<CollisionChecker, Failure> {
    let settings = settings.with_scene(scene);
    warn_of_meshes(&robot, &scene.world, &settings);
    CollisionChecker::with_matrix(Arc::new(robot), &scene.world, settings, scene.matrix.as_ref()).map_err(
        |error| {
            let of_scene = !(scene.link_padding.is_empty() && scene.link_scale.is_empty());
            let hint = if of_scene { " (as link_padding and link_scale of --world say)" } else { "" };
            Failure::Input(format!("{error}{hint}"))
        },
    )
}

/// Logs defects of meshes that should be solid.
pub fn warn_of_meshes(robot: &RobotModel, world: &World, settings: &Settings) {
    if settings.mesh_model == MeshModel::Solid {
        for remark in clearance::checker::solid_mesh_remarks(robot, world) {
            log::warn!("{remark}");
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pairs_that_are_not_checked_anyway_are_told() {
        let link = |name: &str, geometry: &str| {
            format!("<link name='{name}'><collision>{geometry}</collision></link>")
        };
        let ball = "<geometry><sphere radius='0.1'/></geometry>";
        let links = ["a", "b", "c", "d"].map(|name| link(name, ball)).concat();
        let joint = |kind: &str, parent: &str, child: &str| {
            format!(
                "<joint name='{child}' type='{kind}'><parent link='{parent}'/><child link='{child}'/></joint>"
            )
        };
        let joints = joint("continuous", "a", "b")
            + &joint("continuous", "b", "c")
            + &joint("fixed", "c", "d")
            + &joint("fixed", "d", "bare");
        let urdf = format!("<robot name='r'>{links}<link name='bare'/>{joints}</robot>");
        let robot = RobotModel::from_urdf(&urdf, &MeshFiles::default()).unwrap();
        let mut matrix = AllowedCollisionMatrix::of_robot(&robot);
        let mut why = |pair: &str| {
            let links = link_pair(&robot, "--ignore", pair).unwrap();
            let why = why_unchecked(&robot, &matrix, links);
            matrix.set(&robot.link(links[0]).name, &robot.link(links[1]).name, true);
            why
        };
        assert_eq!(why("a,c"), None);
        for (pair, words) in [
            ("c,a", "without it either"),
            ("a,b", "without it either"),
            ("c,d", "never move"),
            ("a,bare", "no collision geometry"),
        ] {
            assert!(why(pair).is_some_and(|why| why.contains(words)), "{pair}: {:?}", why(pair));
        }
    }
}
