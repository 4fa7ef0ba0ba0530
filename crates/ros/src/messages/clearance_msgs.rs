//! The messages of the ROS package `clearance_msgs`, as serde structs.
//!
//! CDR encodes no field names and no field order: the fields below have the same order as in
//! `interfaces/clearance_msgs/msg/*.msg`. Those files also define the unit, the frame and the meaning of every field.

use ros2_client::Message;
use ros2_interfaces_jazzy_serde::builtin_interfaces::msg::Time;
use ros2_interfaces_jazzy_serde::geometry_msgs::msg::{Point, Pose, Twist, Vector3};
use ros2_interfaces_jazzy_serde::std_msgs::msg::Header;
use serde::{Deserialize, Serialize};

/// Two bodies that are checked against each other.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct BodyPair {
    pub body_a: String,
    pub type_a: u8,
    pub body_b: String,
    pub type_b: u8,
}

impl BodyPair {
    pub const LINK: u8 = 0;
    pub const OBSTACLE: u8 = 1;
    pub const ATTACHED: u8 = 2;
}

/// Smallest distance between two bodies, and its witness points.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct PairDistance {
    pub pair: BodyPair,
    pub distance: f64,
    pub witness_points: [Point; 2],
}

/// Bounds on the least distance of the pairs of one kind along a motion. The default claims nothing.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct LeastDistance {
    pub lower: f64,
    pub upper: f64,
    pub segment: u32,
    pub t: f64,
    pub time: f64,
    pub nearest: PairDistance,
}

impl Default for LeastDistance {
    fn default() -> Self {
        let nearest = PairDistance::default();
        Self { lower: 0.0, upper: f64::INFINITY, segment: 0, t: f64::NAN, time: f64::NAN, nearest }
    }
}

/// The first time of a motion at which a pair is not farther apart than a distance. The default is `NOT_CHECKED`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct DistanceEvent {
    pub result: u8,
    pub reason_code: String,
    pub segment: u32,
    pub t_farther: f64,
    pub t_reached: f64,
    pub time_farther: f64,
    pub time_reached: f64,
    pub pair: BodyPair,
}

impl DistanceEvent {
    pub const NOT_CHECKED: u8 = 0;
    pub const FARTHER: u8 = 1;
    pub const REACHED: u8 = 2;
    pub const UNDECIDED: u8 = 3;
}

impl Default for DistanceEvent {
    fn default() -> Self {
        Self {
            result: Self::NOT_CHECKED,
            reason_code: String::new(),
            segment: 0,
            t_farther: 0.0,
            t_reached: 0.0,
            time_farther: f64::NAN,
            time_reached: f64::NAN,
            pair: BodyPair::default(),
        }
    }
}

/// A contact of two bodies that collide.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Contact {
    pub pair: BodyPair,
    pub position: Point,
    pub normal: Vector3,
    pub depth_known: bool,
    pub depth_lower: f64,
    pub depth_upper: f64,
    pub reason: String,
}

/// Speed and separation monitoring of one joint state.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Separation {
    pub header: Header,
    pub pair_known: bool,
    pub pair: BodyPair,
    pub distance: f64,
    pub protective_distance: f64,
    pub approach_speed_known: bool,
    pub approach_speed: f64,
    pub allowed_speed: f64,
    pub requested_scale: f64,
}

/// A contact between two successive joint states: proven, or possible.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct PassedThrough {
    pub pair: BodyPair,
    pub t_lower: f64,
    pub t_upper: f64,
    pub previous_stamp: Time,
    pub stamp: Time,
    pub proven: bool,
}

/// Known motion of an obstacle: a constant twist, or poses with times.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct MovingObstacle {
    pub name: String,
    pub twist: Twist,
    pub centre: Vec<Point>,
    pub poses: Vec<Pose>,
    pub times: Vec<f64>,
}

/// How fast an obstacle may move whose path is not known.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ObstacleLimit {
    pub name: String,
    pub speed: f64,
    pub acceleration: f64,
}

/// Pose and velocity of an obstacle.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ObstacleState {
    pub name: String,
    pub pose: Pose,
    pub twist: Twist,
}

/// Poses and velocities of obstacles at one time.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ObstacleStates {
    pub header: Header,
    pub obstacles: Vec<ObstacleState>,
}

/// Summary of the states since the previous message of the heartbeat topic. The default claims nothing.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SinceHeartbeat {
    pub heartbeat: u64,
    pub messages: u32,
    pub all_free: bool,
    pub least_distance: f64,
    pub least_distance_pair: BodyPair,
    pub least_distance_stamp: Time,
    pub touched_pair_count: u32,
    pub touched_pairs: Vec<BodyPair>,
}

impl Default for SinceHeartbeat {
    fn default() -> Self {
        Self {
            heartbeat: 0,
            messages: 0,
            all_free: false,
            least_distance: f64::NAN,
            least_distance_pair: BodyPair::default(),
            least_distance_stamp: Time::default(),
            touched_pair_count: 0,
            touched_pairs: Vec::new(),
        }
    }
}

/// Numbers of pairs that were not checked, by reason.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SkippedPairs {
    pub reason: String,
    pub count: u32,
}

/// Result for one joint state. The default status is `UNKNOWN`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct CollisionState {
    pub header: Header,
    pub status: u8,
    pub reason: String,
    pub reason_code: String,
    pub colliding_pairs: Vec<BodyPair>,
    pub distance_known: bool,
    pub nearest: PairDistance,
    pub pair_distances: Vec<PairDistance>,
    pub age: f64,
    pub model_revision: u64,
    pub world_revision: u64,
    pub pairs_checked: u32,
    pub pairs_skipped: u32,
    pub skipped: Vec<SkippedPairs>,
    pub warnings: Vec<String>,
    pub compute_time: f64,
    pub fidelity: String,
    pub time_to_contact: f64,
    pub time_to_contact_known: bool,
    pub first_contact_pair: BodyPair,
    pub time_to_contact_considers_obstacle_motion: bool,
    pub self_distance: f64,
    pub self_nearest: PairDistance,
    pub world_distance: f64,
    pub world_nearest: PairDistance,
    pub contacts: Vec<Contact>,
    pub motion_since_previous: u8,
    pub motion_since_previous_reason: String,
    pub passed_through: Vec<PassedThrough>,
    pub contacts_begun: u64,
    pub contacts_ended: u64,
    pub since_heartbeat: SinceHeartbeat,
}

impl CollisionState {
    pub const UNKNOWN: u8 = 0;
    pub const FREE: u8 = 1;
    pub const COLLIDING: u8 = 2;
    pub const NOT_CHECKED: u8 = 0;
    pub const PROVEN_FREE: u8 = 1;
    pub const PASSED_THROUGH: u8 = 2;
    pub const NOT_PROVEN: u8 = 3;
}

impl Message for BodyPair {}
impl Message for PairDistance {}
impl Message for Contact {}
impl Message for Separation {}
impl Message for LeastDistance {}
impl Message for DistanceEvent {}
impl Message for PassedThrough {}
impl Message for SkippedPairs {}
impl Message for CollisionState {}
impl Message for ObstacleStates {}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::messages::interface_text::{constants_in_text, fields_in_rust, fields_in_text};

    macro_rules! msg {
        ($name:literal) => {
            include_str!(concat!("../../../../interfaces/clearance_msgs/msg/", $name, ".msg"))
        };
    }

    #[test]
    fn fields_stand_in_the_order_of_the_msg_files() {
        assert_eq!(fields_in_rust::<BodyPair>(), fields_in_text(msg!("BodyPair")));
        assert_eq!(fields_in_rust::<PairDistance>(), fields_in_text(msg!("PairDistance")));
        assert_eq!(fields_in_rust::<Contact>(), fields_in_text(msg!("Contact")));
        assert_eq!(fields_in_rust::<Separation>(), fields_in_text(msg!("Separation")));
        assert_eq!(fields_in_rust::<LeastDistance>(), fields_in_text(msg!("LeastDistance")));
        assert_eq!(fields_in_rust::<DistanceEvent>(), fields_in_text(msg!("DistanceEvent")));
        assert_eq!(fields_in_rust::<PassedThrough>(), fields_in_text(msg!("PassedThrough")));
        assert_eq!(fields_in_rust::<SkippedPairs>(), fields_in_text(msg!("SkippedPairs")));
        assert_eq!(fields_in_rust::<SinceHeartbeat>(), fields_in_text(msg!("SinceHeartbeat")));
        assert_eq!(fields_in_rust::<ObstacleLimit>(), fields_in_text(msg!("ObstacleLimit")));
        assert_eq!(fields_in_rust::<MovingObstacle>(), fields_in_text(msg!("MovingObstacle")));
        assert_eq!(fields_in_rust::<ObstacleState>(), fields_in_text(msg!("ObstacleState")));
        assert_eq!(fields_in_rust::<ObstacleStates>(), fields_in_text(msg!("ObstacleStates")));
        assert_eq!(fields_in_rust::<CollisionState>(), fields_in_text(msg!("CollisionState")));
    }

    #[test]
    fn constants_have_the_values_of_the_msg_files() {
        let results = [
            ("NOT_CHECKED", DistanceEvent::NOT_CHECKED),
            ("FARTHER", DistanceEvent::FARTHER),
            ("REACHED", DistanceEvent::REACHED),
            ("UNDECIDED", DistanceEvent::UNDECIDED),
        ];
        assert_eq!(constants_in_text(msg!("DistanceEvent")), results);
        assert_eq!(
            constants_in_text(msg!("BodyPair")),
            [("LINK", BodyPair::LINK), ("OBSTACLE", BodyPair::OBSTACLE), ("ATTACHED", BodyPair::ATTACHED),]
        );
        assert_eq!(
            constants_in_text(msg!("CollisionState")),
            [
                ("UNKNOWN", CollisionState::UNKNOWN),
                ("FREE", CollisionState::FREE),
                ("COLLIDING", CollisionState::COLLIDING),
                ("NOT_CHECKED", CollisionState::NOT_CHECKED),
                ("PROVEN_FREE", CollisionState::PROVEN_FREE),
                ("PASSED_THROUGH", CollisionState::PASSED_THROUGH),
                ("NOT_PROVEN", CollisionState::NOT_PROVEN),
            ]
        );
    }
}
