//! Counts of ignored or changed parts of a mesh file, for one remark per kind.

use std::collections::BTreeMap;

/// Number of occurrences by kind, and the line of the first one.
#[derive(Debug, Default)]
pub(super) struct RemarkCounter(BTreeMap<&'static str, (usize, Option<u32>)>);

impl RemarkCounter {
    /// Counts one more of `what`, a clause that follows a number.
    pub fn add(&mut self, what: &'static str, line: Option<u32>) {
        self.0.entry(what).or_insert((0, line)).0 += 1;
    }

    pub fn remarks(&self) -> impl Iterator<Item = String> {
        self.0.iter().map(|(what, (count, line))| {
            let first = line.map(|line| format!(", the first at line {line}")).unwrap_or_default();
            format!("{count} {what}{first}")
        })
    }
}

/// Degenerate polygons: points and lines.
pub(super) const TOO_FEW_CORNERS: &str = "polygons of fewer than three corners are skipped";
