//! Reads states, joint tolerances and edges from files or from the command line.

use std::path::Path;
use std::sync::Arc;

use clearance::robot::{Configuration, ConfigurationError, NamedJoints, RobotModel};
use clearance::scene::{NamedState, StateList};
use clearance_files::input_files::{self, STATES_LIMIT};
use clearance_files::yaml;
use serde::Deserialize;

use super::assignments;
use super::failure::Failure;
use super::state_files;

/// Required content of a file, for error messages about other content.
const EDGES: &str = r#"edges are JSON {"joints": [...], "edges": [[[...], [...]], ...]}"#;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct EdgesText {
    joints: Vec<String>,
    edges: Vec<[Vec<f64>; 2]>,
}

/// Reads states of `robot` from a file: JSON, the YAML of ROS messages, or CSV with a header of joint names.
///
/// Joints without a value take their default. Mimic joints follow their leader; the value of a mimic joint sets its leader.
pub fn from_file(path: &Path, robot: &RobotModel) -> Result<Vec<Configuration>, Failure> {
    let file = path.display();
    let bad = |e: &dyn std::fmt::Display| Failure::Input(format!("{file}: {e}"));
    let text = input_files::read_text(path, STATES_LIMIT).map_err(Failure::input)?;
    let StateList { states, remarks } = state_files::read(path, &text, robot).map_err(|e| bad(&e))?;
    for remark in remarks {
        log::warn!("{file}: {remark}");
    }
    if states.is_empty() {
        return Err(bad(&"there are no states"));
    }
    let rest = robot.default_configuration();
    // the rows of a table share their joint names
    let mut resolved: Option<(&Arc<[String]>, NamedJoints)> = None;
    let mut configurations = Vec::with_capacity(states.len());
    let mut given = vec![0; rest.positions().len()];
    for (i, NamedState { names, positions }) in states.iter().enumerate() {
        let of_state = |e: ConfigurationError| bad(&format!("state {i}: {e}"));
        let joints = match resolved.take().filter(|(of, _)| Arc::ptr_eq(of, names)) {
            Some((_, joints)) => joints,
            None => robot.named_joints(names.iter().map(String::as_str)).map_err(of_state)?,
        };
        configurations.push(joints.configuration(&rest, positions).map_err(of_state)?);
        (0..given.len())
            .filter(|position| joints.decides(*position))
            .for_each(|position| given[position] += 1);
        resolved = Some((names, joints));
    }
    if let Some(note) = partial_states_note(robot, &given, &rest, states.len()) {
        log::warn!("{file}: {note}");
    }
    Ok(configurations)
}

/// Warning about joints that only some states contain; `given` is the number of states that contain each position.
fn partial_states_note(
    robot: &RobotModel,
    given: &[usize],
    rest: &Configuration,
    states: usize,
) -> Option<String> {
    const MOST: usize = 8;
    let partly: Vec<usize> = (0..given.len()).filter(|i| given[*i] > 0 && given[*i] < states).collect();
    if partly.is_empty() {
        return None;
    }
    let of_joint = |&i: &usize| {
        let (name, lacking) = (&robot.position_names()[i], states - given[i]);
        format!("'{name}' ({lacking} of {states}, {} there)", rest.positions()[i])
    };
    let mut joints: Vec<String> = partly.iter().take(MOST).map(of_joint).collect();
    if partly.len() > MOST {
        joints.push(format!("and {} more", partly.len() - MOST));
    }
    Some(format!(
        "the states name different joints; each is checked by itself, without what others give. Joints that are missing in some states: {}; \
         write all joints into every state",
        joints.join(", ")
    ))
}

/// Parses one state such as `"j1=0.1 j2=-1.2"`; joints are separated by blanks or commas.
pub fn from_text(argument: &str, text: &str, robot: &RobotModel) -> Result<Configuration, Failure> {
    let named = assignments::parse(argument, text)?;
    robot.configuration_from_names(named).map_err(|e| Failure::Input(format!("{argument}: {e}")))
}

/// As [`from_text`]; joints without a value are as in `rest`.
pub fn from_text_over(
    argument: &str,
    text: &str,
    robot: &RobotModel,
    rest: &Configuration,
) -> Result<Configuration, Failure> {
    let named = assignments::parse(argument, text)?;
    robot.configuration_over(rest, named).map_err(|e| Failure::Input(format!("{argument}: {e}")))
}

/// Tolerance for each position, from the value of an option: one number for all joints, or values by joint name and zero for the others. A tolerance of a mimic joint
/// applies to its leader.
pub fn tube_from_text(option: &str, text: &str, robot: &RobotModel) -> Result<Vec<f64>, Failure> {
    let tube = if let Ok(all) = text.trim().parse::<f64>() {
        robot.uniform_tolerances(all)
    } else {
        let named = assignments::parse(option, text)?;
        let (joints, values): (Vec<&str>, Vec<f64>) = named.into_iter().unzip();
        robot.named_joints(joints).and_then(|joints| joints.tolerances(&values))
    };
    tube.map_err(|e| Failure::Input(format!("{option}: {e}")))
}

/// Reads edges of `robot` from a file: `{"joints": [...], "edges": [[[...], [...]], ...]}`.
pub fn edges_from_file(path: &Path, robot: &RobotModel) -> Result<Vec<[Configuration; 2]>, Failure> {
    let file = path.display();
    let bad = |e: &dyn std::fmt::Display| Failure::Input(format!("{file}: {e}"));
    let text = input_files::read_text(path, STATES_LIMIT).map_err(Failure::input)?;
    let EdgesText { joints, edges } = read_edges(&text).map_err(|e| bad(&format!("{e}; {EDGES}")))?;
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

/// The JSON parser is tried first, because it is faster. For text that starts with a brace, the error is the one from this parser.
fn read_edges(text: &str) -> Result<EdgesText, String> {
    serde_json::from_str(text).or_else(|error| {
        let is_json = text.trim_start().starts_with('{');
        yaml::from_text(text).map_err(|why| if is_json { error.to_string() } else { why })
    })
}

#[cfg(test)]
mod tests {
    use clearance::robot::MeshFiles;

    use super::*;

    fn note(given: &[usize], states: usize) -> Option<String> {
        let joint = |name: &str| {
            format!(
                "<link name='of_{name}'/><joint name='{name}' type='continuous'><parent link='base'/><child link='of_{name}'/></joint>"
            )
        };
        let joints: String = (0..given.len()).map(|i| joint(&format!("j{i}"))).collect::<Vec<_>>().concat();
        let urdf = format!("<robot name='r'><link name='base'/>{joints}</robot>");
        let robot = RobotModel::from_urdf(&urdf, &MeshFiles::default()).unwrap();
        partial_states_note(&robot, given, &robot.default_configuration(), states)
    }

    #[test]
    fn joints_that_only_some_states_give_are_named() {
        let told = note(&[2, 1, 0], 2).unwrap();
        assert!(
            told.contains("'j1' (1 of 2, 0 there)") && !told.contains("j0") && !told.contains("j2"),
            "{told}"
        );
        assert!(note(&[1; 30], 2).unwrap().contains("and 22 more"));
        for given in [&[2, 2][..], &[2, 0], &[0, 0]] {
            assert_eq!(note(given, 2), None, "{given:?}");
        }
    }
}
