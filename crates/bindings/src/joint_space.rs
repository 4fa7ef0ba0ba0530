//! Joint space of a checker (all joints, or a group with the others fixed): converts rows of positions to states.

use std::sync::Arc;

use clearance::robot::{Configuration, ConfigurationError, JointGroup, JointId, RobotModel, UnknownGroup};

/// Converts positions in the order of a group to configurations of the whole robot.
#[derive(Debug)]
pub struct JointSpace {
    robot: Arc<RobotModel>,
    /// Positions of the joints outside of the group.
    rest: Configuration,
    /// The robot's position of each column; none if they are the same.
    columns: Option<Vec<usize>>,
    names: Vec<String>,
    /// The joints of the columns, if these are in the order of the robot.
    in_order: Option<JointGroup>,
    /// Name of the group; `None` if the columns are all positions.
    group: Option<String>,
}

/// Reason why there are no such states.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum JointSpaceError {
    /// The robot has no such group.
    #[error(transparent)]
    UnknownGroup(#[from] UnknownGroup),
    /// The group has no joint that moves by itself.
    #[error("group '{0}' has no joint that moves by itself")]
    EmptyGroup(String),
    /// A fixed joint is one of those that states give.
    #[error("fixed: joint '{joint}' is one of {states}, whose positions each query gives")]
    FixedInStates {
        /// Name of the joint.
        joint: String,
        /// The states or the group.
        states: String,
    },
    /// A fixed joint follows one of those that states give.
    #[error(
        "fixed: joint '{joint}' mimics joint '{leader}', whose position each query gives: leave '{joint}' out of fixed"
    )]
    FixedFollows {
        /// Name of the joint.
        joint: String,
        /// Name of the joint that it mimics.
        leader: String,
    },
    /// The fixed positions are not valid.
    #[error("fixed: {0}")]
    Fixed(ConfigurationError),
}

impl JointSpace {
    /// All positions of the robot.
    #[must_use]
    pub fn whole(robot: Arc<RobotModel>) -> Self {
        let (rest, names) = (robot.default_configuration(), robot.position_names().to_vec());
        Self { robot, rest, columns: None, names, in_order: None, group: None }.with_order()
    }

    /// The positions of a group of the SRDF, in the order of the robot; `fixed` are values of other joints by name.
    ///
    /// # Errors
    /// If there is no such group, if none of its joints moves by itself, or if the fixed joints do not fit.
    pub fn of_group(
        robot: Arc<RobotModel>,
        group: Option<&str>,
        fixed: &[(String, f64)],
    ) -> Result<Self, JointSpaceError> {
        let columns = group.map(|name| positions_of_group(&robot, name)).transpose()?;
        let names: Vec<String> = match &columns {
            Some(columns) => columns.iter().map(|&i| robot.position_names()[i].clone()).collect(),
            None => robot.position_names().to_vec(),
        };
        if let Some((joint, _)) = fixed.iter().find(|(joint, _)| names.contains(joint)) {
            let states = group.map_or_else(|| "the states".to_owned(), |group| format!("group '{group}'"));
            return Err(JointSpaceError::FixedInStates { joint: joint.clone(), states });
        }
        for (joint, _) in fixed {
            if let Some(leader) = leader_of(&robot, joint).filter(|leader| names.contains(leader)) {
                return Err(JointSpaceError::FixedFollows { joint: joint.clone(), leader });
            }
        }
        let given = fixed.iter().map(|(joint, value)| (joint.as_str(), *value));
        let rest = robot.configuration_from_names(given).map_err(JointSpaceError::Fixed)?;
        let group = group.map(str::to_owned);
        Ok(Self { robot, rest, columns, names, in_order: None, group }.with_order())
    }

    fn with_order(mut self) -> Self {
        let group = JointGroup::of_joints(&self.robot, "states", &self.joints());
        let is_in_order = match &self.columns {
            Some(columns) => group.positions() == columns,
            None => group.len() == self.names.len(),
        };
        self.in_order = is_in_order.then_some(group);
        self
    }

    /// The joints of the columns, with the name of the group for messages.
    #[must_use]
    pub fn joint_group(&self) -> JointGroup {
        let name = self.group.as_deref().unwrap_or("all joints of the robot");
        JointGroup::of_joints(&self.robot, name, &self.joints())
    }

    /// Names of the columns.
    #[must_use]
    pub fn names(&self) -> &[String] {
        &self.names
    }

    /// The robot.
    #[must_use]
    pub fn robot(&self) -> &Arc<RobotModel> {
        &self.robot
    }

    /// Positions of the joints outside of the group; columns have their defaults.
    #[must_use]
    pub fn rest(&self) -> &Configuration {
        &self.rest
    }

    /// Validates a row, which has a position for each column, and writes the configuration of the whole robot; `scratch` is memory that
    /// is reused.
    ///
    /// # Errors
    /// If the positions are not valid.
    pub fn read_into(
        &self,
        row: &[f64],
        scratch: &mut Vec<f64>,
        q: &mut Configuration,
    ) -> Result<(), ConfigurationError> {
        let Some(columns) = &self.columns else { return self.robot.configuration_into(row, q) };
        scratch.clear();
        scratch.extend_from_slice(self.rest.positions());
        for (&position, &value) in columns.iter().zip(row) {
            scratch[position] = value;
        }
        self.robot.configuration_into(scratch, q)
    }

    /// As [`Self::read_into`], into a configuration that was made from [`Self::rest`]: where the columns are in the order of the robot,
    /// only these are validated and written.
    ///
    /// # Errors
    /// If the positions are not valid.
    pub fn move_into(
        &self,
        row: &[f64],
        scratch: &mut Vec<f64>,
        q: &mut Configuration,
    ) -> Result<(), ConfigurationError> {
        match &self.in_order {
            Some(group) => {
                // the caller's memory may change meanwhile: what is validated is what is used
                scratch.clear();
                scratch.extend_from_slice(row);
                group.set(q, scratch)
            }
            None => self.read_into(row, scratch, q),
        }
    }

    /// The configuration of the whole robot for a row, which has a position for each column.
    ///
    /// # Errors
    /// If the positions are not valid.
    pub fn read(&self, row: &[f64]) -> Result<Configuration, ConfigurationError> {
        let mut q = self.rest.clone();
        self.read_into(row, &mut Vec::new(), &mut q)?;
        Ok(q)
    }

    /// The columns of values that the whole robot has, such as a row of derivatives.
    #[must_use]
    pub fn select<T: Copy>(&self, whole: &[T]) -> Vec<T> {
        match &self.columns {
            Some(columns) => columns.iter().map(|&position| whole[position]).collect(),
            None => whole.to_vec(),
        }
    }

    /// Values for the whole robot: those of the columns, and 0 for the others.
    #[must_use]
    pub fn expand(&self, values: &[f64]) -> Vec<f64> {
        let Some(columns) = &self.columns else { return values.to_vec() };
        let mut whole = vec![0.0; self.rest.positions().len()];
        for (&position, &value) in columns.iter().zip(values) {
            whole[position] = value;
        }
        whole
    }

    /// True if the columns are those of a group.
    #[must_use]
    pub fn is_group(&self) -> bool {
        self.columns.is_some()
    }

    /// The joints that the columns move.
    #[must_use]
    pub fn joints(&self) -> Vec<JointId> {
        let owns_column = |joint: &JointId| {
            let first = self.robot.first_position(*joint);
            first.is_some_and(|first| self.columns.as_ref().is_none_or(|columns| columns.contains(&first)))
        };
        self.robot.joint_ids().filter(owns_column).collect()
    }
}

/// The joint that a mimic joint follows.
fn leader_of(robot: &RobotModel, name: &str) -> Option<String> {
    let mimic = robot.joint(robot.joint_by_name(name)?).mimic?;
    Some(robot.joint(mimic.joint).name.clone())
}

/// The positions of a group; its mimic joints have none.
fn positions_of_group(robot: &RobotModel, name: &str) -> Result<Vec<usize>, JointSpaceError> {
    let groups = robot.srdf().map_or(&[][..], |srdf| &srdf.groups);
    let group = groups.iter().find(|group| group.name == name).ok_or_else(|| UnknownGroup {
        name: name.to_owned(),
        known: groups.iter().map(|group| group.name.clone()).collect(),
    })?;
    let positions = group.joints.iter().flat_map(|&joint| {
        let count = robot.joint(joint).kind.position_suffixes().len();
        let first = robot.first_position(joint).filter(|_| robot.joint(joint).mimic.is_none());
        first.into_iter().flat_map(move |first| first..first + count)
    });
    let positions: Vec<usize> = positions.collect();
    if positions.is_empty() {
        return Err(JointSpaceError::EmptyGroup(name.to_owned()));
    }
    Ok(positions)
}
