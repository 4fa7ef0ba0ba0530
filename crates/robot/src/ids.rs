//! Indices that identify links and joints inside the library; names are used only in input and output.

/// A link of one `RobotModel`: its index in the URDF's order.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct LinkId(pub u32);

/// A joint of one `RobotModel`: its index in the URDF's order.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct JointId(pub u32);

impl LinkId {
    /// The index, from 0.
    #[must_use]
    pub fn index(self) -> usize {
        self.0 as usize
    }
}

impl JointId {
    /// The index, from 0.
    #[must_use]
    pub fn index(self) -> usize {
        self.0 as usize
    }
}
