//! Command line arguments that define a motion: `motion` checks it, `verify` expects it.

use std::path::{Path, PathBuf};

use clap::Args;
use clearance::motion::{
    ContinuousDirection, MotionSegment, ObstacleMotions, Trajectory, TrajectoryTextError, shortest_turns,
};
use clearance::robot::{Configuration, RobotModel};
use clearance::scene::World;
use clearance_files::input_files::{self, STATES_LIMIT};

use super::failure::Failure;
use super::run_args::PairArgs;
use super::states;

/// Formats of trajectory files, for error messages.
const TRAJECTORY: &str =
    "the YAML or JSON of a trajectory_msgs/JointTrajectory or moveit_msgs/RobotTrajectory";

/// Motions of the robot, their tracking tolerance, and moving obstacles.
#[derive(Args)]
pub struct MotionInputArgs {
    #[command(flatten)]
    input: InputArgs,

    /// End of a straight motion; joints that are not named stay where --from has them
    #[arg(long, value_name = "J=X ...", allow_hyphen_values = true, requires = "from")]
    to: Option<String>,

    /// Tracking tolerance of the joints: one number (rad, m) for all joints, mimic joints included, or "j1=0.01 j2=0.02"
    #[arg(long, value_name = "T", allow_hyphen_values = true)]
    tube: Option<String>,

    /// Largest deviation of the true motion from the straight motions between samples: one number (rad, m) for all joints, mimic joints
    /// included, or "j1=0.001 j2=0.002". For trajectories that sample a line or an arc of a link. It adds to --tube
    #[arg(long, value_name = "D", allow_hyphen_values = true)]
    deviation: Option<String>,

    /// Direction of rotation of continuous joints between two positions
    #[arg(long, value_enum, default_value_t = Continuous::AsGiven)]
    continuous: Continuous,

    /// Obstacles that move during the motion: YAML or JSON, a list "moving_obstacles" of obstacles by "name", each with a twist ("linear" in
    /// m/s, "angular" in rad/s about "centre") or with "poses" ("time" in s, "position", "orientation"), in the root frame.
    ///
    /// A list "obstacle_limits" of a "speed" in m/s and an "acceleration" in m/s2, by "name" or for all others, lets obstacles move in
    /// addition: the proof then holds for every such motion. "obstacle_latency" in s: their poses are older than the start.
    ///
    /// Times are those of the trajectory, which then needs time_from_start. A twist starts at time 0. The first pose must be
    /// the obstacle's pose in the world. A straight motion lasts from time 0 to 1, so a twist is the displacement during the whole motion.
    #[arg(long, value_name = "FILE")]
    moving: Option<PathBuf>,
}

#[derive(clap::ValueEnum, Clone, Copy, PartialEq, Eq)]
enum Continuous {
    /// Through all positions between the two
    AsGiven,
    /// By at most half a turn between all points of a motion: full turns are subtracted from earlier points. joint_trajectory_controller
    /// does this only from the current state to the first point, and then moves through all positions
    Shortest,
}

#[derive(Args)]
#[group(id = "motion", multiple = false)]
struct InputArgs {
    /// Straight motions in joint space: JSON {"joints": [...], "edges": [[[...], [...]], ...]}
    #[arg(long, value_name = "FILE")]
    edges: Option<PathBuf>,

    /// One trajectory: the YAML or JSON of a trajectory_msgs/JointTrajectory or moveit_msgs/RobotTrajectory
    #[arg(long, value_name = "FILE")]
    trajectory: Option<PathBuf>,

    /// Start of a straight motion, such as "j1=0.1 j2=-1.2"; other joints take 0, or the middle of limits that exclude 0
    #[arg(long, value_name = "J=X ...", allow_hyphen_values = true, requires = "to")]
    from: Option<String>,
}

impl MotionInputArgs {
    /// Whether the arguments contain a motion.
    pub fn is_given(&self) -> bool {
        let InputArgs { edges, trajectory, from } = &self.input;
        edges.is_some() || trajectory.is_some() || from.is_some()
    }

    /// Whether any of the arguments is given.
    pub fn is_any_given(&self) -> bool {
        let others = [&self.to, &self.tube, &self.deviation].into_iter().any(Option::is_some);
        self.is_given() || others || self.moves_obstacles() || self.directs_joints()
    }

    pub fn is_trajectory(&self) -> bool {
        self.input.trajectory.is_some()
    }

    /// Whether a file defines moving obstacles.
    pub fn moves_obstacles(&self) -> bool {
        self.moving.is_some()
    }

    /// Rejects moving obstacles if no pair with an obstacle is checked.
    pub fn check_effect(&self, pairs: PairArgs) -> Result<(), Failure> {
        if self.moves_obstacles() && pairs.no_world {
            let why =
                "--moving has no effect with --no-world, which leaves all obstacles out: give one of them";
            return Err(Failure::Input(why.to_owned()));
        }
        Ok(())
    }

    /// Whether continuous joints move in another direction than given.
    pub fn directs_joints(&self) -> bool {
        self.continuous != Continuous::AsGiven
    }

    /// Tolerance (rad, m) of each position, if one is given: of the tracking, and of the motion between samples.
    pub fn tube(&self, robot: &RobotModel) -> Result<Option<Vec<f64>>, Failure> {
        let read = |name: &str, text: &Option<String>| {
            text.as_ref().map(|text| states::tube_from_text(name, text, robot)).transpose()
        };
        Ok(match (read("--tube", &self.tube)?, read("--deviation", &self.deviation)?) {
            (Some(tube), Some(deviation)) => Some(tube.iter().zip(&deviation).map(|(a, b)| a + b).collect()),
            (tube, deviation) => tube.or(deviation),
        })
    }

    /// The motions with the moving obstacles.
    pub fn with_obstacles(
        &self,
        trajectories: &[Trajectory],
        world: &World,
    ) -> Result<Vec<Trajectory>, Failure> {
        let Some(path) = &self.moving else { return Ok(trajectories.to_vec()) };
        let file = path.display();
        let bad = |e: &dyn std::fmt::Display| Failure::Input(format!("{file}: {e}"));
        let text = input_files::read_text(path, STATES_LIMIT).map_err(Failure::input)?;
        let obstacles = ObstacleMotions::from_yaml(&text, world).map_err(|e| bad(&e))?;
        (trajectories.iter())
            .map(|t| t.clone().with_obstacle_motions(world, &obstacles).map_err(|e| bad(&e)))
            .collect()
    }

    fn direction(&self) -> ContinuousDirection {
        match self.continuous {
            Continuous::AsGiven => ContinuousDirection::AsGiven,
            Continuous::Shortest => ContinuousDirection::Shortest,
        }
    }

    /// End points of a straight motion, adapted to the requested direction of the continuous joints.
    fn directed(&self, robot: &RobotModel, ends: [Configuration; 2]) -> Result<[Configuration; 2], Failure> {
        if self.continuous == Continuous::AsGiven {
            return Ok(ends);
        }
        let (ends, held) = shortest_turns(robot, ends.to_vec()).map_err(Failure::input)?;
        match (held.into_iter().next(), <[Configuration; 2]>::try_from(ends)) {
            (None, Ok(ends)) => Ok(ends),
            (Some(held), _) => Err(Failure::Input(format!("--continuous shortest: {held}"))),
            (None, Err(_)) => Err(Failure::Internal("a way has two ends".to_owned())),
        }
    }

    /// The motions of the robot, each as a trajectory.
    pub fn trajectories(&self, robot: &RobotModel) -> Result<Vec<Trajectory>, Failure> {
        let straight = |ends: [Configuration; 2]| {
            let [from, to] = self.directed(robot, ends)?;
            Trajectory::of_segments(vec![MotionSegment::straight(robot, &from, &to)]).map_err(Failure::input)
        };
        if self.to.is_some() && self.input.from.is_none() {
            return Err(Failure::Input(
                "--to belongs to --from: give --from, or --edges or --trajectory alone".to_owned(),
            ));
        }
        let trajectories = match (&self.input.edges, &self.input.trajectory, &self.input.from, &self.to) {
            (Some(path), ..) => {
                states::edges_from_file(path, robot)?.into_iter().map(straight).collect::<Result<_, _>>()?
            }
            (_, Some(path), ..) => vec![trajectory(path, robot, self.direction())?],
            (.., Some(from), Some(to)) => {
                let from = states::from_text("--from", from, robot)?;
                let to = states::from_text_over("--to", to, robot, &from)?;
                vec![straight([from, to])?]
            }
            _ => return Err(Failure::Input("give --edges, --trajectory, or --from and --to".to_owned())),
        };
        match self.tube(robot)? {
            None => Ok(trajectories),
            Some(tube) => {
                let with_tube = |t: Trajectory| t.map(|s| s.with_tube(robot, tube.clone()));
                trajectories.into_iter().map(with_tube).collect::<Result<_, _>>().map_err(Failure::input)
            }
        }
    }
}

fn trajectory(
    path: &Path,
    robot: &RobotModel,
    direction: ContinuousDirection,
) -> Result<Trajectory, Failure> {
    let file = path.display();
    let bad = |e: &dyn std::fmt::Display| Failure::Input(format!("{file}: {e}"));
    let text = input_files::read_text(path, STATES_LIMIT).map_err(Failure::input)?;
    let read = Trajectory::from_yaml_with_direction(robot, &text, &robot.default_configuration(), direction);
    let (trajectory, remarks) = read.map_err(|e| match e {
        TrajectoryTextError::Text(_) => bad(&format!("{e} (a trajectory is {TRAJECTORY})")),
        TrajectoryTextError::Trajectory(_) | TrajectoryTextError::Start(_) => bad(&e),
    })?;
    for remark in remarks {
        log::warn!("{file}: {remark}");
    }
    Ok(trajectory)
}
