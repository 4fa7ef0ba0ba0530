//! The parameters of the node: what each means, which values it takes, and the values in force.

use std::sync::LazyLock;

use super::parameter_value::Value;
use super::recording::RecordingSettings;
use crate::monitor::{MonitorSettings, SpeedDistances, SpeedSettings};

/// All parameters in force. One value of this is one consistent choice: it changes as a whole.
#[derive(Clone, Debug, PartialEq)]
pub struct Parameters {
    pub heartbeat_rate: f64,
    pub stale_after: f64,
    pub check_deadline: f64,
    pub influence_distance: f64,
    pub distance_limit: f64,
    pub slowdown_distance_self: f64,
    pub slowdown_distance_world: f64,
    pub stop_distance_self: f64,
    pub stop_distance_world: f64,
    pub slowdown_reaction_time: f64,
    pub slowdown_trigger_count: i64,
    pub slowdown_release_count: i64,
    pub look_ahead_horizon: f64,
    pub look_ahead_acceleration: f64,
    pub joint_prefix: String,
    pub link_prefix: String,
    pub padding: f64,
    pub pad_self: bool,
    pub publish_markers: bool,
    pub marker_rate: f64,
    pub link_volume_level: i64,
    pub point_cloud_topics: Vec<String>,
    pub point_radius: f64,
    pub point_cloud_ttl: f64,
    pub stale_source_policy: &'static str,
    pub self_filter_padding: f64,
    pub cloud_voxel_size: f64,
    pub cloud_crop_min: Vec<f64>,
    pub cloud_crop_max: Vec<f64>,
    pub octomap_ttl: f64,
    pub unknown_space: &'static str,
    pub transform_ttl: f64,
    pub transform_joints: Vec<String>,
    pub record_file: String,
    pub record_max_size: f64,
    pub record_max_duration: f64,
    pub use_sim_time: bool,
}

const STALE_SOURCE_POLICIES: &[&str] = &["unknown", "drop"];
const UNKNOWN_SPACES: &[&str] = &["free", "occupied"];

impl Default for Parameters {
    fn default() -> Self {
        let monitor = MonitorSettings::default();
        Self {
            heartbeat_rate: monitor.heartbeat_rate,
            stale_after: monitor.stale_after,
            check_deadline: monitor.check_deadline,
            influence_distance: monitor.influence_distance,
            distance_limit: monitor.distance_limit,
            slowdown_distance_self: monitor.speed.own.slowdown,
            slowdown_distance_world: monitor.speed.world.slowdown,
            stop_distance_self: monitor.speed.own.stop,
            stop_distance_world: monitor.speed.world.stop,
            slowdown_reaction_time: monitor.speed.reaction_time,
            slowdown_trigger_count: monitor.speed.trigger_count.into(),
            slowdown_release_count: monitor.speed.release_count.into(),
            look_ahead_horizon: monitor.look_ahead_horizon,
            look_ahead_acceleration: monitor.look_ahead_acceleration,
            joint_prefix: monitor.joint_prefix,
            link_prefix: String::new(),
            padding: 0.0,
            pad_self: false,
            publish_markers: true,
            marker_rate: 20.0,
            link_volume_level: -1,
            point_cloud_topics: Vec::new(),
            point_radius: 0.01,
            point_cloud_ttl: 1.0,
            stale_source_policy: STALE_SOURCE_POLICIES[0],
            self_filter_padding: 0.0,
            cloud_voxel_size: 0.0,
            cloud_crop_min: Vec::new(),
            cloud_crop_max: Vec::new(),
            octomap_ttl: 0.0,
            unknown_space: UNKNOWN_SPACES[0],
            transform_ttl: monitor.transform_ttl,
            transform_joints: monitor.transform_joints,
            record_file: String::new(),
            record_max_size: 4000.0,
            record_max_duration: 0.0,
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
            check_deadline: self.check_deadline,
            joint_prefix: self.joint_prefix.clone(),
            transform_joints: self.transform_joints.clone(),
            transform_ttl: self.transform_ttl,
            influence_distance: self.influence_distance,
            distance_limit: self.distance_limit,
            speed: self.speed_settings(),
            look_ahead_horizon: self.look_ahead_horizon,
            look_ahead_acceleration: self.look_ahead_acceleration,
        }
    }

    fn speed_settings(&self) -> SpeedSettings {
        // their ranges are far inside
        let count = |number: i64| u32::try_from(number).unwrap_or(u32::MAX);
        SpeedSettings {
            own: SpeedDistances { slowdown: self.slowdown_distance_self, stop: self.stop_distance_self },
            world: SpeedDistances { slowdown: self.slowdown_distance_world, stop: self.stop_distance_world },
            reaction_time: self.slowdown_reaction_time,
            trigger_count: count(self.slowdown_trigger_count),
            release_count: count(self.slowdown_release_count),
        }
    }

    /// Whether what has gone stale is dropped, instead of making the state unknown.
    #[must_use]
    pub fn drops_stale_sources(&self) -> bool {
        self.stale_source_policy == STALE_SOURCE_POLICIES[1]
    }

    /// How many steps below their roots hierarchies are shown, if they are.
    #[must_use]
    pub fn shown_level(&self) -> Option<usize> {
        usize::try_from(self.link_volume_level).ok()
    }

    /// Whether what an octomap does not know counts as occupied.
    #[must_use]
    pub fn unknown_is_occupied(&self) -> bool {
        self.unknown_space == UNKNOWN_SPACES[1]
    }

    /// What is recorded, if anything is.
    #[must_use]
    pub fn recording(&self) -> Option<RecordingSettings> {
        (!self.record_file.is_empty()).then(|| RecordingSettings {
            file: self.record_file.clone().into(),
            max_size: self.record_max_size,
            max_duration: self.record_max_duration,
        })
    }

    /// Sets one parameter of a node that runs, or says why not.
    pub fn set_live(&mut self, name: &str, value: &Value) -> Result<(), String> {
        let mut changed = self.clone();
        changed.set(name, value)?;
        if declaration(name).is_some_and(|d| d.is_fixed() && d.get(&changed) != d.get(self)) {
            return Err(format!("{name} counts at the start only: give it to a new node"));
        }
        *self = changed;
        Ok(())
    }

    /// Sets one parameter, or says why not.
    pub fn set(&mut self, name: &str, value: &Value) -> Result<(), String> {
        let declaration = declaration(name).ok_or_else(|| format!("this node has no parameter '{name}'"))?;
        let mut changed = self.clone();
        declaration.set(&mut changed, value)?;
        // a box that holds nothing would make every cloud empty
        let below = |(min, max): (&f64, &f64)| min < max;
        if !changed.cloud_crop_min.iter().zip(&changed.cloud_crop_max).all(below) {
            return Err(format!(
                "{name}: every number of cloud_crop_min must be below that of cloud_crop_max"
            ));
        }
        *self = changed;
        Ok(())
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
    Double {
        from: f64,
        to: f64,
    },
    Integer {
        from: i64,
        to: i64,
    },
    /// One of these words.
    Word(&'static [&'static str]),
    Text,
    /// What names begin with.
    Prefix,
    /// A list of names, of what is said here.
    Names(&'static str),
    /// A point, or nothing.
    Point,
}

/// Where in [`Parameters`] the value is.
#[derive(Clone, Copy)]
enum Access {
    Bool(fn(&mut Parameters) -> &mut bool),
    Double(fn(&mut Parameters) -> &mut f64),
    Integer(fn(&mut Parameters) -> &mut i64),
    Word(fn(&mut Parameters) -> &mut &'static str),
    Text(fn(&mut Parameters) -> &mut String),
    Texts(fn(&mut Parameters) -> &mut Vec<String>),
    Point(fn(&mut Parameters) -> &mut Vec<f64>),
}

impl Declaration {
    fn in_unit(self, unit: &'static str) -> Self {
        Self { unit, ..self }
    }

    /// Whether it counts at the start only.
    #[must_use]
    pub fn is_fixed(&self) -> bool {
        self.name.starts_with("record_")
    }

    /// The value in force.
    #[must_use]
    pub fn get(&self, parameters: &Parameters) -> Value {
        // one accessor serves reading and writing; a copy of them costs little
        let mut parameters = parameters.clone();
        match self.access {
            Access::Bool(field) => Value::Bool(*field(&mut parameters)),
            Access::Double(field) => Value::Double(*field(&mut parameters)),
            Access::Integer(field) => Value::Integer(*field(&mut parameters)),
            Access::Word(field) => Value::Text((*field(&mut parameters)).to_owned()),
            Access::Text(field) => Value::Text(field(&mut parameters).clone()),
            Access::Texts(field) => Value::Texts(field(&mut parameters).clone()),
            Access::Point(field) => Value::Doubles(field(&mut parameters).clone()),
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
            (Access::Integer(field), _) => *field(parameters) = self.integer(value)?,
            (Access::Word(field), _) => *field(parameters) = self.word(value)?,
            (Access::Text(field), _) => *field(parameters) = self.text(value)?,
            (Access::Texts(field), _) => *field(parameters) = self.texts(value)?,
            (Access::Point(field), _) => *field(parameters) = self.point(value)?,
        }
        Ok(())
    }

    fn integer(&self, value: &Value) -> Result<i64, String> {
        let Range::Integer { from, to } = self.range else {
            return Err(format!("{} is no integer", self.name));
        };
        match value {
            Value::Integer(number) if (from..=to).contains(number) => Ok(*number),
            Value::Integer(number) => {
                Err(format!("{} must be from {from} to {to}, but {number} was given", self.name))
            }
            other => Err(format!("{} is an integer, but {} was given", self.name, other.kind())),
        }
    }

    fn word(&self, value: &Value) -> Result<&'static str, String> {
        let Range::Word(words) = self.range else { return Err(format!("{} is no word", self.name)) };
        let Value::Text(text) = value else {
            return Err(format!("{} is a string, but {} was given", self.name, value.kind()));
        };
        let known = words.iter().find(|word| *word == text);
        known
            .copied()
            .ok_or_else(|| format!("{} is {}, but '{text}' was given", self.name, words.join(" or ")))
    }

    fn text(&self, value: &Value) -> Result<String, String> {
        const LONGEST: usize = 100;
        let Value::Text(text) = value else {
            return Err(format!("{} is a string, but {} was given", self.name, value.kind()));
        };
        let usable = |c: char| c.is_ascii_alphanumeric() || "_-./".contains(c);
        if self.range == Range::Prefix && (text.len() > LONGEST || !text.chars().all(usable)) {
            return Err(format!("{} is up to {LONGEST} letters, digits and _ - . /", self.name));
        }
        Ok(text.clone())
    }

    fn texts(&self, value: &Value) -> Result<Vec<String>, String> {
        let texts = match value {
            Value::Texts(texts) => texts.clone(),
            Value::EmptyList => Vec::new(),
            other => {
                return Err(format!("{} is a list of strings, but {} was given", self.name, other.kind()));
            }
        };
        match texts.iter().enumerate().find(|(i, text)| text.is_empty() || texts[..*i].contains(text)) {
            Some((_, text)) => Err(format!("{}: '{text}' is empty or given twice", self.name)),
            None => Ok(texts),
        }
    }

    fn point(&self, value: &Value) -> Result<Vec<f64>, String> {
        let numbers = match value {
            Value::Doubles(numbers) => numbers.clone(),
            Value::EmptyList => Vec::new(),
            // an empty list on the command line of ros2 param is one of strings
            Value::Texts(texts) if texts.is_empty() => Vec::new(),
            other => {
                return Err(format!("{} is a list of numbers, but {} was given", self.name, other.kind()));
            }
        };
        let usable = (numbers.is_empty() || numbers.len() == 3) && numbers.iter().all(|n| n.is_finite());
        usable.then_some(numbers).ok_or_else(|| format!("{} is three finite numbers, or none", self.name))
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
            "check_deadline",
            "s",
            (0.0, 10.0),
            |p| &mut p.check_deadline,
            "Time that one answer may take, beyond which undecided pairs make the state unknown; 0 means as long as it takes.",
        ),
        Declaration {
            range: Range::Point,
            access: Access::Point(|p| &mut p.cloud_crop_max),
            ..described("cloud_crop_max", "m", "Points of clouds beyond this corner are left out.")
        },
        Declaration {
            range: Range::Point,
            access: Access::Point(|p| &mut p.cloud_crop_min),
            ..described("cloud_crop_min", "m", "Points of clouds before this corner are left out.")
        },
        double(
            "cloud_voxel_size",
            "m",
            (0.0, 1.0),
            |p| &mut p.cloud_voxel_size,
            "Edge of the cubes to which clouds are thinned out; 0 turns it off.",
        ),
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
        Declaration {
            range: Range::Prefix,
            access: Access::Text(|p| &mut p.joint_prefix),
            ..described(
                "joint_prefix",
                "",
                "What the names of this robot's joints begin with, before those of its URDF.",
            )
        },
        Declaration {
            range: Range::Prefix,
            access: Access::Text(|p| &mut p.link_prefix),
            ..described(
                "link_prefix",
                "",
                "What the names of this robot's links begin with, before those of its URDF.",
            )
        },
        integer(
            "link_volume_level",
            (-1, 20),
            |p| &mut p.link_volume_level,
            "Level of the hierarchies of which ~/link_volumes shows the boxes; -1 shows none.",
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
        double(
            "octomap_ttl",
            "s",
            (0.0, 86400.0),
            |p| &mut p.octomap_ttl,
            "Age of an octomap beyond which it says nothing about the world any more; 0 means never.",
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
        double(
            "point_cloud_ttl",
            "s",
            (0.01, 86400.0),
            |p| &mut p.point_cloud_ttl,
            "Age of a point cloud beyond which it says nothing about the world any more.",
        ),
        Declaration {
            range: Range::Names("topics"),
            access: Access::Texts(|p| &mut p.point_cloud_topics),
            ..described("point_cloud_topics", "", "Topics of point clouds that have to be avoided.")
        },
        double(
            "point_radius",
            "m",
            (0.0, 1.0),
            |p| &mut p.point_radius,
            "Radius of the balls that the points of clouds are.",
        ),
        boolean("publish_markers", |p| &mut p.publish_markers, "Whether markers are published for RViz."),
        Declaration {
            range: Range::Text,
            access: Access::Text(|p| &mut p.record_file),
            ..described(
                "record_file",
                "",
                "The MCAP file to which inputs and answers are recorded; none if empty.",
            )
        },
        double(
            "record_max_duration",
            "s",
            (0.0, 1e9),
            |p| &mut p.record_max_duration,
            "Time after which a recording ends; 0 means never.",
        ),
        double(
            "record_max_size",
            "MB",
            (0.0, 1e9),
            |p| &mut p.record_max_size,
            "Size at which a recording ends; 0 means never.",
        ),
        double(
            "self_filter_padding",
            "m",
            (0.0, 1.0),
            |p| &mut p.self_filter_padding,
            "Points of clouds nearer than this to the robot, or to what it holds, are taken for the robot.",
        ),
        double(
            "slowdown_distance_self",
            "m",
            (0.0, 10.0),
            |p| &mut p.slowdown_distance_self,
            "Distance between links below which ~/speed_scale is less than 1; 0 means only when they touch.",
        ),
        double(
            "slowdown_distance_world",
            "m",
            (0.0, 10.0),
            |p| &mut p.slowdown_distance_world,
            "Distance to an obstacle below which ~/speed_scale is less than 1; 0 means only when it is touched.",
        ),
        double(
            "slowdown_reaction_time",
            "s",
            (0.0, 10.0),
            |p| &mut p.slowdown_reaction_time,
            "Time that the robot needs to slow down: what approaches counts as nearer by its way in this time.",
        ),
        integer(
            "slowdown_release_count",
            (1, 1000),
            |p| &mut p.slowdown_release_count,
            "States in a row that have to ask for more speed before ~/speed_scale rises.",
        ),
        integer(
            "slowdown_trigger_count",
            (1, 1000),
            |p| &mut p.slowdown_trigger_count,
            "States in a row that have to ask for less speed before ~/speed_scale falls.",
        ),
        double(
            "stale_after",
            "s",
            (0.001, 3600.0),
            |p| &mut p.stale_after,
            "Age of a joint state beyond which it says nothing about the robot any more.",
        ),
        Declaration {
            range: Range::Word(STALE_SOURCE_POLICIES),
            access: Access::Word(|p| &mut p.stale_source_policy),
            ..described(
                "stale_source_policy",
                "",
                "What becomes of a cloud or octomap that has grown too old.",
            )
        },
        Declaration {
            range: Range::Names("joints"),
            access: Access::Texts(|p| &mut p.transform_joints),
            ..described(
                "transform_joints",
                "",
                "Planar and floating joints whose positions tf tells, instead of joint states.",
            )
        },
        double(
            "stop_distance_self",
            "m",
            (0.0, 10.0),
            |p| &mut p.stop_distance_self,
            "Distance between links up to which ~/speed_scale is 0.",
        ),
        double(
            "stop_distance_world",
            "m",
            (0.0, 10.0),
            |p| &mut p.stop_distance_world,
            "Distance to an obstacle up to which ~/speed_scale is 0.",
        ),
        double(
            "transform_ttl",
            "s",
            (0.001, 3600.0),
            |p| &mut p.transform_ttl,
            "Age of a transform on tf beyond which it says nothing any more.",
        ),
        Declaration {
            range: Range::Word(UNKNOWN_SPACES),
            access: Access::Word(|p| &mut p.unknown_space),
            ..described("unknown_space", "", "What the space that an octomap does not know counts as.")
        },
        boolean(
            "use_sim_time",
            |p| &mut p.use_sim_time,
            "Whether time is read from /clock instead of the system's clock.",
        ),
    ]
});

/// Name, unit and meaning alone.
fn described(name: &'static str, unit: &'static str, description: &'static str) -> Declaration {
    boolean(name, |p| &mut p.use_sim_time, description).in_unit(unit)
}

fn double(
    name: &'static str,
    unit: &'static str,
    (from, to): (f64, f64),
    field: fn(&mut Parameters) -> &mut f64,
    description: &'static str,
) -> Declaration {
    Declaration { name, unit, description, range: Range::Double { from, to }, access: Access::Double(field) }
}

fn integer(
    name: &'static str,
    (from, to): (i64, i64),
    field: fn(&mut Parameters) -> &mut i64,
    description: &'static str,
) -> Declaration {
    Declaration {
        name,
        unit: "",
        description,
        range: Range::Integer { from, to },
        access: Access::Integer(field),
    }
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

    /// Parameters of which every one differs from its default where a list can.
    fn declaration_test_start(name: &str) -> Parameters {
        let mut parameters = Parameters::default();
        match name {
            "point_cloud_topics" => parameters.point_cloud_topics = vec!["/clouds".to_owned()],
            "transform_joints" => parameters.transform_joints = vec!["base".to_owned()],
            _ => {}
        }
        parameters
    }

    #[test]
    fn the_manual_holds_every_parameter_with_its_default_unit_and_range() {
        let manual: serde_json::Value = serde_saphyr::from_str(MANUAL).unwrap();
        let values = manual["/**"]["ros__parameters"].as_object().unwrap();
        let defaults = Parameters::default();
        for declaration in DECLARATIONS.iter() {
            let name = declaration.name;
            let mut as_written = declaration_test_start(name);
            as_written.set(name, &parameter_value::from_node(&values[name])).unwrap();
            assert_eq!(declaration.get(&as_written), declaration.get(&defaults), "{name}");
            let begins = match declaration.range {
                Range::Bool => " true or false.".to_owned(),
                Range::Double { from, to } => format!(" {}, {from} to {to}.", declaration.unit),
                Range::Integer { from, to } => format!(" A whole number, {from} to {to}."),
                Range::Word(words) => format!(" {}.", words.join(" or ")),
                Range::Text => " A file.".to_owned(),
                Range::Prefix => " A text.".to_owned(),
                Range::Names(what) => format!(" A list of {what}."),
                Range::Point => format!(" {}, three numbers or none.", declaration.unit),
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
            ("slowdown_trigger_count", Value::Integer(0), "from 1 to 1000, but 0"),
            ("slowdown_trigger_count", Value::Integer(-1), "from 1 to 1000, but -1"),
            ("slowdown_trigger_count", Value::Double(2.0), "is an integer, but a double"),
            ("joint_prefix", Value::Text("a b".into()), "letters, digits"),
            ("link_prefix", Value::Integer(1), "is a string, but an integer"),
            ("speed", Value::Bool(true), "'speed'"),
            ("link_volume_level", Value::Integer(21), "from -1 to 20, but 21"),
            ("link_volume_level", Value::Double(1.0), "a double"),
            ("unknown_space", Value::Text("full".into()), "free or occupied, but 'full'"),
            ("unknown_space", Value::Bool(true), "a bool"),
            ("point_cloud_topics", Value::Text("/a".into()), "a list of strings, but a string"),
            ("point_cloud_topics", Value::Texts(vec!["/a".into(), "/a".into()]), "twice"),
            ("cloud_crop_min", Value::Doubles(vec![0.0; 2]), "three finite numbers"),
            ("cloud_crop_min", Value::Doubles(vec![0.0, f64::NAN, 0.0]), "three finite numbers"),
        ] {
            let mut parameters = Parameters::default();
            let error = parameters.set(name, &value).unwrap_err();
            assert!(error.contains(name) && error.contains(reason), "{error}");
            assert_eq!(parameters, Parameters::default());
        }
        let mut parameters = Parameters::default();
        parameters.set("cloud_crop_min", &Value::Doubles(vec![0.0; 3])).unwrap();
        let error = parameters.set("cloud_crop_max", &Value::Doubles(vec![1.0, 0.0, 1.0])).unwrap_err();
        assert!(error.contains("must be below"), "{error}");
        parameters.set("cloud_crop_max", &Value::EmptyList).unwrap();
        parameters.set("heartbeat_rate", &Value::Integer(20)).unwrap();
        assert_eq!(declaration("heartbeat_rate").unwrap().get(&parameters), Value::Double(20.0));
    }
}
