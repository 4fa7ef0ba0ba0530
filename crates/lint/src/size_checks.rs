//! Sizes that suggest a wrong unit.

use clearance_geometry::math::{Extremes, Point};
use clearance_robot::{MeshSource, RobotModel};

/// Ratios of units that are often confused, with their names: the larger number belongs to the smaller unit.
const UNIT_RATIOS: [(f64, &str); 4] = [
    (1000.0, "millimetres and metres"),
    (100.0, "centimetres and metres"),
    (39.37, "inches and metres"),
    (25.4, "millimetres and inches"),
];

/// Relative deviation of a ratio of sizes from a ratio of units.
const RATIO_TOLERANCE: f64 = 0.15;

/// Size of a link, relative to the reach of the robot, above which its unit is probably wrong.
const LARGEST_PART: f64 = 30.0;

/// Reach (m) below which a robot gives no scale for its parts.
const LEAST_REACH: f64 = 0.01;

/// Diagonal (m) of a box.
pub(crate) fn diagonal([low, high]: [Point; 2]) -> f64 {
    (high - low).norm()
}

/// Sum of all joint offsets (m): an upper bound of the distance of two link frames while no prismatic joint moves.
pub(crate) fn reach(robot: &RobotModel) -> f64 {
    robot.joints().iter().map(|joint| joint.pose_pj.translation.vector.norm()).sum()
}

/// The units that are probably confused, if the sizes (m) of collision and visual geometry differ by the ratio of two units.
pub(crate) fn confused_units(collision: f64, visual: f64) -> Option<(f64, &'static str)> {
    let least = collision.lesser(visual);
    if least <= 0.0 {
        return None;
    }
    let ratio = collision.greater(visual) / least;
    UNIT_RATIOS.into_iter().find(|(unit, _)| (ratio / unit - 1.0).abs() <= RATIO_TOLERANCE)
}

/// What is probably wrong with the size (m) of a link of a robot with this reach (m).
pub(crate) fn size_fault(size: f64, reach: f64, source: Option<&MeshSource>) -> Option<String> {
    if reach < LEAST_REACH || size <= LARGEST_PART * reach {
        return None;
    }
    let is_unscaled = source.is_some_and(|s| s.scale.iter().all(|factor| *factor == 1.0));
    let advice = if is_unscaled {
        "it is probably in millimetres: add scale=\"0.001 0.001 0.001\""
    } else {
        "check its unit and scale"
    };
    Some(format!("is {size:.3} m large, but all joint offsets of the robot add up to {reach:.3} m; {advice}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ratios_of_units_are_recognised() {
        for (collision, visual, expected) in
            [(1000.0, 1.02, Some(1000.0)), (1.0, 39.0, Some(39.37)), (1.0, 25.0, Some(25.4))]
        {
            assert_eq!(confused_units(collision, visual).map(|(ratio, _)| ratio), expected);
        }
        for (collision, visual) in [(1.0, 1.0), (2.0, 1.0), (5.0, 1.0), (0.0, 1.0)] {
            assert_eq!(confused_units(collision, visual), None);
        }
    }

    #[test]
    fn a_part_larger_than_the_robot_is_reported() {
        assert!(size_fault(100.0, 1.0, None).unwrap().contains("100.000 m"));
        assert_eq!(size_fault(2.0, 1.0, None), None);
        assert_eq!(size_fault(2.0, 0.0, None), None);
    }
}
