//! Reach of the robot: capsules around its bodies, and upper bounds on the distance of its points from the root.

use std::ops::RangeInclusive;

use clearance_geometry::math::{Extremes, MatrixPose};
use clearance_robot::{LinkPoses, Reach, ReachableRegion};

use super::robot_body::RobotBody;
use super::robot_geometry::RobotGeometry;

/// Capsule around a body of the robot (root frame), without padding.
pub fn bounding_capsule(robot_body: &RobotBody, poses: &LinkPoses) -> Reach {
    let pose_rb = poses.pose(robot_body.link()) * robot_body.pose_bl().inverse();
    robot_body.reach_at(&MatrixPose::from(&pose_rb))
}

/// Upper bound (m) on the distance of any point of the robot and its attached objects from its root, padding included.
pub fn extent(robot: &RobotGeometry, poses: &LinkPoses) -> f64 {
    let of_part = |robot_body: &RobotBody| {
        let Reach { ends, radius } = bounding_capsule(robot_body, poses);
        ends[0].norm().greater(ends[1].norm()) + radius + robot_body.padding()
    };
    robot.parts().iter().map(of_part).fold(0.0, f64::greater)
}

/// Upper bound (m) on [`extent`] in all states in which sliding positions are in their ranges (m); infinite where there is
/// none.
pub fn largest_extent(robot: &RobotGeometry, range_of: impl Fn(usize) -> Option<RangeInclusive<f64>>) -> f64 {
    let regions = robot.chain().territories(range_of);
    let of_part = |robot_body: &RobotBody| {
        let Reach { ends, radius } = robot_body.reach_at(&MatrixPose::identity());
        let ReachableRegion { centre, radius: reached } = regions[robot_body.chain_body()];
        centre.norm() + reached + ends[0].norm().greater(ends[1].norm()) + radius + robot_body.padding()
    };
    robot.parts().iter().map(of_part).fold(0.0, f64::greater)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random_scenes::{checker, state};
    use clearance_geometry::testing::Random;

    /// No state within the ranges of sliding joints has a larger extent.
    #[test]
    fn no_state_reaches_beyond_the_largest_extent() {
        let mut random = Random::new(8);
        for _ in 0..100 {
            let checker = checker(&mut random);
            let robot = checker.robot();
            let mut poses = LinkPoses::new(robot);
            let states: Vec<_> = (0..20).map(|_| state(robot, &mut random)).collect();
            let range_of = |position: usize| {
                let all = states.iter().map(|q| q.positions()[position]);
                Some(all.clone().fold(f64::INFINITY, f64::min)..=all.fold(f64::NEG_INFINITY, f64::max))
            };
            let largest = checker.largest_extent(range_of);
            for q in &states {
                robot.forward_kinematics(q, &mut poses);
                let extent = checker.extent(&poses);
                assert!(extent <= largest + 1e-9, "{extent} {largest}");
            }
        }
    }
}
