//! Data type of the result of one benchmark query on one state or edge, and its text.

use clearance::CollisionReport;
use clearance::checker::MotionVerdict;
use clearance::robot::LinkId;
use clearance::scene::BodyId;

/// An answer as the library gives it; it is put into words only where it is compared, never where it is timed.
#[expect(clippy::large_enum_variant, reason = "it is timed, and lives only until it is compared")]
pub enum Answer {
    Free(bool),
    /// The numbers of the colliding pairs.
    Pairs(CollisionReport),
    /// The least distance (m), unless it is beyond the limit of the question.
    Distance(Option<f64>),
    Edge(MotionVerdict),
    /// Bounds (m) on the least distance along an edge.
    Least([f64; 2]),
}

impl std::fmt::Display for Answer {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Free(free) => write!(f, "{}", u8::from(*free)),
            Self::Pairs(report) => {
                let mut names: Vec<String> =
                    link_pairs(report).map(|(a, b)| format!("{}-{}", a.0, b.0)).collect();
                names.sort();
                f.write_str(&names.join(","))
            }
            Self::Distance(Some(distance)) => write!(f, "{distance}"),
            Self::Distance(None) => f.write_str("far"),
            Self::Edge(MotionVerdict::Free) => f.write_str("1"),
            Self::Edge(MotionVerdict::Contact { .. }) => f.write_str("0"),
            Self::Edge(MotionVerdict::Undecided { .. }) => f.write_str("undecided"),
            Self::Least([lower, upper]) => write!(f, "{lower} {upper}"),
        }
    }
}

/// Colliding pairs of links; there is no world here.
pub fn link_pairs(report: &CollisionReport) -> impl Iterator<Item = (LinkId, LinkId)> {
    report.colliding_pairs.iter().filter_map(|pair| match *pair {
        (BodyId::Link(a), BodyId::Link(b)) => Some((a, b)),
        _ => None,
    })
}
