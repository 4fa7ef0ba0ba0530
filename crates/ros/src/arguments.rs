//! Parser for the arguments after `--ros-args`, with the same syntax as every ROS 2 program.

use std::path::PathBuf;
use std::str::FromStr;

use log::LevelFilter;

use crate::names::{Remap, RemapScope};
use crate::parameters::parameter_source::ParameterSource;
use crate::parameters::parameter_value;

/// The ROS arguments of one process.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RosArguments {
    /// `-r from:=to`, in order: the first rule that matches applies.
    pub remaps: Vec<Remap>,
    /// Parameter files and single parameters, in order: the last value applies.
    pub parameters: Vec<ParameterSource>,
    /// `--log-level`.
    pub log_level: Option<LevelFilter>,
    /// Arguments that are valid but have no effect here. The node logs them.
    pub ignored: Vec<String>,
}

/// Argument that is not valid.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ArgumentError {
    #[error("--ros-args: '{0}' is no ROS argument")]
    Unknown(String),
    #[error("--ros-args: '{flag}' is followed by nothing, but it needs {needs}")]
    Missing { flag: String, needs: &'static str },
    #[error("--ros-args: '{argument}' after '{flag}' is wrong: {why}")]
    Malformed { flag: String, argument: String, why: String },
}

impl RosArguments {
    /// Parses the words between `--ros-args` and `--`. Both words may occur again among them.
    pub fn parse<S: AsRef<str>>(words: &[S]) -> Result<Self, ArgumentError> {
        let mut arguments = Self::default();
        let mut words = words.iter().map(AsRef::as_ref);
        while let Some(flag) = words.next() {
            let mut argument =
                |needs| words.next().ok_or(ArgumentError::Missing { flag: flag.to_owned(), needs });
            match flag {
                "--ros-args" | "--" => {}
                "-r" | "--remap" => {
                    let text = argument("from:=to")?;
                    arguments.add_remap(flag, text)?;
                }
                "-p" | "--param" => {
                    let text = argument("name:=value")?;
                    arguments.parameters.push(parameter(flag, text)?);
                }
                "--params-file" => {
                    let file = PathBuf::from(argument("a file")?);
                    arguments.parameters.push(ParameterSource::File(file));
                }
                "--log-level" => {
                    let text = argument("a level")?;
                    arguments.log_level = Some(log_level(flag, text)?);
                }
                "-e" | "--enclave" | "--log-config-file" | "--log-file-name" => {
                    let text = argument("a value")?;
                    arguments.ignored.push(format!("{flag} {text}"));
                }
                _ if is_log_switch(flag) => arguments.ignored.push(flag.to_owned()),
                _ => match flag.split_once(":=") {
                    // many scripts still use the short form of ROS 1
                    Some(_) => arguments.add_remap("-r", flag)?,
                    None => return Err(ArgumentError::Unknown(flag.to_owned())),
                },
            }
        }
        Ok(arguments)
    }

    fn add_remap(&mut self, flag: &str, text: &str) -> Result<(), ArgumentError> {
        let rule = remap(flag, text)?;
        if rule.has_effect() {
            self.remaps.push(rule);
        } else {
            self.ignored.push(format!("{flag} {text}"));
        }
        Ok(())
    }
}

/// Whether a flag is `--enable-rosout-logs`, `--disable-stdout-logs` or similar.
fn is_log_switch(flag: &str) -> bool {
    (flag.strip_prefix("--enable-").or_else(|| flag.strip_prefix("--disable-")))
        .is_some_and(|what| ["rosout-logs", "stdout-logs", "external-lib-logs"].contains(&what))
}

fn malformed(flag: &str, argument: &str, why: impl Into<String>) -> ArgumentError {
    ArgumentError::Malformed { flag: flag.to_owned(), argument: argument.to_owned(), why: why.into() }
}

fn remap(flag: &str, text: &str) -> Result<Remap, ArgumentError> {
    let wrong = || malformed(flag, text, "it must be from:=to");
    let (from, to) = text.split_once(":=").ok_or_else(wrong)?;
    // the colon of rostopic:// names no node
    let has_scheme = RemapScope::split(from).0 != RemapScope::All;
    let (node, from) = if has_scheme { (None, from) } else { node_qualifier(from) };
    let (scope, from) = RemapScope::split(from);
    if from.is_empty() || to.is_empty() || node.as_deref() == Some("") {
        return Err(wrong());
    }
    Ok(Remap { node, scope, from: from.to_owned(), to: to.to_owned() })
}

fn parameter(flag: &str, text: &str) -> Result<ParameterSource, ArgumentError> {
    let (name, value) = (text.split_once(":="))
        .filter(|(name, _)| !name.is_empty())
        .ok_or_else(|| malformed(flag, text, "it must be name:=value"))?;
    let (node, name) = node_qualifier(name);
    let value = parameter_value::from_yaml(value).map_err(|why| malformed(flag, text, why))?;
    Ok(ParameterSource::Single { node, name: name.to_owned(), value })
}

/// Splits `node:name` into node and name; a plain `name` has no node.
fn node_qualifier(text: &str) -> (Option<String>, &str) {
    match text.split_once(':') {
        Some((node, name)) => (Some(node.to_owned()), name),
        None => (None, text),
    }
}

/// Parses `debug` or `logger:=debug`. The logger's name is ignored, because this program has only one logger.
fn log_level(flag: &str, text: &str) -> Result<LevelFilter, ArgumentError> {
    let level = text.split_once(":=").map_or(text, |(_, level)| level);
    match level.to_ascii_lowercase().as_str() {
        "fatal" => Ok(LevelFilter::Error),
        "unset" => Ok(LevelFilter::Info),
        other => LevelFilter::from_str(other)
            .map_err(|_| malformed(flag, text, "a level is debug, info, warn, error or fatal")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::parameters::parameter_value::Value;

    #[test]
    fn everything_that_ros_2_run_and_launch_pass_is_read() {
        let words = "-r __node:=guard -r __ns:=/cell --remap clearance:joint_states:=/js \
                     -p padding:=0.02 --param other:pad_self:=true --params-file a.yaml \
                     --log-level debug --log-level clearance:=warn --disable-stdout-logs --ros-args --enclave /x";
        let words: Vec<&str> = words.split_whitespace().collect();
        let arguments = RosArguments::parse(&words).unwrap();
        let remap = |node: Option<&str>, from: &str, to: &str| Remap {
            node: node.map(str::to_owned),
            scope: RemapScope::All,
            from: from.to_owned(),
            to: to.to_owned(),
        };
        assert_eq!(
            arguments.remaps,
            [
                remap(None, "__node", "guard"),
                remap(None, "__ns", "/cell"),
                remap(Some("clearance"), "joint_states", "/js"),
            ]
        );
        assert_eq!(
            arguments.parameters,
            [
                ParameterSource::Single { node: None, name: "padding".into(), value: Value::Double(0.02) },
                ParameterSource::Single {
                    node: Some("other".into()),
                    name: "pad_self".into(),
                    value: Value::Bool(true)
                },
                ParameterSource::File("a.yaml".into()),
            ]
        );
        assert_eq!(arguments.log_level, Some(LevelFilter::Warn));
        assert_eq!(arguments.ignored, ["--disable-stdout-logs", "--enclave /x"]);
    }

    #[test]
    fn rules_with_a_scheme_are_for_topics_or_services_and_reserved_names_have_no_effect() {
        let words = "-r rostopic://joint_states:=/y -r clearance:rosservice:///clear_octomap:=/z \
                     rostopic://tf:=/tf -r __log:=x -r rostopic://__ns:=/cell";
        let words: Vec<&str> = words.split_whitespace().collect();
        let arguments = RosArguments::parse(&words).unwrap();
        let rules: Vec<_> =
            arguments.remaps.iter().map(|r| (r.node.as_deref(), r.scope, r.from.as_str())).collect();
        assert_eq!(
            rules,
            [
                (None, RemapScope::Topics, "joint_states"),
                (Some("clearance"), RemapScope::Services, "/clear_octomap"),
                (None, RemapScope::Topics, "tf"),
            ]
        );
        assert_eq!(arguments.ignored, ["-r __log:=x", "-r rostopic://__ns:=/cell"]);
    }

    #[test]
    fn what_is_wrong_is_named() {
        for (words, named) in [
            (&["-r"][..], "-r"),
            (&["-r", "joint_states"], "joint_states"),
            (&["-r", ":=x"], ":=x"),
            (&["-r", "rostopic://:=x"], "rostopic://:=x"),
            (&["-r", "clearance::=x"], "clearance::=x"),
            (&["-r", ":joint_states:=x"], ":joint_states:=x"),
            (&["-p", "padding=1"], "padding=1"),
            (&["-p", ":=1"], ":=1"),
            (&["--params-file"], "--params-file"),
            (&["--log-level", "loud"], "loud"),
            (&["--colour"], "--colour"),
        ] {
            let message = RosArguments::parse(words).unwrap_err().to_string();
            assert!(message.contains(named), "{message}");
        }
    }
}
