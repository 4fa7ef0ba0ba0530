//! Source of parameter values on the command line.

use std::path::PathBuf;

use crate::parameters::parameter_value::Value;

/// Source of parameter values.
#[derive(Clone, Debug, PartialEq)]
pub enum ParameterSource {
    /// `--params-file FILE`
    File(PathBuf),
    /// `-p name:=value`, for every node or for the node named `node`.
    Single { node: Option<String>, name: String, value: Value },
}
