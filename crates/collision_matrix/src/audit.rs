//! Audit of an SRDF: its disabled pairs, compared with the decisions about them.

use std::collections::HashMap;

use clearance_robot::{LinkId, RobotModel};

use crate::decision::{DecidedPair, Decision};

/// Comparison of an SRDF's entry with the decision about its pair.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AuditFinding {
    /// The links never collide: proven, whatever the reason in the SRDF is.
    NeverProven,
    /// The entry claims that the links never collide, but they can.
    Refuted,
    /// The links can collide, and the entry claims nothing else: collisions are hidden on purpose.
    Hidden,
    /// The links always collide: proven.
    AlwaysProven,
    /// The pair is undecided.
    Undecided,
}

impl AuditFinding {
    /// Name in tables and documents.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::NeverProven => "never_proven",
            Self::Refuted => "refuted",
            Self::Hidden => "hidden",
            Self::AlwaysProven => "always_proven",
            Self::Undecided => "undecided",
        }
    }
}

/// An entry of an SRDF with its decision.
#[derive(Clone, Debug, PartialEq)]
pub struct AuditedPair<'d> {
    /// Reason in the SRDF.
    pub reason: &'d str,
    /// The finding.
    pub finding: AuditFinding,
    /// The decision.
    pub pair: &'d DecidedPair,
}

/// The pairs that the robot's SRDF disables, by an entry or by default, whose links have geometry, in the order of the links.
#[must_use]
pub fn audit<'d>(robot: &'d RobotModel, decided: &'d [DecidedPair]) -> Vec<AuditedPair<'d>> {
    let disabled = robot.srdf().map_or_else(Vec::new, |srdf| srdf.unchecked_pairs(robot.link_ids()));
    let decided = PairsByName::new(decided);
    let of_entry = |(a, b, reason): (LinkId, LinkId, &'d str)| {
        let [a, b] = [a, b].map(|link| robot.described_name(link));
        let pair = decided.get(a, b)?;
        Some(AuditedPair { reason, finding: finding(reason, pair), pair })
    };
    disabled.into_iter().filter_map(of_entry).collect()
}

/// Decided pairs by the names of their links. A lookup takes the same time for any number of pairs.
struct PairsByName<'d>(HashMap<[&'d str; 2], &'d DecidedPair>);

impl<'d> PairsByName<'d> {
    fn new(decided: &'d [DecidedPair]) -> Self {
        Self(decided.iter().map(|pair| (ordered(&pair.link1, &pair.link2), pair)).collect())
    }

    /// The pair of these links, in any order.
    fn get(&self, a: &str, b: &str) -> Option<&'d DecidedPair> {
        self.0.get(&ordered(a, b)).copied()
    }
}

/// Two names in alphabetical order.
fn ordered<'n>(a: &'n str, b: &'n str) -> [&'n str; 2] {
    if a <= b { [a, b] } else { [b, a] }
}

/// Links that never move relative to each other hide no collision, whatever the reason says.
fn finding(reason: &str, pair: &DecidedPair) -> AuditFinding {
    let claims_never = reason.trim().eq_ignore_ascii_case("never") && pair.variables > 0;
    match &pair.decision {
        Decision::Never { .. } => AuditFinding::NeverProven,
        Decision::Undecided { .. } => AuditFinding::Undecided,
        Decision::Sometimes { .. } | Decision::Always { .. } if claims_never => AuditFinding::Refuted,
        Decision::Sometimes { .. } => AuditFinding::Hidden,
        Decision::Always { .. } => AuditFinding::AlwaysProven,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pair(link1: &str, link2: &str) -> DecidedPair {
        DecidedPair {
            link1: link1.to_owned(),
            link2: link2.to_owned(),
            variables: 1,
            is_adjacent: false,
            contact_share: 0.0,
            depth: None,
            decision: Decision::Undecided { least_distance: None, state: Vec::new() },
        }
    }

    #[test]
    fn pairs_are_found_by_their_names_in_any_order() {
        let decided = [pair("base", "tip"), pair("tip", "arm"), pair("arm", "base")];
        let by_name = PairsByName::new(&decided);
        for expected in &decided {
            let DecidedPair { link1, link2, .. } = expected;
            assert_eq!(by_name.get(link1, link2), Some(expected));
            assert_eq!(by_name.get(link2, link1), Some(expected));
        }
        assert_eq!(by_name.get("base", "hand"), None);
        assert_eq!(by_name.get("base", "base"), None);
    }
}
