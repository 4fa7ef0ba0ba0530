//! Poses of all bodies and joint axes at the middle of an interval, and how far each body reaches from each axis.

use clearance_geometry::math::{Extremes, MatrixPose, Point, Vector};
use clearance_robot::{LinkId, LinkPoses, RobotModel};

use super::body::Body;
use super::segment_kinematics::{AxisFrame, SegmentKinematics};

/// Rounding error (m) of kinematics and distances, per metre of the coordinates used and per radian.
const ROUNDING: f64 = 1e-14;

/// The robot and the obstacles at one t. Extents of bodies are computed once, at the first use.
#[derive(Debug)]
pub(super) struct IntervalMidpoint {
    pub t: f64,
    poses: LinkPoses,
    /// By step.
    lines: Vec<Line>,
    /// By body.
    bodies: Vec<Option<Placed>>,
    /// Largest coordinate (m) of any frame.
    farthest: f64,
    /// Largest angle of any joint, or number that it is computed from.
    radians: f64,
    /// No number that positions and displacements are computed from is larger: sums of them may cancel.
    size: f64,
}

/// The line of a step, in the root's frame: a point of it and its direction, of length one or zero.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Line {
    pub origin: Point,
    pub axis: Vector,
    pub turns: bool,
}

/// The link or moving obstacle that gives a body its pose.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum BodyCarrier {
    Link(LinkId),
    /// By its place.
    Obstacle(usize),
}

/// A body to be placed: its index, its carrier, and the indices of the steps that move it.
pub(super) struct BodyPlacement<'b> {
    pub index: usize,
    pub carrier: BodyCarrier,
    pub body: &'b Body,
    pub path: &'b [usize],
}

/// A body at its pose.
#[derive(Debug)]
pub(super) struct Placed {
    pub pose_rb: MatrixPose,
    /// Corners of its box, in the root's frame.
    pub corners: [Point; 8],
    /// By step of its path: the farthest that the box is from the line.
    pub reach: Vec<f64>,
    /// The same of the body itself.
    pub exact_reach: Option<Vec<f64>>,
}

impl Line {
    /// How far a point is from the line; 1 for what slides, as the derivation counts.
    fn reach(&self, corners: &[Point]) -> f64 {
        if !self.turns {
            return 1.0;
        }
        let squared = corners.iter().map(|p| self.axis.cross(&(p - self.origin)).norm_squared());
        squared.fold(0.0, f64::greater).sqrt()
    }
}

impl Placed {
    /// By step of a path: the farthest that the body's box is from the line.
    pub fn box_reach(&self, lines: &[Line], path: &[usize]) -> Vec<f64> {
        path.iter().map(|step| lines[*step].reach(&self.corners)).collect()
    }

    /// The same of the body itself.
    pub fn body_reach(&self, lines: &[Line], body: &Body, path: &[usize]) -> Vec<f64> {
        let back = self.pose_rb.inverse();
        let of_line = |line: &Line| {
            let (origin, axis) = (&back * line.origin, back.rotation * line.axis);
            let reach = |p: &Point| axis.cross(&(p - origin)).norm();
            if line.turns { body.greatest(1.0, reach) } else { 1.0 }
        };
        path.iter().map(|step| of_line(&lines[*step])).collect()
    }
}

impl IntervalMidpoint {
    pub fn new(robot: &RobotModel, bodies: usize) -> Self {
        Self {
            t: f64::NAN,
            poses: LinkPoses::new(robot),
            lines: Vec::new(),
            bodies: (0..bodies).map(|_| None).collect(),
            farthest: f64::NAN,
            radians: f64::NAN,
            size: f64::NAN,
        }
    }

    /// Goes to another t, or to another segment.
    pub fn go_to(&mut self, robot: &RobotModel, kinematics: &SegmentKinematics, t: f64) {
        self.t = t;
        self.size = kinematics.motion.size();
        self.bodies.fill_with(|| None);
        let q = kinematics.motion.at(t);
        robot.forward_kinematics(&q, &mut self.poses);
        let poses = &self.poses;
        self.lines.clear();
        self.lines.extend(kinematics.steps.iter().map(|step| {
            let (origin, axis) = match step.frame {
                AxisFrame::Joint(id) => {
                    let joint = robot.joint(id);
                    let rotation = poses.pose(joint.parent).rotation * joint.pose_pj.rotation;
                    (poses.pose(joint.child).translation.vector.into(), rotation * step.axis)
                }
                AxisFrame::Obstacle { at, linear } => (at + linear * t, step.axis),
            };
            Line { origin, axis, turns: step.turns }
        }));
        let origins = self.lines.iter().map(|line| line.origin.coords.amax());
        let links = robot.link_ids().map(|link| poses.pose(link).translation.vector.amax());
        self.farthest = origins.chain(links).fold(0.0, f64::greater);
        let angles = kinematics.steps.iter().filter(|step| step.turns).map(|step| step.size);
        self.radians = angles.fold(0.0, f64::greater);
    }

    /// Computes a body's pose and the extent of its box at the first use: the body is carried by a link, or is an obstacle.
    pub fn place(
        &mut self,
        kinematics: &SegmentKinematics,
        BodyPlacement { index, carrier, body, path }: BodyPlacement,
    ) {
        let Self { poses, lines, bodies, t, .. } = self;
        bodies[index].get_or_insert_with(|| {
            let pose_rb = match carrier {
                BodyCarrier::Link(link) => MatrixPose::from(poses.pose(link)),
                BodyCarrier::Obstacle(obstacle) => match kinematics.mover_of[obstacle] {
                    Some(mover) => kinematics.motion.obstacles()[mover].matrix(*t),
                    None => MatrixPose::identity(),
                },
            };
            let corners = body.box_corners().map(|p| &pose_rb * p);
            let mut placed = Placed { pose_rb, corners, reach: Vec::new(), exact_reach: None };
            placed.reach = placed.box_reach(lines, path);
            placed
        });
    }

    /// Computes the extent of a placed body itself, at the first use.
    pub fn measure(&mut self, index: usize, body: &Body, path: &[usize]) {
        let Self { lines, bodies, .. } = self;
        let Some(placed) = &mut bodies[index] else { return };
        if placed.exact_reach.is_none() {
            placed.exact_reach = Some(placed.body_reach(lines, body, path));
        }
    }

    /// A body that was placed.
    pub fn placed(&self, index: usize) -> &Placed {
        self.bodies[index].as_ref().expect("bodies are placed before they are looked at")
    }

    pub fn lines(&self) -> &[Line] {
        &self.lines
    }

    /// Rounding error (m) of f64 in the distance of two placed bodies.
    pub fn rounding(&self, bodies: [usize; 2]) -> f64 {
        let extent =
            |index: usize| self.placed(index).corners.iter().map(|p| p.coords.amax()).fold(0.0, f64::greater);
        let reach = self.farthest + extent(bodies[0]) + extent(bodies[1]);
        ROUNDING * ((10.0 + self.radians) * reach + 10.0 * self.size)
    }
}
