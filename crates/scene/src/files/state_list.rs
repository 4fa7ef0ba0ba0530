//! Reader of robot state files, YAML or JSON: this project's format, `JointState` or `RobotState` messages.

use std::sync::Arc;

use clearance_files::yaml::{self, Document};
use clearance_robot::RobotModel;
use serde::Deserialize;
use serde::de::{DeserializeOwned, IgnoredAny};

use super::text::{AttachedText, JointStateText, MultiDofText, RobotStateText};
use crate::NamedState;

/// One element of a file, in any of the three formats.
#[derive(Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
struct StateText {
    joints: Option<Vec<String>>,
    states: Option<Vec<Vec<f64>>>,

    #[serde(rename = "header")]
    _header: Option<IgnoredAny>,
    name: Option<Vec<String>>,
    position: Vec<f64>,
    #[serde(rename = "velocity")]
    _velocity: Option<IgnoredAny>,
    #[serde(rename = "effort")]
    _effort: Option<IgnoredAny>,

    joint_state: Option<JointStateText>,
    multi_dof_joint_state: Option<MultiDofText>,
    attached_collision_objects: Vec<AttachedText>,
    #[serde(rename = "is_diff")]
    _is_diff: Option<IgnoredAny>,
}

/// The states of a text.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct StateList {
    /// The states, in the order of the text.
    pub states: Vec<NamedState>,
    /// Warnings about parts of the text that belong to no state.
    pub remarks: Vec<String>,
}

impl NamedState {
    /// Reads a text of states: `{"joints": [...], "states": [[...], ...]}`, a `sensor_msgs/JointState` or a `moveit_msgs/RobotState`;
    /// also a list of them, or documents one after the other as `ros2 topic echo` writes them.
    ///
    /// # Errors
    /// One line with the location in the text, or the number of the state.
    pub fn list_from_text(text: &str, robot: &RobotModel) -> Result<StateList, String> {
        let (text, remarks) = yaml::without_remarks_of_echo(text);
        let mut states = Vec::new();
        for element in elements(&text)? {
            element.read_into(&mut states, robot).map_err(|why| format!("state {}: {why}", states.len()))?;
        }
        Ok(StateList { states, remarks })
    }
}

fn elements(text: &str) -> Result<Vec<StateText>, String> {
    let text = text.trim_start_matches('\u{feff}');
    // large files are JSON, which is faster to parse
    let as_json = json(text);
    if let Ok(elements) = as_json {
        return Ok(elements);
    }
    let documents = yaml::documents(text);
    if documents.is_empty() {
        return Err("it is empty".to_owned());
    }
    let mut elements = Vec::new();
    for document in documents {
        match (from_document(&document), &as_json) {
            (Ok(more), _) => elements.extend(more),
            (Err(_), Err(Some(why))) => return Err(why.clone()),
            (Err(why), _) => return Err(why),
        }
    }
    Ok(elements)
}

/// The elements of a JSON text; an error without a message means that the text is not JSON.
fn json(text: &str) -> Result<Vec<StateText>, Option<String>> {
    let read = match text.trim_start().chars().next() {
        Some('{') => serde_json::from_str(text).map(|one| vec![one]),
        Some('[') => serde_json::from_str(text),
        _ => return Err(None),
    };
    read.map_err(|error| Some(error.to_string()))
}

fn from_document(document: &Document) -> Result<Vec<StateText>, String> {
    if is_list(document.text) { parse(document) } else { parse(document).map(|one| vec![one]) }
}

fn parse<T: DeserializeOwned>(document: &Document) -> Result<T, String> {
    yaml::from_document(document.text).map_err(|first| {
        // parsed again, to obtain the line in the whole text
        let padded = "\n".repeat(document.line - 1) + document.text;
        yaml::from_document::<T>(&padded).err().unwrap_or(first)
    })
}

fn is_list(document: &str) -> bool {
    let mut lines = document.lines().map(str::trim_start);
    let first = lines.find(|line| !line.is_empty() && !line.starts_with('#'));
    first.is_some_and(|line| line.starts_with("- ") || line.trim_end() == "-" || line.starts_with('['))
}

impl StateText {
    fn read_into(self, states: &mut Vec<NamedState>, robot: &RobotModel) -> Result<(), String> {
        let is_table = self.joints.is_some() || self.states.is_some();
        let is_of_joints = self.name.is_some() || !self.position.is_empty();
        let is_of_robot = self.joint_state.is_some()
            || self.multi_dof_joint_state.is_some()
            || !self.attached_collision_objects.is_empty();
        match (is_table, is_of_joints, is_of_robot) {
            (true, false, false) => {
                let joints: Arc<[String]> = self.joints.ok_or("states without joints")?.into();
                for positions in self.states.ok_or("joints without states")? {
                    let (given, wanted) = (positions.len(), joints.len());
                    if given != wanted {
                        return Err(format!("{given} positions for {wanted} joints"));
                    }
                    states.push(NamedState::of_joints(Arc::clone(&joints), positions)?);
                }
            }
            (false, true, false) => {
                states.push(NamedState::of_joints(self.name.unwrap_or_default(), self.position)?);
            }
            (false, false, true) => {
                let text = RobotStateText {
                    joint_state: self.joint_state.unwrap_or_default(),
                    multi_dof_joint_state: self.multi_dof_joint_state.unwrap_or_default(),
                    attached_collision_objects: self.attached_collision_objects,
                    _is_diff: None,
                };
                states.push(NamedState::of_robot(text, robot)?);
            }
            (false, false, false) => return Err("no joint is named".to_owned()),
            _ => {
                return Err(
                    "joints and states, name and position, and joint_state exclude each other".to_owned()
                );
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests;
