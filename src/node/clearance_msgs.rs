//! The messages of the ROS package `clearance_msgs`, as serde structs.
//!
//! CDR carries neither names nor an order of its own: the fields below stand in the order of
//! `interfaces/clearance_msgs/msg/*.msg`, which also hold every field's unit, frame and meaning.

use ros2_client::Message;
use ros2_interfaces_jazzy_serde::{geometry_msgs::msg::Point, std_msgs::msg::Header};
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

/// The least distance between two bodies, and where it is.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct PairDistance {
    pub pair: BodyPair,
    pub distance: f64,
    pub witness_points: [Point; 2],
}

/// Pairs of bodies that were not checked, counted by the reason why.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SkippedPairs {
    pub reason: String,
    pub count: u32,
}

/// What is known about one joint state. The default says `UNKNOWN`.
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
}

impl CollisionState {
    pub const UNKNOWN: u8 = 0;
    pub const FREE: u8 = 1;
    pub const COLLIDING: u8 = 2;
}

impl Message for BodyPair {}
impl Message for PairDistance {}
impl Message for SkippedPairs {}
impl Message for CollisionState {}

#[cfg(test)]
mod tests {
    use serde::de::{Deserializer, Error as _, Visitor, value::Error};
    use serde::forward_to_deserialize_any;

    use super::*;

    /// Deserializes nothing: it fails with the field names that the type asks for, in their order.
    struct FieldNames;

    impl<'de> Deserializer<'de> for FieldNames {
        type Error = Error;

        fn deserialize_struct<V: Visitor<'de>>(
            self,
            _name: &'static str,
            fields: &'static [&'static str],
            _visitor: V,
        ) -> Result<V::Value, Error> {
            Err(Error::custom(fields.join(" ")))
        }

        fn deserialize_any<V: Visitor<'de>>(self, _visitor: V) -> Result<V::Value, Error> {
            Err(Error::custom("a message is a struct"))
        }

        forward_to_deserialize_any! {
            bool i8 i16 i32 i64 u8 u16 u32 u64 f32 f64 char str string bytes byte_buf option unit
            unit_struct newtype_struct seq tuple tuple_struct map enum identifier ignored_any
        }
    }

    fn fields_in_rust<M: Message + std::fmt::Debug>() -> String {
        M::deserialize(FieldNames).unwrap_err().to_string()
    }

    /// The declarations of a .msg file, comments left out: the type and what follows it.
    fn declarations(msg: &str) -> impl Iterator<Item = (&str, &str)> {
        msg.lines()
            .filter_map(|line| line.split('#').next()?.trim().split_once(char::is_whitespace))
            .map(|(kind, rest)| (kind, rest.trim()))
    }

    fn fields_in_msg(msg: &str) -> String {
        let names: Vec<_> =
            declarations(msg).map(|(_, rest)| rest).filter(|rest| !rest.contains('=')).collect();
        names.join(" ")
    }

    fn constants_in_msg(msg: &str) -> Vec<(&str, u8)> {
        declarations(msg)
            .filter_map(|(_, rest)| rest.split_once('='))
            .map(|(name, value)| (name, value.parse().unwrap()))
            .collect()
    }

    macro_rules! msg {
        ($name:literal) => {
            include_str!(concat!("../../interfaces/clearance_msgs/msg/", $name, ".msg"))
        };
    }

    #[test]
    fn fields_stand_in_the_order_of_the_msg_files() {
        assert_eq!(fields_in_rust::<BodyPair>(), fields_in_msg(msg!("BodyPair")));
        assert_eq!(fields_in_rust::<PairDistance>(), fields_in_msg(msg!("PairDistance")));
        assert_eq!(fields_in_rust::<SkippedPairs>(), fields_in_msg(msg!("SkippedPairs")));
        assert_eq!(fields_in_rust::<CollisionState>(), fields_in_msg(msg!("CollisionState")));
    }

    #[test]
    fn constants_have_the_values_of_the_msg_files() {
        assert_eq!(
            constants_in_msg(msg!("BodyPair")),
            [("LINK", BodyPair::LINK), ("OBSTACLE", BodyPair::OBSTACLE), ("ATTACHED", BodyPair::ATTACHED),]
        );
        assert_eq!(
            constants_in_msg(msg!("CollisionState")),
            [
                ("UNKNOWN", CollisionState::UNKNOWN),
                ("FREE", CollisionState::FREE),
                ("COLLIDING", CollisionState::COLLIDING),
            ]
        );
    }
}
