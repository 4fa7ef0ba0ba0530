//! The soundness of the proximity queries: every answer against oracles that share no code with the library.
//!
//! The suite speaks to the public questions only, so that it judges any engine behind them. What is true comes from
//! construction ([`slabs`]), from exact integers ([`grid`]) or from brute force in 106 bits ([`solid_oracle`]).
//!
//! ```text
//! cargo test --test it soundness                                                         a fast share
//! CLEARANCE_SOUNDNESS=long cargo test --release --test it soundness -- --nocapture       everything
//! ```
//!
//! The long mode asks about more than 10⁷ pairs of triangles and 10⁶ poses of robots' links. Either prints the error
//! table, a row for each family; a missed collision, a broken law or an error beyond the stated accuracy fails.

mod cylinder_oracle;
mod double_double;
mod grid;
mod grid_oracle;
mod laws;
mod ledger;
mod links;
mod meshes;
mod oracles;
mod outline;
mod parts;
mod primitives;
mod slabs;
mod solid_oracle;
mod subject;
mod triangle_oracle;
mod triangles;

/// How many cases to try: few in the normal tests, many in the long mode.
fn share(fast: usize, long: usize) -> usize {
    if std::env::var_os("CLEARANCE_SOUNDNESS").is_some_and(|mode| mode == "long") { long } else { fast }
}
