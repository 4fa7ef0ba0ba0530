//! Least distances along a motion, as `clearance motion` prints them in text and JSON.

use clearance::checker::{
    CollisionChecker, LeastClearance, MotionClearance, MotionClearanceOptions, NearestMoment, UndecidedReason,
};
use clearance::motion::Trajectory;
use serde::Serialize;

use super::rounded_bounds::{at_least, at_most};

/// The least distances along a motion (m, padding subtracted); `null` where no such pairs are checked.
#[derive(Serialize)]
pub struct ClearanceResult {
    #[serde(rename = "self")]
    nearest_self: Option<LeastResult>,
    world: Option<LeastResult>,
    /// Why the bounds differ by more than the tolerance.
    #[serde(skip_serializing_if = "Option::is_none")]
    reason: Option<&'static str>,
}

/// Bounds on one least distance, and the moment at which the upper one is attained.
#[derive(Serialize)]
struct LeastResult {
    lower: f64,
    /// `null` if nothing was measured.
    upper: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pair: Option<[String; 2]>,
    #[serde(skip_serializing_if = "Option::is_none")]
    t: Option<f64>,
    /// For a trajectory: index of the segment, and time in seconds from the start.
    #[serde(skip_serializing_if = "Option::is_none")]
    segment: Option<usize>,
    #[serde(skip_serializing_if = "Option::is_none")]
    time: Option<f64>,
    /// Nearest points of the pair (root frame), in the order of `pair`.
    #[serde(skip_serializing_if = "Option::is_none")]
    witness_points: Option<[[f64; 3]; 2]>,
}

impl ClearanceResult {
    /// Searches the least distances along a trajectory.
    pub fn along(
        checker: &CollisionChecker,
        trajectory: &Trajectory,
        options: &MotionClearanceOptions,
        is_trajectory: bool,
    ) -> Self {
        let found = checker.clearance_along_trajectory(trajectory, options, &mut checker.workspace());
        let MotionClearance { nearest_self, nearest_world, unfinished, .. } = found;
        let result = |least: LeastClearance| LeastResult::new(&least, checker, trajectory, is_trajectory);
        Self {
            nearest_self: nearest_self.map(result),
            world: nearest_world.map(result),
            reason: unfinished.map(UndecidedReason::code),
        }
    }

    /// For each kind of pairs: its name, bounds, pair and t.
    pub fn text(&self) -> String {
        let kinds = [("self", &self.nearest_self), ("world", &self.world)];
        let kinds = kinds.into_iter().filter_map(|(kind, least)| Some((kind, least.as_ref()?)));
        let texts = kinds.map(|(kind, least)| format!("; least {kind} distance {}", least.text()));
        let reason = self.reason.map(|reason| format!(" (bounds are wide: {reason})"));
        texts.chain(reason).collect()
    }
}

impl LeastResult {
    fn new(
        LeastClearance { lower, upper, nearest }: &LeastClearance,
        checker: &CollisionChecker,
        trajectory: &Trajectory,
        is_trajectory: bool,
    ) -> Self {
        let pair = nearest.map(|NearestMoment { pair, .. }| {
            [pair.a, pair.b].map(|body| checker.body_name(body).to_owned())
        });
        // index in the given trajectory, not in the parts into which moving obstacles split it
        let origin = nearest.map(|nearest| trajectory.origin(nearest.segment, nearest.t));
        Self {
            lower: *lower,
            upper: upper.is_finite().then_some(*upper),
            pair,
            t: origin.map(|(_, t)| t),
            segment: origin.map(|(segment, _)| segment).filter(|_| is_trajectory),
            time: nearest.and_then(|nearest| nearest.time),
            witness_points: nearest.map(|nearest| nearest.pair.witness_points.map(|p| p.coords.into())),
        }
    }

    fn text(&self) -> String {
        let Self { lower, upper, pair, t, segment, .. } = self;
        let lower = at_least(*lower, 6);
        let upper = upper.map_or_else(|| "unknown".to_owned(), |upper| at_most(upper, 6));
        let pair = pair.as_ref().map_or_else(String::new, |[a, b]| format!(" ({a} – {b}"));
        let t = t.map_or_else(String::new, |t| format!(" at t = {t:.6}"));
        let segment = segment.map_or_else(String::new, |segment| format!(" of segment {segment}"));
        let end = if pair.is_empty() { "" } else { ")" };
        format!("{lower} to {upper} m{pair}{t}{segment}{end}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bounds_are_rounded_to_the_outside() {
        let text = |lower, upper| {
            let none = LeastResult {
                lower,
                upper,
                pair: None,
                t: None,
                segment: None,
                time: None,
                witness_points: None,
            };
            none.text()
        };
        assert_eq!(text(0.008_657_066, Some(0.009_657_066)), "0.008657 to 0.009658 m");
        assert_eq!(text(0.008_657_9, Some(0.009)), "0.008657 to 0.009000 m");
        assert_eq!(text(0.0, None), "0.000000 to unknown m");
    }
}
