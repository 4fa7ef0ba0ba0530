//! The arguments that name a robot and a world, and what they load.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use clap::Args;
use clearance::checker::{AllowedCollisionMatrix, CollisionChecker, MeshModel, Settings};
use clearance::robot::{MeshFiles, RobotModel};
use clearance::world::{PlanningScene, World};

use super::failure::Failure;

/// A robot.
#[derive(Args, Clone, Debug, Default)]
pub struct ModelArgs {
    /// The robot: a URDF file
    #[arg(long, value_name = "FILE")]
    pub urdf: Option<PathBuf>,

    /// Its SRDF: pairs of links that need no check
    #[arg(long, value_name = "FILE", requires = "urdf")]
    pub srdf: Option<PathBuf>,

    /// Where package://NAME/path is looked up, as DIR/NAME/path; may be given more than once
    #[arg(long, value_name = "DIR")]
    pub package_path: Vec<PathBuf>,

    /// Safety distance around every link, in metres
    #[arg(long, value_name = "M", allow_negative_numbers = true)]
    pub padding: Option<f64>,

    /// Padding counts between links of the robot too, not only against the world
    #[arg(long)]
    pub pad_self: bool,

    /// What a mesh is: a surface, or a solid if it is closed
    #[arg(long, value_name = "MODEL")]
    pub mesh: Option<MeshArg>,
}

#[derive(clap::ValueEnum, Clone, Copy, Debug)]
pub enum MeshArg {
    Surface,
    Solid,
}

/// A world.
#[derive(Args, Clone, Debug, Default)]
pub struct WorldArgs {
    /// Obstacles: the YAML of a MoveIt planning scene; may be given more than once
    #[arg(long, value_name = "FILE")]
    pub world: Vec<PathBuf>,
}

/// Obstacles and what scene files say of allowed collisions.
#[derive(Clone, Debug, Default)]
pub struct LoadedWorld {
    pub world: World,
    pub allowed: Option<AllowedCollisionMatrix>,
}

impl ModelArgs {
    /// Loads the robot; warnings are logged.
    pub fn load(&self) -> Result<RobotModel, Failure> {
        let urdf =
            (self.urdf.as_deref()).ok_or_else(|| Failure::Input("no robot: give --urdf FILE".to_owned()))?;
        let robot =
            RobotModel::load(urdf, self.srdf.as_deref(), &self.package_path).map_err(Failure::input)?;
        for warning in robot.warnings() {
            log::warn!("{warning}");
        }
        Ok(robot)
    }

    /// Where the meshes of scene files are looked up.
    pub fn mesh_files(&self) -> MeshFiles {
        let files = (self.package_path.iter())
            .fold(MeshFiles::default(), MeshFiles::with_package_path)
            .with_environment();
        match self.urdf.as_deref().and_then(Path::parent) {
            Some(folder) => files.beside_urdf(folder),
            None => files,
        }
    }

    /// The checker's settings as these arguments say.
    pub fn settings(&self) -> Settings {
        Settings {
            padding: self.padding.unwrap_or(0.0),
            pad_self: self.pad_self,
            mesh_model: match self.mesh {
                Some(MeshArg::Solid) => MeshModel::Solid,
                Some(MeshArg::Surface) | None => MeshModel::Surface,
            },
            ..Settings::default()
        }
    }
}

impl WorldArgs {
    /// Loads all scene files into one world; warnings are logged.
    pub fn load(&self, robot: &RobotModel, files: &MeshFiles) -> Result<LoadedWorld, Failure> {
        let mut loaded = LoadedWorld::default();
        for path in &self.world {
            let file = path.display().to_string();
            let text = std::fs::read_to_string(path).map_err(|e| Failure::Input(format!("{file}: {e}")))?;
            let files = files.clone().with_folder(path.parent().unwrap_or(Path::new(".")));
            let scene = PlanningScene::from_yaml(&text, &file, robot, &files).map_err(Failure::input)?;
            for warning in &scene.warnings {
                log::warn!("{warning}");
            }
            if let Some(entries) = &scene.allowed {
                let matrix = AllowedCollisionMatrix::from_entries(entries)
                    .map_err(|e| Failure::Input(format!("{file}: {e}")))?;
                if loaded.allowed.replace(matrix).is_some() {
                    return Err(Failure::Input(format!(
                        "{file}: a second allowed_collision_matrix; only one world file may have one"
                    )));
                }
                log::warn!("{file}: its allowed_collision_matrix replaces the SRDF's disabled pairs");
            }
            for obstacle in scene.obstacles {
                (loaded.world.add(obstacle)).map_err(|e| Failure::Input(format!("{file}: {e}")))?;
            }
        }
        Ok(loaded)
    }
}

/// A checker from arguments; says which meshes are not closed when they were asked to be solid.
pub fn checker(
    robot: RobotModel,
    loaded: &LoadedWorld,
    settings: Settings,
) -> Result<CollisionChecker, Failure> {
    if settings.mesh_model == MeshModel::Solid {
        for mesh in clearance::checker::open_meshes(&robot, &loaded.world) {
            log::warn!("{mesh} is not closed: it stays a surface");
        }
    }
    CollisionChecker::with_matrix(Arc::new(robot), &loaded.world, settings, loaded.allowed.as_ref())
        .map_err(Failure::input)
}
