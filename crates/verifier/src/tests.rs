//! True certificates are accepted, false ones are not, and what is believed is true of sampled points.

mod apart;
mod bound;
mod prover;
mod refusals;
mod scenes;
