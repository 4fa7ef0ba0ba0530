//! Proven collision matrix: which pairs of links of a robot can collide within the joint limits?
//!
//! | content | file |
//! |---|---|
//! | decisions about pairs | `decision` |
//! | decisions as a document that a search resumes from | `matrix_document` |
//! | pairs that an SRDF disables, compared with the decisions | `audit` |
//! | pairs that become entries of an SRDF; new entries in its text | `srdf_entries`, `srdf_update` |
//! | limits of the search | `options` |
//! | decides all pairs, on many threads | `matrix_builder` |
//! | joints between two links | `joint_path` |
//! | geometry of a link; points around it; its connected solids | `link_geometry`, `outline`, `solid_parts` |
//! | distances and motions of a pair | `pair_problem`, `relative_motion` |
//! | random states and descent to a collision | `witness_search` |
//! | points of links that are fixed to each other | `fixed_contact` |
//! | proofs by branch and bound | `never_proof`, `always_proof`, `inner_points`, `joint_box`, `split_tree`, `plane_direction` |
//!
//! A pair is decided over the joints between its links only; a mimic joint moves with its leader. `Never` and `Always` are proofs; both
//! states of `Sometimes` are confirmed by the checker. The method is described in
//! `docs/decisions/0038-collision-matrix-by-branch-and-bound.md`.

#![deny(missing_docs)]

mod always_proof;
mod audit;
mod decision;
mod fixed_contact;
mod inner_points;
mod joint_box;
mod joint_path;
mod link_geometry;
mod matrix_builder;
mod matrix_document;
mod never_proof;
mod options;
mod outline;
mod pair_problem;
mod plane_direction;
mod relative_motion;
mod solid_parts;
mod split_tree;
mod srdf_entries;
mod srdf_update;
mod witness_search;

pub use audit::{AuditFinding, AuditedPair, audit};
pub use decision::{DecidedPair, Decision};
pub use matrix_builder::MatrixBuilder;
pub use matrix_document::{DocumentError, MatrixDocument};
pub use options::{MatrixFailure, MatrixOptions};
pub use srdf_entries::{AllowedPairError, AllowedPairs};
pub use srdf_update::{SrdfEntry, SrdfTextError, add_disabled_pairs};
