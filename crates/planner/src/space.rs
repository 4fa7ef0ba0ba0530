//! State space of the planner: the positions that move, their ranges, random samples and distances.

use std::f64::consts::PI;

use clearance_robot::{Configuration, JointGroup, JointId, RobotModel};

use crate::options::PlanError;

/// The box of all states of a group within the limits, widened to the start and the goal where there is no limit.
#[derive(Clone, Debug)]
pub struct Space<'p> {
    /// The joints that move: those of the group that are not passive.
    group: JointGroup,
    start: &'p Configuration,
    goal: &'p Configuration,
    ranges: Vec<[f64; 2]>,
}

impl<'p> Space<'p> {
    pub fn new(
        robot: &RobotModel,
        group: &JointGroup,
        start: &'p Configuration,
        goal: &'p Configuration,
    ) -> Result<Self, PlanError> {
        let group = JointGroup::of_joints(robot, group.name(), &driven_joints(robot, group));
        if group.is_empty() {
            return Err(PlanError::EmptyGroup(group.name().to_owned()));
        }
        if let Some(joint) = group.joint_names().iter().find(|name| robot.joint_by_name(name).is_none()) {
            return Err(PlanError::SeveralPositions { joint: joint.clone(), group: group.name().to_owned() });
        }
        let moves = |index: &usize| group.positions().contains(index);
        let mut others = (0..start.positions().len()).filter(|index| !moves(index));
        if let Some(index) = others.find(|i| start.positions()[*i] != goal.positions()[*i]) {
            let joint = robot.position_names()[index].clone();
            if is_passive(robot, index) {
                return Err(PlanError::PassiveJoint { joint });
            }
            return Err(PlanError::OtherJoint { joint, group: group.name().to_owned() });
        }
        let space = Self { group, start, goal, ranges: Vec::new() };
        let ends = [space.of(start), space.of(goal)];
        for (end, positions) in ["start", "goal"].into_iter().zip(&ends) {
            space.check_limits(end, positions)?;
        }
        let range = |i: usize| {
            let (lower, upper) = (space.group.lower()[i], space.group.upper()[i]);
            let widened = |bound: f64, otherwise: f64| if bound.is_finite() { bound } else { otherwise };
            let [low, high] = [ends[0][i].min(ends[1][i]), ends[0][i].max(ends[1][i])];
            [widened(lower, low.min(-PI)), widened(upper, high.max(PI))]
        };
        let ranges = (0..space.group.len()).map(range).collect();
        Ok(Self { ranges, ..space })
    }

    fn check_limits(&self, end: &'static str, positions: &[f64]) -> Result<(), PlanError> {
        let limits = self.group.lower().iter().zip(self.group.upper());
        for ((joint, &value), (&lower, &upper)) in self.group.joint_names().iter().zip(positions).zip(limits)
        {
            if !(lower..=upper).contains(&value) {
                return Err(PlanError::BeyondLimits { end, joint: joint.clone(), value, lower, upper });
            }
        }
        Ok(())
    }

    pub fn start(&self) -> Vec<f64> {
        self.of(self.start)
    }

    pub fn goal(&self) -> Vec<f64> {
        self.of(self.goal)
    }

    fn of(&self, q: &Configuration) -> Vec<f64> {
        let mut positions = vec![0.0; self.group.len()];
        self.group.get(q, &mut positions);
        positions
    }

    /// The state of the whole robot.
    pub fn state(&self, positions: &[f64]) -> Configuration {
        let mut q = self.start.clone();
        self.group.set(&mut q, positions).expect("positions within the ranges are finite");
        q
    }

    /// A uniform sample.
    pub fn sample(&self, random: &mut fastrand::Rng) -> Vec<f64> {
        let within = |&[low, high]: &[f64; 2]| (low + (high - low) * random.f64()).clamp(low, high);
        self.ranges.iter().map(within).collect()
    }
}

/// The joints of a group that an actuator moves: all but the passive ones of the SRDF.
fn driven_joints(robot: &RobotModel, group: &JointGroup) -> Vec<JointId> {
    let is_in_group = |joint: &JointId| {
        robot.first_position(*joint).is_some_and(|first| group.positions().contains(&first))
    };
    robot.joint_ids().filter(is_in_group).filter(|joint| !robot.joint(*joint).passive).collect()
}

/// Whether a position is one of a passive joint.
fn is_passive(robot: &RobotModel, position: usize) -> bool {
    robot.joint_ids().filter(|joint| robot.joint(*joint).passive).any(|joint| {
        let count = robot.joint(joint).kind.position_suffixes().len();
        robot.first_position(joint).is_some_and(|first| (first..first + count).contains(&position))
    })
}

/// Square of the Euclidean distance (rad, m).
pub fn squared_distance(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum()
}

/// The state on the line between two, at t in 0 to 1; rounding does not leave the box of the two.
pub fn between(a: &[f64], b: &[f64], t: f64) -> Vec<f64> {
    let at = |(&a, &b): (&f64, &f64)| (a + t * (b - a)).max(a.min(b)).min(a.max(b));
    a.iter().zip(b).map(at).collect()
}
