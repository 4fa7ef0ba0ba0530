//! The world of a checker: obstacles with collision geometry, indexed by trees of boxes.
//!
//! | content | file |
//! |---|---|
//! | obstacle with its geometry | `placed_obstacle` |
//! | obstacles by place | `obstacles` |
//! | trees of the pieces of obstacles | `piece_trees` |
//! | regions that the robot can reach | `reachable_regions` |
//! | queries of the broad phase, and their scratch memory | `broad_phase` |
//! | index of the world: broad phase, and numbers of pairs with obstacles | `world_index` |
//! | parts that can touch an obstacle, and their order | `bodies_in_reach` |
//! | nodes of the search for the nearest obstacle | `search_node` |

mod bodies_in_reach;
mod broad_phase;
mod inside_index;
mod obstacles;
mod piece_trees;
mod placed_obstacle;
mod reachable_regions;
mod search_node;
mod world_index;

pub use bodies_in_reach::{BodiesInReach, BodyOrder};
pub use broad_phase::{BroadPhaseScratch, EightQuery, EightStatesQuery, PartQuery};
pub use inside_index::EightPoints;
pub use placed_obstacle::PlacedObstacle;
pub use search_node::SearchNode;
pub use world_index::{WorldIndex, WorldPair, obstacle_id};
