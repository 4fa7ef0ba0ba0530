//! Finding of `clearance doctor`: verdict, subject and text of one check, with limits on number and length.

use std::collections::BTreeMap;

use clearance_files::readable_text::on_one_line;
use serde::Serialize;

/// Result of one check.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Finding {
    pub verdict: Verdict,
    /// Subject of the check, such as `joint_states`.
    pub about: String,
    pub text: String,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Verdict {
    Good,
    /// Information that may be useful.
    Note,
    /// The node cannot work in this environment, or not with these peers.
    Wrong,
}

impl Verdict {
    fn word(self) -> &'static str {
        match self {
            Self::Good => "good",
            Self::Note => "note",
            Self::Wrong => "wrong",
        }
    }
}

/// Bounds the number and length of findings, and removes control characters, since peers can influence the text.
pub fn bounded(findings: Vec<Finding>) -> Vec<Finding> {
    const MOST: usize = 20;
    const LONGEST: usize = 1000;
    let readable = |text: &str| {
        let mut readable = on_one_line(&text.chars().take(LONGEST).collect::<String>()).into_owned();
        if text.chars().nth(LONGEST).is_some() {
            readable.push('…');
        }
        readable
    };
    let mut counts: BTreeMap<(String, &str), usize> = BTreeMap::new();
    let mut bounded_findings = Vec::new();
    for Finding { verdict, about, text } in findings {
        let count = counts.entry((about.clone(), verdict.word())).or_default();
        *count += 1;
        if *count <= MOST {
            bounded_findings.push(Finding { verdict, about, text: readable(&text) });
        }
    }
    for ((about, word), count) in counts {
        if count > MOST {
            bounded_findings
                .push(note(&about, format!("{} more of the kind '{word}' are not listed", count - MOST)));
        }
    }
    bounded_findings
}

pub fn good(about: &str, text: impl Into<String>) -> Finding {
    Finding { verdict: Verdict::Good, about: about.to_owned(), text: text.into() }
}

pub fn note(about: &str, text: impl Into<String>) -> Finding {
    Finding { verdict: Verdict::Note, about: about.to_owned(), text: text.into() }
}

pub fn wrong(about: &str, text: impl Into<String>) -> Finding {
    Finding { verdict: Verdict::Wrong, about: about.to_owned(), text: text.into() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_from_peers_is_shortened_and_contains_no_control_characters() {
        let many = (0..5000).map(|number| wrong("peers", format!("peer {number}")));
        let long = good("joint_states", format!("\u{1b}[2J{}", "x".repeat(100_000)));
        let bounded_findings = bounded(many.chain([long, good("robot", "'ur5e'")]).collect());
        assert_eq!(bounded_findings.len(), 20 + 2 + 1);
        assert!(
            bounded_findings.last().unwrap().text.starts_with("4980 more of the kind 'wrong'"),
            "{bounded_findings:?}"
        );
        let long = &bounded_findings[20].text;
        assert!(long.starts_with(r"\u{1b}[2J") && long.ends_with('…') && long.chars().count() == 1006);
        assert_eq!(bounded_findings[21], good("robot", "'ur5e'"));
        assert_eq!(bounded(bounded_findings.clone())[..20], bounded_findings[..20]);
    }
}
