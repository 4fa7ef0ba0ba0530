//! Tests of the soundness of proximity queries, against oracles that share no code with the library.
//!
//! The suite speaks to the public questions only, so that it judges any engine behind them. What is true comes from
//! construction ([`known_gaps`]), from exact integers ([`grid`]) or from brute force in 106 bits ([`solid_oracle`]).
//!
//! ```text
//! cargo test --test it soundness                                                         a fast share
//! CLEARANCE_SOUNDNESS=long cargo test --release --test it soundness -- --nocapture       everything
//! ```
//!
//! The long mode asks about more than 10⁷ pairs of triangles, each a body of its own, and 10⁶ poses of robots' links;
//! `CLEARANCE_SOUNDNESS=0.1` about a tenth of that. Every mode prints the error table, a row for each family, and leaves
//! it in `soundness.md` of cargo's temporary folder; a missed collision, a broken law or an error beyond the stated
//! accuracy fails. A disagreement names its case: `CLEARANCE_SOUNDNESS_CASE=17` asks about number 17 only.

mod double_double;
mod grid;
mod grid_oracle;
mod known_gaps;
mod laws;
mod ledger;
mod links;
mod meshes;
mod motions;
mod oracles;
mod outline;
mod parts;
mod planes_points_voxels;
mod primitives;
mod random_pairs;
mod solid_oracle;
mod subject;
mod triangle_oracle;
mod triangles;
mod turned_oracle;

/// How many cases to try: few in the normal tests, many in the long mode, or any share of those.
pub fn share(fast: usize, long: usize) -> usize {
    #[allow(clippy::cast_possible_truncation, clippy::cast_precision_loss, clippy::cast_sign_loss)]
    let part_of_long = |part: f64| (long as f64 * part).ceil() as usize;
    match std::env::var("CLEARANCE_SOUNDNESS").as_deref() {
        Err(_) => fast,
        Ok("long") => long,
        Ok(part) => part_of_long(part.parse().expect("CLEARANCE_SOUNDNESS is 'long' or a share of it")),
    }
}

/// Whether more is asked for than the fast share.
fn is_long() -> bool {
    std::env::var_os("CLEARANCE_SOUNDNESS").is_some()
}
