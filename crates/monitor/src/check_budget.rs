//! How much a check may cost so that no joint state has to be passed over.

use std::collections::VecDeque;
use std::time::Duration;

use clearance_proximity::Effort;

/// Volume tests in a second, of an ordinary machine: counted instead of timed, they are the same whenever a check is done again.
const TESTS_PER_SECOND: f64 = 2e7;

/// Joint states over which the time between two of them is averaged; before so many have come there is no hurry.
const AVERAGED: usize = 16;

/// Silence after which there is time for exact distances, and joint states begin anew.
const REST: Duration = Duration::from_millis(100);

/// What distances are told within where exact ones would take too long: a tenth, or a millimetre.
const ROUGHLY: Effort = Effort {
    relative_tolerance: 0.1,
    absolute_tolerance: 0.001,
    exact_within: 0.0,
    exact_cost: 0,
    deadline: None,
};

/// How fast joint states come.
#[derive(Debug, Default)]
pub(super) struct CheckBudget {
    /// When the last ones came, by the steady clock.
    arrivals: VecDeque<Duration>,
}

impl CheckBudget {
    /// A joint state is taken in.
    pub fn note(&mut self, arrival: Duration) {
        self.rests(arrival);
        if self.arrivals.len() > AVERAGED {
            self.arrivals.pop_front();
        }
        self.arrivals.push_back(arrival);
    }

    /// Whether none came for a while; then there is no hurry.
    pub fn rests(&mut self, now: Duration) -> bool {
        let rests = self.arrivals.back().is_none_or(|last| now.saturating_sub(*last) >= REST);
        if rests {
            self.arrivals.clear();
        }
        rests
    }

    /// Time (s) between two joint states, in the mean.
    fn interval(&self) -> Option<f64> {
        let (first, last) = (self.arrivals.front()?, self.arrivals.back()?);
        let all = last.saturating_sub(*first).as_secs_f64();
        #[expect(clippy::cast_precision_loss, reason = "there are few")]
        let mean = all / AVERAGED as f64;
        (self.arrivals.len() > AVERAGED).then_some(mean)
    }

    /// How much effort a check may make whose exact distances may take this share of the time between joint states; with a share of
    /// 0, or where less than exact distances are asked for anyway, as much as before.
    pub fn limit(&self, effort: Effort, share: f64) -> Effort {
        match self.interval() {
            Some(interval) if share > 0.0 && effort.is_exact() => {
                #[expect(
                    clippy::cast_possible_truncation,
                    clippy::cast_sign_loss,
                    reason = "a gap is a few hours at most"
                )]
                let exact_cost = (share * interval * TESTS_PER_SECOND) as u64;
                Effort { exact_cost: exact_cost.max(1), ..ROUGHLY }
            }
            _ => effort,
        }
    }
}
