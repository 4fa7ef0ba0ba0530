//! Checks for sizes that suggest a wrong unit or scale, against the robot, visual geometry and adjacent links.

use clearance_geometry::Shape;
use clearance_geometry::math::{Extremes, Point};
use clearance_robot::{Collision, Link, MeshSource, RobotModel};

use crate::finding::{Check, Finding, GeometryKind, Severity};
use crate::link_geometry::{Numbered, PlacedShape, bounds_of, placed};

/// Ratios of units that are often confused, with their names: the larger number belongs to the smaller unit.
const UNIT_RATIOS: [(f64, &str); 4] = [
    (1000.0, "millimetres and metres"),
    (100.0, "centimetres and metres"),
    (39.37, "inches and metres"),
    (25.4, "millimetres and inches"),
];

/// Relative deviation of a ratio of sizes from a ratio of units.
const RATIO_TOLERANCE: f64 = 0.15;

/// Factor by which the ratio of extents along one axis may deviate from a ratio of units.
const AXIS_TOLERANCE: f64 = 1.5;

/// Ratio of the sizes of collision and visual geometry of a link above which one of them is probably wrong.
const LARGEST_RATIO: f64 = 10.0;

/// Size of a link, relative to the reach of the robot, above which its unit is probably wrong.
const LARGEST_PART: f64 = 30.0;

/// Reach (m) below which a robot gives no scale for its parts.
const LEAST_REACH: f64 = 0.01;

/// A link may be too large if it is this many times larger than its neighbours ...
const MANY_NEIGHBOURS: f64 = 15.0;
/// ... and than the reach of the robot.
const MANY_REACHES: f64 = 2.0;

/// A mesh may be too small if it is smaller than this (m) ...
const SMALL_MESH: f64 = 0.002;
/// ... and than this fraction of a neighbour.
const SMALL_FRACTION: f64 = 0.005;

/// Findings about the sizes of all links. `visuals` are those of a link, by its index.
pub(crate) fn size_findings<'v>(robot: &RobotModel, visuals: impl Fn(usize) -> Numbered<'v>) -> Vec<Finding> {
    let sizes: Vec<f64> = robot.links().iter().map(|link| size_of(&link.collisions)).collect();
    let reach = reach(robot);
    let mut findings = Vec::new();
    for (index, link) in robot.links().iter().enumerate() {
        findings.extend(against_reach(link, visuals(index), reach));
        findings.extend(against_visual(link, visuals(index).geometry));
        findings.extend(against_neighbours(link, &neighbour_sizes(robot, &sizes, index), reach));
    }
    findings
}

fn finding(severity: Severity, link: &Link, element: String, message: String) -> Finding {
    let check = if severity == Severity::Error { Check::WrongUnit } else { Check::UnlikelyScale };
    Finding { severity, check, link: link.name.clone(), element, mesh: None, point: None, message }
}

/// Sum of all joint offsets (m): an upper bound of the distance of two link frames while no prismatic joint moves.
fn reach(robot: &RobotModel) -> f64 {
    robot.joints().iter().map(|joint| joint.pose_pj.translation.vector.norm()).sum()
}

fn extents([low, high]: [Point; 2]) -> [f64; 3] {
    (high - low).into()
}

fn diagonal(extents: [f64; 3]) -> f64 {
    extents[0].hypot(extents[1]).hypot(extents[2])
}

/// Diagonal (m) of the box around geometry; 0 without geometry.
fn size_of(geometry: &[Collision]) -> f64 {
    bounds_of(&placed(geometry)).map_or(0.0, |bounds| diagonal(extents(bounds)))
}

/// Sizes of the next links with collision geometry towards the root and away from it.
fn neighbour_sizes(robot: &RobotModel, sizes: &[f64], index: usize) -> Vec<f64> {
    let parent = |link: usize| {
        let joint = robot.links()[link].parent_joint?;
        Some(robot.joint(joint).parent.index())
    };
    let next_with_geometry = |link: usize| {
        let mut above = parent(link);
        while let Some(link) = above.filter(|link| sizes[*link] == 0.0) {
            above = parent(link);
        }
        above
    };
    if sizes[index] == 0.0 {
        return Vec::new();
    }
    let below =
        (0..sizes.len()).filter(|link| sizes[*link] > 0.0 && next_with_geometry(*link) == Some(index));
    next_with_geometry(index).into_iter().chain(below).map(|link| sizes[link]).collect()
}

/// Parts that are much larger than the whole robot.
fn against_reach(link: &Link, visuals: Numbered, reach: f64) -> Vec<Finding> {
    let mut findings = Vec::new();
    let collisions = Numbered { geometry: &link.collisions, numbers: &[] };
    for (kind, list) in [(GeometryKind::Collision, collisions), (GeometryKind::Visual, visuals)] {
        for (number, collision) in list.elements() {
            let source = collision.mesh_source.as_ref();
            let Some(bounds) = PlacedShape::of(collision).and_then(|placed| placed.bounds()) else {
                continue;
            };
            let Some(message) = size_fault(diagonal(extents(bounds)), reach, source) else { continue };
            let mesh = source.map(|s| s.uri.clone());
            let element = format!("{} {number}", kind.name());
            findings.push(Finding { mesh, ..finding(Severity::Error, link, element, message) });
        }
    }
    findings
}

/// The reason why the size (m) of a part of a robot with this reach (m) is probably wrong.
fn size_fault(size: f64, reach: f64, source: Option<&MeshSource>) -> Option<String> {
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

/// Collision and visual geometry of very different sizes.
fn against_visual(link: &Link, visuals: &[Collision]) -> Option<Finding> {
    let [collision, visual] =
        [bounds_of(&placed(&link.collisions))?, bounds_of(&placed(visuals))?].map(extents);
    let [c, v] = [collision, visual].map(diagonal);
    let sizes = format!("collision geometry is {c:.4} m and visual geometry {v:.4} m large");
    if let Some((ratio, units)) = confused_units(collision, visual) {
        let message = format!(
            "{sizes}, a ratio of about {ratio}: {units} are probably confused; correct the scale of one mesh"
        );
        return Some(finding(Severity::Error, link, String::new(), message));
    }
    let is_far = c.greater(v) > LARGEST_RATIO * c.lesser(v);
    is_far.then(|| finding(Severity::Warning, link, String::new(), format!("{sizes}: check both scales")))
}

/// The units that are probably confused, if the extents (m) of collision and visual geometry differ by the ratio of two units.
fn confused_units(collision: [f64; 3], visual: [f64; 3]) -> Option<(f64, &'static str)> {
    let [small, large] =
        if diagonal(collision) < diagonal(visual) { [collision, visual] } else { [visual, collision] };
    if diagonal(small) <= 0.0 {
        return None;
    }
    let fits = |unit: f64| {
        // flat geometry has no ratio along its normal
        let is_flat = |i: usize| small[i] < 0.01 * diagonal(small) && large[i] < 0.01 * diagonal(large);
        let deviation = |i: usize| large[i] / small[i] / unit;
        let is_near = |i: usize| (AXIS_TOLERANCE.recip()..AXIS_TOLERANCE).contains(&deviation(i));
        (diagonal(large) / diagonal(small) / unit - 1.0).abs() <= RATIO_TOLERANCE
            && (0..3).all(|i| is_flat(i) || is_near(i))
    };
    UNIT_RATIOS.into_iter().find(|(unit, _)| fits(*unit))
}

/// A link whose collision geometry is much larger or much smaller than that of its neighbours.
fn against_neighbours(link: &Link, neighbours: &[f64], reach: f64) -> Option<Finding> {
    let size = size_of(&link.collisions);
    let largest = neighbours.iter().copied().fold(0.0, Extremes::greater);
    if largest == 0.0 {
        return None;
    }
    let is_mesh = link.collisions.iter().any(|c| matches!(c.shape, Shape::Mesh(_)));
    let is_large = size > MANY_NEIGHBOURS * largest && size > MANY_REACHES * reach && reach >= LEAST_REACH;
    let is_small = is_mesh && size < SMALL_MESH && size < SMALL_FRACTION * largest;
    // a part that is larger than the whole robot is an error already
    let is_error = size > LARGEST_PART * reach && is_large;
    let message = format!(
        "collision geometry is {size:.6} m large, but that of the links beside it at most {largest:.4} m: \
         check its unit and scale"
    );
    ((is_large && !is_error) || is_small).then(|| finding(Severity::Warning, link, String::new(), message))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ratios_of_units_are_recognised() {
        let cases = [(1000.0, 1.02, Some(1000.0)), (1.0, 39.0, Some(39.37)), (1.0, 25.0, Some(25.4))];
        let rest = [(1.0, 1.0, None), (2.0, 1.0, None), (5.0, 1.0, None), (0.0, 1.0, None)];
        for (collision, visual, expected) in cases.into_iter().chain(rest) {
            let found = confused_units([collision, 0.5 * collision, 0.0], [visual, 0.6 * visual, 0.0]);
            assert_eq!(found.map(|(ratio, _)| ratio), expected, "{collision} {visual}");
        }
        // a small marker in a large link has other proportions
        assert_eq!(confused_units([0.01, 0.01, 0.01], [0.1, 0.1, 0.98]), None);
    }

    #[test]
    fn a_part_larger_than_the_robot_is_reported() {
        assert!(size_fault(100.0, 1.0, None).unwrap().contains("100.000 m"));
        assert_eq!(size_fault(2.0, 1.0, None), None);
        assert_eq!(size_fault(2.0, 0.0, None), None);
    }
}
