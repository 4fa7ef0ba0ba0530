//! Selects the pairs that become new entries of an SRDF.

use clearance_robot::{LinkId, RobotModel};

use crate::decision::{DecidedPair, Decision};
use crate::srdf_update::SrdfEntry;

/// Pairs that become entries besides those that never collide.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct AllowedPairs {
    /// Pairs of names of links, in any order, which get the reason `User`.
    pub pairs: Vec<[String; 2]>,
    /// Whether links that are joined by a joint and touch in most states get the reason `Adjacent`.
    pub adjacent: bool,
}

/// Reason why a pair cannot be allowed.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum AllowedPairError {
    /// Both links are the same.
    #[error("'{0}' is given twice: give two links")]
    SameLink(String),
    /// A link is in no pair.
    #[error("link '{0}' has no collision geometry, so there is no pair to allow")]
    NoGeometry(String),
}

impl AllowedPairs {
    /// Adds a pair of links.
    ///
    /// # Errors
    /// If the links are no pair that is decided.
    pub fn allow(&mut self, robot: &RobotModel, links: [LinkId; 2]) -> Result<(), AllowedPairError> {
        let names = links.map(|link| robot.described_name(link).to_owned());
        if links[0] == links[1] {
            return Err(AllowedPairError::SameLink(names[0].clone()));
        }
        for (link, name) in links.into_iter().zip(&names) {
            if robot.link(link).collisions.is_empty() {
                return Err(AllowedPairError::NoGeometry(name.clone()));
            }
        }
        self.pairs.push(names);
        Ok(())
    }

    /// Entries of the decided pairs that the SRDF of `original` neither disables nor enables. Only what is proven gets the reason `Never`.
    #[must_use]
    pub fn new_entries(&self, pairs: &[DecidedPair], original: Option<&RobotModel>) -> Vec<SrdfEntry> {
        let entry = |pair: &DecidedPair| {
            let (link1, link2) = (pair.link1.clone(), pair.link2.clone());
            Some(SrdfEntry { link1, link2, reason: self.reason(pair)? })
        };
        let is_new = |pair: &&DecidedPair| !original.is_some_and(|model| names(model, pair));
        pairs.iter().filter(is_new).filter_map(entry).collect()
    }

    fn reason(&self, pair: &DecidedPair) -> Option<&'static str> {
        match pair.decision {
            Decision::Never { .. } => Some("Never"),
            _ if self.pairs.iter().any(|[a, b]| pair.is_of(a, b)) => Some("User"),
            _ if self.adjacent && pair.is_adjacent && pair.touches_mostly() => Some("Adjacent"),
            _ => None,
        }
    }
}

/// True if the model's SRDF disables or enables the pair.
fn names(model: &RobotModel, pair: &DecidedPair) -> bool {
    let Some(srdf) = model.srdf() else { return false };
    let disabled = srdf.disabled_pairs.iter().map(|entry| (entry.a, entry.b));
    let mut named = disabled.chain(srdf.enabled_pairs.iter().copied());
    named.any(|(a, b)| pair.is_of(model.described_name(a), model.described_name(b)))
}
