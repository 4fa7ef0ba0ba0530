//! Pairs of bodies that are checked: their numbers, and queries on them.
//!
//! | content | file |
//! |---|---|
//! | all pairs of a robot in its world, by number | `checked_pairs` |
//! | one pair at its poses | `posed_pair` |
//! | points of two bodies that are near each other | `near_points` |
//! | one pair with the memory of earlier states | `pair_memory` |
//! | memory of self pairs for states near a start | `pairs_around_start` |
//! | candidates for the nearest pair | `measured_pair` |
//! | results that are the same in all states | `state_independent` |
//! | poses of the robot, and level 0 of self pairs, in one state | `placed_robot` |
//! | contacts with obstacles, in SIMD lanes | `obstacle_contacts` |

mod checked_pairs;
mod inside_search;
mod measured_pair;
mod near_points;
mod obstacle_contacts;
mod pair_memory;
mod pairs_around_start;
mod placed_robot;
mod posed_pair;
mod state_independent;

pub use checked_pairs::{CheckedPairs, PairBodies};
pub use inside_search::{InsideSearch, SearchedBodies};
pub use measured_pair::{MeasuredPair, PostponedPair};
pub use near_points::{NearPoints, hardly_less_than};
pub use obstacle_contacts::{ObstacleContacts, ObstacleScratch, StatesInLanes};
pub use pair_memory::{PairMemory, RememberedPair};
pub use pairs_around_start::PairsAroundStart;
pub use placed_robot::PlacedRobot;
pub use posed_pair::{PosedPair, RoughDistance};
pub use state_independent::NearestToFixed;
