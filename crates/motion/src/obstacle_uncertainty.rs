//! Speed and acceleration limits of obstacles with unknown motion, and the bound on their displacement.
//!
//! An obstacle whose points move at most at speed v at time 0, and accelerate by at most a, is displaced by at most
//! v t + ½ a t² at time t (Hubbard 1995, *Collision detection for interactive graphics applications*: space-time bounds).

use std::collections::BTreeMap;
use std::sync::Arc;

use clearance_geometry::math::Extremes;
use clearance_scene::World;
use serde::{Deserialize, Serialize};

/// Rounding of a displacement: a few operations.
const ROUNDING: f64 = 1e-14;

/// Limits on the motion of an obstacle whose path is not known.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SpeedLimit {
    /// Largest speed (m/s) of any of its points at the time at which its pose is known.
    pub speed: f64,
    /// Largest acceleration (m/s²) of any of its points afterwards.
    #[serde(default)]
    pub acceleration: f64,
}

/// Limits of all obstacles of a world.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ObstacleLimits {
    /// Limit of the obstacles without one of their own.
    #[serde(default)]
    pub default: SpeedLimit,
    /// Limits by name of the obstacle.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub by_name: BTreeMap<String, SpeedLimit>,
}

/// Reason why limits are not valid.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[allow(missing_docs, reason = "the message of each variant describes it and its fields")]
pub enum LimitError {
    #[error("the {what} limit of {} is {value}, but must be finite and not negative", of_obstacle(name.as_deref()))]
    Value { name: Option<String>, what: &'static str, value: f64 },
    #[error("there are two limits of {}", of_obstacle(.0.as_deref()))]
    Twice(Option<String>),
    #[error("within {time} s the motion of {} is larger than any number", of_obstacle(name.as_deref()))]
    Overflow { name: Option<String>, time: f64 },
    #[error("the poses of the obstacles are known from {} s to {} s: these must be finite, and in order", .0[0], .0[1])]
    Time([f64; 2]),
}

fn of_obstacle(name: Option<&str>) -> String {
    name.map_or_else(|| "all other obstacles".to_owned(), |name| format!("obstacle '{name}'"))
}

impl SpeedLimit {
    /// True if the obstacle stands.
    #[must_use]
    pub fn is_zero(&self) -> bool {
        *self == Self::default()
    }

    /// Upper bound (m) on the displacement of any point of the obstacle after a time (s).
    #[must_use]
    pub fn displacement(&self, time: f64) -> f64 {
        (self.speed * time + 0.5 * self.acceleration * time * time) * (1.0 + ROUNDING)
    }
}

impl ObstacleLimits {
    /// From limits by name; a limit without a name is for all obstacles without one of their own.
    ///
    /// # Errors
    /// If an obstacle has two limits, or a number is negative or not finite.
    pub fn from_list(
        list: impl IntoIterator<Item = (Option<String>, SpeedLimit)>,
    ) -> Result<Self, LimitError> {
        let (mut default, mut limits) = (None, Self::default());
        for (name, limit) in list {
            let before = match &name {
                None => default.replace(limit),
                Some(name) => limits.by_name.insert(name.clone(), limit),
            };
            if before.is_some() {
                return Err(LimitError::Twice(name));
            }
        }
        limits.default = default.unwrap_or_default();
        limits.check()?;
        Ok(limits)
    }

    /// The limit of an obstacle.
    #[must_use]
    pub fn of(&self, name: &str) -> SpeedLimit {
        self.by_name.get(name).copied().unwrap_or(self.default)
    }

    /// The limits relative to a frame that moves itself, within the limit `frame`.
    #[must_use]
    pub fn relative_to(&self, frame: SpeedLimit) -> Self {
        let faster = |limit: SpeedLimit| SpeedLimit {
            speed: limit.speed + frame.speed,
            acceleration: limit.acceleration + frame.acceleration,
        };
        let by_name = self.by_name.iter().map(|(name, limit)| (name.clone(), faster(*limit))).collect();
        Self { default: faster(self.default), by_name }
    }

    /// True if no obstacle may move.
    #[must_use]
    pub fn is_zero(&self) -> bool {
        self.all().all(SpeedLimit::is_zero)
    }

    fn all(&self) -> impl Iterator<Item = &SpeedLimit> {
        self.named().map(|(_, limit)| limit)
    }

    /// All limits, the one without a name last.
    fn named(&self) -> impl Iterator<Item = (Option<&String>, &SpeedLimit)> {
        self.by_name.iter().map(|(name, limit)| (Some(name), limit)).chain([(None, &self.default)])
    }

    /// Upper bound (m) on the displacement of any obstacle of a world after a time (s).
    #[must_use]
    pub fn largest_displacement(&self, world: &World, time: f64) -> f64 {
        let named = self.by_name.iter().filter(|(name, _)| world.id(name).is_some());
        let all = named.map(|(_, limit)| limit).chain([&self.default]);
        all.map(|limit| limit.displacement(time)).fold(0.0, f64::greater)
    }

    /// True if every motion that the other limits allow is allowed by these, too.
    #[must_use]
    pub fn cover(&self, other: &Self) -> bool {
        let allows = |limit: SpeedLimit, other: SpeedLimit| {
            limit.speed >= other.speed && limit.acceleration >= other.acceleration
        };
        let mut names = self.by_name.keys().chain(other.by_name.keys());
        allows(self.default, other.default) && names.all(|name| allows(self.of(name), other.of(name)))
    }

    /// Rejects limits that are negative or not finite.
    pub fn check(&self) -> Result<(), LimitError> {
        for (name, limit) in self.named() {
            for (what, value) in [("speed", limit.speed), ("acceleration", limit.acceleration)] {
                if !(value.is_finite() && value >= 0.0) {
                    return Err(LimitError::Value { name: name.cloned(), what, value });
                }
            }
        }
        Ok(())
    }
}

/// Limits of obstacles during a motion segment.
#[derive(Clone, Debug, PartialEq)]
pub struct ObstacleUncertainty {
    limits: Arc<ObstacleLimits>,
    /// Time (s) since the obstacles' poses were known, at t = 0 and at t = 1.
    time: [f64; 2],
}

/// File format of the limits during a segment.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct UncertaintyText {
    /// Time (s) since the obstacles' poses were known, at the start and at the end of the segment.
    pub time: [f64; 2],
    /// The limits.
    pub limits: ObstacleLimits,
}

impl ObstacleUncertainty {
    /// Limits during a segment, with the time (s) since the obstacles' poses were known, at its start and at its end.
    pub fn new(limits: Arc<ObstacleLimits>, time: [f64; 2]) -> Result<Self, LimitError> {
        limits.check()?;
        let [from, to] = time;
        if !(0.0 <= from && from <= to && to.is_finite()) {
            return Err(LimitError::Time(time));
        }
        if let Some((name, _)) = limits.named().find(|(_, limit)| !limit.displacement(to).is_finite()) {
            return Err(LimitError::Overflow { name: name.cloned(), time: to });
        }
        Ok(Self { limits, time })
    }

    /// Upper bound (m) on the unknown displacement of an obstacle at t, which never decreases with t.
    #[must_use]
    pub fn of(&self, name: &str, t: f64) -> f64 {
        self.limits.of(name).displacement(self.time_at(t))
    }

    /// Upper bound (m) on the unknown displacement of any obstacle of a world at t.
    #[must_use]
    pub fn largest(&self, world: &World, t: f64) -> f64 {
        self.limits.largest_displacement(world, self.time_at(t))
    }

    /// True if no obstacle can have moved.
    #[must_use]
    pub fn is_zero(&self) -> bool {
        self.limits.is_zero() || self.time[1] == 0.0
    }

    /// True if the limits are the same, and the poses of the obstacles became known no later than for the segment before.
    #[must_use]
    pub fn continues(&self, before: &Self) -> bool {
        self.limits == before.limits && self.time[0] >= before.time[1]
    }

    /// The limits between two values of t.
    pub(super) fn part(&self, t: [f64; 2]) -> Self {
        Self { limits: Arc::clone(&self.limits), time: t.map(|t| self.time_at(t)) }
    }

    /// As it stands in a file.
    pub(super) fn text(&self) -> UncertaintyText {
        UncertaintyText { time: self.time, limits: (*self.limits).clone() }
    }

    fn time_at(&self, t: f64) -> f64 {
        let [from, to] = self.time;
        // the end is exact, so that the next segment continues from it
        if t == 1.0 { to } else { from + t * (to - from) }
    }
}

impl TryFrom<UncertaintyText> for ObstacleUncertainty {
    type Error = LimitError;

    fn try_from(UncertaintyText { time, limits }: UncertaintyText) -> Result<Self, LimitError> {
        Self::new(Arc::new(limits), time)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use clearance_geometry::math::Pose;
    use clearance_geometry::testing::Random;
    use clearance_geometry::{Primitive, Shape};
    use clearance_scene::Obstacle;

    /// A point that starts at the speed limit, or slower, and accelerates by random accelerations within the limit.
    #[test]
    fn no_point_gets_farther_than_its_limits_allow() {
        let mut random = Random::new(77);
        for _ in 0..200 {
            let limit =
                SpeedLimit { speed: random.within(2.0).abs(), acceleration: random.within(5.0).abs() };
            let mut velocity = random.direction().into_inner() * limit.speed;
            let (mut way, step) = (velocity * 0.0, 1e-3);
            for i in 1..=500 {
                let acceleration = random.direction().into_inner() * limit.acceleration;
                way += velocity * step + acceleration * (0.5 * step * step);
                velocity += acceleration * step;
                assert!(way.norm() <= limit.displacement(f64::from(i) * step) + 1e-12);
            }
        }
    }

    #[test]
    fn parts_have_the_displacements_of_the_whole() {
        let by_name = [("cart".to_owned(), SpeedLimit { speed: 0.5, acceleration: 2.0 })].into();
        let limits = ObstacleLimits { default: SpeedLimit { speed: 1.6, acceleration: 0.0 }, by_name };
        let whole = ObstacleUncertainty::new(Arc::new(limits), [0.1, 2.1]).unwrap();
        let part = whole.part([0.25, 0.75]);
        assert!((whole.of("cart", 0.0) - (0.05 + 0.01)).abs() < 1e-12);
        assert!((whole.of("person", 1.0) - 1.6 * 2.1).abs() < 1e-12);
        for t in [0.0, 0.3, 1.0] {
            assert!((part.of("cart", t) - whole.of("cart", 0.25 + 0.5 * t)).abs() < 1e-12);
        }
        let mut world = World::default();
        assert!((whole.largest(&world, 1.0) - 1.6 * 2.1).abs() < 1e-12, "there is no cart");
        let shape = Shape::Primitive(Primitive::Sphere { radius: 0.1 });
        world.add(Obstacle::of_shape("cart", Pose::identity(), shape)).unwrap();
        assert!((whole.largest(&world, 1.0) - (0.5 * 2.1 + 2.1 * 2.1)).abs() < 1e-12, "the cart accelerates");
        assert_eq!(ObstacleUncertainty::try_from(whole.text()), Ok(whole));
    }

    #[test]
    fn limits_cover_what_is_slower() {
        let limits = |default: f64, cart: Option<f64>| {
            let of = |speed| SpeedLimit { speed, acceleration: 0.0 };
            let by_name = cart.map(|speed| ("cart".to_owned(), of(speed))).into_iter().collect();
            ObstacleLimits { default: of(default), by_name }
        };
        assert!(limits(1.0, None).cover(&limits(1.0, Some(0.5))));
        assert!(limits(1.0, Some(0.5)).cover(&limits(0.5, None)));
        assert!(!limits(1.0, Some(0.5)).cover(&limits(1.0, None)));
        assert!(!limits(1.0, None).cover(&limits(0.5, Some(2.0))));
    }

    #[test]
    fn invalid_limits_are_rejected_by_name() {
        let of = |speed| {
            let by_name = [("cart".to_owned(), SpeedLimit { speed, acceleration: 0.0 })].into();
            Arc::new(ObstacleLimits { by_name, ..ObstacleLimits::default() })
        };
        for bad in [-1.0, f64::NAN, f64::INFINITY] {
            let error = ObstacleUncertainty::new(of(bad), [0.0, 1.0]).unwrap_err().to_string();
            assert!(error.contains("speed limit of obstacle 'cart'"), "{error}");
        }
        for time in [[1.0, 0.5], [-0.1, 1.0], [0.0, f64::NAN], [0.0, f64::INFINITY]] {
            assert!(ObstacleUncertainty::new(of(1.0), time).is_err());
        }
    }
}
