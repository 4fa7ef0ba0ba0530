//! Check budget: limits the work on exact distances by the rate of the joint states, so that none has to be skipped.

use std::collections::VecDeque;
use std::time::Duration;

use clearance_proximity::Effort;

/// Volume tests per second on an ordinary machine. Tests are counted instead of timed, so that repeated checks give
/// equal results.
const TESTS_PER_SECOND: f64 = 2e7;

/// Number of joint states over which the interval is averaged. Until this number is reached there is no limit.
const AVERAGED: usize = 16;

/// Pause after which the average restarts. In it there is time for exact distances.
const REST: Duration = Duration::from_millis(100);

/// Tolerance of distances that would take too long to compute exactly: a tenth, or a millimetre.
const TOLERANT: Effort = Effort {
    relative_tolerance: 0.1,
    absolute_tolerance: 0.001,
    exact_within: 0.0,
    exact_cost: 0,
    deadline: None,
};

/// Rate of the joint states.
#[derive(Debug, Default)]
pub(super) struct CheckBudget {
    /// Reception times of the last ones (steady clock).
    receptions: VecDeque<Duration>,
    /// Mean time (s) between joint states before a pause. It is used after the pause until there is a new mean: when a
    /// host pauses the node, the joint states that have queued come all at once.
    before_pause: Option<f64>,
    /// Nothing is known after a pause.
    pub forgets_in_pauses: bool,
}

impl CheckBudget {
    /// Records the reception of a joint state.
    pub fn note(&mut self, received_at: Duration) {
        self.is_paused(received_at);
        if self.receptions.len() > AVERAGED {
            self.receptions.pop_front();
        }
        self.receptions.push_back(received_at);
    }

    /// Whether the joint states pause; then there is no limit.
    pub fn is_paused(&mut self, now: Duration) -> bool {
        let is_paused = self.receptions.back().is_none_or(|last| now.saturating_sub(*last) >= REST);
        if is_paused && !self.receptions.is_empty() {
            self.before_pause = self.mean_interval().filter(|_| !self.forgets_in_pauses);
            self.receptions.clear();
        }
        is_paused
    }

    /// Time (s) between two joint states, unless they pause.
    fn interval(&self) -> Option<f64> {
        if self.receptions.is_empty() { None } else { self.mean_interval().or(self.before_pause) }
    }

    /// Mean time (s) between joint states since the last pause.
    fn mean_interval(&self) -> Option<f64> {
        let (first, last) = (self.receptions.front()?, self.receptions.back()?);
        let all = last.saturating_sub(*first).as_secs_f64();
        #[expect(clippy::cast_precision_loss, reason = "there are few")]
        let mean = all / AVERAGED as f64;
        (self.receptions.len() > AVERAGED).then_some(mean)
    }

    /// Effort limit of a check whose exact distances may take this share of the time between joint states. The effort
    /// is unchanged if the share is 0, or if exact distances are not requested anyway.
    pub fn limit(&self, effort: Effort, share: f64) -> Effort {
        match self.interval() {
            Some(interval) if share > 0.0 && effort.is_exact() => {
                #[expect(
                    clippy::cast_possible_truncation,
                    clippy::cast_sign_loss,
                    reason = "a gap is a few hours at most"
                )]
                let exact_cost = (share * interval * TESTS_PER_SECOND) as u64;
                Effort { exact_cost: exact_cost.max(1), ..TOLERANT }
            }
            _ => effort,
        }
    }
}
