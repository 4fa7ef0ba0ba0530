//! Queries on states of the robot.
//!
//! | content | file |
//! |---|---|
//! | one state: candidate pairs | `queried_state` |
//! | memory of the last states of a stream | `stream` |
//! | contact and distance of single pairs of a state | `pair_evaluation` |
//! | priority queue of the search for the nearest pair | `nearest_first_queue` |
//! | search for the nearest pair | `nearest_search` |
//! | nearest obstacle to the parts that no joint moves | `nearest_to_fixed` |
//! | least distance of all pairs | `least_distance` |
//! | one query on one state | `state_query` |
//! | whether anything touches, in one state | `contact_search` |
//! | whether anything touches, in many states | `batch` |
//! | level 0 of eight states in SIMD lanes | `eight_states` |
//! | depth, normal and point of a contact | `contact` |

mod batch;
mod contact;
mod contact_search;
mod eight_states;
mod least_distance;
mod nearest_first_queue;
mod nearest_search;
mod nearest_to_fixed;
mod pair_contacts;
mod pair_evaluation;
mod queried_state;
mod state_query;
mod stream;

pub use batch::BatchSearch;
pub use contact::Contact;
pub(crate) use contact::FoundContact;
pub use contact_search::ContactSearch;
pub use eight_states::EightStates;
pub use nearest_search::DistanceScratch;
pub use pair_contacts::{LocalContact, PairContacts};
pub use pair_evaluation::PairEvaluation;
pub use queried_state::QueriedState;
pub use state_query::StateQuery;
pub use stream::Stream;
