//! C interface of worlds: creation, files, and adding, moving and removing obstacles.

use std::ffi::{c_char, c_int};
use std::path::Path;
use std::ptr;
use std::sync::OnceLock;

use clearance::geometry::math::Pose;
use clearance::geometry::{Primitive, PrimitiveError, Shape};
use clearance::robot::{MeshFiles, RobotModel};
use clearance::scene::{Obstacle, Scene, SceneLoader, WorldFileKind};
use clearance_bindings::why_no_obstacle;
use clearance_files::input_files::{self, WORLD_LIMIT};

use crate::arguments::Arguments;
use crate::robot::{clearance_robot, mesh_failure};
use crate::shapes::{self, clearance_mesh, clearance_points};
use crate::status::{Failure, Outcome, call, call_for, clearance_status};
use crate::structs::clearance_pose;
use crate::texts::Names;

/// The robot of a file that is read without one: its only link is the root, in the frame `world`.
const NO_ROBOT: &str = "<robot name='not given'><link name='world'/></robot>";

/// Obstacles around a robot, by name; lengths in metres.
///
/// Poses are in the frame of the robot's root link; a null pose is the origin of that frame. Functions that add something reject a name
/// that is taken and invalid shapes, and then change nothing. A checker keeps a copy of its world: later changes need
/// `clearance_checker_with_world`.
///
/// Any number of threads may read a world. While a thread changes it, no other thread may use it.
#[derive(Debug, Default)]
pub struct clearance_world {
    pub(crate) scene: Scene,
    names: OnceLock<Names>,
    warnings: Names,
}

impl clearance_world {
    /// A world with this content.
    pub(crate) fn of_scene(scene: Scene) -> Self {
        Self { scene, ..Self::default() }
    }

    fn names(&self) -> &Names {
        let obstacles = || self.scene.world.obstacles().map(|obstacle| obstacle.name.as_str());
        self.names.get_or_init(|| Names::new(obstacles()))
    }
}

/// Changes the obstacle `name` of a world; errors are about it.
fn change(
    world: *mut clearance_world,
    name: *const c_char,
    change: impl FnOnce(Arguments<'_>, &mut Scene, &str) -> Outcome,
) -> clearance_status {
    call(|arguments| {
        // a copy, because the caller may pass a name of this world's list
        let name = arguments.text(name, "name")?.to_owned();
        let world = arguments.object_mut(world, "world")?;
        change(arguments, &mut world.scene, &name)?;
        world.names = OnceLock::new();
        Ok(())
    })
}

fn read_pose(arguments: Arguments<'_>, pose: *const clearance_pose, name: &str) -> Outcome<Pose> {
    clearance_pose::read(arguments, pose, "pose").map_err(|why| why.about(&format!("obstacle '{name}'")))
}

/// Adds an obstacle of one shape.
fn add(
    world: *mut clearance_world,
    name: *const c_char,
    pose: *const clearance_pose,
    shape: impl FnOnce(Arguments<'_>) -> Outcome<Shape>,
) -> clearance_status {
    change(world, name, |arguments, scene, name| {
        let pose = read_pose(arguments, pose, name)?;
        let shape = shape(arguments).map_err(|why| why.about(&format!("obstacle '{name}'")))?;
        scene.world.add(Obstacle::of_shape(name, pose, shape)).map(|_| ()).map_err(Failure::rejected)
    })
}

fn primitive(made: Result<Primitive, PrimitiveError>) -> Outcome<Shape> {
    made.map(Shape::Primitive).map_err(Failure::rejected)
}

/// Makes a world without obstacles.
#[unsafe(no_mangle)]
pub extern "C" fn clearance_world_new(world: *mut *mut clearance_world) -> clearance_status {
    call(|arguments| arguments.write_handle(world, clearance_world::default(), "world"))
}

/// Reads obstacles, attached objects and allowed collisions of a file: the YAML of a MoveIt planning scene, MoveIt's `.scene` text, an
/// octree (`.bt`, `.ot`), or a cloud (PCD, PLY).
///
/// `robot` gives the frames of its links and resolves the links of attached objects. If it is null, the only frame is `world`, the robot's
/// root. `point_radius` (m) is the radius of the balls around the points of a cloud; 0 if the file is none. Unknown space of an octree
/// counts as occupied if `unknown_is_occupied` is not 0. Meshes are searched beside the file, and where those of the robot are.
///
/// Rejected: every fault of the file, and a `point_radius` or `unknown_is_occupied` for a file of another kind. Unusual content that is
/// accepted is among the warnings (`clearance_world_warning`).
#[unsafe(no_mangle)]
pub extern "C" fn clearance_world_from_file(
    path: *const c_char,
    robot: *const clearance_robot,
    point_radius: f64,
    unknown_is_occupied: c_int,
    world: *mut *mut clearance_world,
) -> clearance_status {
    call(|arguments| {
        let path = Path::new(arguments.text(path, "path")?);
        let mut loader = SceneLoader::default();
        loader.unknown_is_occupied = unknown_is_occupied != 0;
        // NaN is a radius that the library rejects
        let radius = (point_radius != 0.0).then_some(point_radius);
        let loader = match arguments.object_or_none(robot, "robot")? {
            Some(robot) => read(loader, path, radius, &robot.model, &robot.files)?,
            None => read_without_robot(loader, path, radius)?,
        };
        let warnings = Names::new(loader.warnings.iter().map(String::as_str));
        let loaded = clearance_world { warnings, ..clearance_world::of_scene(loader.into_scene()) };
        arguments.write_handle(world, loaded, "world")
    })
}

fn read_without_robot(loader: SceneLoader, path: &Path, point_radius: Option<f64>) -> Outcome<SceneLoader> {
    let none = RobotModel::from_urdf(NO_ROBOT, &MeshFiles::default()).map_err(Failure::rejected)?;
    let files = MeshFiles::default().with_environment();
    read(loader, path, point_radius, &none, &files).map_err(|why| {
        Failure::rejected(format!(
            "{why} (the file was read without a robot: the argument robot gives the frames of its links)"
        ))
    })
}

fn read(
    mut loader: SceneLoader,
    path: &Path,
    point_radius: Option<f64>,
    robot: &RobotModel,
    files: &MeshFiles,
) -> Outcome<SceneLoader> {
    let bytes = input_files::read(path, WORLD_LIMIT).map_err(Failure::rejected)?;
    let kind = WorldFileKind::of(&bytes, path);
    let rejected = |why: &str| Err(Failure::rejected(format!("{}: {why}", path.display())));
    match (kind == WorldFileKind::Cloud, point_radius) {
        (true, None) => return rejected("a cloud needs a point_radius (m)"),
        (false, Some(_)) => return rejected("point_radius has no effect: the file is no cloud"),
        _ => {}
    }
    if loader.unknown_is_occupied && kind != WorldFileKind::Octomap {
        return rejected("unknown_is_occupied has no effect: the file is no octree");
    }
    let files = files.clone().with_folder(path.parent().unwrap_or(Path::new(".")));
    loader.read_file(&bytes, path, point_radius, robot, &files).map_err(mesh_failure)?;
    Ok(loader)
}

/// Makes a copy, which shares the shapes.
#[unsafe(no_mangle)]
pub extern "C" fn clearance_world_copy(
    world: *const clearance_world,
    copy: *mut *mut clearance_world,
) -> clearance_status {
    call(|arguments| {
        let scene = arguments.object(world, "world")?.scene.clone();
        arguments.write_handle(copy, clearance_world::of_scene(scene), "copy")
    })
}

/// Frees a world; null is ignored. Checkers that were made with it stay valid.
#[unsafe(no_mangle)]
pub extern "C" fn clearance_world_free(world: *mut clearance_world) {
    call(|arguments| arguments.release(world, "world"));
}

/// Number of obstacles.
#[unsafe(no_mangle)]
pub extern "C" fn clearance_world_obstacle_count(world: *const clearance_world) -> usize {
    call_for(0, |arguments| Ok(arguments.object(world, "world")?.scene.world.len()))
}

/// Name of an obstacle, valid until the world changes; null beyond the last.
#[unsafe(no_mangle)]
pub extern "C" fn clearance_world_obstacle_name(
    world: *const clearance_world,
    index: usize,
) -> *const c_char {
    call_for(ptr::null(), |arguments| Ok(arguments.object(world, "world")?.names().get(index)))
}

/// Number of warnings about unusual content of files that was accepted; copies have none.
#[unsafe(no_mangle)]
pub extern "C" fn clearance_world_warning_count(world: *const clearance_world) -> usize {
    call_for(0, |arguments| Ok(arguments.object(world, "world")?.warnings.len()))
}

/// Text of a warning, valid as long as the world; null beyond the last.
#[unsafe(no_mangle)]
pub extern "C" fn clearance_world_warning(world: *const clearance_world, index: usize) -> *const c_char {
    call_for(ptr::null(), |arguments| Ok(arguments.object(world, "world")?.warnings.get(index)))
}

/// Adds a box with 3 edges `size` (m) along x, y and z, centred at `pose`.
#[unsafe(no_mangle)]
pub extern "C" fn clearance_world_add_box(
    world: *mut clearance_world,
    name: *const c_char,
    size: *const f64,
    pose: *const clearance_pose,
) -> clearance_status {
    add(world, name, pose, |arguments| {
        let size = arguments.array(size, 3, "size")?;
        primitive(Primitive::cuboid([size[0], size[1], size[2]]))
    })
}

/// Adds a sphere (m), centred at `pose`.
#[unsafe(no_mangle)]
pub extern "C" fn clearance_world_add_sphere(
    world: *mut clearance_world,
    name: *const c_char,
    radius: f64,
    pose: *const clearance_pose,
) -> clearance_status {
    add(world, name, pose, |_| primitive(Primitive::sphere(radius)))
}

/// Adds a cylinder (m) along z, centred at `pose`.
#[unsafe(no_mangle)]
pub extern "C" fn clearance_world_add_cylinder(
    world: *mut clearance_world,
    name: *const c_char,
    radius: f64,
    length: f64,
    pose: *const clearance_pose,
) -> clearance_status {
    add(world, name, pose, |_| primitive(Primitive::cylinder(radius, length)))
}

/// Adds a capsule (m) along z, centred at `pose`; `length` does not include its half spheres.
#[unsafe(no_mangle)]
pub extern "C" fn clearance_world_add_capsule(
    world: *mut clearance_world,
    name: *const c_char,
    radius: f64,
    length: f64,
    pose: *const clearance_pose,
) -> clearance_status {
    add(world, name, pose, |_| primitive(Primitive::capsule(radius, length)))
}

/// Adds a triangle mesh.
#[unsafe(no_mangle)]
pub extern "C" fn clearance_world_add_mesh(
    world: *mut clearance_world,
    name: *const c_char,
    mesh: clearance_mesh,
    pose: *const clearance_pose,
) -> clearance_status {
    add(world, name, pose, |arguments| shapes::mesh(arguments, mesh))
}

/// Adds a mesh file (STL, OBJ, COLLADA, PLY, glTF); `scale` has a factor for each axis, or is null.
///
/// Unusual content that is accepted is among the warnings (`clearance_world_warning`).
#[unsafe(no_mangle)]
pub extern "C" fn clearance_world_add_mesh_file(
    world: *mut clearance_world,
    name: *const c_char,
    path: *const c_char,
    scale: *const f64,
    pose: *const clearance_pose,
) -> clearance_status {
    let mut remarks = Vec::new();
    let status = add(world, name, pose, |arguments| {
        let path = Path::new(arguments.text(path, "path")?);
        let scale = if scale.is_null() { &[1.0; 3] } else { arguments.array(scale, 3, "scale")? };
        let (shape, found) = shapes::mesh_file(path, [scale[0], scale[1], scale[2]])?;
        remarks.extend(found.iter().map(|remark| format!("{}: {remark}", path.display())));
        Ok(shape)
    });
    if status != clearance_status::Ok {
        return status;
    }
    call(|arguments| {
        let world = arguments.object_mut(world, "world")?;
        world.warnings.extend(remarks.iter().map(String::as_str));
        Ok(())
    })
}

/// Adds solid balls of one `radius` (m) around points, in the frame at `pose`.
///
/// Points are kept as 32-bit floats; the radius grows by the largest rounding, so that nothing is lost.
#[unsafe(no_mangle)]
pub extern "C" fn clearance_world_add_points(
    world: *mut clearance_world,
    name: *const c_char,
    points: clearance_points,
    radius: f64,
    pose: *const clearance_pose,
) -> clearance_status {
    add(world, name, pose, |arguments| shapes::points(arguments, points, radius))
}

/// Moves an obstacle. Rejected: an unknown name.
#[unsafe(no_mangle)]
pub extern "C" fn clearance_world_move(
    world: *mut clearance_world,
    name: *const c_char,
    pose: *const clearance_pose,
) -> clearance_status {
    change(world, name, |arguments, scene, name| {
        let pose = read_pose(arguments, pose, name)?;
        scene.world.move_to(name, pose).map_err(|_| Failure::rejected(why_no_obstacle(scene, name)))
    })
}

/// Removes an obstacle. Rejected: an unknown name.
#[unsafe(no_mangle)]
pub extern "C" fn clearance_world_remove(
    world: *mut clearance_world,
    name: *const c_char,
) -> clearance_status {
    change(world, name, |_, scene, name| match scene.world.remove(name) {
        Ok(_) => Ok(()),
        Err(_) => Err(Failure::rejected(why_no_obstacle(scene, name))),
    })
}
