//! The joints between two links, as one chain from the first link to the second.

use std::f64::consts::PI;

use clearance_geometry::math::{MatrixPose, Point, Vector};
use clearance_robot::{JointId, JointKind, LinkId, RobotModel};

/// The relative pose of two links as a function of a few joint positions, the variables.
#[derive(Clone, Debug)]
pub struct JointPath {
    variables: Vec<Variable>,
    joints: Vec<PathJoint>,
    /// Pose of the second link in the frame behind the last joint.
    last: MatrixPose,
    is_bounded: bool,
}

/// One position of a configuration that moves the links relative to each other.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Variable {
    /// Index of the position in a configuration.
    pub position: usize,
    /// Least and largest value (rad, m). A joint that turns without limits has one whole turn.
    pub range: [f64; 2],
}

/// A joint of the path, which is `factor * variable + offset` along its axis.
#[derive(Clone, Copy, Debug)]
struct PathJoint {
    /// Pose of the joint frame in the frame behind the joint before.
    pose: MatrixPose,
    axis: Vector,
    turns: bool,
    variable: usize,
    factor: f64,
    offset: f64,
}

/// A joint axis at one state, in the frame of the first link.
#[derive(Clone, Copy, Debug)]
pub struct PlacedAxis {
    /// A point of the axis (m).
    pub origin: Point,
    /// Unit vector.
    pub axis: Vector,
    /// False for a translation along the axis.
    pub turns: bool,
    /// Index of the variable that moves it.
    pub variable: usize,
    /// Joint position per unit of the variable.
    pub factor: f64,
}

/// A path at one state.
#[derive(Clone, Debug)]
pub struct PlacedPath {
    /// Axes from the first link to the second.
    pub axes: Vec<PlacedAxis>,
    /// Pose of the second link in the frame of the first.
    pub pose_ab: MatrixPose,
}

impl JointPath {
    /// The path from link `a` to link `b`.
    #[must_use]
    pub fn new(robot: &RobotModel, a: LinkId, b: LinkId) -> Self {
        let (up, down) = joints_between(robot, a, b);
        let mut builder = Builder {
            robot,
            ranges: robot.position_ranges(),
            next: MatrixPose::identity(),
            path: Self {
                variables: Vec::new(),
                joints: Vec::new(),
                last: MatrixPose::identity(),
                is_bounded: true,
            },
        };
        for id in up {
            builder.add_motion(id, -1.0);
            builder.next = builder.next.compose(&MatrixPose::from(&robot.joint(id).pose_pj).inverse());
        }
        for id in down {
            builder.next = builder.next.compose(&MatrixPose::from(&robot.joint(id).pose_pj));
            builder.add_motion(id, 1.0);
        }
        Self { last: builder.next, ..builder.path }
    }

    /// Number of the path's variables, without the path.
    #[must_use]
    pub fn variable_count(robot: &RobotModel, a: LinkId, b: LinkId) -> usize {
        let (up, down) = joints_between(robot, a, b);
        let mut positions: Vec<usize> = (up.into_iter().chain(down))
            .filter(|id| has_one_axis(&robot.joint(*id).kind))
            .filter_map(|id| robot.first_position(robot.joint(id).mimic.map_or(id, |mimic| mimic.joint)))
            .collect();
        positions.sort_unstable();
        positions.dedup();
        positions.len()
    }

    /// The positions that move the links relative to each other.
    #[must_use]
    pub fn variables(&self) -> &[Variable] {
        &self.variables
    }

    /// False if a position has no finite range: nothing can be proven for all states.
    #[must_use]
    pub fn is_bounded(&self) -> bool {
        self.is_bounded
    }

    /// Memory for [`Self::place`].
    #[must_use]
    pub fn placed(&self) -> PlacedPath {
        PlacedPath { axes: Vec::with_capacity(self.joints.len()), pose_ab: MatrixPose::identity() }
    }

    /// Computes the axes and the relative pose for values of the variables.
    pub fn place(&self, values: &[f64], placed: &mut PlacedPath) {
        placed.axes.clear();
        let mut pose = MatrixPose::identity();
        for joint in &self.joints {
            pose = pose.compose(&joint.pose);
            let axis = pose.rotation * joint.axis;
            let origin = Point::from(pose.translation);
            let PathJoint { turns, variable, factor, .. } = *joint;
            placed.axes.push(PlacedAxis { origin, axis, turns, variable, factor });
            pose = pose.compose(&joint.motion(values[variable]));
        }
        placed.pose_ab = pose.compose(&self.last);
    }

    /// The largest joint position (rad, m) of any state, for rounding errors.
    #[must_use]
    pub fn size(&self) -> f64 {
        let of_joint = |joint: &PathJoint| {
            let [low, high] = self.variables[joint.variable].range;
            joint.factor.abs() * low.abs().max(high.abs()) + joint.offset.abs()
        };
        self.joints.iter().map(of_joint).fold(0.0, f64::max)
    }
}

impl PathJoint {
    fn motion(&self, value: f64) -> MatrixPose {
        let position = self.factor * value + self.offset;
        if self.turns {
            let rotation = nalgebra_rotation(&self.axis, position);
            MatrixPose { rotation, translation: Vector::zeros() }
        } else {
            MatrixPose { translation: self.axis * position, ..MatrixPose::identity() }
        }
    }
}

/// Rotation matrix about a unit axis (Rodrigues).
fn nalgebra_rotation(axis: &Vector, angle: f64) -> clearance_geometry::math::RotationMatrix {
    let (sin, cos) = angle.sin_cos();
    let cross = axis.cross_matrix();
    clearance_geometry::math::RotationMatrix::identity() + cross * sin + cross * cross * (1.0 - cos)
}

/// Joints from `a` up to the lowest common ancestor, and from there down to `b`.
fn joints_between(robot: &RobotModel, a: LinkId, b: LinkId) -> (Vec<JointId>, Vec<JointId>) {
    let to_root = |mut link: LinkId| {
        let mut joints = Vec::new();
        while let Some(joint) = robot.link(link).parent_joint {
            joints.push(joint);
            link = robot.joint(joint).parent;
        }
        joints
    };
    let (mut up, mut down) = (to_root(a), to_root(b));
    while let (Some(x), Some(y)) = (up.last(), down.last())
        && x == y
    {
        up.pop();
        down.pop();
    }
    down.reverse();
    (up, down)
}

fn has_one_axis(kind: &JointKind) -> bool {
    matches!(kind, JointKind::Revolute(_) | JointKind::Continuous(_) | JointKind::Prismatic(_))
}

struct Builder<'r> {
    robot: &'r RobotModel,
    ranges: Vec<[f64; 2]>,
    /// Pose of the present frame in the frame behind the last joint with motion.
    next: MatrixPose,
    path: JointPath,
}

impl Builder<'_> {
    /// Adds the motion of a joint, `sign` times.
    fn add_motion(&mut self, id: JointId, sign: f64) {
        let joint = self.robot.joint(id);
        let (driver, factor, offset) =
            joint.mimic.map_or((id, 1.0, 0.0), |m| (m.joint, m.multiplier, m.offset));
        let (turns, axis) = match &joint.kind {
            JointKind::Fixed => return,
            JointKind::Revolute(axis) | JointKind::Continuous(axis) => (true, axis.into_inner()),
            JointKind::Prismatic(axis) => (false, axis.into_inner()),
            JointKind::Planar(_) | JointKind::Floating => {
                self.path.is_bounded = false;
                return;
            }
        };
        let Some(position) = self.robot.first_position(driver) else { return };
        let variable = self.variable(position, driver);
        let pose = std::mem::replace(&mut self.next, MatrixPose::identity());
        let (factor, offset) = (sign * factor, sign * offset);
        self.path.joints.push(PathJoint { pose, axis, turns, variable, factor, offset });
    }

    fn variable(&mut self, position: usize, driver: JointId) -> usize {
        let known = self.path.variables.iter().position(|v| v.position == position);
        known.unwrap_or_else(|| {
            let range = self.range(position, driver);
            self.path.is_bounded &= range.iter().all(|bound| bound.is_finite());
            self.path.variables.push(Variable { position, range });
            self.path.variables.len() - 1
        })
    }

    /// The limits, or one whole turn if every pose recurs after a turn; infinite if there is no range in which a proof holds.
    ///
    /// Limits of followers do not narrow those of their leader: drivers and planners often respect the leader's only. They count where the
    /// leader has none.
    fn range(&self, position: usize, driver: JointId) -> [f64; 2] {
        let own = self.robot.joint(driver).limits.map(|limits| [limits.lower, limits.upper]);
        let [low, high] = own.unwrap_or(self.ranges[position]);
        if low.is_finite() && high.is_finite() {
            return if low <= high { [low, high] } else { [f64::NEG_INFINITY, f64::INFINITY] };
        }
        let recurs = matches!(self.robot.joint(driver).kind, JointKind::Continuous(_))
            && self.robot.moved_by_whole_turns(driver).is_none();
        if recurs { [-PI, PI] } else { [low, high] }
    }
}

#[cfg(test)]
mod tests {
    use clearance_robot::MeshFiles;

    use super::*;

    /// A branch with a follower, a sliding joint, a fixed one and one without an axis.
    const TREE: &str = r#"<robot name="tree">
  <link name="a"/><link name="b"/><link name="c"/><link name="d"/><link name="e"/>
  <joint name="ab" type="continuous"><parent link="a"/><child link="b"/><axis xyz="0 0 1"/></joint>
  <joint name="bc" type="prismatic">
    <parent link="b"/><child link="c"/><axis xyz="0 0 1"/><limit lower="0" upper="1" effort="1" velocity="1"/>
  </joint>
  <joint name="cd" type="continuous">
    <parent link="c"/><child link="d"/><axis xyz="1 0 0"/><mimic joint="ab" multiplier="2"/>
  </joint>
  <joint name="ae" type="floating"><parent link="a"/><child link="e"/></joint>
</robot>"#;

    #[test]
    fn variables_are_counted_without_the_path() {
        let robot = RobotModel::from_urdf(TREE, &MeshFiles::default()).unwrap();
        for a in robot.link_ids() {
            for b in robot.link_ids() {
                let path = JointPath::new(&robot, a, b);
                assert_eq!(JointPath::variable_count(&robot, a, b), path.variables().len());
            }
        }
        let [a, d] = ["a", "d"].map(|name| robot.link_ids().find(|id| robot.link(*id).name == name).unwrap());
        assert_eq!(JointPath::variable_count(&robot, a, d), 2);
    }
}
