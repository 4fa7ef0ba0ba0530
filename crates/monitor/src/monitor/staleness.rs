//! Methods of the monitor for validity times: ages of joint states, transforms and world data, and the next heartbeat.

use std::time::Duration;

use super::Monitor;
use crate::state_evaluator::StateEvaluator;
use crate::{Expiry, Now, Reason};

impl Monitor {
    /// Time until the next evaluation has to be published, if no joint state is received.
    #[must_use]
    pub fn time_to_heartbeat(&self, now: Now) -> Duration {
        let Some(published_at) = self.published_at.filter(|_| !self.outdated) else {
            return Duration::ZERO;
        };
        let mut due = published_at + self.settings.heartbeat_period();
        // a heartbeat is due at the time from which the world lags too far behind
        if let Some(lags) = self.world_updates.due().filter(|lags| *lags > published_at) {
            due = due.min(lags);
        }
        let heartbeat = due.saturating_sub(now.steady);
        // a heartbeat is due at the time at which the evaluation becomes stale
        let stale = self.check_result.checked_state.as_ref().and_then(|_| {
            let ends = [self.robot_time_to_stale(now), self.world_time_to_stale(now)];
            ends.into_iter().flatten().min()
        });
        stale.map_or(heartbeat, |stale| heartbeat.min(stale))
    }

    /// How long the robot's configuration stays valid, if no message is received.
    fn robot_time_to_stale(&self, now: Now) -> Option<Duration> {
        let of_base = self.transform_joints.time_to_stale(now, &self.settings);
        // slightly later, so that the state is stale at that time despite rounding
        let of_base = Duration::try_from_secs_f64(of_base).ok().map(|left| left + Duration::from_millis(1));
        self.contributions.time_to_stale(now, &self.settings).into_iter().chain(of_base).min()
    }

    /// How long the obstacles' positions stay valid, if no message is received.
    fn world_time_to_stale(&self, now: Now) -> Option<Duration> {
        let sources = self.evaluator.iter().flat_map(|evaluator| &evaluator.revision.sources);
        let of_ground = self.root_location.time_to_stale(now, self.settings.transform_ttl);
        sources.filter_map(|source| source.time_to_stale(now)).chain(of_ground).min()
    }

    pub(super) fn expiry(&self, now: Now) -> Expiry {
        let end = |left: Option<Duration>| left.and_then(|left| now.steady.checked_add(left));
        Expiry {
            published_at: now.steady,
            of_robot: end(self.robot_time_to_stale(now)),
            of_world: end(self.world_time_to_stale(now)).into_iter().chain(self.world_updates.due()).min(),
        }
    }

    /// Whether the positions of the robot's joints are still valid.
    pub(super) fn freshness(&self, evaluator: &StateEvaluator, now: Now) -> Result<(), Reason> {
        let robot = evaluator.revision.checker.robot();
        if !self.received_states.messages().is_empty() {
            self.contributions.freshness(now, &self.settings, robot.position_names())?;
        }
        if self.check_result.checked_state.is_some() {
            return self.transform_joints.read(robot, now, &self.settings).unknown.map_or(Ok(()), Err);
        }
        Ok(())
    }
}
