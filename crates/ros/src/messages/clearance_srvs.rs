//! The services and the action of the ROS package `clearance_msgs`, as serde structs.
//!
//! The fields have the same order as in `interfaces/clearance_msgs/srv/*.srv` and `action/*.action`. Those files also
//! define the unit, the frame and the meaning of every field. Fields that several services share are a separate struct
//! here: CDR encodes a nested struct like its fields in the same position. A goal of the action is the request of the
//! service with the same name; a result is its response.

use ros2_client::Message;
use ros2_interfaces_jazzy_serde::geometry_msgs::msg::{Point, Vector3};
use ros2_interfaces_jazzy_serde::trajectory_msgs::msg::JointTrajectory;
use serde::{Deserialize, Serialize};

use crate::messages::clearance_msgs::{
    BodyPair, DistanceEvent, LeastDistance, MovingObstacle, ObstacleLimit, PairDistance,
};

/// Request: is the straight motion in joint space free of collisions?
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct CheckMotionRequest {
    pub joint_names: Vec<String>,
    pub start: Vec<f64>,
    pub goal: Vec<f64>,
    pub terms: MotionTerms,
    pub duration: f64,
}

/// Request: is a trajectory free of collisions?
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct CheckTrajectoryRequest {
    pub trajectory: JointTrajectory,
    pub terms: MotionTerms,
}

/// Settings for the check of a motion.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct MotionTerms {
    pub tolerance: f64,
    pub any_contact: bool,
    pub timeout: f64,
    pub joint_tolerances: Vec<f64>,
    pub certificate: bool,
    pub swept_volume_intervals: u32,
    pub continuous_joint_direction: u8,
    pub with_clearance: bool,
    pub event_distance: f64,
    pub margin: f64,
    pub moving_obstacles: Vec<MovingObstacle>,
    pub obstacle_limits: Vec<ObstacleLimit>,
    pub obstacle_latency: f64,
}

impl MotionTerms {
    pub const DEFAULT: u8 = 0;
    pub const SHORTEST: u8 = 1;
    pub const AS_GIVEN: u8 = 2;
}

/// Result of the check of a motion. The default status is `ERROR`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct MotionFindings {
    pub verdict: u8,
    pub message: String,
    pub reason_code: String,
    pub t_free: f64,
    pub t_contact: f64,
    pub pair: BodyPair,
    pub witness_point: Point,
    pub witness_known: bool,
    pub distance_lower: f64,
    pub distance_upper: f64,
    pub certificate: String,
    pub certificate_digest: String,
    pub model_revision: u64,
    pub world_revision: u64,
    pub compute_time: f64,
}

impl MotionFindings {
    pub const ERROR: u8 = 0;
    pub const FREE: u8 = 1;
    pub const CONTACT: u8 = 2;
    pub const UNDECIDED: u8 = 3;
}

/// The continuous joints that turn, and their positions at the start and at the end of the motion.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[expect(clippy::struct_field_names, reason = "names of the fields in the .srv files")]
pub struct ContinuousTurns {
    pub continuous_joints: Vec<String>,
    pub continuous_starts: Vec<f64>,
    pub continuous_goals: Vec<f64>,
}

/// Distances along a motion that the request selects. The default claims nothing.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct MotionDistances {
    pub self_clearance: LeastDistance,
    pub world_clearance: LeastDistance,
    pub clearance_reason_code: String,
    pub event: DistanceEvent,
}

/// Results for one straight motion. Two responses share these fields.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct CheckMotionResponse {
    pub motion: MotionFindings,
    pub turns: ContinuousTurns,
    pub distances: MotionDistances,
}

/// Result of the check of a trajectory: the result of one of its segments.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct CheckTrajectoryResponse {
    pub motion: MotionFindings,
    pub segment: u32,
    pub time_free: f64,
    pub time_contact: f64,
    pub turns: ContinuousTurns,
    pub distances: MotionDistances,
}

impl CheckTrajectoryResponse {
    /// Response for a trajectory that was not checked.
    #[must_use]
    pub fn unchecked(motion: MotionFindings) -> Self {
        let (time_free, time_contact) = (f64::NAN, f64::NAN);
        Self { motion, time_free, time_contact, ..Self::default() }
    }
}

/// Action feedback: the part of a trajectory that is proven free so far.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct CheckTrajectoryFeedback {
    pub segments_free: u32,
    pub segments: u32,
    pub t_free: f64,
    pub time_free: f64,
}

/// Request: are these straight motions free of collisions?
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct CheckMotionsRequest {
    pub joint_names: Vec<String>,
    pub group: String,
    pub starts: Vec<f64>,
    pub goals: Vec<f64>,
    pub other_joints: Vec<String>,
    pub other_positions: Vec<f64>,
    pub tolerance: f64,
    pub any_contact: bool,
    pub timeout: f64,
    pub joint_tolerances: Vec<f64>,
    pub continuous_joint_direction: u8,
    pub with_clearance: bool,
    pub event_distance: f64,
    pub margin: f64,
}

impl CheckMotionsRequest {
    /// The settings for each of the checks.
    #[must_use]
    pub fn terms(&self) -> MotionTerms {
        MotionTerms {
            tolerance: self.tolerance,
            any_contact: self.any_contact,
            timeout: self.timeout,
            continuous_joint_direction: self.continuous_joint_direction,
            with_clearance: self.with_clearance,
            event_distance: self.event_distance,
            margin: self.margin,
            ..MotionTerms::default()
        }
    }
}

/// Results for straight motions. The default status is `ERROR`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct CheckMotionsResponse {
    pub verdict: u8,
    pub message: String,
    pub reason_code: String,
    pub verdicts: Vec<u8>,
    pub reasons: Vec<u8>,
    pub t_free: Vec<f64>,
    pub t_contact: Vec<f64>,
    pub pair_a: Vec<i32>,
    pub pair_b: Vec<i32>,
    pub bodies: Vec<String>,
    pub body_types: Vec<u8>,
    pub joint_names: Vec<String>,
    pub model_revision: u64,
    pub world_revision: u64,
    pub compute_time: f64,
    pub clearances: BatchClearances,
    pub events: BatchEvents,
}

/// Least distances along each motion of a batch.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct BatchClearances {
    pub self_lower: Vec<f64>,
    pub self_upper: Vec<f64>,
    pub self_t: Vec<f64>,
    pub self_pair_a: Vec<i32>,
    pub self_pair_b: Vec<i32>,
    pub world_lower: Vec<f64>,
    pub world_upper: Vec<f64>,
    pub world_t: Vec<f64>,
    pub world_pair_a: Vec<i32>,
    pub world_pair_b: Vec<i32>,
    pub clearance_reasons: Vec<u8>,
}

/// First time within the distance, for each motion of a batch.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[expect(clippy::struct_field_names, reason = "names of the fields in the .srv files")]
pub struct BatchEvents {
    pub event_results: Vec<u8>,
    pub event_reasons: Vec<u8>,
    pub event_t_farther: Vec<f64>,
    pub event_t_reached: Vec<f64>,
    pub event_pair_a: Vec<i32>,
    pub event_pair_b: Vec<i32>,
}

impl BatchEvents {
    pub const FARTHER: u8 = 1;
    pub const REACHED: u8 = 2;
    pub const UNDECIDED: u8 = 3;
}

impl CheckMotionsResponse {
    pub const ERROR: u8 = 0;
    pub const FREE: u8 = 1;
    pub const CONTACT: u8 = 2;
    pub const UNDECIDED: u8 = 3;

    pub const REASON_NONE: u8 = 0;
    pub const REASON_TOLERANCE: u8 = 1;
    pub const REASON_TUBE: u8 = 2;
    pub const REASON_DEADLINE: u8 = 3;
    pub const REASON_BUDGET: u8 = 4;
    pub const REASON_OVERFLOW: u8 = 5;
}

/// Request: are these states free of collisions, and how large are their distances?
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct CheckStatesRequest {
    pub joint_names: Vec<String>,
    pub positions: Vec<f64>,
    pub with_distance: bool,
    pub distance_limit: f64,
    pub timeout: f64,
}

/// Results for states. The default status is `ERROR`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct CheckStatesResponse {
    pub verdict: u8,
    pub message: String,
    pub reason_code: String,
    pub verdicts: Vec<u8>,
    pub distances: Vec<f64>,
    pub pair_a: Vec<i32>,
    pub pair_b: Vec<i32>,
    pub bodies: Vec<String>,
    pub body_types: Vec<u8>,
    pub model_revision: u64,
    pub world_revision: u64,
    pub compute_time: f64,
    pub self_distances: Vec<f64>,
    pub self_pair_a: Vec<i32>,
    pub self_pair_b: Vec<i32>,
    pub world_distances: Vec<f64>,
    pub world_pair_a: Vec<i32>,
    pub world_pair_b: Vec<i32>,
}

impl CheckStatesResponse {
    pub const ERROR: u8 = 0;
    pub const FREE: u8 = 1;
    pub const COLLIDING: u8 = 2;
    pub const UNKNOWN: u8 = 3;
}

/// Request: how far apart are the bodies in one state?
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct GetDistancesRequest {
    pub joint_names: Vec<String>,
    pub positions: Vec<f64>,
    pub max_distance: f64,
    pub max_pairs: u32,
    pub bodies: Vec<String>,
    pub timeout: f64,
    pub with_gradients: bool,
}

/// Distances in one state. The default status is `ERROR`; the status constants are the same as in
/// [`CheckStatesResponse`].
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct GetDistancesResponse {
    pub verdict: u8,
    pub message: String,
    pub reason_code: String,
    pub pairs: Vec<PairDistance>,
    pub pairs_found: u32,
    pub model_revision: u64,
    pub world_revision: u64,
    pub compute_time: f64,
    pub self_distance: f64,
    pub self_nearest: PairDistance,
    pub world_distance: f64,
    pub world_nearest: PairDistance,
    pub signed_distances: Vec<f64>,
    pub signed_distances_upper: Vec<f64>,
    pub normals: Vec<Vector3>,
    pub witness_counts: Vec<u8>,
    pub gradient_joints: Vec<String>,
    pub gradient: Vec<f64>,
}

impl GetDistancesResponse {
    pub const MANY_UNKNOWN: u8 = 0;
    pub const ONE: u8 = 1;
    pub const SEVERAL: u8 = 2;
}

/// Request: is there a free state near this one?
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct FindFreeStateRequest {
    pub joint_names: Vec<String>,
    pub positions: Vec<f64>,
    pub group: String,
    pub locked_joints: Vec<String>,
    pub max_distance: f64,
    pub clearance: f64,
    pub timeout: f64,
}

/// Result of the search for a free state. The default result is `ERROR`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct FindFreeStateResponse {
    pub result: u8,
    pub message: String,
    pub reason_code: String,
    pub joint_names: Vec<String>,
    pub start: Vec<f64>,
    pub free_state: Vec<f64>,
    pub distance: f64,
    pub exit: f64,
    pub unmoved_pair: BodyPair,
    pub model_revision: u64,
    pub world_revision: u64,
    pub compute_time: f64,
}

impl FindFreeStateResponse {
    pub const ERROR: u8 = 0;
    pub const ALREADY_FREE: u8 = 1;
    pub const FOUND: u8 = 2;
    pub const NONE_FOUND: u8 = 3;
}

impl Message for CheckMotionRequest {}
impl Message for CheckTrajectoryRequest {}
impl Message for CheckMotionResponse {}
impl Message for CheckTrajectoryResponse {}
impl Message for CheckTrajectoryFeedback {}
impl Message for CheckMotionsRequest {}
impl Message for CheckMotionsResponse {}
impl Message for CheckStatesRequest {}
impl Message for CheckStatesResponse {}
impl Message for GetDistancesRequest {}
impl Message for GetDistancesResponse {}
impl Message for FindFreeStateRequest {}
impl Message for FindFreeStateResponse {}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::messages::interface_text::{constants_in_text, fields_in_rust, fields_in_text};

    macro_rules! srv {
        ($name:literal) => {
            include_str!(concat!("../../../../interfaces/clearance_msgs/srv/", $name, ".srv"))
                .split_once("\n---\n")
                .unwrap()
        };
    }

    /// Replaces the field `name` by the fields of the struct `inner`.
    fn unfolded(fields: &str, name: &str, inner: &str) -> String {
        let unfold = |field| if field == name { inner } else { field };
        fields.split(' ').map(unfold).collect::<Vec<_>>().join(" ")
    }

    #[test]
    fn fields_stand_in_the_order_of_the_srv_files() {
        let terms = fields_in_rust::<MotionTerms>();
        let (request, response) = srv!("CheckMotion");
        assert_eq!(
            unfolded(&fields_in_rust::<CheckMotionRequest>(), "terms", &terms),
            fields_in_text(request)
        );
        let [motion, turns] = [fields_in_rust::<MotionFindings>(), fields_in_rust::<ContinuousTurns>()];
        let distances = fields_in_rust::<MotionDistances>();
        let parts = [("motion", &motion), ("turns", &turns), ("distances", &distances)];
        let answer =
            |fields: String| parts.iter().fold(fields, |all, (name, part)| unfolded(&all, name, part));
        assert_eq!(answer(fields_in_rust::<CheckMotionResponse>()), fields_in_text(response));

        let (request, response) = srv!("CheckTrajectory");
        assert_eq!(
            unfolded(&fields_in_rust::<CheckTrajectoryRequest>(), "terms", &terms),
            fields_in_text(request)
        );
        assert_eq!(answer(fields_in_rust::<CheckTrajectoryResponse>()), fields_in_text(response));

        let (request, response) = srv!("CheckStates");
        assert_eq!(fields_in_rust::<CheckStatesRequest>(), fields_in_text(request));
        assert_eq!(fields_in_rust::<CheckStatesResponse>(), fields_in_text(response));
        let (request, response) = srv!("GetDistances");
        assert_eq!(fields_in_rust::<GetDistancesRequest>(), fields_in_text(request));
        assert_eq!(fields_in_rust::<GetDistancesResponse>(), fields_in_text(response));
    }

    #[test]
    fn the_action_is_the_service_with_progress() {
        let text = include_str!("../../../../interfaces/clearance_msgs/action/CheckTrajectory.action");
        let [goal, result, feedback]: [&str; 3] =
            text.split("\n---\n").collect::<Vec<_>>().try_into().unwrap();
        let (request, response) = srv!("CheckTrajectory");
        assert_eq!(fields_in_text(goal), fields_in_text(request));
        assert_eq!(constants_in_text(goal), constants_in_text(request));
        assert_eq!(fields_in_text(result), fields_in_text(response));
        assert_eq!(constants_in_text(result), constants_in_text(response));
        assert_eq!(fields_in_rust::<CheckTrajectoryFeedback>(), fields_in_text(feedback));
    }

    #[test]
    fn the_search_of_a_free_state_is_as_in_its_srv_file() {
        let (request, response) = srv!("FindFreeState");
        assert_eq!(fields_in_rust::<FindFreeStateRequest>(), fields_in_text(request));
        assert_eq!(fields_in_rust::<FindFreeStateResponse>(), fields_in_text(response));
        let expected = [
            ("ERROR", FindFreeStateResponse::ERROR),
            ("ALREADY_FREE", FindFreeStateResponse::ALREADY_FREE),
            ("FOUND", FindFreeStateResponse::FOUND),
            ("NONE_FOUND", FindFreeStateResponse::NONE_FOUND),
        ];
        assert_eq!(constants_in_text(response), expected);
    }

    #[test]
    fn the_batch_of_motions_is_as_in_its_srv_file() {
        let (request, response) = srv!("CheckMotions");
        assert_eq!(fields_in_rust::<CheckMotionsRequest>(), fields_in_text(request));
        let fields = fields_in_rust::<CheckMotionsResponse>();
        let fields = unfolded(&fields, "clearances", &fields_in_rust::<BatchClearances>());
        let fields = unfolded(&fields, "events", &fields_in_rust::<BatchEvents>());
        assert_eq!(fields, fields_in_text(response));
        let directions = [
            ("DEFAULT", MotionTerms::DEFAULT),
            ("SHORTEST", MotionTerms::SHORTEST),
            ("AS_GIVEN", MotionTerms::AS_GIVEN),
        ];
        assert_eq!(constants_in_text(request), directions);
        let expected = [
            ("ERROR", CheckMotionsResponse::ERROR),
            ("FREE", CheckMotionsResponse::FREE),
            ("CONTACT", CheckMotionsResponse::CONTACT),
            ("UNDECIDED", CheckMotionsResponse::UNDECIDED),
            ("REASON_NONE", CheckMotionsResponse::REASON_NONE),
            ("REASON_TOLERANCE", CheckMotionsResponse::REASON_TOLERANCE),
            ("REASON_TUBE", CheckMotionsResponse::REASON_TUBE),
            ("REASON_DEADLINE", CheckMotionsResponse::REASON_DEADLINE),
            ("REASON_BUDGET", CheckMotionsResponse::REASON_BUDGET),
            ("REASON_OVERFLOW", CheckMotionsResponse::REASON_OVERFLOW),
            ("EVENT_FARTHER", BatchEvents::FARTHER),
            ("EVENT_REACHED", BatchEvents::REACHED),
            ("EVENT_UNDECIDED", BatchEvents::UNDECIDED),
        ];
        assert_eq!(constants_in_text(response), expected);
    }

    #[test]
    fn constants_have_the_values_of_the_srv_files() {
        let expected = [
            ("ERROR", MotionFindings::ERROR),
            ("FREE", MotionFindings::FREE),
            ("CONTACT", MotionFindings::CONTACT),
            ("UNDECIDED", MotionFindings::UNDECIDED),
        ];
        let directions = [
            ("DEFAULT", MotionTerms::DEFAULT),
            ("SHORTEST", MotionTerms::SHORTEST),
            ("AS_GIVEN", MotionTerms::AS_GIVEN),
        ];
        for (request, response) in [srv!("CheckMotion"), srv!("CheckTrajectory")] {
            assert_eq!(constants_in_text(request), directions);
            assert_eq!(constants_in_text(response), expected);
        }
        let expected = [
            ("ERROR", CheckStatesResponse::ERROR),
            ("FREE", CheckStatesResponse::FREE),
            ("COLLIDING", CheckStatesResponse::COLLIDING),
            ("UNKNOWN", CheckStatesResponse::UNKNOWN),
        ];
        let counts = [
            ("ONE", GetDistancesResponse::ONE),
            ("SEVERAL", GetDistancesResponse::SEVERAL),
            ("MANY_UNKNOWN", GetDistancesResponse::MANY_UNKNOWN),
        ];
        for (request, response, more) in [(srv!("CheckStates"), &[][..]), (srv!("GetDistances"), &counts[..])]
            .map(|((q, r), more)| (q, r, more))
        {
            assert_eq!(constants_in_text(request), []);
            assert_eq!(constants_in_text(response), [&expected, more].concat());
        }
    }
}
