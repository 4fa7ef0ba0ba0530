//! Conversion of rows of joint positions to configurations; errors name the argument.

use clearance::robot::Configuration;
use clearance_bindings::JointSpace;

use crate::status::{Failure, Outcome};

/// Validates a row, called `name`, and writes the configuration of the whole robot; `scratch` is memory that is reused.
pub fn read_into(
    space: &JointSpace,
    row: &[f64],
    name: &dyn Fn() -> String,
    scratch: &mut Vec<f64>,
    q: &mut Configuration,
) -> Outcome {
    let names = space.names();
    if row.len() != names.len() {
        return Err(Failure::argument(format!(
            "{} has {} positions, but must have {}: one for each of {}",
            name(),
            row.len(),
            names.len(),
            names.join(", ")
        )));
    }
    space.read_into(row, scratch, q).map_err(|why| Failure::rejected(format!("{}: {why}", name())))
}

/// The configuration of the whole robot for a row, called `name`.
pub fn read(space: &JointSpace, row: &[f64], name: &dyn Fn() -> String) -> Outcome<Configuration> {
    let mut q = space.rest().clone();
    read_into(space, row, name, &mut Vec::new(), &mut q)?;
    Ok(q)
}
