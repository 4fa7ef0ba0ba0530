//! Initial parameters of the node: those of arguments and parameter files, with warnings about those without effect.

use crate::arguments::RosArguments;
use crate::names::{NODE_NAME, Names};
use crate::node_error::NodeError;
use crate::parameters::parameter_files;
use crate::parameters::parameter_set::Parameters;

/// Parameters from the files and the `-p` arguments.
///
/// # Errors
/// When a file cannot be read, or a value is not valid for its parameter.
pub fn initial_parameters(arguments: &RosArguments) -> Result<Parameters, NodeError> {
    for ignored in &arguments.ignored {
        log::warn!("{ignored} has no effect here");
    }
    let names = Names::new(NODE_NAME, &arguments.remaps)?;
    for rule in names.other_remaps() {
        log::warn!("-r {rule} has no effect here: this node is '{}'", names.node());
    }
    let (parameters, passed_over) =
        parameter_files::initial(Parameters::default(), &arguments.parameters, &names)
            .map_err(|error| NodeError::Input(error.to_string()))?;
    for parameter in passed_over {
        log::warn!("parameters that are not of this node are skipped: {parameter}");
    }
    Ok(parameters)
}
