//! Numbers that stand for names inside the program; text names live only at the edges.

/// A link of one [`RobotModel`](super::RobotModel): its index in the URDF's order.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct LinkId(pub u32);

/// A joint of one [`RobotModel`](super::RobotModel): its index in the URDF's order.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct JointId(pub u32);

impl LinkId {
    #[must_use]
    pub fn index(self) -> usize {
        self.0 as usize
    }
}

impl JointId {
    #[must_use]
    pub fn index(self) -> usize {
        self.0 as usize
    }
}
