//! Output of `clearance acm` as text and JSON: decided pairs, and the audit of an SRDF.

use clearance::collision_matrix::{
    AuditFinding, AuditedPair, DecidedPair, Decision, MatrixDocument, SrdfEntry,
};
use clearance::robot::RobotModel;
use clearance_files::readable_text::on_one_line;
use serde_json::{Value, json};

/// The decisions of a run.
pub struct AcmOutput<'o> {
    pub document: &'o MatrixDocument,
    pub robot: &'o RobotModel,
    pub seconds: f64,
    /// New entries of the SRDF.
    pub written: Vec<SrdfEntry>,
    pub lists_all: bool,
}

/// The comparison of an SRDF with the decisions.
pub struct AuditOutput<'o> {
    pub robot: &'o RobotModel,
    pub audited: &'o [AuditedPair<'o>],
    pub seconds: f64,
    pub lists_all: bool,
}

impl AcmOutput<'_> {
    fn count(&self, name: &str) -> usize {
        self.document.pairs.iter().filter(|pair| pair.decision.name() == name).count()
    }

    pub fn text(&self) -> String {
        let pairs = &self.document.pairs;
        let mut lines: Vec<String> = Vec::new();
        if self.lists_all {
            lines.extend(pairs.iter().map(pair_line));
        } else {
            let touching: Vec<&DecidedPair> = pairs.iter().filter(|pair| pair.touches_mostly()).collect();
            if !touching.is_empty() {
                lines.push(
                    "in contact in most states; if this is by design, --allow A,B accepts a pair:".to_owned(),
                );
                lines.extend(touching.iter().map(|pair| pair_line(pair)));
            }
            let undecided: Vec<&DecidedPair> =
                pairs.iter().filter(|pair| !pair.decision.is_final() && !pair.touches_mostly()).collect();
            if !undecided.is_empty() {
                lines.push(
                    "undecided; a larger --deadline or --max-boxes may decide them, unless a planar joint, or a continuous joint whose \
                     mimic joint does not come back after a turn, moves them:"
                        .to_owned(),
                );
                lines.extend(undecided.iter().map(|pair| pair_line(pair)));
            }
        }
        if !self.written.is_empty() {
            let count = |reason: &str| self.written.iter().filter(|entry| entry.reason == reason).count();
            lines.push(format!(
                "new entries of the SRDF: {} Never, {} Adjacent, {} User",
                count("Never"),
                count("Adjacent"),
                count("User")
            ));
        }
        lines.push(format!(
            "{}: {} pairs: {} never, {} always, {} sometimes, {} undecided; decided in {:.1} s",
            self.robot.name(),
            pairs.len(),
            self.count("never"),
            self.count("always"),
            self.count("sometimes"),
            self.count("undecided"),
            self.seconds
        ));
        lines.iter().map(|line| on_one_line(line)).collect::<Vec<_>>().join("\n")
    }

    pub fn json(&self) -> String {
        let pairs = self.document.pairs.iter().map(|pair| {
            let mut value = serde_json::to_value(pair).unwrap_or_default();
            if let Some(object) = value.as_object_mut() {
                // proofs are for --certificate
                object.remove("proof");
                object.remove("evidence");
            }
            value
        });
        json!({
            "robot": self.robot.name(),
            "joints": self.document.joints,
            "seconds": self.seconds,
            "pairs": pairs.collect::<Vec<Value>>(),
            "written": self.written.iter().map(|entry| json!([entry.link1, entry.link2, entry.reason])).collect::<Vec<_>>(),
        })
        .to_string()
    }
}

impl AuditOutput<'_> {
    fn count(&self, finding: AuditFinding) -> usize {
        self.audited.iter().filter(|entry| entry.finding == finding).count()
    }

    pub fn is_refuted(&self) -> bool {
        self.count(AuditFinding::Refuted) > 0
    }

    pub fn text(&self) -> String {
        let shown = |entry: &&AuditedPair| {
            self.lists_all || matches!(entry.finding, AuditFinding::Refuted | AuditFinding::Undecided)
        };
        let mut lines: Vec<String> =
            self.audited.iter().filter(shown).map(|entry| self.line(entry)).collect();
        lines.push(format!(
            "{}: {} disabled pairs: {} refuted, {} never collide, {} always collide, {} can collide and are hidden, {} undecided; decided in {:.1} s",
            self.robot.name(),
            self.audited.len(),
            self.count(AuditFinding::Refuted),
            self.count(AuditFinding::NeverProven),
            self.count(AuditFinding::AlwaysProven),
            self.count(AuditFinding::Hidden),
            self.count(AuditFinding::Undecided),
            self.seconds
        ));
        lines.iter().map(|line| on_one_line(line)).collect::<Vec<_>>().join("\n")
    }

    fn line(&self, entry: &AuditedPair) -> String {
        let AuditedPair { reason, finding, pair } = entry;
        let named = format!("{} – {} (reason \"{reason}\")", pair.link1, pair.link2);
        match (finding, &pair.decision) {
            (AuditFinding::Refuted, Decision::Sometimes { colliding, .. }) => {
                format!("REFUTED {named}: collides at \"{}\"", self.state(colliding))
            }
            (AuditFinding::Refuted, _) => format!("REFUTED {named}: collides in every state"),
            (AuditFinding::Undecided, Decision::Undecided { least_distance, .. }) => {
                format!("undecided {named}{}", nearest(*least_distance))
            }
            (finding, _) => format!("{} {named}", finding.name().replace('_', " ")),
        }
    }

    /// A state as `clearance check --state` reads it; joints at their defaults are left out.
    fn state(&self, state: &[f64]) -> String {
        let default = self.robot.default_configuration();
        let named = self.robot.position_names().iter().zip(state).zip(default.positions());
        let named = named.filter(|((_, q), rest)| q != rest).map(|((name, q), _)| format!("{name}={q:?}"));
        named.collect::<Vec<_>>().join(" ")
    }

    pub fn json(&self) -> String {
        let entries = self.audited.iter().map(|entry| {
            let mut value = json!({
                "link1": entry.pair.link1, "link2": entry.pair.link2, "reason": entry.reason,
                "finding": entry.finding.name(),
            });
            if let (Some(object), Decision::Sometimes { colliding, .. }) =
                (value.as_object_mut(), &entry.pair.decision)
            {
                object.insert("colliding".to_owned(), json!(colliding));
            }
            value
        });
        json!({
            "robot": self.robot.name(),
            "joints": self.robot.position_names(),
            "seconds": self.seconds,
            "entries": entries.collect::<Vec<Value>>(),
        })
        .to_string()
    }
}

/// The smallest distance that was found.
fn nearest(distance: Option<f64>) -> String {
    distance.map_or_else(String::new, |distance| format!(", nearest {distance:.4} m"))
}

/// A pair with its decision, as one line.
fn pair_line(pair: &DecidedPair) -> String {
    let detail = match &pair.decision {
        Decision::Never { least_distance, .. } => nearest(*least_distance),
        Decision::Undecided { least_distance, .. } if !pair.touches_mostly() => nearest(*least_distance),
        Decision::Sometimes { .. } | Decision::Undecided { .. } => {
            format!(", in contact in {:.0} % of the states", 100.0 * pair.contact_share)
        }
        Decision::Always { .. } => String::new(),
    };
    let depth = pair.depth.map_or_else(String::new, |depth| format!(", depth {depth:.4} m"));
    let adjacent = if pair.is_adjacent && pair.touches_mostly() { ", adjacent" } else { "" };
    format!("  {} – {}: {}{detail}{depth}{adjacent}", pair.link1, pair.link2, pair.decision.name())
}
