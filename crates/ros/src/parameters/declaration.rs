//! Declaration of one parameter: its name, unit, meaning and range.

use clearance_scene::VolumeSelection;
use std::collections::BTreeSet;

use crate::names::fault_of_topic;
use crate::parameters::obstacle_limit::{obstacle_limit, obstacle_speed};
use crate::parameters::parameter_set::Parameters;
use crate::parameters::parameter_value::Value;

/// Kind of the names in a list of topics.
pub(super) const TOPICS: &str = "topics";

/// Maximum number of topics in one list: each topic needs a subscription.
const MOST_TOPICS: usize = 32;

/// Description of a parameter, as users see it.
pub struct Declaration {
    pub name: &'static str,
    pub unit: &'static str,
    pub description: &'static str,
    pub range: Range,
    pub(super) access: Access,
}

/// Range of valid values, including both ends.
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
    /// Name of a service, or empty.
    Service,
    /// Prefix of names.
    Prefix,
    /// Kinds of bounding volumes: `KIND`, `LINK=KIND`, or both, separated by commas.
    Volumes,
    /// List of names; the text says what they are names of.
    Names(&'static str),
    /// List of limits of obstacles, `NAME SPEED ACCELERATION`.
    ObstacleLimits,
    /// List of speeds of obstacles, `NAME SPEED`.
    ObstacleSpeeds,
    /// Point, or empty.
    Point,
}

/// Access to the field of [`Parameters`] that stores the value.
#[derive(Clone, Copy)]
pub(super) enum Access {
    Bool(fn(&mut Parameters) -> &mut bool),
    Double(fn(&mut Parameters) -> &mut f64),
    Integer(fn(&mut Parameters) -> &mut i64),
    Word(fn(&mut Parameters) -> &mut &'static str),
    Text(fn(&mut Parameters) -> &mut String),
    Texts(fn(&mut Parameters) -> &mut Vec<String>),
    Point(fn(&mut Parameters) -> &mut Vec<f64>),
}

impl Declaration {
    pub(super) fn in_unit(self, unit: &'static str) -> Self {
        Self { unit, ..self }
    }

    /// Whether the value can only be set at the start.
    #[must_use]
    pub fn is_fixed(&self) -> bool {
        self.name.starts_with("record_") || self.name == "use_realtime_priority"
    }

    /// Current value.
    #[must_use]
    pub fn get(&self, parameters: &Parameters) -> Value {
        // the same accessor is used to read and to write; a copy of the parameters is cheap
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

    pub(super) fn set(&self, parameters: &mut Parameters, value: &Value) -> Result<(), String> {
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
        if let Some(why) = fault_of_topic(text).filter(|_| self.range == Range::Service && !text.is_empty()) {
            return Err(format!("{}: '{}' is no name of a service: {why}", self.name, text.escape_debug()));
        }
        if self.range == Range::Volumes {
            let checked = text.parse::<VolumeSelection>();
            return checked.map(|volumes| volumes.to_string()).map_err(|why| format!("{}: {why}", self.name));
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
        if self.range == Range::Names(TOPICS) {
            if texts.len() > MOST_TOPICS {
                return Err(format!(
                    "{} has {} topics, but at most {MOST_TOPICS} are watched",
                    self.name,
                    texts.len()
                ));
            }
            if let Some((topic, why)) = texts.iter().find_map(|topic| Some((topic, fault_of_topic(topic)?))) {
                return Err(format!(
                    "{}: '{}' is no name of a topic: {why}",
                    self.name,
                    topic.escape_debug()
                ));
            }
        }
        match self.range {
            Range::ObstacleLimits => {
                self.check_obstacles(&texts, "limits", |text| Ok(obstacle_limit(text)?.0))?;
            }
            Range::ObstacleSpeeds => {
                self.check_obstacles(&texts, "speeds", |text| Ok(obstacle_speed(text)?.0))?;
            }
            _ => {}
        }
        match texts.iter().enumerate().find(|(i, text)| text.is_empty() || texts[..*i].contains(text)) {
            Some((_, text)) => Err(format!("{}: '{text}' is empty or given twice", self.name)),
            None => Ok(texts),
        }
    }

    /// Rejects texts whose obstacle cannot be read, and obstacles with two texts.
    fn check_obstacles(
        &self,
        texts: &[String],
        what: &str,
        name_of: impl Fn(&str) -> Result<String, String>,
    ) -> Result<(), String> {
        let mut names = BTreeSet::new();
        for text in texts {
            let shown = text.escape_debug();
            let name = name_of(text).map_err(|why| format!("{}: '{shown}': {why}", self.name))?;
            if !names.insert(name) {
                return Err(format!("{}: '{shown}': this obstacle has two {what}", self.name));
            }
        }
        Ok(())
    }

    fn point(&self, value: &Value) -> Result<Vec<f64>, String> {
        let numbers = match value {
            Value::Doubles(numbers) => numbers.clone(),
            Value::EmptyList => Vec::new(),
            other => {
                return Err(format!("{} is a list of numbers, but {} was given", self.name, other.kind()));
            }
        };
        let usable = (numbers.is_empty() || numbers.len() == 3) && numbers.iter().all(|n| n.is_finite());
        usable.then_some(numbers).ok_or_else(|| format!("{} is three finite numbers, or none", self.name))
    }
}
