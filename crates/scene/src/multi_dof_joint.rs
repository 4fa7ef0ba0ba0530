//! Finds the URDF joint or the virtual joint that a transform of `sensor_msgs/MultiDOFJointState` belongs to.
//!
//! A joint of the URDF has priority. A virtual joint of the SRDF places the root link in a frame outside of the robot. As in MoveIt, the
//! first virtual joint with the root as child link places the root; others have no effect on poses.

use clearance_robot::{RobotModel, VirtualJoint};

/// The meaning of a joint name in a `sensor_msgs/MultiDOFJointState`; neither field is set for an unknown name.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MultiDofJoint<'r> {
    /// True if the URDF has a joint of this name: the transform gives its positions.
    pub is_of_model: bool,
    /// Set if the SRDF has a virtual joint of this name.
    pub virtual_joint: Option<VirtualJointRole<'r>>,
}

/// Effect of a virtual joint.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum VirtualJointRole<'r> {
    /// It places the root in its parent frame.
    PlacesRoot(&'r VirtualJoint),
    /// Its child link is the root, but another virtual joint places the root.
    OtherOfRoot {
        /// The virtual joint that places the root.
        first: &'r VirtualJoint,
    },
    /// Its child link is not the root.
    OfOtherLink,
}

impl<'r> MultiDofJoint<'r> {
    /// Looks up a joint name.
    #[must_use]
    pub fn find(robot: &'r RobotModel, name: &str) -> Self {
        let virtual_joints = || robot.srdf().into_iter().flat_map(|srdf| &srdf.virtual_joints);
        let mut of_root = virtual_joints().filter(|joint| joint.child_link == robot.root());
        let virtual_joint = match of_root.next() {
            Some(first) if first.name == name => Some(VirtualJointRole::PlacesRoot(first)),
            Some(first) if of_root.any(|other| other.name == name) => {
                Some(VirtualJointRole::OtherOfRoot { first })
            }
            _ => virtual_joints().any(|joint| joint.name == name).then_some(VirtualJointRole::OfOtherLink),
        };
        Self { is_of_model: robot.joint_by_name(name).is_some(), virtual_joint }
    }

    /// The virtual joint, if it places the root.
    #[must_use]
    pub fn placement_of_root(&self) -> Option<&'r VirtualJoint> {
        match self.virtual_joint {
            Some(VirtualJointRole::PlacesRoot(joint)) => Some(joint),
            _ => None,
        }
    }

    /// True for a virtual joint that is not also a joint of the URDF. A robot state that does not place the robot in the world accepts
    /// only the identity for it.
    #[must_use]
    pub fn is_only_virtual(&self) -> bool {
        !self.is_of_model && self.virtual_joint.is_some()
    }
}
