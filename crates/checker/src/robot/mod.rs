//! The robot of a checker: bodies with geometry on a kinematic chain, and their self pairs.
//!
//! | content | file |
//! |---|---|
//! | paddings and scale factors, validated | `geometry_settings` |
//! | collision geometry of scaled shapes | `scaled_body` |
//! | link or attached object with geometry | `robot_body` |
//! | kinematic chain with its bodies, and bounds on their motion | `robot_geometry` |
//! | volumes around the robot's parts, for visualisation | `link_volumes` |
//! | capsules around the robot's bodies, and its extent | `robot_reach` |
//! | sums along kinematic paths | `path_sums` |
//! | points that decide whether a body is inside an obstacle | `decisive_points` |
//! | constants of a pair; candidate pairs | `pair_info` |
//! | self pairs and their capsules | `self_pairs` |
//! | self pairs that collided most often recently | `pair_priority` |

mod decisive_points;
mod geometry_settings;
mod link_volumes;
mod pair_info;
mod pair_priority;
mod path_sums;
mod robot_body;
mod robot_geometry;
mod robot_reach;
mod scaled_body;
mod self_pairs;

pub use decisive_points::DecisivePoint;
pub use geometry_settings::{object_padding, object_scale};
pub use link_volumes::{LinkVolume, link_volumes};
pub use pair_info::{CandidatePair, PairInfo};
pub use pair_priority::PairPriority;
pub use robot_body::{RobotBody, SceneOfRobot};
pub use robot_geometry::RobotGeometry;
pub use robot_reach::{bounding_capsule, extent, largest_extent};
pub use scaled_body::{BodyBuild, LazySolidBody, ScaledBody};
pub use self_pairs::{PlacedSegments, SelfPairs, set_bits};
