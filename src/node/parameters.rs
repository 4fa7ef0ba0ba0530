//! The parameters of the node: what each means, which values it takes, and the values in force.

use std::sync::LazyLock;

use super::parameter_value::Value;
use crate::monitor::MonitorSettings;

/// All parameters in force. One value of this is one consistent choice: it changes as a whole.
#[derive(Clone, Debug, PartialEq)]
pub struct Parameters {
    pub heartbeat_rate: f64,
    pub stale_after: f64,
    pub influence_distance: f64,
    pub distance_limit: f64,
    pub look_ahead_horizon: f64,
    pub look_ahead_acceleration: f64,
    pub padding: f64,
    pub pad_self: bool,
    pub publish_markers: bool,
    pub marker_rate: f64,
    pub use_sim_time: bool,
}

impl Default for Parameters {
    fn default() -> Self {
        let monitor = MonitorSettings::default();
        Self {
            heartbeat_rate: monitor.heartbeat_rate,
            stale_after: monitor.stale_after,
            influence_distance: monitor.influence_distance,
            distance_limit: monitor.distance_limit,
            look_ahead_horizon: monitor.look_ahead_horizon,
            look_ahead_acceleration: monitor.look_ahead_acceleration,
            padding: 0.0,
            pad_self: false,
            publish_markers: true,
            marker_rate: 20.0,
            use_sim_time: false,
        }
    }
}

impl Parameters {
    #[must_use]
    pub fn monitor_settings(&self) -> MonitorSettings {
        MonitorSettings {
            heartbeat_rate: self.heartbeat_rate,
            stale_after: self.stale_after,
            influence_distance: self.influence_distance,
            distance_limit: self.distance_limit,
            look_ahead_horizon: self.look_ahead_horizon,
            look_ahead_acceleration: self.look_ahead_acceleration,
        }
    }

    /// Sets one parameter, or says why not.
    pub fn set(&mut self, name: &str, value: &Value) -> Result<(), String> {
        let declaration = declaration(name).ok_or_else(|| format!("this node has no parameter '{name}'"))?;
        declaration.set(self, value)
    }
}

/// A parameter as it is described to its users.
pub struct Declaration {
    pub name: &'static str,
    pub unit: &'static str,
    pub description: &'static str,
    pub range: Range,
    access: Access,
}

/// Values that a parameter takes; both ends belong to it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Range {
    Bool,
    Double { from: f64, to: f64 },
}

/// Where in [`Parameters`] the value is.
#[derive(Clone, Copy)]
enum Access {
    Bool(fn(&mut Parameters) -> &mut bool),
    Double(fn(&mut Parameters) -> &mut f64),
}

impl Declaration {
    /// The value in force.
    #[must_use]
    pub fn get(&self, parameters: &Parameters) -> Value {
        // one accessor serves reading and writing; a copy of eleven numbers costs nothing
        let mut parameters = parameters.clone();
        match self.access {
            Access::Bool(field) => Value::Bool(*field(&mut parameters)),
            Access::Double(field) => Value::Double(*field(&mut parameters)),
        }
    }

    fn set(&self, parameters: &mut Parameters, value: &Value) -> Result<(), String> {
        match (self.access, self.range) {
            (Access::Bool(field), _) => {
                let Value::Bool(value) = value else {
                    return Err(format!("{} is a bool, but {} was given", self.name, value.kind()));
                };
                *field(parameters) = *value;
            }
            (Access::Double(field), range) => {
                let number = match value {
                    Value::Double(number) => *number,
                    #[expect(clippy::cast_precision_loss, reason = "the range is far below 2^52")]
                    Value::Integer(number) => *number as f64,
                    _ => {
                        return Err(format!("{} is a double, but {} was given", self.name, value.kind()));
                    }
                };
                if let Range::Double { from, to } = range
                    && !(from..=to).contains(&number)
                {
                    let unit = self.unit;
                    return Err(format!(
                        "{} must be from {from} to {to} {unit}, but {number} was given",
                        self.name
                    ));
                }
                *field(parameters) = number;
            }
        }
        Ok(())
    }
}

/// The parameter called `name`.
#[must_use]
pub fn declaration(name: &str) -> Option<&'static Declaration> {
    DECLARATIONS.iter().find(|d| d.name == name)
}

/// Every parameter, by name. `config/clearance.yaml` says the same with more words; a test compares them.
pub static DECLARATIONS: LazyLock<Vec<Declaration>> = LazyLock::new(|| {
    vec![
        double(
            "distance_limit",
            "m",
            (0.0, 100.0),
            |p| &mut p.distance_limit,
            "Distance beyond which the least distance is not looked for; it is then reported as infinite.",
        ),
        double(
            "heartbeat_rate",
            "Hz",
            (0.1, 1000.0),
            |p| &mut p.heartbeat_rate,
            "How often the state is published at least, also when no joint state arrives.",
        ),
        double(
            "influence_distance",
            "m",
            (0.0, 10.0),
            |p| &mut p.influence_distance,
            "Distance up to which every pair is reported with its distance and nearest points.",
        ),
        double(
            "look_ahead_acceleration",
            "rad/s2",
            (0.0, 10000.0),
            |p| &mut p.look_ahead_acceleration,
            "Acceleration (m/s2 of sliding joints) that joints without a limit of their own are thought capable of.",
        ),
        double(
            "look_ahead_horizon",
            "s",
            (0.0, 10.0),
            |p| &mut p.look_ahead_horizon,
            "How far ahead contacts are looked for from the joint velocities; 0 turns it off.",
        ),
        double(
            "marker_rate",
            "Hz",
            (0.1, 1000.0),
            |p| &mut p.marker_rate,
            "How often markers are published at most; a change of status publishes them at once.",
        ),
        boolean(
            "pad_self",
            |p| &mut p.pad_self,
            "Whether padding counts between links of the robot too, or against the world only.",
        ),
        double(
            "padding",
            "m",
            (0.0, 1.0),
            |p| &mut p.padding,
            "Safety distance by which every link counts as larger.",
        ),
        boolean("publish_markers", |p| &mut p.publish_markers, "Whether markers are published for RViz."),
        double(
            "stale_after",
            "s",
            (0.001, 3600.0),
            |p| &mut p.stale_after,
            "Age of a joint state beyond which it says nothing about the robot any more.",
        ),
        boolean(
            "use_sim_time",
            |p| &mut p.use_sim_time,
            "Whether time is read from /clock instead of the system's clock.",
        ),
    ]
});

fn double(
    name: &'static str,
    unit: &'static str,
    (from, to): (f64, f64),
    field: fn(&mut Parameters) -> &mut f64,
    description: &'static str,
) -> Declaration {
    Declaration { name, unit, description, range: Range::Double { from, to }, access: Access::Double(field) }
}

fn boolean(
    name: &'static str,
    field: fn(&mut Parameters) -> &mut bool,
    description: &'static str,
) -> Declaration {
    Declaration { name, unit: "", description, range: Range::Bool, access: Access::Bool(field) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::node::parameter_value;

    const MANUAL: &str = include_str!("../../config/clearance.yaml");

    /// The comment right above a parameter of the manual.
    fn comment_above(name: &str) -> String {
        let lines: Vec<&str> = MANUAL.lines().map(str::trim).collect();
        let line = lines.iter().position(|line| line.starts_with(&format!("{name}:"))).unwrap();
        let above = lines[..line].iter().rposition(|line| !line.starts_with('#')).unwrap();
        lines[above + 1..line].iter().map(|line| line.trim_start_matches('#')).collect()
    }

    #[test]
    fn the_manual_holds_every_parameter_with_its_default_unit_and_range() {
        let manual: serde_json::Value = serde_saphyr::from_str(MANUAL).unwrap();
        let values = manual["/**"]["ros__parameters"].as_object().unwrap();
        let defaults = Parameters::default();
        for declaration in DECLARATIONS.iter() {
            let name = declaration.name;
            assert_eq!(parameter_value::from_node(&values[name]), declaration.get(&defaults), "{name}");
            let begins = match declaration.range {
                Range::Bool => " true or false.".to_owned(),
                Range::Double { from, to } => format!(" {}, {from} to {to}.", declaration.unit),
            };
            let comment = comment_above(name);
            assert!(comment.starts_with(&begins), "{name} should begin with '{begins}': {comment}");
        }
        assert_eq!(values.len(), DECLARATIONS.len());
    }

    #[test]
    fn a_refused_value_is_named_with_its_reason_and_changes_nothing() {
        for (name, value, reason) in [
            ("padding", Value::Double(-0.1), "from 0 to 1 m, but -0.1"),
            ("padding", Value::Double(f64::NAN), "NaN"),
            ("heartbeat_rate", Value::Integer(0), "from 0.1 to 1000 Hz, but 0"),
            ("stale_after", Value::Text("long".into()), "a string"),
            ("publish_markers", Value::Integer(1), "an integer"),
            ("padding", Value::Other("an array"), "an array"),
            ("speed", Value::Bool(true), "'speed'"),
        ] {
            let mut parameters = Parameters::default();
            let error = parameters.set(name, &value).unwrap_err();
            assert!(error.contains(name) && error.contains(reason), "{error}");
            assert_eq!(parameters, Parameters::default());
        }
        let mut parameters = Parameters::default();
        parameters.set("heartbeat_rate", &Value::Integer(20)).unwrap();
        assert_eq!(declaration("heartbeat_rate").unwrap().get(&parameters), Value::Double(20.0));
    }
}
