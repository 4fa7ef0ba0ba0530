//! The joints of a checker's states: all of the robot, or those of a group, with fixed values for the others.

use std::sync::Arc;

use clearance::robot::{Configuration, JointId, RobotModel};

use crate::status::{Failure, Outcome};

/// Converts positions in the order of a group to configurations of the whole robot.
#[derive(Debug)]
pub struct JointSpace {
    robot: Arc<RobotModel>,
    /// Positions of the joints outside of the group.
    rest: Configuration,
    /// The robot's position of each column; none if they are the same.
    columns: Option<Vec<usize>>,
    names: Vec<String>,
}

impl JointSpace {
    /// All positions of the robot.
    pub fn whole(robot: Arc<RobotModel>) -> Self {
        let (rest, names) = (robot.default_configuration(), robot.position_names().to_vec());
        Self { robot, rest, columns: None, names }
    }

    /// The positions of a group of the SRDF, in the order of the group; `fixed` are values of other joints by name.
    pub fn of_group(robot: Arc<RobotModel>, group: Option<&str>, fixed: &[(String, f64)]) -> Outcome<Self> {
        let columns = group.map(|name| positions_of_group(&robot, name)).transpose()?;
        let names = match &columns {
            Some(columns) => columns.iter().map(|&i| robot.position_names()[i].clone()).collect(),
            None => robot.position_names().to_vec(),
        };
        if let Some((name, _)) = fixed.iter().find(|(name, _)| names.contains(name)) {
            let of = group.map_or_else(|| "the states".to_owned(), |group| format!("group '{group}'"));
            return Err(Failure::rejected(format!(
                "fixed: joint '{name}' is one of {of}, whose positions each query gives"
            )));
        }
        let given = fixed.iter().map(|(name, value)| (name.as_str(), *value));
        let rest =
            robot.configuration_from_names(given).map_err(|e| Failure::rejected(format!("fixed: {e}")))?;
        Ok(Self { robot, rest, columns, names })
    }

    /// Names of the columns.
    pub fn names(&self) -> &[String] {
        &self.names
    }

    /// The robot.
    pub fn robot(&self) -> &Arc<RobotModel> {
        &self.robot
    }

    /// Positions of the joints outside of the group; columns have their defaults.
    pub fn rest(&self) -> &Configuration {
        &self.rest
    }

    /// Validates a row, called `name`, and writes the configuration of the whole robot; `scratch` is memory that is reused.
    pub fn read_into(
        &self,
        row: &[f64],
        name: &dyn Fn() -> String,
        scratch: &mut Vec<f64>,
        q: &mut Configuration,
    ) -> Outcome {
        if row.len() != self.names.len() {
            return Err(Failure::argument(format!(
                "{} has {} positions, but must have {}: one for each of {}",
                name(),
                row.len(),
                self.names.len(),
                self.names.join(", ")
            )));
        }
        let whole = match &self.columns {
            None => row,
            Some(columns) => {
                scratch.clear();
                scratch.extend_from_slice(self.rest.positions());
                for (&position, &value) in columns.iter().zip(row) {
                    scratch[position] = value;
                }
                &*scratch
            }
        };
        self.robot.configuration_into(whole, q).map_err(|why| Failure::rejected(format!("{}: {why}", name())))
    }

    /// The configuration of the whole robot for a row, called `name`.
    pub fn read(&self, row: &[f64], name: &dyn Fn() -> String) -> Outcome<Configuration> {
        let mut q = self.rest.clone();
        self.read_into(row, name, &mut Vec::new(), &mut q)?;
        Ok(q)
    }

    /// The columns of values that the whole robot has, such as a row of derivatives.
    pub fn select<T: Copy>(&self, whole: &[T]) -> Vec<T> {
        match &self.columns {
            Some(columns) => columns.iter().map(|&position| whole[position]).collect(),
            None => whole.to_vec(),
        }
    }

    /// Values for the whole robot: those of the columns, and 0 for the others.
    pub fn expand(&self, values: &[f64]) -> Vec<f64> {
        let Some(columns) = &self.columns else { return values.to_vec() };
        let mut whole = vec![0.0; self.rest.positions().len()];
        for (&position, &value) in columns.iter().zip(values) {
            whole[position] = value;
        }
        whole
    }

    /// True if the columns are those of a group.
    pub fn is_group(&self) -> bool {
        self.columns.is_some()
    }

    /// The joints that the columns move.
    pub fn joints(&self) -> Vec<JointId> {
        let owns_column = |joint: &JointId| {
            let first = self.robot.first_position(*joint);
            first.is_some_and(|first| self.columns.as_ref().is_none_or(|columns| columns.contains(&first)))
        };
        self.robot.joint_ids().filter(owns_column).collect()
    }
}

/// The positions of a group; its mimic joints have none.
fn positions_of_group(robot: &RobotModel, name: &str) -> Outcome<Vec<usize>> {
    let groups = robot.srdf().map_or(&[][..], |srdf| &srdf.groups);
    let Some(group) = groups.iter().find(|group| group.name == name) else {
        let known: Vec<String> = groups.iter().map(|group| format!("'{}'", group.name)).collect();
        let known =
            if known.is_empty() { "it has none".to_owned() } else { format!("it has {}", known.join(", ")) };
        return Err(Failure::rejected(format!("the robot has no group '{name}': {known}")));
    };
    let positions = group.joints.iter().flat_map(|&joint| {
        let count = robot.joint(joint).kind.position_suffixes().len();
        let first = robot.first_position(joint).filter(|_| robot.joint(joint).mimic.is_none());
        first.into_iter().flat_map(move |first| first..first + count)
    });
    let positions: Vec<usize> = positions.collect();
    if positions.is_empty() {
        return Err(Failure::rejected(format!("group '{name}' has no joint that moves by itself")));
    }
    Ok(positions)
}
