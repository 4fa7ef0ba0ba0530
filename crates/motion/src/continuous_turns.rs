//! Lists the continuous joints that rotate in a trajectory, and warns of rotations by half a turn or more.

use std::f64::consts::PI;

use clearance_robot::{Configuration, Mimic, RobotModel};

use super::{MotionSegment, Trajectory};

/// Deviation (rad) from half a turn within which a controller, which measures the start itself, may select the other direction.
const HALF_TURN_DOUBT: f64 = 1e-3;

/// A continuous joint, or the angle of a planar joint, that rotates in a motion, with its positions (rad) at the start and the end; the proof covers all positions in
/// between.
#[derive(Clone, Debug, PartialEq)]
pub struct ContinuousTurn {
    /// Name of the joint, or of the angle's position.
    pub joint: String,
    /// Position (rad) at the start.
    pub from: f64,
    /// Position (rad) at the end.
    pub to: f64,
}

/// A continuous joint, which may be a mimic joint: its position is `multiplier · q[index] + offset`.
struct Turning<'r> {
    name: &'r str,
    index: usize,
    multiplier: f64,
    offset: f64,
}

impl Turning<'_> {
    fn position(&self, q: &Configuration) -> f64 {
        self.multiplier * q.positions()[self.index] + self.offset
    }

    /// True if it rotates so far in a straight segment that the other direction is shorter, or about as short.
    fn is_long(&self, segment: &MotionSegment) -> bool {
        let turn = self.multiplier.abs() * segment.top_speed(self.index);
        segment.is_straight() && turn > PI - HALF_TURN_DOUBT
    }
}

/// All continuous joints, mimic joints included, and the angles of planar joints.
fn turning(robot: &RobotModel) -> impl Iterator<Item = Turning<'_>> {
    let joints = robot.joint_ids().map(|id| (id, robot.joint(id)));
    joints.filter_map(|(id, joint)| {
        let angle = joint.kind.unlimited_angle()?;
        let Some(Mimic { joint: leader, multiplier, offset }) = joint.mimic else {
            let index = robot.first_position(id)? + angle;
            return Some(Turning {
                name: &robot.position_names()[index],
                index,
                multiplier: 1.0,
                offset: 0.0,
            });
        };
        Some(Turning { name: &joint.name, index: robot.first_position(leader)?, multiplier, offset })
    })
}

impl Trajectory {
    /// The continuous joints that rotate, with their positions at the start and at the end.
    #[must_use]
    pub fn continuous_turns(&self, robot: &RobotModel) -> Vec<ContinuousTurn> {
        let (Some(first), Some(last)) = (self.segments().first(), self.segments().last()) else {
            return Vec::new();
        };
        let (start, end) = (first.at(0.0), last.at(1.0));
        let moves = |index: usize| self.segments().iter().any(|segment| segment.top_speed(index) > 0.0);
        (turning(robot).filter(|joint| joint.multiplier != 0.0 && moves(joint.index)))
            .map(|joint| ContinuousTurn {
                joint: joint.name.to_owned(),
                from: joint.position(&start),
                to: joint.position(&end),
            })
            .collect()
    }

    /// A warning about straight segments in which a continuous joint rotates by half a turn or more, where a controller may rotate it by
    /// less.
    #[must_use]
    pub fn long_turn_note(&self, robot: &RobotModel) -> Option<String> {
        let joints: Vec<Turning> = turning(robot).collect();
        let long_in = |segment: &MotionSegment| joints.iter().find(|joint| joint.is_long(segment));
        let mut long = (self.segments().iter().enumerate())
            .filter_map(|(number, segment)| Some((number, segment, long_in(segment)?)));
        let (number, segment, joint) = long.next()?;
        let which = if self.segments().len() > 1 { format!("segment {number}: ") } else { String::new() };
        let others = match long.count() {
            0 => String::new(),
            others => format!(", and so in {others} more segments"),
        };
        let [from, to] = segment.ends().map(|end| joint.position(&end));
        let name = joint.name;
        let size =
            if (to - from).abs() > PI + HALF_TURN_DOUBT { "more than half a turn" } else { "half a turn" };
        Some(format!(
            "{which}continuous joint '{name}' turns by {size}, from {from} to {to}{others}: a controller that goes the shortest way may go the other way round"
        ))
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;
    use crate::continuous_direction::tests::robot;

    #[test]
    fn long_turns_are_reported() {
        let robot = robot("fixed", 0.0);
        let straight = |from: [f64; 2], to: [f64; 2]| {
            let [from, to] = [from, to].map(|q| robot.configuration(&q).unwrap());
            MotionSegment::straight(&robot, &from, &to)
        };
        let note = |segments| Trajectory::of_segments(segments).unwrap().long_turn_note(&robot);
        assert_eq!(note(vec![straight([0.0, -3.0], [3.0, 3.0])]), None);
        let words = note(vec![straight([3.0, 0.0], [-3.0, 0.0])]).unwrap();
        assert!(words.contains("'wheel' turns by more than half a turn, from 3 to -3:"), "{words}");
        assert!(note(vec![straight([0.0, 0.0], [PI, 0.0])]).unwrap().contains("by half a turn, from 0 to"));
        let words = note(vec![
            straight([0.0, 0.0], [3.0, 0.0]),
            straight([3.0, 0.0], [-3.0, 0.0]),
            straight([-3.0, 0.0], [3.0, 0.0]),
        ]);
        let words = words.unwrap();
        assert!(words.starts_with("segment 1: ") && words.contains("in 1 more"), "{words}");
    }

    #[test]
    fn continuous_joints_that_mimic_another_one_turn_as_well() {
        let robot = robot("continuous", -2.0);
        let [from, to] = [[0.0, 0.0], [2.0, 0.0]].map(|q| robot.configuration(&q).unwrap());
        let way = Trajectory::of_segments(vec![MotionSegment::straight(&robot, &from, &to)]).unwrap();
        let words = way.long_turn_note(&robot).unwrap();
        assert!(words.contains("'k' turns by more than half a turn, from 0 to -4:"), "{words}");
        let turns = way.continuous_turns(&robot);
        assert_eq!(
            turns.iter().map(|turn| (turn.joint.as_str(), turn.to)).collect::<Vec<_>>(),
            [("wheel", 2.0), ("k", -4.0)]
        );
    }
}
