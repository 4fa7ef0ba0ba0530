//! What messages say about the world, applied to it: obstacles, attached objects, allowed contacts, paddings and frames, with the
//! meaning that `moveit_msgs` gives them. No I/O and no ROS types; an object or field that is refused changes nothing.
//!
//! | what comes | what it does |
//! |---|---|
//! | [`ObjectChange`] | adds, replaces, extends, moves or removes one obstacle, or removes all |
//! | [`AttachedChange`] | lets a link take an object up, or put it down where it is |
//! | [`WorldChange`] | takes the place of all obstacles |
//! | [`SceneChange`] | a whole scene takes the place of everything; a difference changes what it names |
//!
//! Where it departs from `MoveIt`, on purpose: a whole scene without allowed collision matrix goes back to what the SRDF says; a name that
//! cannot be resolved is refused, never taken for another one.

mod anchors;
mod attached;
mod change;
mod frames;
mod gaps;
mod ineffective;
mod objects;
mod refusal;
mod scenes;
mod state;
#[cfg(test)]
mod tests;
mod transform_tree;
mod way;

pub use anchors::Grounds;
pub(super) use anchors::is_elsewhere;
pub(in crate::monitor) use anchors::{Lost, Told};
pub use change::{
    AttachedChange, FixedFrame, ObjectChange, OctomapPlacement, Operation, RobotStateChange, SceneChange,
    SceneUpdate, WorldChange,
};
pub use frames::SceneContext;
pub use gaps::{Extent, Gap, Subject};
pub use refusal::SceneRefusal;
pub use state::{Applied, OCTOMAP, PlanningSceneState, Unfit};
pub use transform_tree::{Transform, TransformTree};
pub(in crate::monitor) use way::{Link, Way};
