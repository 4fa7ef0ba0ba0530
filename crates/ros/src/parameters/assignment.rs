//! Assignment of values to parameters by name.

use crate::parameters::declarations::{declaration_of, unknown};
use crate::parameters::parameter_set::Parameters;
use crate::parameters::parameter_value::Value;

/// Changes parameters of a running node: all of them, or none and an error.
pub fn set_live(parameters: &mut Parameters, changes: &[(String, Value)]) -> Result<(), String> {
    let mut changed = parameters.clone();
    for (name, value) in changes {
        assign(&mut changed, name, value)?;
        if declaration_of(name).is_some_and(|d| d.is_fixed() && d.get(&changed) != d.get(parameters)) {
            return Err(format!("{name} counts at the start only: give it to a new node"));
        }
    }
    changed.check_together()?;
    *parameters = changed;
    Ok(())
}

/// Assigns one of several parameters. The caller must call [`Parameters::check_together`] after the last one.
pub fn assign(parameters: &mut Parameters, name: &str, value: &Value) -> Result<(), String> {
    declaration_of(name).ok_or_else(|| unknown(name))?.set(parameters, value)
}
