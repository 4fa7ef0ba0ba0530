//! C interface of the robot model: loading, names, limits, group states, random states and forward kinematics.

use std::ffi::{CString, c_char};
use std::fmt::Display;
use std::path::{Path, PathBuf};
use std::ptr;
use std::sync::Arc;

use clearance::geometry::math::Pose;
use clearance::robot::{Configuration, LinkPoses, MeshFiles, RobotModel, RobotText, check_package_path};
use clearance_bindings::{JointSpace, with_package_paths};
use clearance_files::input_files::{self, DESCRIPTION_LIMIT};

use crate::arguments::Arguments;
use crate::rows;
use crate::status::{Failure, Outcome, call, call_for, clearance_status};
use crate::structs::{clearance_named_value, clearance_pose, clearance_state, named_values, texts};
use crate::texts::{Names, c_text};

/// A robot: links and joints from URDF, groups and allowed collisions from SRDF, with the meshes. Immutable: any number of threads may
/// use it.
///
/// Joint positions are in the order of `clearance_robot_joint_name` (rad, m). Mimic joints have no position of their own: they follow
/// their leaders. A floating joint `j` has seven positions, `j/trans_x j/trans_y j/trans_z j/rot_x j/rot_y j/rot_z j/rot_w`, a planar
/// one three, `j/x j/y j/theta`. All poses are in the frame of the root link.
#[derive(Debug)]
pub struct clearance_robot {
    pub(crate) model: Arc<RobotModel>,
    pub(crate) files: MeshFiles,
    space: JointSpace,
    texts: RobotTexts,
}

#[derive(Debug)]
struct RobotTexts {
    name: CString,
    joints: Names,
    links: Names,
    warnings: Names,
    groups: Names,
    group_joints: Vec<Names>,
    group_states: Names,
}

impl RobotTexts {
    fn new(model: &Arc<RobotModel>) -> Self {
        let groups = model.srdf().map_or(&[][..], |srdf| &srdf.groups);
        let states = model.srdf().map_or(&[][..], |srdf| &srdf.group_states);
        let joints_of = |group: &str| {
            let space = JointSpace::of_group(Arc::clone(model), Some(group), &[]);
            space.map_or_else(|_| Names::default(), |space| names(space.names()))
        };
        let states: Vec<String> =
            states.iter().map(|state| format!("{}/{}", state.group, state.name)).collect();
        let warnings: Vec<String> = model.warnings().iter().map(ToString::to_string).collect();
        Self {
            name: c_text(model.name()),
            joints: names(model.position_names()),
            links: Names::new(model.links().iter().map(|link| link.name.as_str())),
            warnings: names(&warnings),
            groups: Names::new(groups.iter().map(|group| group.name.as_str())),
            group_joints: groups.iter().map(|group| joints_of(&group.name)).collect(),
            group_states: names(&states),
        }
    }
}

fn names(texts: &[String]) -> Names {
    Names::new(texts.iter().map(String::as_str))
}

impl clearance_robot {
    fn configuration(&self, arguments: Arguments<'_>, state: clearance_state) -> Outcome<Configuration> {
        let row = arguments.array(state.positions, state.n, "state")?;
        rows::read(&self.space, row, &|| "state".to_owned())
    }
}

/// The pose of a link in the root frame.
pub fn link_pose(robot: &RobotModel, link: &str, q: &Configuration) -> Outcome<Pose> {
    let id = robot.link_by_name(link).ok_or_else(|| {
        let names: Vec<&str> = robot.links().iter().map(|link| link.name.as_str()).collect();
        Failure::rejected(format!("the robot has no link '{link}'; it has {}", names.join(", ")))
    })?;
    let mut poses = LinkPoses::new(robot);
    robot.forward_kinematics(q, &mut poses);
    Ok(*poses.pose(id))
}

/// A rejection, perhaps of a mesh that is not found.
pub fn mesh_failure(why: impl Display) -> Failure {
    Failure::rejected(with_package_paths(&why.to_string(), "package_paths of clearance_robot_from_urdf"))
}

/// A text of a robot's description, and its path if it is a file.
struct Source {
    text: String,
    path: Option<PathBuf>,
}

impl Source {
    /// XML text, or else a path, of the argument `name`.
    fn read(given: &str, name: &str) -> Outcome<Self> {
        let content = given.trim_start_matches('\u{feff}').trim_start();
        if content.is_empty() {
            return Err(Failure::rejected(format!("{name} is empty: give a path or XML text")));
        }
        if content.starts_with('<') {
            return Ok(Self { text: given.to_owned(), path: None });
        }
        let path = PathBuf::from(given);
        let text = input_files::read_text(&path, DESCRIPTION_LIMIT).map_err(Failure::rejected)?;
        Ok(Self { text, path: Some(path) })
    }

    fn name(&self) -> Option<&str> {
        self.path.as_deref().and_then(Path::to_str)
    }
}

fn load(urdf: &Source, srdf: Option<&Source>, package_paths: &[String]) -> Outcome<clearance_robot> {
    for dir in package_paths {
        check_package_path(Path::new(dir))
            .map_err(|why| Failure::rejected(format!("package_paths: {why}")))?;
    }
    let files = package_paths.iter().fold(MeshFiles::default(), MeshFiles::with_package_path);
    let files = match &urdf.path {
        Some(path) => {
            let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
            files.beside_urdf(folder.unwrap_or(Path::new(".")))
        }
        None => files,
    };
    let files = files.with_environment();
    let text = RobotText {
        urdf: &urdf.text,
        urdf_name: urdf.name(),
        srdf: srdf.map(|srdf| srdf.text.as_str()),
        srdf_name: srdf.and_then(Source::name),
    };
    let model = Arc::new(RobotModel::from_text(&text, &files).map_err(mesh_failure)?);
    let (space, texts) = (JointSpace::whole(Arc::clone(&model)), RobotTexts::new(&model));
    Ok(clearance_robot { model, files, space, texts })
}

/// Reads a robot. `urdf` and `srdf` are paths, or XML texts; `srdf` may be null.
///
/// `package://NAME/path` is searched in the `package_path_count` folders `package_paths`, then beside the URDF and in its parents, then in
/// `AMENT_PREFIX_PATH` and `ROS_PACKAGE_PATH`. A xacro file has to be expanded before.
///
/// Rejected: every fault of the files; the text names file, line, link and joint. Unusual content that is accepted is among the warnings
/// (`clearance_robot_warning`).
#[unsafe(no_mangle)]
pub extern "C" fn clearance_robot_from_urdf(
    urdf: *const c_char,
    srdf: *const c_char,
    package_paths: *const *const c_char,
    package_path_count: usize,
    robot: *mut *mut clearance_robot,
) -> clearance_status {
    call(|arguments| {
        let urdf = Source::read(arguments.text(urdf, "urdf")?, "urdf")?;
        let srdf = arguments.text_or_none(srdf, "srdf")?;
        let srdf = srdf.map(|srdf| Source::read(srdf, "srdf")).transpose()?;
        let package_paths = texts(arguments, package_paths, package_path_count, "package_paths")?;
        arguments.write_handle(robot, load(&urdf, srdf.as_ref(), &package_paths)?, "robot")
    })
}

/// Frees a robot; null is ignored. Worlds and checkers that were made with it stay valid.
#[unsafe(no_mangle)]
pub extern "C" fn clearance_robot_free(robot: *mut clearance_robot) {
    call(|arguments| arguments.release(robot, "robot"));
}

/// A part of a robot's texts, or `default` for null.
fn of_robot<T>(robot: *const clearance_robot, default: T, get: impl FnOnce(&clearance_robot) -> T) -> T {
    call_for(default, |arguments| Ok(get(arguments.object(robot, "robot")?)))
}

/// Name of the robot in the URDF. All texts of a robot are valid as long as the robot.
#[unsafe(no_mangle)]
pub extern "C" fn clearance_robot_name(robot: *const clearance_robot) -> *const c_char {
    of_robot(robot, ptr::null(), |robot| robot.texts.name.as_ptr())
}

/// Number of joint positions of the robot.
#[unsafe(no_mangle)]
pub extern "C" fn clearance_robot_joint_count(robot: *const clearance_robot) -> usize {
    of_robot(robot, 0, |robot| robot.texts.joints.len())
}

/// Name of a joint position; null beyond the last.
#[unsafe(no_mangle)]
pub extern "C" fn clearance_robot_joint_name(robot: *const clearance_robot, index: usize) -> *const c_char {
    of_robot(robot, ptr::null(), |robot| robot.texts.joints.get(index))
}

/// Number of links.
#[unsafe(no_mangle)]
pub extern "C" fn clearance_robot_link_count(robot: *const clearance_robot) -> usize {
    of_robot(robot, 0, |robot| robot.texts.links.len())
}

/// Name of a link, in the order of the URDF; null beyond the last.
#[unsafe(no_mangle)]
pub extern "C" fn clearance_robot_link_name(robot: *const clearance_robot, index: usize) -> *const c_char {
    of_robot(robot, ptr::null(), |robot| robot.texts.links.get(index))
}

/// Name of the root link, whose frame is the frame of all poses and points.
#[unsafe(no_mangle)]
pub extern "C" fn clearance_robot_root_link(robot: *const clearance_robot) -> *const c_char {
    of_robot(robot, ptr::null(), |robot| robot.texts.links.get(robot.model.root().index()))
}

/// Number of warnings about unusual content that was accepted.
#[unsafe(no_mangle)]
pub extern "C" fn clearance_robot_warning_count(robot: *const clearance_robot) -> usize {
    of_robot(robot, 0, |robot| robot.texts.warnings.len())
}

/// Text of a warning; null beyond the last.
#[unsafe(no_mangle)]
pub extern "C" fn clearance_robot_warning(robot: *const clearance_robot, index: usize) -> *const c_char {
    of_robot(robot, ptr::null(), |robot| robot.texts.warnings.get(index))
}

/// Number of groups of the SRDF.
#[unsafe(no_mangle)]
pub extern "C" fn clearance_robot_group_count(robot: *const clearance_robot) -> usize {
    of_robot(robot, 0, |robot| robot.texts.groups.len())
}

/// Name of a group; null beyond the last.
#[unsafe(no_mangle)]
pub extern "C" fn clearance_robot_group_name(robot: *const clearance_robot, group: usize) -> *const c_char {
    of_robot(robot, ptr::null(), |robot| robot.texts.groups.get(group))
}

/// Number of joint positions of a group; 0 beyond the last group.
#[unsafe(no_mangle)]
pub extern "C" fn clearance_robot_group_joint_count(robot: *const clearance_robot, group: usize) -> usize {
    of_robot(robot, 0, |robot| robot.texts.group_joints.get(group).map_or(0, Names::len))
}

/// Name of a joint position of a group, in the order of the states of a checker of this group; null beyond the last.
#[unsafe(no_mangle)]
pub extern "C" fn clearance_robot_group_joint_name(
    robot: *const clearance_robot,
    group: usize,
    index: usize,
) -> *const c_char {
    of_robot(robot, ptr::null(), |robot| {
        robot.texts.group_joints.get(group).map_or(ptr::null(), |names| names.get(index))
    })
}

/// Number of group states of the SRDF.
#[unsafe(no_mangle)]
pub extern "C" fn clearance_robot_group_state_count(robot: *const clearance_robot) -> usize {
    of_robot(robot, 0, |robot| robot.texts.group_states.len())
}

/// Name of a group state as `GROUP/STATE`; null beyond the last.
#[unsafe(no_mangle)]
pub extern "C" fn clearance_robot_group_state_name(
    robot: *const clearance_robot,
    index: usize,
) -> *const c_char {
    of_robot(robot, ptr::null(), |robot| robot.texts.group_states.get(index))
}

/// Writes the `n` lower and `n` upper limits (rad, m), also of the joints that mimic these; infinite without limit.
///
/// `n` is the number of joint positions. Collisions are checked beyond limits, too.
#[unsafe(no_mangle)]
pub extern "C" fn clearance_robot_limits(
    robot: *const clearance_robot,
    lower: *mut f64,
    upper: *mut f64,
    n: usize,
) -> clearance_status {
    call(|arguments| {
        let ranges = arguments.object(robot, "robot")?.model.position_ranges();
        let side = |k: usize| ranges.iter().map(|range| range[k]).collect::<Vec<f64>>();
        arguments.write_array(lower, n, &side(0), "lower")?;
        arguments.write_array(upper, n, &side(1), "upper")
    })
}

/// Writes a state of `n` positions with `count` joints set by name (rad, m).
///
/// The others are at 0, or in the middle of limits that exclude 0. A mimic joint moves its leader. Rejected: unknown names.
#[unsafe(no_mangle)]
pub extern "C" fn clearance_robot_state(
    robot: *const clearance_robot,
    values: *const clearance_named_value,
    count: usize,
    positions: *mut f64,
    n: usize,
) -> clearance_status {
    call(|arguments| {
        let robot = arguments.object(robot, "robot")?;
        let values = named_values(arguments, values, count, "values")?;
        let given = values.iter().map(|(name, value)| (name.as_str(), *value));
        let q = robot.model.configuration_from_names(given).map_err(Failure::rejected)?;
        arguments.write_array(positions, n, q.positions(), "positions")
    })
}

/// Writes a group state of the SRDF as a state of `n` positions, those of the whole robot. `name` is `STATE`, or `GROUP/STATE` where
/// several groups have a state of this name. Joints that it does not name are at their defaults.
///
/// Rejected: unknown, ambiguous and faulty states.
#[unsafe(no_mangle)]
pub extern "C" fn clearance_robot_group_state(
    robot: *const clearance_robot,
    name: *const c_char,
    positions: *mut f64,
    n: usize,
) -> clearance_status {
    call(|arguments| {
        let robot = arguments.object(robot, "robot")?;
        let q = robot.model.group_state(arguments.text(name, "name")?).map_err(Failure::rejected)?;
        arguments.write_array(positions, n, q.positions(), "positions")
    })
}

/// Writes `count` random states of `n` positions each, those of the whole robot, uniform between the limits.
///
/// `seed` is the state of the random generator, and is updated: the same number gives the same states. Continuous joints are within half
/// a turn; prismatic joints without limits are within half a metre. Planar and floating joints keep their default positions.
#[unsafe(no_mangle)]
pub extern "C" fn clearance_robot_random_states(
    robot: *const clearance_robot,
    seed: *mut u64,
    count: usize,
    positions: *mut f64,
    n: usize,
) -> clearance_status {
    call(|arguments| {
        let robot = arguments.object(robot, "robot")?;
        let mut random = fastrand::Rng::with_seed(*arguments.object(seed, "seed")?);
        let columns = robot.space.names().len();
        if n != columns {
            return Err(Failure::argument(format!("n is {n}, but the robot has {columns} joint positions")));
        }
        if n == 0 {
            return Ok(());
        }
        let total = count.saturating_mul(n);
        arguments.check_room(positions, total, "positions")?;
        let mut states = Vec::new();
        for _ in 0..count {
            states.extend_from_slice(robot.model.random_configuration(&mut random).positions());
        }
        arguments.write_array(positions, total, &states, "positions")?;
        arguments.write(seed, random.get_seed(), "seed")
    })
}

/// Writes the poses of all links in the frame of the root link, in the order of `clearance_robot_link_name`; `count` is their number.
///
/// `state` has all positions of the robot. Rejected: positions that are not finite.
#[unsafe(no_mangle)]
pub extern "C" fn clearance_robot_forward_kinematics(
    robot: *const clearance_robot,
    state: clearance_state,
    poses: *mut clearance_pose,
    count: usize,
) -> clearance_status {
    call(|arguments| {
        let robot = arguments.object(robot, "robot")?;
        let q = robot.configuration(arguments, state)?;
        let mut of_links = LinkPoses::new(&robot.model);
        robot.model.forward_kinematics(&q, &mut of_links);
        let all: Vec<_> =
            robot.model.link_ids().map(|link| clearance_pose::new(of_links.pose(link))).collect();
        arguments.write_array(poses, count, &all, "poses")
    })
}

/// Writes the pose of a link in the frame of the root link. `state` has all positions of the robot.
///
/// Rejected: an unknown link, and positions that are not finite.
#[unsafe(no_mangle)]
pub extern "C" fn clearance_robot_link_pose(
    robot: *const clearance_robot,
    state: clearance_state,
    link: *const c_char,
    pose: *mut clearance_pose,
) -> clearance_status {
    call(|arguments| {
        let robot = arguments.object(robot, "robot")?;
        let q = robot.configuration(arguments, state)?;
        let found = link_pose(&robot.model, arguments.text(link, "link")?, &q)?;
        arguments.write(pose, clearance_pose::new(&found), "pose")
    })
}
