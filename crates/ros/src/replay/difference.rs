//! Comparison of a replayed evaluation with the recorded one.

use clearance_monitor::Evaluation;
use ros2_interfaces_jazzy_serde::std_msgs::msg::{Bool, Float64};
use serde_json::Value as Json;

use crate::dds::cdr;
use crate::messages::clearance_msgs::CollisionState;
use crate::messages::collision_state::{ROUGH_FIDELITY, collision_state};
use crate::recording::mcap_file::RawMessage;
use crate::recording::step::Late;
use crate::replay::step_messages::StepMessages;

/// Result of one step.
pub(super) enum StepResult {
    Nothing,
    Same(Late),
    Differs { field: String, recorded: String, replayed: String },
}

/// Compares a result with the recorded one; returns the first field that differs, if any. `history` selects the fields about
/// earlier results.
pub(super) fn difference(
    evaluation: &Evaluation,
    late: Late,
    history: ComparedHistory,
    messages: &mut StepMessages,
) -> Result<Option<StepResult>, String> {
    let differs = |field: &str, recorded: &Json, replayed: &Json| {
        let (recorded, replayed) = (recorded.to_string(), replayed.to_string());
        (recorded != replayed).then(|| StepResult::Differs { field: field.to_owned(), recorded, replayed })
    };
    let raw = messages.raw("an answer")?;
    let names = fields(&raw.schema);
    let recorded = json(&state(&raw)?)?;
    let replayed = json(&collision_state(evaluation))?;
    for (field, replayed) in replayed.as_object().into_iter().flatten() {
        // the computing time is not compared, nor are fields that the recording version did not have
        if late == Late::Pairs || field == "compute_time" || !names.contains(field) {
            continue;
        }
        if !history.includes(field) {
            continue;
        }
        // where the deadline left contacts open, the first ones are compared
        if late == Late::Contacts && is_begun_by(replayed, &recorded[field], field) {
            continue;
        }
        // where the deadline left the search for the first contact open, another one may have been found
        if late == Late::PassageExtent && FIELDS_OF_PASSAGE.contains(&field.as_str()) {
            continue;
        }
        let is_older = !names.iter().any(|name| name == FIELD_OF_BOTH_DISTANCES);
        if is_older && field == "warnings" && warns_of_all(replayed, &recorded[field]) {
            continue;
        }
        // the fidelity also covers distances that the recording version did not compute
        if is_older && field == "fidelity" && replayed == ROUGH_FIDELITY {
            continue;
        }
        if let Some(difference) = differs(field, &recorded[field], replayed) {
            return Ok(Some(difference));
        }
    }
    let is_free: Bool = messages.next("is_free")?;
    let distance: Float64 = messages.next("distance")?;
    let number = |field: &str, was: f64, is: f64| {
        let text = |number: f64| Json::from(number.to_string());
        let is_same = was.to_bits() == is.to_bits() || (was.is_nan() && is.is_nan());
        (!is_same).then(|| differs(field, &text(was), &text(is)))?
    };
    if let Some(difference) = differs("is_free", &is_free.data.into(), &evaluation.status.is_free().into()) {
        return Ok(Some(difference));
    }
    if late != Late::Pairs
        && let Some(difference) = number("distance", distance.data, evaluation.distance())
    {
        return Ok(Some(difference));
    }
    // recordings of older versions lack this message
    if messages.is_empty() {
        return Ok(None);
    }
    let speed_scale: Float64 = messages.next("speed_scale")?;
    Ok(number("speed_scale", speed_scale.data, evaluation.speed_scale))
}

/// Fields about earlier results that are compared: those whose earlier results are all equal to the recorded ones.
#[derive(Clone, Copy)]
pub(super) struct ComparedHistory {
    /// All results since the start.
    pub since_start: bool,
    /// All results since the last message of the heartbeat topic.
    pub since_heartbeat: bool,
}

impl ComparedHistory {
    pub const ALL: Self = Self { since_start: true, since_heartbeat: true };

    fn includes(self, field: &str) -> bool {
        match field {
            "contacts_begun" | "contacts_ended" => self.since_start,
            "since_heartbeat" => self.since_heartbeat,
            _ => true,
        }
    }
}

/// Fields that name the contact since the previous state.
const FIELDS_OF_PASSAGE: [&str; 2] = ["passed_through", "reason"];

/// Versions without this field have fewer warnings and fewer distances.
const FIELD_OF_BOTH_DISTANCES: &str = "world_nearest";

/// Whether a replay with all contacts has those that were recorded, and their warnings.
fn is_begun_by(replayed: &Json, recorded: &Json, field: &str) -> bool {
    let (Some(all), Some(first)) = (replayed.as_array(), recorded.as_array()) else { return false };
    match field {
        "contacts" => all.starts_with(first),
        "warnings" => warns_of_all(replayed, recorded),
        _ => false,
    }
}

/// Whether `list` contains every element of `other`.
fn warns_of_all(list: &Json, other: &Json) -> bool {
    let texts = |list: &Json| list.as_array().cloned().unwrap_or_default();
    let list = texts(list);
    texts(other).iter().all(|text| list.contains(text))
}

fn json(state: &CollisionState) -> Result<Json, String> {
    serde_json::to_value(state).map_err(|error| error.to_string())
}

/// Decodes a recorded result. Older versions lack the fields that were later added at the end.
fn state(raw: &RawMessage) -> Result<CollisionState, String> {
    const ROOM: usize = 4096;
    if raw.kind != "clearance_msgs/msg/CollisionState" {
        return Err(format!("{}: is a {}, no CollisionState", raw.topic, raw.kind));
    }
    let mut bytes = raw.data.clone();
    bytes.extend([0; ROOM]);
    cdr::decode(&bytes).map_err(|why| format!("{}: {why}", raw.topic))
}

/// Names of the fields that a message had when it was recorded.
fn fields(schema: &[u8]) -> Vec<String> {
    let text = String::from_utf8_lossy(schema);
    let own = text.split("\n====").next().unwrap_or_default();
    let declarations = own.lines().filter_map(|line| line.split('#').next());
    let names =
        declarations.filter(|line| !line.contains('=')).filter_map(|line| line.split_whitespace().nth(1));
    names.map(str::to_owned).collect()
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    #[test]
    fn a_replay_with_all_contacts_begins_with_the_recorded_ones() {
        let all = json!([{"depth_lower": 1.0}, {"depth_lower": 0.5}]);
        for (recorded, is_same) in [
            (json!([]), true),
            (json!([{"depth_lower": 1.0}]), true),
            (all.clone(), true),
            (json!([{"depth_lower": 0.5}]), false),
            (json!([{"depth_lower": 1.0}, {"depth_lower": 0.5}, {"depth_lower": 0.1}]), false),
        ] {
            assert_eq!(is_begun_by(&all, &recorded, "contacts"), is_same, "{recorded}");
            assert!(!is_begun_by(&all, &recorded, "colliding_pairs"));
        }
    }
}
