//! Bounds that are summed along the joints of kinematic paths, for all parts at once.

use clearance_robot::PathsToRoot;

use super::robot_body::RobotBody;

/// Places of each part's kinematic paths in a list of the paths of all parts. A part has one path per number of joints,
/// from none up to all joints between it and the root.
#[derive(Clone, Debug)]
pub struct PathSums {
    /// By part: its first path, which has no joints.
    starts: Vec<usize>,
    /// By part: the path to the root, which matters for static obstacles.
    to_root: Vec<usize>,
    /// By part: the radius (m) around its body's origin that contains it.
    radii: Vec<f64>,
}

impl PathSums {
    pub fn new(paths_to_root: &PathsToRoot, parts: &[RobotBody]) -> Self {
        let (mut starts, mut to_root) = (Vec::new(), Vec::new());
        let mut next = 0;
        for robot_body in parts {
            let depth = paths_to_root.depth(robot_body.chain_body());
            starts.push(next);
            to_root.push(next + depth);
            next += depth + 1;
        }
        Self { starts, to_root, radii: parts.iter().map(RobotBody::radius_around_origin).collect() }
    }

    /// By part: the radius (m) around its body's origin that contains it.
    pub fn radii(&self) -> &[f64] {
        &self.radii
    }

    /// The value of the path with the first `joints` joints of a part.
    #[inline]
    pub fn of_joints(&self, values: &[f64], part: usize, joints: u32) -> f64 {
        values[self.starts[part] + joints as usize]
    }

    /// By part: the value of its path to the root.
    pub fn to_root<'s>(&'s self, values: &'s [f64]) -> impl Iterator<Item = f64> + 's {
        self.to_root.iter().map(|path| values[*path])
    }
}
