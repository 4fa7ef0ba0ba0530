//! Value of a ROS parameter: its types, and conversion from YAML and from and to messages.

use ros2_client::parameters::raw::{ParameterType, ParameterValue};
use serde_json::Value as Yaml;

/// Value of one of the types that this node's parameters have, or `Other`.
#[derive(Clone, Debug, PartialEq)]
pub enum Value {
    Bool(bool),
    Integer(i64),
    Double(f64),
    Text(String),
    Texts(Vec<String>),
    /// List of doubles, or of integers converted to doubles.
    Doubles(Vec<f64>),
    /// Empty list, whose element type is unknown.
    EmptyList,
    /// Other arrays, or no value. No parameter of this node accepts them; the text names the type.
    Other(&'static str),
}

impl Value {
    /// Name of the value's type for error messages.
    #[must_use]
    pub fn kind(&self) -> &'static str {
        match self {
            Self::Bool(_) => "a bool",
            Self::Integer(_) => "an integer",
            Self::Double(_) => "a double",
            Self::Text(_) => "a string",
            Self::Texts(_) => "a list of strings",
            Self::Doubles(_) => "a list of numbers",
            Self::EmptyList => "an empty list",
            Self::Other(kind) => kind,
        }
    }

    /// Converts the value to a message.
    #[must_use]
    pub fn to_message(&self) -> ParameterValue {
        let mut message = not_set();
        match self {
            Self::Bool(value) => {
                message.ptype = ParameterType::BOOL;
                message.boolean_value = *value;
            }
            Self::Integer(value) => {
                message.ptype = ParameterType::INTEGER;
                message.int_value = *value;
            }
            Self::Double(value) => {
                message.ptype = ParameterType::DOUBLE;
                message.double_value = *value;
            }
            Self::Text(value) => {
                message.ptype = ParameterType::STRING;
                message.string_value.clone_from(value);
            }
            Self::Texts(values) => {
                message.ptype = ParameterType::STRING_ARRAY;
                message.string_array.clone_from(values);
            }
            Self::Doubles(values) => {
                message.ptype = ParameterType::DOUBLE_ARRAY;
                message.double_array.clone_from(values);
            }
            Self::EmptyList | Self::Other(_) => {}
        }
        message
    }

    /// Converts a message to a value.
    #[must_use]
    pub fn from_message(message: &ParameterValue) -> Self {
        match message.ptype {
            ParameterType::BOOL => Self::Bool(message.boolean_value),
            ParameterType::INTEGER => Self::Integer(message.int_value),
            ParameterType::DOUBLE => Self::Double(message.double_value),
            ParameterType::STRING => Self::Text(message.string_value.clone()),
            // `ros2 param` sends `[]` from its command line as an array of bools
            _ if is_empty_array(message) => Self::EmptyList,
            ParameterType::STRING_ARRAY => Self::Texts(message.string_array.clone()),
            ParameterType::DOUBLE_ARRAY => Self::Doubles(message.double_array.clone()),
            #[expect(clippy::cast_precision_loss, reason = "whoever wants doubles takes what they can hold")]
            ParameterType::INTEGER_ARRAY => {
                Self::Doubles(message.int_array.iter().map(|&number| number as f64).collect())
            }
            ParameterType::NOT_SET => Self::Other("no value, which would delete it"),
            _ => Self::Other("an array"),
        }
    }
}

fn is_empty_array(message: &ParameterValue) -> bool {
    match message.ptype {
        ParameterType::BYTE_ARRAY => message.byte_array.is_empty(),
        ParameterType::BOOL_ARRAY => message.bool_array.is_empty(),
        ParameterType::INTEGER_ARRAY => message.int_array.is_empty(),
        ParameterType::DOUBLE_ARRAY => message.double_array.is_empty(),
        ParameterType::STRING_ARRAY => message.string_array.is_empty(),
        _ => false,
    }
}

/// Message for a parameter that does not exist.
#[must_use]
pub fn not_set() -> ParameterValue {
    ParameterValue {
        ptype: ParameterType::NOT_SET,
        boolean_value: false,
        int_value: 0,
        double_value: 0.0,
        string_value: String::new(),
        byte_array: Vec::new(),
        bool_array: Vec::new(),
        int_array: Vec::new(),
        double_array: Vec::new(),
        string_array: Vec::new(),
    }
}

/// Parses the value after `:=` in `-p name:=value`, which is YAML as in rcl.
pub fn from_yaml(text: &str) -> Result<Value, String> {
    if let Some(special) = special_number(text.trim()) {
        return Ok(Value::Double(special));
    }
    let yaml: Yaml = serde_saphyr::from_str(text).map_err(|error| clearance_files::yaml::in_words(&error))?;
    Ok(from_node(&yaml))
}

/// Value of a YAML node.
#[must_use]
pub fn from_node(yaml: &Yaml) -> Value {
    match yaml {
        Yaml::Bool(value) => Value::Bool(*value),
        Yaml::Number(number) => match (number.as_i64(), number.as_f64()) {
            (Some(integer), _) => Value::Integer(integer),
            (None, Some(double)) => Value::Double(double),
            (None, None) => Value::Other("a number too large"),
        },
        Yaml::String(text) => special_number(text).map_or_else(|| Value::Text(text.clone()), Value::Double),
        Yaml::Array(items) => from_list(items),
        Yaml::Object(_) => Value::Other("a map"),
        Yaml::Null => Value::Other("nothing, or not a number"),
    }
}

fn from_list(items: &[Yaml]) -> Value {
    if items.is_empty() {
        return Value::EmptyList;
    }
    let values: Vec<Value> = items.iter().map(from_node).collect();
    let texts = values.iter().map(|value| match value {
        Value::Text(text) => Some(text.clone()),
        _ => None,
    });
    if let Some(texts) = texts.collect() {
        return Value::Texts(texts);
    }
    let numbers = values.iter().map(|value| match *value {
        #[expect(clippy::cast_precision_loss, reason = "whoever wants doubles takes what they can hold")]
        Value::Integer(number) => Some(number as f64),
        Value::Double(number) => Some(number),
        _ => None,
    });
    numbers.collect::<Option<_>>().map_or(Value::Other("a list of various things"), Value::Doubles)
}

/// Parses the YAML numbers that JSON does not have.
fn special_number(text: &str) -> Option<f64> {
    match text.to_ascii_lowercase().as_str() {
        ".nan" => Some(f64::NAN),
        ".inf" | "+.inf" => Some(f64::INFINITY),
        "-.inf" => Some(f64::NEG_INFINITY),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn yaml_decides_the_type() {
        assert_eq!(from_yaml("true"), Ok(Value::Bool(true)));
        assert_eq!(from_yaml("20"), Ok(Value::Integer(20)));
        assert_eq!(from_yaml("-1.5"), Ok(Value::Double(-1.5)));
        assert_eq!(from_yaml("1e-3"), Ok(Value::Double(1e-3)));
        assert_eq!(from_yaml(".inf"), Ok(Value::Double(f64::INFINITY)));
        assert_eq!(from_yaml("some text"), Ok(Value::Text("some text".into())));
        assert_eq!(from_yaml("[1, 2.5]"), Ok(Value::Doubles(vec![1.0, 2.5])));
        assert_eq!(from_yaml("[a, b]"), Ok(Value::Texts(vec!["a".into(), "b".into()])));
        assert_eq!(from_yaml("[]"), Ok(Value::EmptyList));
        assert_eq!(from_yaml("[a, 1]"), Ok(Value::Other("a list of various things")));
        assert!(from_yaml("[1, 2").is_err());
    }

    #[test]
    fn messages_go_both_ways() {
        let text = Value::Text("x".into());
        let lists = [Value::Texts(vec!["x".into()]), Value::Doubles(vec![0.5])];
        for value in
            [Value::Bool(true), Value::Integer(-3), Value::Double(0.5), text].into_iter().chain(lists)
        {
            assert_eq!(Value::from_message(&value.to_message()), value);
        }
        for empty in [Value::Texts(vec![]), Value::Doubles(vec![])] {
            assert_eq!(Value::from_message(&empty.to_message()), Value::EmptyList);
        }
        let bools = ParameterValue { ptype: ParameterType::BOOL_ARRAY, ..not_set() };
        assert_eq!(Value::from_message(&bools), Value::EmptyList);
        assert!(matches!(Value::from_message(&not_set()), Value::Other(_)));
    }
}
