//! Contacts of colliding pairs in the output of `clearance check`.

use clap::Args;
use clearance::checker::{CollisionChecker, CollisionReport, Contact, LocalContact, PairContacts, Workspace};
use clearance::geometry::math::{Point, Vector};
use clearance::proximity::UnknownDepth;
use clearance::robot::Configuration;
use clearance::scene::BodyId;
use rayon::prelude::*;
use serde::Serialize;

use super::failure::Failure;
use super::rounded_bounds::{at_least, at_most};
use super::run_args::RunArgs;

#[derive(Args)]
pub struct ContactArgs {
    /// Contacts of every colliding pair, at most N each: position, normal towards the second body, and depth; with --query pairs, which
    /// it implies
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    pub contacts: Option<u32>,
}

/// One contact, in the root frame.
#[derive(Serialize)]
pub struct ContactResult {
    /// Names, sorted.
    pair: [String; 2],
    /// In metres.
    position: [f64; 3],
    /// Unit vector towards the second body of the pair; null if it is not known.
    normal: Option<[f64; 3]>,
    /// Lower and upper bound in metres on the translation that separates the bodies; equal numbers are the local depth of a further
    /// contact of the pair. Null if it is not known.
    depth: Option<[f64; 2]>,
    /// Why the depth is not known, or why its bounds are far apart.
    reason: Option<&'static str>,
}

impl ContactArgs {
    /// The contacts of every state; `None` without the option.
    pub fn of_states(
        &self,
        checker: &CollisionChecker,
        states: &[Configuration],
        reports: &[CollisionReport],
        run: &RunArgs,
    ) -> Result<Option<Vec<Vec<ContactResult>>>, Failure> {
        let Some(most) = self.contacts else { return Ok(None) };
        let most = usize::try_from(most).unwrap_or(usize::MAX);
        let pool = run.pool(states.len())?;
        Ok(Some(pool.install(|| {
            let each = states.par_iter().zip(reports);
            each.map_init(
                || checker.workspace(),
                |workspace, (q, report)| contacts(checker, q, report, most, workspace),
            )
            .collect()
        })))
    }
}

/// The contacts of one state, by pair in the order of the names, the deepest of a pair first.
fn contacts(
    checker: &CollisionChecker,
    q: &Configuration,
    report: &CollisionReport,
    most: usize,
    workspace: &mut Workspace,
) -> Vec<ContactResult> {
    let mut found = Vec::new();
    for &bodies in &report.colliding_pairs {
        let Some(PairContacts { deepest, others }) = checker.contacts(q, bodies, most, workspace) else {
            continue;
        };
        let pair = NamedPair::new(checker, bodies);
        found.push(pair.deepest(&deepest));
        found.extend(others.iter().map(|contact| pair.local(contact, &deepest)));
    }
    // a stable sort keeps the order within a pair
    found.sort_by(|a, b| a.pair.cmp(&b.pair));
    found
}

/// The names of a pair, sorted.
struct NamedPair {
    names: [String; 2],
    /// Whether the names are in the other order than the bodies.
    is_swapped: bool,
}

impl NamedPair {
    fn new(checker: &CollisionChecker, (a, b): (BodyId, BodyId)) -> Self {
        let mut names = [a, b].map(|body| checker.body_name(body).to_owned());
        let is_swapped = names[0] > names[1];
        names.sort();
        Self { names, is_swapped }
    }

    fn deepest(&self, contact: &Contact) -> ContactResult {
        let Contact { point, normal, depth, depth_lower, unknown } = contact;
        ContactResult {
            depth: depth.map(|upper| [*depth_lower, upper]),
            reason: unknown.map(UnknownDepth::code),
            ..self.contact(point, *normal)
        }
    }

    fn local(&self, contact: &LocalContact, deepest: &Contact) -> ContactResult {
        let LocalContact { point, normal, depth } = contact;
        let reason = deepest.unknown.filter(|_| depth.is_none());
        ContactResult {
            depth: depth.map(|depth| [depth; 2]),
            reason: reason.map(UnknownDepth::code),
            ..self.contact(point, Some(*normal))
        }
    }

    fn contact(&self, point: &Point, normal: Option<Vector>) -> ContactResult {
        let towards_second = |n: Vector| if self.is_swapped { -n } else { n };
        ContactResult {
            pair: self.names.clone(),
            position: [point.x, point.y, point.z],
            normal: normal.map(towards_second).map(|n| [n.x, n.y, n.z]),
            depth: None,
            reason: None,
        }
    }
}

impl ContactResult {
    /// One line of text.
    pub fn line(&self) -> String {
        let [a, b] = &self.pair;
        let [x, y, z] = self.position.map(|c| rounded(c, 1e4));
        let normal = self.normal.map_or_else(
            || "normal not known".to_owned(),
            |normal| {
                let [x, y, z] = normal.map(|c| rounded(c, 1e3));
                format!("normal ({x:.3}, {y:.3}, {z:.3})")
            },
        );
        let depth = match self.depth {
            Some([lower, upper]) if upper - lower <= 1e-6 => format!("depth {upper:.6} m"),
            Some([lower, upper]) => format!("depth {} to {} m", at_least(lower, 6), at_most(upper, 6)),
            None => "depth not known".to_owned(),
        };
        let reason = self.reason.map_or_else(String::new, |reason| format!(" ({reason})"));
        format!("  contact {a} – {b} at ({x:.4}, {y:.4}, {z:.4}), {normal}, {depth}{reason}")
    }
}

/// A number rounded to a fraction of one; zero has no sign.
fn rounded(value: f64, fraction: f64) -> f64 {
    (value * fraction).round() / fraction + 0.0
}
