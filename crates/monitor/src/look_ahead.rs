//! Look-ahead: the time until which nothing can touch, computed from one joint state with velocities.

use std::sync::Arc;

use clearance_checker::{CollisionChecker, CollisionReport, LookAhead, LookAheadState, Workspace};
use clearance_geometry::math::Extremes;
use clearance_motion::{MovingObstacle, ObstacleLimits, SpeedLimit};
use clearance_robot::{Configuration, JointKind, LinkPoses, RobotModel, quoted, quoted_list};

use super::obstacle_motion::ObstacleMotion;
use super::past_states::{Leg, PastStates};
use super::root_speed::{JointRanges, RootSpeed};
use super::tracked_obstacle::TrackedObstacles;
use super::{LeftOut, MonitorSettings, Time};

/// Look-ahead for one checker.
#[derive(Debug)]
pub(super) struct LookAheadEvaluator {
    /// Its own workspace, so that its motions do not overwrite the data that speeds up the stream of states.
    workspace: Workspace,
    /// By position: acceleration limit (rad/s², m/s²), if it has one.
    limits: Vec<Option<f64>>,
    /// Whether the robot has a floating joint. Its velocity is not the derivative of its seven positions, so there is
    /// no look-ahead for such a robot.
    floats: bool,
}

/// State that a look-ahead starts from.
pub(super) struct LookAheadInput<'i> {
    pub configuration: &'i Configuration,
    /// Velocities of the positions, if all are known.
    pub velocities: Option<&'i [f64]>,
    /// Difference (s) between the times of measurement of the joints.
    pub spread: f64,
    /// Result of the check of this state.
    pub report: &'i CollisionReport,
    pub poses: &'i LinkPoses,
    pub obstacle_motions: &'i [ObstacleMotion],
    /// Obstacles that move by themselves.
    pub tracked_obstacles: &'i TrackedObstacles,
    /// Configurations up to this one.
    pub past_states: &'i PastStates,
    /// Stamp of the state.
    pub stamp: Time,
    /// Time (s) for which the obstacles have not been moved to follow `tf`.
    pub obstacle_lag: f64,
    /// A frame of obstacles in which nothing shows whether the root moves.
    pub unwatched_frame: Option<&'i str>,
    /// Whether the deadline leaves no time for it.
    pub is_late: bool,
}

impl LookAheadInput<'_> {
    /// The part that the deadline leaves out.
    pub fn left_out(&self, settings: &MonitorSettings) -> LeftOut {
        let is_on = settings.look_ahead_horizon > 0.0;
        if self.is_late && is_on { LeftOut::LookAhead } else { LeftOut::Nothing }
    }
}

impl LookAheadEvaluator {
    pub fn new(checker: &CollisionChecker) -> Self {
        let robot = checker.robot();
        let floats = robot.joints().iter().any(|joint| joint.kind == JointKind::Floating);
        Self { workspace: checker.workspace(), limits: acceleration_limits(robot), floats }
    }

    /// Proven time without contact after an evaluated state, with warnings, also if it is unknown; nothing if it is off.
    pub fn look_in_time(
        &mut self,
        checker: &CollisionChecker,
        input: &LookAheadInput,
        settings: &MonitorSettings,
    ) -> (Option<LookAhead>, Vec<String>) {
        if settings.look_ahead_horizon <= 0.0 {
            return (None, Vec::new());
        }
        if input.is_late {
            return (None, vec!["the time to contact is not known: check_deadline has passed".to_owned()]);
        }
        match self.look(checker, input, settings) {
            Ok(found) => (Some(found), Vec::new()),
            Err(why) => (None, vec![why]),
        }
    }

    /// Proven time without contact after an evaluated state, or why it is unknown.
    fn look(
        &mut self,
        checker: &CollisionChecker,
        input: &LookAheadInput,
        settings: &MonitorSettings,
    ) -> Result<LookAhead, String> {
        let &LookAheadInput { configuration, velocities, spread, report, tracked_obstacles, .. } = input;
        let unknown = |why: &str| Err(format!("the time to contact is not known: {why}"));
        if let Some(&pair) = report.colliding_pairs.first() {
            return Ok(LookAhead { free_for: 0.0, first: Some(pair) });
        }
        if self.floats {
            return unknown("the robot has a floating joint");
        }
        let Some(velocities) = velocities else {
            return unknown("the joint state does not give every joint a finite velocity");
        };
        // the computation starts all joints at the same time: a joint that was measured later has moved since
        if spread > 0.0 {
            return unknown(&format!("joints were measured {spread:.3} s apart"));
        }
        let usual = settings.look_ahead_acceleration;
        let accelerations: Vec<f64> = self.limits.iter().map(|limit| limit.unwrap_or(usual)).collect();
        let horizon = settings.look_ahead_horizon;
        let positions = configuration.positions();
        let ranges = JointRanges { positions, velocities, accelerations: &accelerations, horizon };
        let of_root = RootSpeed::after(input, checker, &ranges, settings.look_ahead_root_accelerations);
        let of_root = of_root.map_err(|why| format!("the time to contact is not known: {why}"))?;
        if let Some(name) = tracked_obstacles.of_a_later_clock() {
            return unknown(&format!("the last state of obstacle {} has a later stamp", quoted(name)));
        }
        match self.since_poses(checker, input, settings) {
            Ok(LookAhead { free_for, first }) if free_for <= 0.0 => return Ok(LookAhead { free_for, first }),
            Ok(_) => {}
            Err(why) => return unknown(&why),
        }
        let mut obstacle_limits = tracked_obstacles.limits_beyond_motion(&settings.obstacle_limits);
        let accelerating = tracked_obstacles.longest_age(|limit| limit.acceleration > 0.0, settings);
        let mut obstacle_latency = settings.obstacle_latency.greater(accelerating);
        if let Some(RootSpeed { limit, latency }) = of_root {
            obstacle_limits = obstacle_limits.relative_to(limit);
            // the root has moved since a state, too
            obstacle_latency +=
                latency + input.obstacle_lag + tracked_obstacles.longest_age(|_| true, settings);
        }
        let obstacle_limits = Some(Arc::new(obstacle_limits)).filter(|limits| !limits.is_zero());
        let moving_obstacles = tracked_obstacles.motions(horizon);
        let state = LookAheadState {
            q: configuration,
            velocities,
            accelerations: &accelerations,
            moving_obstacles: &moving_obstacles,
            obstacle_limits: obstacle_limits.as_ref(),
            obstacle_latency,
            only_moving_obstacles: false,
        };
        let found = checker.look_ahead(state, horizon, &mut self.workspace);
        found.or_else(|error| unknown(&error.to_string()))
    }
}

impl LookAheadEvaluator {
    /// No time is left if a moving obstacle may have touched since its last known pose: where it moves on from there is not
    /// known. The robot was where its states say.
    fn since_poses(
        &mut self,
        checker: &CollisionChecker,
        input: &LookAheadInput,
        settings: &MonitorSettings,
    ) -> Result<LookAhead, String> {
        for (age, obstacles) in input.tracked_obstacles.by_age() {
            let limit = |obstacle: &MovingObstacle| settings.obstacle_limits.of(&obstacle.name);
            let beyond = obstacles
                .iter()
                .map(|obstacle| (obstacle.name.clone(), SpeedLimit { speed: 0.0, ..limit(obstacle) }));
            let limits = ObstacleLimits { by_name: beyond.collect(), ..ObstacleLimits::default() };
            let limits = Some(Arc::new(limits)).filter(|limits| !limits.is_zero());
            for leg in input.past_states.legs(age) {
                let since_pose = leg.before.map(|before| age - before);
                let moving: Vec<_> = obstacles.iter().map(|obstacle| obstacle.part(since_pose)).collect();
                let found = self.on_leg(checker, &leg, &moving, limits.as_ref(), since_pose[0])?;
                if found.free_for < leg.duration() {
                    return Ok(LookAhead { free_for: 0.0, ..found });
                }
            }
        }
        Ok(LookAhead { free_for: f64::INFINITY, first: None })
    }

    /// Time without contact of moving obstacles on a leg that the robot has passed.
    fn on_leg(
        &mut self,
        checker: &CollisionChecker,
        leg: &Leg,
        moving_obstacles: &[MovingObstacle],
        obstacle_limits: Option<&Arc<ObstacleLimits>>,
        obstacle_latency: f64,
    ) -> Result<LookAhead, String> {
        let ([from, to], duration) = (&leg.ends, leg.duration());
        let velocities: Vec<f64> = from.iter().zip(to).map(|(from, to)| (to - from) / duration).collect();
        let state = LookAheadState {
            q: &checker.robot().configuration(from).map_err(|error| error.to_string())?,
            velocities: &velocities,
            accelerations: &vec![0.0; velocities.len()],
            moving_obstacles,
            obstacle_limits,
            obstacle_latency,
            only_moving_obstacles: true,
        };
        checker.look_ahead(state, duration, &mut self.workspace).map_err(|error| error.to_string())
    }
}

/// Whether any obstacle of the world may move.
pub(super) fn obstacles_may_move(checker: &CollisionChecker, settings: &MonitorSettings) -> bool {
    let limits = settings.moving_obstacles();
    limits.is_some_and(|limits| checker.world().obstacles().any(|of| !limits.of(&of.name).is_zero()))
}

/// Warning about limits of obstacles that the world does not have.
pub(super) fn limits_without_effect(
    checker: &CollisionChecker,
    settings: &MonitorSettings,
) -> Option<String> {
    let names = settings.obstacle_limits.by_name.keys();
    let unknown: Vec<String> = names.filter(|name| checker.world().id(name).is_none()).cloned().collect();
    (!unknown.is_empty())
        .then(|| format!("obstacle_limits: the world has no obstacle {}", quoted_list(&unknown)))
}

fn acceleration_limits(robot: &RobotModel) -> Vec<Option<f64>> {
    let mut limits = vec![None; robot.position_names().len()];
    for id in robot.joint_ids() {
        let joint = robot.joint(id);
        // joints with several positions have no acceleration limits of their own
        if let (1, Some(index), Some(l)) =
            (joint.kind.position_suffixes().len(), robot.first_position(id), joint.limits)
        {
            // a limit of zero means "not given": such a joint could never start to move
            limits[index] = (l.acceleration.is_finite() && l.acceleration > 0.0).then_some(l.acceleration);
        }
    }
    limits
}
