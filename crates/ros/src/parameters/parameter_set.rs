//! Current values and defaults of all parameters of the node, and the `MonitorSettings` made from them. Units, ranges
//! and descriptions: `declarations`.

use std::sync::Arc;

use crate::parameters::obstacle_limit::{obstacle_limit, obstacle_speed};
use crate::parameters::recording_settings::RecordingSettings;
use clearance_geometry::VolumeKind;
use clearance_monitor::{
    MonitorSettings, SeparationRules, SeparationSettings, SpeedDistances, SpeedSettings,
};
use clearance_motion::{ContinuousDirection, ObstacleLimits, SpeedLimit};

/// All current parameters. One value of this type is a consistent set, and is replaced as a whole.
#[derive(Clone, Debug, PartialEq)]
#[expect(clippy::struct_excessive_bools, reason = "one field for each parameter of the node")]
pub struct Parameters {
    pub heartbeat_rate: f64,
    pub stale_after: f64,
    pub check_deadline: f64,
    pub influence_distance: f64,
    pub distance_limit: f64,
    pub distance_absolute_tolerance: f64,
    pub distance_relative_tolerance: f64,
    pub exact_distance_share: f64,
    pub contacts_per_pair: i64,
    pub check_between_states: bool,
    pub joint_noise: f64,
    pub between_states_acceleration: f64,
    pub slowdown_distance_self: f64,
    pub slowdown_distance_world: f64,
    pub stop_distance_self: f64,
    pub stop_distance_world: f64,
    pub slowdown_reaction_time: f64,
    pub slowdown_trigger_count: i64,
    pub slowdown_release_count: i64,
    pub speed_mode: &'static str,
    pub ssm_human_speed: f64,
    pub ssm_robot_speed: f64,
    pub ssm_reaction_time: f64,
    pub ssm_deceleration: f64,
    pub ssm_acceleration: f64,
    pub ssm_intrusion_distance: f64,
    pub ssm_human_uncertainty: f64,
    pub ssm_robot_uncertainty: f64,
    pub ssm_resting_obstacles: Vec<String>,
    pub ssm_obstacle_speeds: Vec<String>,
    pub look_ahead_horizon: f64,
    pub look_ahead_acceleration: f64,
    pub look_ahead_root_acceleration: f64,
    pub look_ahead_root_angular_acceleration: f64,
    pub obstacle_speed: f64,
    pub obstacle_acceleration: f64,
    pub obstacle_limits: Vec<String>,
    pub obstacle_latency: f64,
    pub obstacle_state_ttl: f64,
    pub continuous_joint_direction: &'static str,
    pub joint_prefix: String,
    pub link_prefix: String,
    pub padding: f64,
    pub pad_self: bool,
    pub publish_markers: bool,
    pub marker_rate: f64,
    pub retreat_rate: f64,
    pub link_volume_level: i64,
    pub planning_scene_service: String,
    pub require_planning_scene: bool,
    pub point_cloud_topics: Vec<String>,
    pub point_radius: f64,
    pub point_cloud_ttl: f64,
    pub stale_source_policy: &'static str,
    pub blind_cloud: &'static str,
    pub rejected_obstacle: &'static str,
    pub lost_messages: &'static str,
    pub mimic_contradiction: &'static str,
    pub self_filter_padding: f64,
    pub cloud_voxel_size: f64,
    pub cloud_crop_min: Vec<f64>,
    pub cloud_crop_max: Vec<f64>,
    pub octomap_ttl: f64,
    pub unknown_space: &'static str,
    pub transform_ttl: f64,
    pub transform_joints: Vec<String>,
    pub record_file: String,
    pub record_max_size: f64,
    pub record_max_duration: f64,
    pub memory_limit: f64,
    pub use_realtime_priority: bool,
    pub use_sim_time: bool,
    pub volumes: String,
}

pub(super) const STALE_SOURCE_POLICIES: &[&str] = &["unknown", "drop"];
/// Effect of a fault in the world: it makes the status UNKNOWN, or is only a warning.
pub const UNKNOWN_OR_WARN: &[&str] = &["unknown", "warn"];
/// Direction in which continuous joints move from the current state.
pub(super) const CONTINUOUS_DIRECTIONS: &[&str] = &["shortest", "as_given"];
/// Rule of the speed scale for obstacles: by distances, or speed and separation monitoring.
pub(super) const SPEED_MODES: &[&str] = &["distances", "ssm"];
/// Largest distance (m) from which speed and separation monitoring may slow the robot down.
const LARGEST_SEPARATION: f64 = 10.0;
pub(super) const UNKNOWN_SPACES: &[&str] = &["free", "occupied"];

impl Default for Parameters {
    fn default() -> Self {
        let monitor = MonitorSettings::default();
        Self {
            heartbeat_rate: monitor.heartbeat_rate,
            stale_after: monitor.stale_after,
            check_deadline: monitor.check_deadline,
            influence_distance: monitor.influence_distance,
            distance_limit: monitor.distance_limit,
            distance_absolute_tolerance: monitor.distance_absolute_tolerance,
            distance_relative_tolerance: monitor.distance_relative_tolerance,
            exact_distance_share: monitor.exact_distance_share,
            contacts_per_pair: 0,
            check_between_states: monitor.check_between_states,
            joint_noise: monitor.joint_noise,
            between_states_acceleration: monitor.between_states_acceleration,
            slowdown_distance_self: monitor.speed.own.slowdown,
            slowdown_distance_world: monitor.speed.world.slowdown,
            stop_distance_self: monitor.speed.own.stop,
            stop_distance_world: monitor.speed.world.stop,
            slowdown_reaction_time: monitor.speed.reaction_time,
            slowdown_trigger_count: monitor.speed.trigger_count.into(),
            slowdown_release_count: monitor.speed.release_count.into(),
            speed_mode: SPEED_MODES[0],
            ssm_human_speed: 1.6,
            ssm_robot_speed: 0.0,
            ssm_reaction_time: 0.0,
            ssm_deceleration: 0.0,
            ssm_acceleration: 0.0,
            ssm_intrusion_distance: 0.0,
            ssm_human_uncertainty: 0.0,
            ssm_robot_uncertainty: 0.0,
            ssm_resting_obstacles: Vec::new(),
            ssm_obstacle_speeds: Vec::new(),
            look_ahead_horizon: monitor.look_ahead_horizon,
            look_ahead_acceleration: monitor.look_ahead_acceleration,
            look_ahead_root_acceleration: 0.0,
            look_ahead_root_angular_acceleration: 0.0,
            obstacle_speed: 0.0,
            obstacle_acceleration: 0.0,
            obstacle_limits: Vec::new(),
            obstacle_latency: monitor.obstacle_latency,
            obstacle_state_ttl: 1.0,
            continuous_joint_direction: CONTINUOUS_DIRECTIONS[0],
            joint_prefix: monitor.joint_prefix,
            link_prefix: String::new(),
            padding: 0.0,
            pad_self: false,
            publish_markers: true,
            marker_rate: 20.0,
            retreat_rate: 0.0,
            link_volume_level: -1,
            planning_scene_service: String::new(),
            require_planning_scene: false,
            point_cloud_topics: Vec::new(),
            point_radius: 0.01,
            point_cloud_ttl: 1.0,
            stale_source_policy: STALE_SOURCE_POLICIES[0],
            blind_cloud: UNKNOWN_OR_WARN[0],
            rejected_obstacle: UNKNOWN_OR_WARN[0],
            lost_messages: UNKNOWN_OR_WARN[0],
            mimic_contradiction: UNKNOWN_OR_WARN[0],
            self_filter_padding: 0.0,
            cloud_voxel_size: 0.0,
            cloud_crop_min: Vec::new(),
            cloud_crop_max: Vec::new(),
            octomap_ttl: 0.0,
            unknown_space: UNKNOWN_SPACES[0],
            transform_ttl: monitor.transform_ttl,
            transform_joints: monitor.transform_joints,
            record_file: String::new(),
            record_max_size: 4000.0,
            record_max_duration: 0.0,
            memory_limit: 0.0,
            use_realtime_priority: false,
            use_sim_time: false,
            volumes: VolumeKind::default().name().to_owned(),
        }
    }
}

impl Parameters {
    #[must_use]
    pub fn monitor_settings(&self) -> MonitorSettings {
        MonitorSettings {
            heartbeat_rate: self.heartbeat_rate,
            stale_after: self.stale_after,
            check_deadline: self.check_deadline,
            joint_prefix: self.joint_prefix.clone(),
            mimic_contradiction_is_unknown: self.mimic_contradiction == UNKNOWN_OR_WARN[0],
            transform_joints: self.transform_joints.clone(),
            transform_ttl: self.transform_ttl,
            influence_distance: self.influence_distance,
            distance_limit: self.distance_limit,
            distance_absolute_tolerance: self.distance_absolute_tolerance,
            distance_relative_tolerance: self.distance_relative_tolerance,
            exact_distance_share: self.exact_distance_share,
            // the parameter's range is far inside
            contacts_per_pair: usize::try_from(self.contacts_per_pair).unwrap_or(0),
            check_between_states: self.check_between_states,
            joint_noise: self.joint_noise,
            between_states_acceleration: self.between_states_acceleration,
            speed: self.speed_settings(),
            look_ahead_horizon: self.look_ahead_horizon,
            look_ahead_acceleration: self.look_ahead_acceleration,
            look_ahead_root_accelerations: [
                self.look_ahead_root_acceleration,
                self.look_ahead_root_angular_acceleration,
            ],
            obstacle_limits: Arc::new(self.obstacle_limits()),
            obstacle_latency: self.obstacle_latency,
        }
    }

    /// How fast obstacles may move.
    #[must_use]
    pub fn obstacle_limits(&self) -> ObstacleLimits {
        let default = SpeedLimit { speed: self.obstacle_speed, acceleration: self.obstacle_acceleration };
        // texts were checked when they were set
        let by_name = self.obstacle_limits.iter().filter_map(|text| obstacle_limit(text).ok()).collect();
        ObstacleLimits { default, by_name }
    }

    fn speed_settings(&self) -> SpeedSettings {
        // the parameters' ranges are far inside
        let count = |number: i64| u32::try_from(number).unwrap_or(u32::MAX);
        SpeedSettings {
            own: SpeedDistances { slowdown: self.slowdown_distance_self, stop: self.stop_distance_self },
            world: SpeedDistances { slowdown: self.slowdown_distance_world, stop: self.stop_distance_world },
            reaction_time: self.slowdown_reaction_time,
            trigger_count: count(self.slowdown_trigger_count),
            release_count: count(self.slowdown_release_count),
            separation: self.monitors_separation().then(|| self.separation_rules()),
        }
    }

    /// Whether the speed scale follows speed and separation monitoring.
    #[must_use]
    pub fn monitors_separation(&self) -> bool {
        self.speed_mode == SPEED_MODES[1]
    }

    fn separation_rules(&self) -> SeparationRules {
        let usual = SeparationSettings {
            human_speed: self.ssm_human_speed,
            robot_speed: self.ssm_robot_speed,
            reaction_time: self.ssm_reaction_time,
            deceleration: self.ssm_deceleration,
            acceleration: self.ssm_acceleration,
            margin: self.ssm_intrusion_distance + self.ssm_human_uncertainty + self.ssm_robot_uncertainty,
        };
        let resting_obstacles = self.ssm_resting_obstacles.clone();
        // texts were checked when they were set
        let speeds = self.ssm_obstacle_speeds.iter().filter_map(|text| obstacle_speed(text).ok());
        SeparationRules { usual, resting_obstacles, obstacle_speeds: speeds.collect() }
    }

    /// Checks the parameters of speed and separation monitoring, if it is on.
    fn check_separation(&self) -> Result<(), String> {
        if !self.monitors_separation() {
            return Ok(());
        }
        for (name, unit, value) in [
            ("ssm_robot_speed", "m/s", self.ssm_robot_speed),
            ("ssm_reaction_time", "s", self.ssm_reaction_time),
            ("ssm_deceleration", "m/s2", self.ssm_deceleration),
        ] {
            if value <= 0.0 {
                return Err(format!(
                    "speed_mode ssm needs {name} above 0 {unit}: set it before speed_mode, or together with it"
                ));
            }
        }
        let range = self.separation_rules().range();
        if range > LARGEST_SEPARATION {
            return Err(format!(
                "with these ssm_ parameters, obstacles up to {range:.2} m away slow the robot down, and at most {LARGEST_SEPARATION} m are allowed: give a higher ssm_deceleration, or a lower ssm_robot_speed, ssm_human_speed, ssm_obstacle_speeds or ssm_reaction_time"
            ));
        }
        Ok(())
    }

    /// Whether data of stale sources is removed, instead of making the status UNKNOWN.
    #[must_use]
    pub fn drops_stale_sources(&self) -> bool {
        self.stale_source_policy == STALE_SOURCE_POLICIES[1]
    }

    /// Whether a blind sensor makes the status UNKNOWN, instead of being only a warning.
    #[must_use]
    pub fn blind_makes_unknown(&self) -> bool {
        self.blind_cloud == UNKNOWN_OR_WARN[0]
    }

    /// Whether a rejected obstacle makes the status UNKNOWN, instead of being only a warning.
    #[must_use]
    pub fn rejected_makes_unknown(&self) -> bool {
        self.rejected_obstacle == UNKNOWN_OR_WARN[0]
    }

    /// Whether lost scene messages make the status UNKNOWN, instead of being only a warning.
    #[must_use]
    pub fn lost_makes_unknown(&self) -> bool {
        self.lost_messages == UNKNOWN_OR_WARN[0]
    }

    /// Level of the bounding volume hierarchies to show, counted from their roots; `None` if they are not shown.
    #[must_use]
    pub fn shown_level(&self) -> Option<usize> {
        usize::try_from(self.link_volume_level).ok()
    }

    /// Whether the unknown space of an octomap counts as occupied.
    #[must_use]
    pub fn unknown_is_occupied(&self) -> bool {
        self.unknown_space == UNKNOWN_SPACES[1]
    }

    /// Direction in which continuous joints move from the current state.
    #[must_use]
    pub fn continuous_direction(&self) -> ContinuousDirection {
        if self.continuous_joint_direction == CONTINUOUS_DIRECTIONS[0] {
            ContinuousDirection::Shortest
        } else {
            ContinuousDirection::AsGiven
        }
    }

    /// Settings of the recording; `None` if recording is off.
    #[must_use]
    pub fn recording(&self) -> Option<RecordingSettings> {
        (!self.record_file.is_empty()).then(|| RecordingSettings {
            file: self.record_file.clone().into(),
            max_size: self.record_max_size,
            max_duration: self.record_max_duration,
        })
    }

    /// Checks that values which are valid individually are also consistent.
    pub fn check_together(&self) -> Result<(), String> {
        // an empty crop box would make every cloud empty
        let below = |(min, max): (&f64, &f64)| min < max;
        if !self.cloud_crop_min.iter().zip(&self.cloud_crop_max).all(below) {
            return Err("every number of cloud_crop_min must be below that of cloud_crop_max".to_owned());
        }
        self.check_separation()
    }
}

#[cfg(test)]
mod tests;
