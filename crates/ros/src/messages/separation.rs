//! Conversion of the result of speed and separation monitoring to its message.

use clearance_monitor::Evaluation;

use crate::messages::clearance_msgs::Separation;
use crate::messages::collision_state::{header, pair_message};

/// Message for `~/separation`; its numbers are NaN unless separation is monitored and the status is FREE.
#[must_use]
pub fn separation_message(evaluation: &Evaluation) -> Separation {
    let unknown = Separation {
        header: header(evaluation),
        distance: f64::NAN,
        protective_distance: f64::NAN,
        approach_speed: f64::NAN,
        allowed_speed: f64::NAN,
        requested_scale: f64::NAN,
        ..Separation::default()
    };
    let Some((separation, revision)) = evaluation.separation.zip(evaluation.revision.as_ref()) else {
        return unknown;
    };
    let pair = separation.bodies.map(|(a, b)| pair_message(&revision.checker, a, b));
    Separation {
        pair_known: pair.is_some(),
        pair: pair.unwrap_or_default(),
        distance: separation.distance,
        protective_distance: separation.protective_distance,
        approach_speed_known: separation.approach_speed.is_some(),
        approach_speed: separation.approach_speed.unwrap_or(f64::NAN),
        allowed_speed: separation.allowed_speed,
        requested_scale: separation.share,
        ..unknown
    }
}
