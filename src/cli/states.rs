//! States to check: from a JSON or CSV file, or from the command line.

use std::path::Path;

use clearance::input_files::{self, STATES_LIMIT};
use clearance::robot::{Configuration, JointKind, RobotModel};
use serde::Deserialize;

use super::failure::Failure;

/// What a file has to hold, for those that hold something else.
const STATES: &str = r#"states are JSON {"joints": [...], "states": [[...], ...]}, or CSV with a header of joint names in FILE.csv"#;
const EDGES: &str = r#"edges are JSON {"joints": [...], "edges": [[[...], [...]], ...]}"#;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct StatesText {
    joints: Vec<String>,
    states: Vec<Vec<f64>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct EdgesText {
    joints: Vec<String>,
    edges: Vec<[Vec<f64>; 2]>,
}

/// States of `robot` from a file: `{"joints": [...], "states": [[...], ...]}`, or CSV with a header of joint names.
///
/// Joints that are not given take their default. Mimic joints follow; a value of one moves its leader.
pub fn from_file(path: &Path, robot: &RobotModel) -> Result<Vec<Configuration>, Failure> {
    let file = path.display();
    let bad = |e: &dyn std::fmt::Display| Failure::Input(format!("{file}: {e}"));
    let text = input_files::read_text(path, STATES_LIMIT).map_err(Failure::input)?;
    let is_csv = (path.extension()).is_some_and(|e| e.eq_ignore_ascii_case("csv"));
    let StatesText { joints, states } = if is_csv {
        from_csv(&text).map_err(|e| bad(&e))?
    } else {
        serde_json::from_str(&text).map_err(|e| bad(&format!("{e}; {STATES}")))?
    };
    if states.is_empty() {
        return Err(bad(&"there are no states"));
    }
    let named = robot.named_joints(joints.iter().map(String::as_str));
    let named = named.map_err(|e| bad(&format!("state 0: {e}")))?;
    let rest = robot.default_configuration();
    (states.iter().enumerate())
        .map(|(i, positions)| {
            let of_state = |e: &dyn std::fmt::Display| bad(&format!("state {i}: {e}"));
            if positions.len() != joints.len() {
                let (given, wanted) = (positions.len(), joints.len());
                return Err(of_state(&format!("{given} positions for {wanted} joints")));
            }
            named.configuration(&rest, positions).map_err(|e| of_state(&e))
        })
        .collect()
}

fn from_csv(text: &str) -> Result<StatesText, String> {
    let mut reader = csv::ReaderBuilder::new().trim(csv::Trim::All).from_reader(text.as_bytes());
    let joints = reader.headers().map_err(|e| e.to_string())?.clone();
    let states = (reader.records())
        .map(|record| {
            let record = record.map_err(|e| e.to_string())?;
            let line = record.position().map_or(0, csv::Position::line);
            (record.iter())
                .map(|field| {
                    (field.parse::<f64>()).map_err(|_| format!("line {line}: '{field}' is not a number"))
                })
                .collect()
        })
        .collect::<Result<_, String>>()?;
    Ok(StatesText { joints: joints.iter().map(str::to_owned).collect(), states })
}

/// One state from text such as `"j1=0.1 j2=-1.2"`; blanks or commas between the joints.
pub fn from_text(argument: &str, text: &str, robot: &RobotModel) -> Result<Configuration, Failure> {
    let named = named(argument, text)?;
    robot.configuration_from_names(named).map_err(|e| Failure::Input(format!("{argument}: {e}")))
}

/// A tolerance for each position: one number for all, or joints by name and zero for the rest. Mimic joints follow; a tolerance of one counts
/// for its leader.
pub fn tube_from_text(text: &str, robot: &RobotModel) -> Result<Vec<f64>, Failure> {
    let names = robot.position_names();
    if let Ok(all) = text.trim().parse::<f64>() {
        let mut tube = vec![all; names.len()];
        // a floating joint has none
        for joint in robot.joint_ids().filter(|j| robot.joint(*j).kind == JointKind::Floating) {
            if let Some(first) = robot.first_position(joint) {
                tube[first..first + 7].fill(0.0);
            }
        }
        return Ok(tube);
    }
    let (joints, values): (Vec<&str>, Vec<f64>) = named("--tube", text)?.into_iter().unzip();
    let tube = robot.named_joints(joints).and_then(|joints| joints.tolerances(&values));
    tube.map_err(|e| Failure::Input(format!("--tube: {e}")))
}

/// Edges of `robot` from a file: `{"joints": [...], "edges": [[[...], [...]], ...]}`.
pub fn edges_from_file(path: &Path, robot: &RobotModel) -> Result<Vec<[Configuration; 2]>, Failure> {
    let file = path.display();
    let bad = |e: &dyn std::fmt::Display| Failure::Input(format!("{file}: {e}"));
    let text = input_files::read_text(path, STATES_LIMIT).map_err(Failure::input)?;
    let EdgesText { joints, edges } =
        serde_json::from_str(&text).map_err(|e| bad(&format!("{e}; {EDGES}")))?;
    if edges.is_empty() {
        return Err(bad(&"there are no edges"));
    }
    let named = robot.named_joints(joints.iter().map(String::as_str));
    let named = named.map_err(|e| bad(&format!("edge 0: {e}")))?;
    let rest = robot.default_configuration();
    let end = |i: usize, positions: &[f64]| {
        let of_edge = |e: &dyn std::fmt::Display| bad(&format!("edge {i}: {e}"));
        if positions.len() != joints.len() {
            return Err(of_edge(&format!("{} positions for {} joints", positions.len(), joints.len())));
        }
        named.configuration(&rest, positions).map_err(|e| of_edge(&e))
    };
    (edges.iter().enumerate()).map(|(i, [from, to])| Ok([end(i, from)?, end(i, to)?])).collect()
}

/// Joints and numbers from text such as `"j1=0.1 j2=-1.2"`.
fn named<'t>(argument: &str, text: &'t str) -> Result<Vec<(&'t str, f64)>, Failure> {
    (text.split(|c: char| c == ',' || c.is_whitespace()))
        .filter(|word| !word.is_empty())
        .map(|word| {
            let value = |v: &str| v.parse::<f64>().ok();
            (word.rsplit_once('='))
                .and_then(|(joint, v)| Some((joint, value(v)?)))
                .ok_or_else(|| Failure::Input(format!("{argument}: '{word}' is not JOINT=NUMBER")))
        })
        .collect()
}
