//! Recovery from a collision: a near free state, and the joint velocity that reduces the penetration fastest.
//!
//! | content | file |
//! |---|---|
//! | what may move, and how far | `recovery_options` |
//! | results | `free_state` |
//! | the joints that matter, and their ranges | `search_space` |
//! | contact and clearance near a start | `neighbourhood` |
//! | search of a near free state | `free_state_search` |
//! | joint velocities that reduce the penetration fastest | `retreat` |

mod free_state;
mod free_state_search;
mod neighbourhood;
mod recovery_options;
mod retreat;
mod search_space;

use clearance_robot::Configuration;

pub use free_state::{FreeState, NoFreeState, Recovery};
pub use recovery_options::{RecoveryError, RecoveryOptions};
pub use retreat::{Retreat, RetreatDirection};

use crate::collision_checker::CollisionChecker;
use crate::workspace::Workspace;
use free_state_search::FreeStateSearch;

impl CollisionChecker {
    /// Searches a free state near a state that collides, and a straight motion to it that is proven free after its first exit from
    /// collision.
    ///
    /// The nearest of the free states that were found is returned: the search draws random directions, from a fixed seed, among the
    /// joints that move a colliding pair, at growing distances, and then turns the best direction such that the free state comes nearer.
    /// Nothing proves that no free state is nearer still. Without a deadline, the same state and options give the same result.
    ///
    /// # Errors
    /// If the options do not fit the robot.
    pub fn find_free_state(
        &self,
        q: &Configuration,
        options: &RecoveryOptions,
        workspace: &mut Workspace,
    ) -> Result<Recovery, RecoveryError> {
        options.validate(self.robot())?;
        Ok(FreeStateSearch::new(self, q, options, workspace).run())
    }

    /// The unit joint velocity that reduces the penetration fastest in a state that collides: of all pairs, the depth of the deepest one.
    ///
    /// Positions beyond or at a limit do not move farther outwards. The first depth of a body takes milliseconds longer than others, for
    /// its preparation.
    ///
    /// # Errors
    /// If the options do not fit the robot; only what may move matters, not how far.
    pub fn retreat_direction(
        &self,
        q: &Configuration,
        options: &RecoveryOptions,
        workspace: &mut Workspace,
    ) -> Result<Retreat, RecoveryError> {
        options.validate(self.robot())?;
        Ok(retreat::retreat_direction(self, q, options, workspace))
    }
}
