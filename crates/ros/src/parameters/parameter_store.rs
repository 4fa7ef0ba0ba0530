//! The current parameters, shared between threads.

use std::sync::{Arc, Mutex, PoisonError};

use crate::parameters::assignment::set_live;
use crate::parameters::parameter_set::Parameters;
use crate::parameters::parameter_value::Value;

/// Callback that receives every new set of parameters, in the order of the changes.
pub type OnChange = Box<dyn Fn(&Parameters) + Send + Sync>;

/// Active parameters, shared between the threads that change and read them.
#[derive(Clone)]
pub struct ParameterStore {
    values: Arc<Mutex<Parameters>>,
    on_change: Arc<OnChange>,
}

impl ParameterStore {
    #[must_use]
    pub fn new(initial: Parameters, on_change: OnChange) -> Self {
        Self { values: Arc::new(Mutex::new(initial)), on_change: Arc::new(on_change) }
    }

    #[must_use]
    pub fn get(&self) -> Parameters {
        self.values.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// Applies all changes or none. The new values become active at the same time.
    pub fn set_together(&self, changes: &[(String, Value)]) -> Result<(), String> {
        let mut values = self.values.lock().unwrap_or_else(PoisonError::into_inner);
        let mut changed = values.clone();
        set_live(&mut changed, changes)?;
        if *values != changed {
            *values = changed;
            (self.on_change)(&values);
        }
        Ok(())
    }

    /// Applies each valid change. The new values become active at the same time.
    pub fn set_each(&self, changes: &[(String, Value)]) -> Vec<Result<(), String>> {
        let mut values = self.values.lock().unwrap_or_else(PoisonError::into_inner);
        let mut changed = values.clone();
        let results = changes
            .iter()
            .map(|change| set_live(&mut changed, std::slice::from_ref(change)))
            .collect::<Vec<_>>();
        if *values != changed {
            *values = changed;
            (self.on_change)(&values);
        }
        results
    }
}
