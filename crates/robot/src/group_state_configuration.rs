//! Configurations from the group states (named states) of the SRDF, and their errors.

use std::collections::BTreeSet;

use super::joint_group::known_names;
use super::srdf::GroupState;
use super::{Configuration, ConfigurationError, RobotModel};

/// Reason why a name is not a configuration.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum GroupStateError {
    /// The SRDF has no such state.
    #[error("the robot has no group state '{name}'; {}", known_names("SRDF", known))]
    Unknown {
        /// The given name.
        name: String,
        /// The states of the SRDF, as `GROUP/STATE`.
        known: Vec<String>,
    },
    /// Several states have this name.
    #[error("the SRDF has several group states '{name}': {}", remedy(states))]
    Ambiguous {
        /// The given name.
        name: String,
        /// These states, as `GROUP/STATE`.
        states: Vec<String>,
    },
    /// The state has a fault.
    #[error("group state '{name}' of the SRDF: {fault}")]
    Faulty {
        /// Name of the state.
        name: String,
        /// What is wrong with it.
        fault: String,
    },
    /// The positions of the state are not a configuration.
    #[error("group state '{name}' of the SRDF: {error}")]
    Positions {
        /// Name of the state.
        name: String,
        /// What is wrong with the positions.
        error: ConfigurationError,
    },
}

/// How to tell states of one name apart.
fn remedy(states: &[String]) -> String {
    let distinct: BTreeSet<&String> = states.iter().collect();
    if distinct.len() == states.len() {
        format!("give one of {}", super::quoted_list(states))
    } else {
        "rename all but one".to_owned()
    }
}

impl RobotModel {
    /// The configuration with a named state of the SRDF (`<group_state>`): `ready`, or `arm/ready` where several groups have
    /// a state of this name. Joints that the state does not name are at their defaults.
    ///
    /// # Errors
    /// If there is no such state, if there are several, or if the SRDF gives values that are no positions.
    pub fn group_state(&self, name: &str) -> Result<Configuration, GroupStateError> {
        self.group_state_over(&self.default_configuration(), name)
    }

    /// As [`Self::group_state`], but joints that the state does not name keep their positions of `rest`.
    ///
    /// # Errors
    /// As [`Self::group_state`].
    pub fn group_state_over(
        &self,
        rest: &Configuration,
        name: &str,
    ) -> Result<Configuration, GroupStateError> {
        let state = self.find_group_state(name)?;
        let name = || state.name.clone();
        if let Some(fault) = &state.fault {
            return Err(GroupStateError::Faulty { name: name(), fault: fault.clone() });
        }
        let positions = state.positions.iter().map(|(joint, position)| (joint.as_str(), *position));
        self.configuration_over(rest, positions)
            .map_err(|error| GroupStateError::Positions { name: name(), error })
    }

    fn find_group_state(&self, name: &str) -> Result<&GroupState, GroupStateError> {
        let states = self.srdf().map_or(&[][..], |srdf| &srdf.group_states);
        let qualified = |state: &GroupState| format!("{}/{}", state.group, state.name);
        let mut found: Vec<&GroupState> = states.iter().filter(|state| qualified(state) == name).collect();
        if found.is_empty() {
            found = states.iter().filter(|state| state.name == name).collect();
        }
        match found[..] {
            [state] => Ok(state),
            [] => Err(GroupStateError::Unknown {
                name: name.to_owned(),
                known: states.iter().map(qualified).collect(),
            }),
            _ => Err(GroupStateError::Ambiguous {
                name: name.to_owned(),
                states: found.into_iter().map(qualified).collect(),
            }),
        }
    }
}
