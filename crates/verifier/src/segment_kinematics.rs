//! Kinematics of a segment: its rotations and translations, and their rates.

use clearance_geometry::math::{Point, Vector};
use clearance_motion::MotionSegment;
use clearance_robot::{JointId, JointKind, RobotModel};
use clearance_scene::World;

use super::Rejection;

/// A segment as steps: rotations about lines and translations along them.
#[derive(Debug)]
pub(super) struct SegmentKinematics {
    pub motion: MotionSegment,
    /// Steps of joints first, in the order of the tree; a planar joint has three, a floating one two.
    pub steps: Vec<Step>,
    /// By obstacle: its steps, or none if it does not move.
    obstacle_steps: Vec<Vec<usize>>,
    /// By obstacle: its index among the motion's moving obstacles.
    pub mover_of: Vec<Option<usize>>,
}

/// One rotation or translation.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Step {
    pub frame: AxisFrame,
    pub turns: bool,
    /// Unit vector in the axis frame; zero without motion.
    pub axis: Vector,
    /// Angle (rad) or length (m) as polynomial of t, the constant first.
    pub law: [f64; 6],
    /// Tolerance (rad, m) along the motion.
    pub tube: f64,
    /// Upper bound (rad, m) on the numbers that its value is computed from, before sums of them cancel.
    pub size: f64,
}

/// Frame of an axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum AxisFrame {
    /// The joint's frame in its parent; the line passes through the child's origin.
    Joint(JointId),
    /// The root's frame; the line passes through a point that moves at constant velocity.
    Obstacle { at: Point, linear: Vector },
}

/// Motion of a step within half an interval's width of its middle.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Rate {
    /// Velocity at the middle, per unit of t.
    pub velocity: f64,
    /// Maximum deviation from the value at the middle.
    pub most: f64,
    /// Maximum deviation from the motion at the velocity of the middle.
    pub bent: f64,
}

/// By link: indices of the steps between it and the root, the root's first. The same for every segment.
pub(super) fn link_paths(robot: &RobotModel) -> Vec<Vec<usize>> {
    let mut paths = vec![Vec::new(); robot.links().len()];
    let mut next = 0;
    for &id in robot.topological_order() {
        let joint = robot.joint(id);
        let mut path: Vec<usize> = paths[joint.parent.index()].clone();
        let count = step_count(&joint.kind);
        path.extend(next..next + count);
        next += count;
        paths[joint.child.index()] = path;
    }
    paths
}

fn step_count(kind: &JointKind) -> usize {
    match kind {
        JointKind::Fixed => 0,
        JointKind::Revolute(_) | JointKind::Continuous(_) | JointKind::Prismatic(_) => 1,
        JointKind::Floating => 2,
        JointKind::Planar(_) => 3,
    }
}

impl SegmentKinematics {
    pub fn new(
        robot: &RobotModel,
        world: &World,
        segment: usize,
        motion: MotionSegment,
    ) -> Result<Self, Rejection> {
        let laws = Laws::new(robot, &motion);
        let mut steps = Vec::new();
        for &id in robot.topological_order() {
            let before = steps.len();
            laws.add_joint(id, &mut steps);
            debug_assert_eq!(steps.len() - before, step_count(&robot.joint(id).kind));
        }
        let mut obstacle_steps = vec![Vec::new(); world.place_count()];
        let mut mover_of = vec![None; world.place_count()];
        for (number, mover) in motion.obstacles().iter().enumerate() {
            let name = || mover.name.clone();
            let Some(o) = world.id(&mover.name).map(|id| id.0 as usize) else {
                return Err(Rejection::UnknownObstacle { segment, name: name() });
            };
            if mover_of[o].replace(number).is_some() {
                return Err(Rejection::ObstacleTwice { segment, name: name() });
            }
            obstacle_steps[o] = vec![steps.len(), steps.len() + 1];
            let linear = Vector::from(mover.linear);
            let frame = AxisFrame::Obstacle { at: Point::from(mover.centre), linear };
            steps.push(Step::constant_speed(frame, false, linear));
            steps.push(Step::constant_speed(frame, true, Vector::from(mover.angular)));
        }
        Ok(Self { motion, steps, obstacle_steps, mover_of })
    }

    /// Indices of the steps between an obstacle and the root.
    pub fn obstacle_path(&self, obstacle: usize) -> &[usize] {
        &self.obstacle_steps[obstacle]
    }
}

impl Step {
    /// A rotation or translation at constant speed, given by the product of axis and speed.
    fn constant_speed(frame: AxisFrame, turns: bool, speed: Vector) -> Self {
        let axis = speed.try_normalize(0.0).unwrap_or_else(Vector::zeros);
        let size = speed.norm();
        Self { frame, turns, axis, law: [0.0, size, 0.0, 0.0, 0.0, 0.0], tube: 0.0, size }
    }

    /// By Taylor's theorem, which is exact for polynomials.
    pub fn rate(&self, middle: f64, half_width: f64) -> Rate {
        const BINOMIALS: [[f64; 6]; 6] = [
            [1.0, 1.0, 1.0, 1.0, 1.0, 1.0],
            [0.0, 1.0, 2.0, 3.0, 4.0, 5.0],
            [0.0, 0.0, 1.0, 3.0, 6.0, 10.0],
            [0.0, 0.0, 0.0, 1.0, 4.0, 10.0],
            [0.0, 0.0, 0.0, 0.0, 1.0, 5.0],
            [0.0, 0.0, 0.0, 0.0, 0.0, 1.0],
        ];
        // the j-th derivative over j!
        let taylor = |j: usize| (j..6).rev().fold(0.0, |sum, i| sum * middle + BINOMIALS[j][i] * self.law[i]);
        let velocity = taylor(1);
        let curved: f64 =
            (2..6).map(|j| taylor(j).abs() * half_width.powi(i32::try_from(j).unwrap_or(0))).sum();
        let bent = curved + self.tube;
        Rate { velocity, most: velocity.abs() * half_width + bent, bent }
    }
}

/// Positions of the robot by t.
struct Laws<'r> {
    robot: &'r RobotModel,
    motion: &'r MotionSegment,
    /// By position.
    polynomials: Vec<[f64; 6]>,
}

impl<'r> Laws<'r> {
    fn new(robot: &'r RobotModel, motion: &'r MotionSegment) -> Self {
        let text = motion.text();
        let polynomials = text.polynomials.unwrap_or_else(|| {
            let ends = text.from.unwrap_or_default().into_iter().zip(text.to.unwrap_or_default());
            ends.map(|(from, to)| [from, to - from, 0.0, 0.0, 0.0, 0.0]).collect()
        });
        Self { robot, motion, polynomials }
    }

    fn add_joint(&self, id: JointId, steps: &mut Vec<Step>) {
        let joint = self.robot.joint(id);
        let (driver, multiplier, offset) =
            joint.mimic.map_or((id, 1.0, 0.0), |m| (m.joint, m.multiplier, m.offset));
        let Some(first) = self.robot.first_position(driver) else { return };
        let frame = AxisFrame::Joint(id);
        let step = |turns: bool, axis: Vector, position: usize| Step {
            frame,
            turns,
            axis,
            law: self.polynomials[position].map(|c| multiplier * c),
            tube: multiplier.abs() * self.motion.tube().get(position).copied().unwrap_or(0.0),
            size: offset.abs()
                + self.polynomials[position].iter().map(|c| (multiplier * c).abs()).sum::<f64>(),
        };
        match &joint.kind {
            JointKind::Fixed => {}
            JointKind::Revolute(axis) | JointKind::Continuous(axis) => {
                steps.push(step(true, axis.into_inner(), first));
            }
            JointKind::Prismatic(axis) => steps.push(step(false, axis.into_inner(), first)),
            JointKind::Planar(normal) => {
                let shift = |x: f64, y: f64| joint.kind.motion(&[x, y, 0.0]).translation.vector;
                steps.push(step(false, shift(1.0, 0.0), first));
                steps.push(step(false, shift(0.0, 1.0), first + 1));
                steps.push(step(true, normal.into_inner(), first + 2));
            }
            JointKind::Floating => {
                // it translates and rotates at constant velocity: its motion until the middle determines it, and is never half a turn
                let [start, middle] =
                    [0.0, 0.5].map(|t| joint.kind.motion(&self.motion.at(t).positions()[first..]));
                let speed = |i: usize| self.polynomials[first + i][1];
                let turn = (middle.rotation * start.rotation.inverse()).scaled_axis() * 2.0;
                steps.push(Step::constant_speed(frame, false, Vector::new(speed(0), speed(1), speed(2))));
                steps.push(Step::constant_speed(frame, true, turn));
            }
        }
    }
}
