//! Allowed collision matrix (ACM) of MoveIt: pairs that may touch.

use std::collections::{BTreeMap, BTreeSet, HashMap, HashSet};

use clearance_robot::RobotModel;
use serde::Deserialize;

/// For pairs of names: whether they may touch. An entry for a pair takes precedence over the defaults of its names; where neither exists
/// the pair is checked.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct AllowedCollisionMatrix {
    entries: HashMap<(String, String), bool>,
    /// Names that have entries.
    named: HashSet<String>,
    defaults: HashMap<String, bool>,
}

/// Errors in the entries of a matrix.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[allow(missing_docs, reason = "the message of each variant describes it and its fields")]
pub enum MatrixError {
    #[error("allowed_collision_matrix: {names} entry_names but {rows} rows of entry_values")]
    Rows { names: usize, rows: usize },
    #[error("allowed_collision_matrix: row '{row}' has {columns} values for {names} entry_names")]
    Columns { row: String, columns: usize, names: usize },
    #[error("allowed_collision_matrix: entry '{a}' – '{b}' is not symmetric")]
    Asymmetric { a: String, b: String },
    #[error("allowed_collision_matrix: {names} default_entry_names but {values} default_entry_values")]
    Defaults { names: usize, values: usize },
    #[error("allowed_collision_matrix: default_entry_names has '{0}' twice, with both values: leave one out")]
    Contradiction(String),
}

/// `moveit_msgs/AllowedCollisionMatrix` in the format of the file.
#[derive(Clone, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(default)]
pub struct MatrixEntries {
    /// Names of the rows and columns: links or objects.
    pub entry_names: Vec<String>,
    /// One row for each name; true where contact is allowed.
    #[serde(deserialize_with = "rows")]
    pub entry_values: Vec<Vec<bool>>,
    /// Names with a default value.
    pub default_entry_names: Vec<String>,
    /// One value for each default name; true where contact is allowed.
    pub default_entry_values: Vec<bool>,
}

impl AllowedCollisionMatrix {
    /// The matrix of the robot's SRDF, as `MoveIt` builds it: default entries of links with `<disable_default_collisions>`, and
    /// entries of enabled and disabled pairs.
    #[must_use]
    pub fn from_srdf(robot: &RobotModel) -> Self {
        let mut matrix = Self::default();
        let Some(srdf) = robot.srdf() else { return matrix };
        for &link in &srdf.unchecked_by_default {
            matrix.set_default(&robot.link(link).name, true);
        }
        for &(a, b) in &srdf.enabled_pairs {
            matrix.set(&robot.link(a).name, &robot.link(b).name, false);
        }
        for pair in &srdf.disabled_pairs {
            matrix.set(&robot.link(pair.a).name, &robot.link(pair.b).name, true);
        }
        matrix
    }

    /// Allowed pairs without a scene's matrix: the pairs that the SRDF disables, or without an SRDF, adjacent rigid bodies.
    #[must_use]
    pub fn of_robot(robot: &RobotModel) -> Self {
        if robot.srdf().is_some() {
            return Self::from_srdf(robot);
        }
        let mut matrix = Self::default();
        for a in robot.link_ids() {
            for b in robot.link_ids().filter(|b| a < *b && robot.adjacent_rigid_bodies(a, *b)) {
                matrix.set(&robot.link(a).name, &robot.link(b).name, true);
            }
        }
        matrix
    }

    /// The matrix of a planning scene.
    pub fn from_entries(given: &MatrixEntries) -> Result<Self, MatrixError> {
        let names = &given.entry_names;
        if given.entry_values.len() != names.len() {
            return Err(MatrixError::Rows { names: names.len(), rows: given.entry_values.len() });
        }
        if given.default_entry_names.len() != given.default_entry_values.len() {
            return Err(MatrixError::Defaults {
                names: given.default_entry_names.len(),
                values: given.default_entry_values.len(),
            });
        }
        let mut matrix = Self::default();
        for (a, row) in names.iter().zip(&given.entry_values) {
            if row.len() != names.len() {
                return Err(MatrixError::Columns { row: a.clone(), columns: row.len(), names: names.len() });
            }
            for (b, &allowed) in names.iter().zip(row) {
                if matrix.entry(a, b).is_some_and(|earlier| earlier != allowed) {
                    return Err(MatrixError::Asymmetric { a: a.clone(), b: b.clone() });
                }
                matrix.set(a, b, allowed);
            }
        }
        for (name, &allowed) in given.default_entry_names.iter().zip(&given.default_entry_values) {
            if matrix.defaults.insert(name.clone(), allowed).is_some_and(|earlier| earlier != allowed) {
                return Err(MatrixError::Contradiction(name.clone()));
            }
        }
        Ok(matrix)
    }

    /// Sets whether `a` and `b` may touch.
    pub fn set(&mut self, a: &str, b: &str, allowed: bool) {
        self.entries.insert(key(a, b), allowed);
        for name in [a, b] {
            if !self.named.contains(name) {
                self.named.insert(name.to_owned());
            }
        }
    }

    /// Sets the default of `name`: whether it may touch everything that it has no entry with, now and later.
    pub fn set_default(&mut self, name: &str, allowed: bool) {
        self.defaults.insert(name.to_owned(), allowed);
    }

    /// Removes all entries and defaults of some names, in one pass.
    pub fn forget(&mut self, names: &HashSet<&str>) {
        self.entries.retain(|(a, b), _| !names.contains(a.as_str()) && !names.contains(b.as_str()));
        self.named = self.entries.keys().flat_map(|(a, b)| [a, b]).cloned().collect();
        self.defaults.retain(|name, _| !names.contains(name.as_str()));
    }

    /// The equivalent matrix of a planning scene; names are sorted.
    #[must_use]
    pub fn to_entries(&self) -> MatrixEntries {
        let names: BTreeSet<&String> = self.named.iter().collect();
        let row = |a: &&String| names.iter().map(|b| self.allows(a, b)).collect();
        let defaults: BTreeMap<_, _> = self.defaults.iter().collect();
        MatrixEntries {
            entry_values: names.iter().map(row).collect(),
            entry_names: names.into_iter().cloned().collect(),
            default_entry_names: defaults.keys().map(|name| (*name).clone()).collect(),
            default_entry_values: defaults.values().map(|allowed| **allowed).collect(),
        }
    }

    /// True if the pair has an entry of its own, so that no default applies.
    #[must_use]
    pub fn has_entry(&self, a: &str, b: &str) -> bool {
        self.entry(a, b).is_some()
    }

    fn entry(&self, a: &str, b: &str) -> Option<bool> {
        self.entries.get(&key(a, b)).copied()
    }

    /// All names that have entries or defaults; a name may occur twice.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.named.iter().chain(self.defaults.keys()).map(String::as_str)
    }

    /// True if a name has an entry or a default.
    #[must_use]
    pub fn mentions(&self, name: &str) -> bool {
        self.defaults.contains_key(name) || self.named.contains(name)
    }

    /// The default of a name: whether it may touch names without an entry.
    #[must_use]
    pub fn allows_by_default(&self, name: &str) -> bool {
        self.defaults.get(name).copied().unwrap_or(false)
    }

    /// True if `a` and `b` may touch; false without an entry or default. If both names have defaults, both must allow it.
    #[must_use]
    pub fn allows(&self, a: &str, b: &str) -> bool {
        self.entry(a, b).unwrap_or_else(|| match (self.defaults.get(a), self.defaults.get(b)) {
            (Some(&a), Some(&b)) => a && b,
            (Some(&one), None) | (None, Some(&one)) => one,
            (None, None) => false,
        })
    }
}

fn key(a: &str, b: &str) -> (String, String) {
    let (a, b) = if a <= b { (a, b) } else { (b, a) };
    (a.to_owned(), b.to_owned())
}

/// Rows as `[true, false]` or as `moveit_msgs/AllowedCollisionEntry` with the field `enabled`.
fn rows<'de, D: serde::Deserializer<'de>>(deserializer: D) -> Result<Vec<Vec<bool>>, D::Error> {
    #[derive(Deserialize)]
    #[serde(untagged, expecting = "a row must be a list of true and false, or have such a list as enabled")]
    enum Row {
        List(Vec<bool>),
        Map { enabled: Vec<bool> },
    }
    let rows = Vec::<Row>::deserialize(deserializer)?;
    Ok((rows.into_iter())
        .map(|row| match row {
            Row::List(values) | Row::Map { enabled: values } => values,
        })
        .collect())
}
