//! Joints between two links of a collision matrix, and the range of each of their positions.

use std::f64::consts::PI;

use clearance_geometry::math::{MatrixPose, Point, Pose, Vector};
use clearance_robot::{JointId, JointKind, LinkId, RobotModel};

/// Joints from one link up to the lowest common ancestor of two, and from there down to the other.
#[derive(Debug)]
pub(super) struct MatrixPath<'r> {
    robot: &'r RobotModel,
    /// From the first link to the ancestor.
    up: Vec<JointId>,
    /// From the ancestor to the second link.
    down: Vec<JointId>,
    /// Positions in the configuration, in the order of the joints from the first link to the second.
    positions: Vec<usize>,
    /// By variable: least and largest value (rad, m).
    pub ranges: Vec<[f64; 2]>,
}

/// A joint axis in the frame of the ancestor.
#[derive(Clone, Copy, Debug)]
pub(super) struct MatrixAxis {
    pub origin: Point,
    pub direction: Vector,
    pub turns: bool,
    pub variable: usize,
    /// Absolute value of the joint position per unit of the variable.
    pub rate: f64,
}

/// Both links and all axes between them at one state, in the frame of their ancestor.
#[derive(Debug, Default)]
pub(super) struct MatrixState {
    /// From the first link to the second.
    pub axes: Vec<MatrixAxis>,
    pub poses: [Pose; 2],
    /// Largest number that positions are computed from (rad, m).
    pub size: f64,
}

impl<'r> MatrixPath<'r> {
    /// `None` if a joint on the path has no finite range.
    pub fn new(robot: &'r RobotModel, [a, b]: [LinkId; 2]) -> Option<Self> {
        let ancestors = |link: LinkId| {
            let above = |link: &LinkId| robot.link(*link).parent_joint.map(|joint| robot.joint(joint).parent);
            std::iter::successors(Some(link), above).collect::<Vec<_>>()
        };
        let of_a = ancestors(a);
        let common = ancestors(b).into_iter().find(|link| of_a.contains(link))?;
        let joints = |link: LinkId| -> Vec<JointId> {
            let below = ancestors(link).into_iter().take_while(|link| *link != common);
            below.filter_map(|link| robot.link(link).parent_joint).collect()
        };
        let (up, mut down) = (joints(a), joints(b));
        down.reverse();
        let mut path = Self { robot, up, down, positions: Vec::new(), ranges: Vec::new() };
        let limits = robot.position_ranges();
        for id in path.up.iter().chain(&path.down) {
            let joint = robot.joint(*id);
            let leader = joint.mimic.map_or(*id, |mimic| mimic.joint);
            match joint.kind {
                JointKind::Fixed => continue,
                JointKind::Planar(_) | JointKind::Floating => return None,
                JointKind::Revolute(_) | JointKind::Continuous(_) | JointKind::Prismatic(_) => {}
            }
            let Some(position) = robot.first_position(leader) else { continue };
            if !path.positions.contains(&position) {
                path.positions.push(position);
                path.ranges.push(range(robot, leader, limits[position])?);
            }
        }
        Some(path)
    }

    /// The state with these values of the variables.
    pub fn state(&self, values: &[f64]) -> MatrixState {
        let mut state = MatrixState::default();
        let mut of_first = Vec::new();
        state.poses[0] = self.walk(self.up.iter().rev(), values, &mut of_first, &mut state.size);
        of_first.reverse();
        state.axes = of_first;
        let mut of_second = Vec::new();
        state.poses[1] = self.walk(self.down.iter(), values, &mut of_second, &mut state.size);
        state.axes.append(&mut of_second);
        state
    }

    /// The pose at the end of joints that follow each other from the ancestor on, and the axes of these joints.
    fn walk<'j>(
        &self,
        joints: impl Iterator<Item = &'j JointId>,
        values: &[f64],
        axes: &mut Vec<MatrixAxis>,
        size: &mut f64,
    ) -> Pose {
        let mut pose = Pose::identity();
        for id in joints {
            let joint = self.robot.joint(*id);
            pose *= joint.pose_pj;
            let (leader, multiplier, offset) =
                joint.mimic.map_or((*id, 1.0, 0.0), |m| (m.joint, m.multiplier, m.offset));
            let (turns, axis) = match &joint.kind {
                JointKind::Revolute(axis) | JointKind::Continuous(axis) => (true, axis),
                JointKind::Prismatic(axis) => (false, axis),
                JointKind::Fixed | JointKind::Planar(_) | JointKind::Floating => continue,
            };
            let position = self.robot.first_position(leader);
            let Some(variable) = self.positions.iter().position(|p| Some(*p) == position) else { continue };
            axes.push(MatrixAxis {
                origin: Point::from(pose.translation.vector),
                direction: pose.rotation * axis.into_inner(),
                turns,
                variable,
                rate: multiplier.abs(),
            });
            let product = multiplier * values[variable];
            let numbers = product.abs() + offset.abs();
            if numbers > *size {
                *size = numbers;
            }
            pose *= joint.kind.motion(&[product + offset]);
            pose.rotation.renormalize();
        }
        pose
    }
}

impl MatrixState {
    /// Pose of the second link in the frame of the first.
    pub fn pose_ab(&self) -> MatrixPose {
        MatrixPose::from(&self.poses[0]).relative(&MatrixPose::from(&self.poses[1]))
    }
}

/// The leader's own limits; where it has none those of its followers, or one whole turn where every pose recurs after it.
fn range(robot: &RobotModel, leader: JointId, of_followers: [f64; 2]) -> Option<[f64; 2]> {
    let own = robot.joint(leader).limits.map(|limits| [limits.lower, limits.upper]);
    let [low, high] = own.unwrap_or(of_followers);
    if low.is_finite() && high.is_finite() {
        return (low <= high).then_some([low, high]);
    }
    let recurs = matches!(robot.joint(leader).kind, JointKind::Continuous(_))
        && robot.moved_by_whole_turns(leader).is_none();
    recurs.then_some([-PI, PI])
}
