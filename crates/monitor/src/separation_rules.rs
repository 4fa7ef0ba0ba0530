//! Rules of speed and separation monitoring: which obstacles are monitored, and with which settings.

use clearance_geometry::math::Extremes;

use super::separation_settings::SeparationSettings;

/// Settings of speed and separation monitoring, by obstacle.
#[derive(Clone, Debug, PartialEq)]
pub struct SeparationRules {
    /// Settings for all other obstacles: each of them may be a person.
    pub usual: SeparationSettings,
    /// Names of obstacles that rest, and to which [`SpeedDistances`](crate::SpeedDistances) apply. A `*` at the end stands
    /// for any text.
    pub resting_obstacles: Vec<String>,
    /// Speeds (m/s) at which single obstacles may approach, by names of the same form. The highest one of an obstacle counts,
    /// also if it is among those that rest.
    pub obstacle_speeds: Vec<(String, f64)>,
}

impl SeparationRules {
    /// The same settings for all obstacles.
    #[must_use]
    pub fn of_all(usual: SeparationSettings) -> Self {
        Self { usual, resting_obstacles: Vec::new(), obstacle_speeds: Vec::new() }
    }

    /// The settings for an obstacle; `None` if it rests.
    #[must_use]
    pub fn of(&self, obstacle: &str) -> Option<SeparationSettings> {
        let speeds = self.obstacle_speeds.iter().filter(|(name, _)| matches(name, obstacle));
        match speeds.map(|(_, speed)| *speed).reduce(f64::greater) {
            Some(human_speed) => Some(SeparationSettings { human_speed, ..self.usual }),
            None if self.resting_obstacles.iter().any(|name| matches(name, obstacle)) => None,
            None => Some(self.usual),
        }
    }

    /// The settings for an obstacle whose speed (m/s) was measured: it counts if it is higher. What moves does not rest.
    pub(super) fn of_measured(&self, obstacle: &str, speed: Option<f64>) -> Option<SeparationSettings> {
        let settings = self.of(obstacle);
        let Some(speed) = speed else { return settings };
        let human_speed = settings.map_or(0.0, |settings| settings.human_speed).greater(speed);
        Some(SeparationSettings { human_speed, ..self.usual })
    }

    /// The names with a speed of which no obstacle exists; `exists` tells whether any obstacle has a name that matches.
    pub(super) fn speeds_without_effect(
        &self,
        exists: impl Fn(&dyn Fn(&str) -> bool) -> bool,
    ) -> Vec<String> {
        let names = self.obstacle_speeds.iter().map(|(name, _)| name);
        names.filter(|name| !exists(&|obstacle| matches(name, obstacle))).cloned().collect()
    }

    /// Distance (m) from which the robot may move at its full speed, beside any obstacle.
    #[must_use]
    pub fn range(&self) -> f64 {
        self.range_of_measured(0.0, 0.0)
    }

    /// The same, if no obstacle was measured to be faster than `of_obstacles` (m/s), and no point of the robot than `of_robot`.
    pub(super) fn range_of_measured(&self, of_obstacles: f64, of_robot: f64) -> f64 {
        let speeds = self.obstacle_speeds.iter().map(|(_, speed)| *speed);
        let human_speed = speeds.fold(self.usual.human_speed.greater(of_obstacles), f64::greater);
        let robot_speed = self.usual.robot_speed.greater(of_robot);
        SeparationSettings { human_speed, robot_speed, ..self.usual }.range()
    }
}

impl From<SeparationSettings> for SeparationRules {
    fn from(usual: SeparationSettings) -> Self {
        Self::of_all(usual)
    }
}

fn matches(name: &str, obstacle: &str) -> bool {
    match name.strip_suffix('*') {
        Some(beginning) => obstacle.starts_with(beginning),
        None => obstacle == name,
    }
}

#[cfg(test)]
mod tests {
    #![expect(clippy::float_cmp, reason = "speeds are passed on as they are")]

    use super::*;
    use crate::separation_settings::tests::CELL;

    #[test]
    fn names_may_end_in_a_star() {
        let resting_obstacles = vec!["table".into(), "wall_*".into()];
        let named = SeparationRules { resting_obstacles, ..SeparationRules::of_all(CELL) };
        for (name, rests) in
            [("table", true), ("table2", false), ("wall_", true), ("wall_north", true), ("wall", false)]
        {
            assert_eq!(named.of(name).is_none(), rests, "{name}");
        }
        assert_eq!(SeparationRules::of_all(CELL).of("table"), Some(CELL));
    }

    #[test]
    fn the_highest_speed_of_an_obstacle_counts() {
        let rules = SeparationRules {
            usual: CELL,
            resting_obstacles: vec!["cart_*".into()],
            obstacle_speeds: vec![("cart_*".into(), 0.5), ("cart_7".into(), 2.0), ("cart_7*".into(), 1.0)],
        };
        let speed = |name: &str| rules.of(name).unwrap().human_speed;
        assert_eq!([speed("cart_1"), speed("cart_7"), speed("cart_71"), speed("anna")], [0.5, 2.0, 1.0, 1.6]);
        assert_eq!(rules.range(), SeparationSettings { human_speed: 2.0, ..CELL }.range());
        assert!(rules.range() > CELL.range());
        let measured = |name: &str, speed| rules.of_measured(name, Some(speed)).unwrap().human_speed;
        assert_eq!(
            [measured("cart_1", 0.4), measured("cart_1", 0.6), measured("anna", 1.0)],
            [0.5, 0.6, 1.6]
        );
        let slow = rules.range_of_measured(1.0, CELL.robot_speed);
        assert!(slow == rules.range() && rules.range_of_measured(3.0, 0.0) > rules.range());
        let robot_speed = 2.0 * CELL.robot_speed;
        let fast = SeparationSettings { human_speed: 2.0, robot_speed, ..CELL };
        assert_eq!(rules.range_of_measured(0.0, robot_speed), fast.range());
    }
}
