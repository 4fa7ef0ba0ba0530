//! Limit on the number of link pairs that may collide: checkers store data per pair.

use std::collections::HashMap;

use super::model::Link;
use super::{Fault, Place};

/// Maximum number of pairs of links with geometry that move relative to each other: the pairs of 3000 links.
const MOST_PAIRS: usize = 5_000_000;

/// # Errors
/// If the links form more pairs than a checker can store.
pub(super) fn check(links: &[Link]) -> Result<(), Fault> {
    let mut of_body = HashMap::<_, usize>::new();
    for link in links.iter().filter(|link| !link.collisions.is_empty()) {
        *of_body.entry(link.rigid_body).or_default() += 1;
    }
    let pairs_among = |count: usize| count.saturating_mul(count.saturating_sub(1)) / 2;
    let count: usize = of_body.values().sum();
    let pairs = pairs_among(count) - of_body.values().map(|&count| pairs_among(count)).sum::<usize>();
    if pairs <= MOST_PAIRS {
        return Ok(());
    }
    Err(Fault {
        place: Place::default(),
        message: format!(
            "{count} links with collision geometry make {pairs} pairs that may collide, more than the limit of \
             {MOST_PAIRS}: merge links, or join those that do not move by fixed joints"
        ),
    })
}

#[cfg(test)]
mod tests {
    use crate::{MeshFiles, RobotModel};

    /// `count` links on a base, all moving or all fixed.
    fn star(count: usize, joint: &str) -> String {
        let geometry = "<collision><geometry><sphere radius='0.1'/></geometry></collision>";
        let links = (0..count)
            .map(|i| {
                format!(
                    "<link name='l{i}'>{geometry}</link><joint name='j{i}' type='{joint}'><parent link='base'/>\
                     <child link='l{i}'/><axis xyz='1 0 0'/></joint>"
                )
            })
            .collect::<Vec<_>>()
            .concat();
        format!("<robot name='star'><link name='base'/>{links}</robot>")
    }

    #[test]
    fn too_many_pairs_are_rejected_with_their_number() {
        let of = |count, joint| RobotModel::from_urdf(&star(count, joint), &MeshFiles::default());
        let message = of(20_000, "continuous").unwrap_err().to_string();
        assert!(message.contains("20000 links") && message.contains("199990000 pairs"), "{message}");
        assert!(of(1000, "continuous").is_ok());
        // fixed joints make one body
        assert!(of(4000, "fixed").is_ok());
    }
}
