//! Allowed collision matrix (ACM) of MoveIt: pairs that may touch.

use std::collections::{BTreeMap, HashMap, HashSet};
use std::sync::Arc;

use clearance_robot::RobotModel;
use serde::Deserialize;

use super::pair_entries::PairEntries;

/// For pairs of names: whether they may touch. An entry for a pair takes precedence over the defaults of its names; where neither exists
/// the pair is checked. Copies share their content.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct AllowedCollisionMatrix {
    entries: Arc<PairEntries>,
    defaults: Arc<HashMap<String, bool>>,
}

/// A name in a matrix.
struct NameInMatrix<'m> {
    name: &'m str,
    /// Its index in the entries.
    index: usize,
    /// Its default, if it has one.
    default: Option<bool>,
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
#[serde(default, deny_unknown_fields)]
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
        let mut entries = PairEntries::default();
        let indices: Vec<usize> = names.iter().map(|name| entries.add(name)).collect();
        for ((a, &index_a), row) in names.iter().zip(&indices).zip(&given.entry_values) {
            if row.len() != names.len() {
                return Err(MatrixError::Columns { row: a.clone(), columns: row.len(), names: names.len() });
            }
            for ((b, &index_b), &allowed) in names.iter().zip(&indices).zip(row) {
                if entries.get(index_a, index_b).is_some_and(|earlier| earlier != allowed) {
                    return Err(MatrixError::Asymmetric { a: a.clone(), b: b.clone() });
                }
                entries.set(index_a, index_b, allowed);
            }
        }
        let mut defaults = HashMap::new();
        for (name, &allowed) in given.default_entry_names.iter().zip(&given.default_entry_values) {
            if defaults.insert(name.clone(), allowed).is_some_and(|earlier| earlier != allowed) {
                return Err(MatrixError::Contradiction(name.clone()));
            }
        }
        Ok(Self { entries: Arc::new(entries), defaults: Arc::new(defaults) })
    }

    /// Sets whether `a` and `b` may touch.
    pub fn set(&mut self, a: &str, b: &str, allowed: bool) {
        let entries = Arc::make_mut(&mut self.entries);
        let [a, b] = [a, b].map(|name| entries.add(name));
        entries.set(a, b, allowed);
    }

    /// Sets the default of `name`: whether it may touch everything that it has no entry with, now and later.
    pub fn set_default(&mut self, name: &str, allowed: bool) {
        Arc::make_mut(&mut self.defaults).insert(name.to_owned(), allowed);
    }

    /// Removes all entries of some names, in one pass. Their defaults stay, as in `MoveIt`.
    pub fn forget(&mut self, names: &HashSet<&str>) {
        if names.iter().any(|name| self.has_entries(name)) {
            self.entries = Arc::new(self.entries.without(names));
        }
    }

    /// The equivalent matrix of a planning scene; names are sorted.
    #[must_use]
    pub fn to_entries(&self) -> MatrixEntries {
        let named = self.entries.names().enumerate().map(|(index, name)| NameInMatrix {
            name,
            index,
            default: self.defaults.get(name).copied(),
        });
        let mut names: Vec<NameInMatrix> = named.collect();
        names.sort_unstable_by_key(|named| named.name);
        let value = |a: &NameInMatrix, b: &NameInMatrix| {
            let entry = self.entries.get(a.index, b.index);
            entry.unwrap_or_else(|| allows_by_defaults(a.default, b.default))
        };
        let row = |a: &NameInMatrix| names.iter().map(|b| value(a, b)).collect();
        let defaults: BTreeMap<_, _> = self.defaults.iter().collect();
        MatrixEntries {
            entry_values: names.iter().map(row).collect(),
            entry_names: names.iter().map(|named| named.name.to_owned()).collect(),
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
        self.entries.get(self.entries.index(a)?, self.entries.index(b)?)
    }

    /// All names that have entries or defaults; a name may occur twice.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.entries.names().chain(self.defaults.keys().map(String::as_str))
    }

    /// True if a name has an entry or a default.
    #[must_use]
    pub fn mentions(&self, name: &str) -> bool {
        self.defaults.contains_key(name) || self.has_entries(name)
    }

    /// True if a name has an entry with any name, whatever its default.
    #[must_use]
    pub fn has_entries(&self, name: &str) -> bool {
        self.entries.index(name).is_some()
    }

    /// The default of a name: whether it may touch names without an entry.
    #[must_use]
    pub fn allows_by_default(&self, name: &str) -> bool {
        self.defaults.get(name).copied().unwrap_or(false)
    }

    /// True if `a` and `b` may touch; false without an entry or default. If both names have defaults, both must allow it.
    #[must_use]
    pub fn allows(&self, a: &str, b: &str) -> bool {
        let default = |name: &str| self.defaults.get(name).copied();
        self.entry(a, b).unwrap_or_else(|| allows_by_defaults(default(a), default(b)))
    }
}

/// True if the defaults of two names allow contact: both must, if both exist.
fn allows_by_defaults(a: Option<bool>, b: Option<bool>) -> bool {
    match (a, b) {
        (Some(a), Some(b)) => a && b,
        (Some(one), None) | (None, Some(one)) => one,
        (None, None) => false,
    }
}

/// Rows as `[true, false]` or as `moveit_msgs/AllowedCollisionEntry` with the field `enabled`.
fn rows<'de, D: serde::Deserializer<'de>>(deserializer: D) -> Result<Vec<Vec<bool>>, D::Error> {
    #[derive(Deserialize)]
    #[serde(
        untagged,
        deny_unknown_fields,
        expecting = "a row must be a list of true and false, or have such a list as enabled, and nothing else"
    )]
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
