//! Clearance of one state: signed distances of near pairs, with normals and derivatives with respect to the positions.
//!
//! | content | file |
//! |---|---|
//! | result: pairs, and the matrix of derivatives | `pair_clearances` |
//! | queries of a checker | `checker_queries` |
//! | evaluation of one state | `clearance_query` |

mod checker_queries;
mod clearance_query;
mod pair_clearances;

pub use clearance_query::ClearanceQuery;
pub use pair_clearances::{Clearance, ClearanceCandidate, ClearanceOptions, PairClearance, WitnessCount};
