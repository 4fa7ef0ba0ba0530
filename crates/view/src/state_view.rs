//! Public handle of a view without a node: opens its web server, sets and returns the robot's state.

use std::sync::Arc;

use clearance_checker::CollisionChecker;
use clearance_robot::{Configuration, ConfigurationError};

use crate::address::ViewAddress;
use crate::latest_evaluation::EvaluationSlot;
use crate::server::{View, ViewError};
use crate::state_control::StateControl;

/// A running server whose page has a slider for each joint; dropping it stops the server. Threads may share it.
#[derive(Debug)]
pub struct StateView {
    control: Arc<StateControl>,
    view: View,
}

/// Error: the view cannot be opened.
#[derive(Debug, thiserror::Error)]
pub enum StateViewError {
    /// The first state is not valid.
    #[error(transparent)]
    State(#[from] ConfigurationError),
    /// The server cannot be started.
    #[error(transparent)]
    Server(#[from] ViewError),
}

impl StateView {
    /// Starts the server. `state` has all positions (rad, m) of the robot; `positions` are the indices of those with a slider.
    ///
    /// # Errors
    /// If the state is not valid, or if the address cannot be used.
    pub fn open(
        address: &ViewAddress,
        checker: CollisionChecker,
        positions: &[usize],
        state: &[f64],
    ) -> Result<Self, StateViewError> {
        let slot = Arc::new(EvaluationSlot::default());
        let control = Arc::new(StateControl::new(checker, positions, state, Arc::clone(&slot))?);
        let view = View::start(address, slot, Some(Arc::clone(&control)))?;
        Ok(Self { control, view })
    }

    /// URL of the page.
    #[must_use]
    pub fn url(&self) -> &str {
        self.view.url()
    }

    /// The state that the page shows.
    #[must_use]
    pub fn state(&self) -> Configuration {
        self.control.state()
    }

    /// Evaluates and shows a state: all positions (rad, m) of the robot.
    ///
    /// # Errors
    /// If the robot has no such state.
    pub fn set_state(&self, positions: &[f64]) -> Result<(), ConfigurationError> {
        self.control.set_state(positions)
    }
}
