//! Test helper: counts the cases that agree with expected results, lists the others; finds the shared test data.

use std::path::{Path, PathBuf};

/// A folder of the shared robots, cases and truths; `None`, said loudly, where they are not.
pub fn shared_folder(name: &str) -> Option<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared").join(name);
    if folder.is_dir() {
        return Some(folder);
    }
    eprintln!("NOT TESTED: the shared folder {} is not here", folder.display());
    None
}

pub fn json(path: &Path) -> serde_json::Value {
    let text = std::fs::read_to_string(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    serde_json::from_str(&text).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
}

/// How many cases were tried and which disagree.
pub struct Tally {
    what: String,
    tried: usize,
    disagreements: Vec<String>,
}

impl Tally {
    pub fn new(what: &str) -> Self {
        Self { what: what.to_owned(), tried: 0, disagreements: vec![] }
    }

    /// Counts a case; `wrong` says what disagrees.
    pub fn add(&mut self, case: &str, wrong: &[String]) {
        self.tried += 1;
        if !wrong.is_empty() {
            self.disagreements.push(format!("{case}: {}", wrong.join("; ")));
        }
    }

    /// Counts many cases at once, and what disagreed among them.
    pub fn add_all(&mut self, tried: usize, disagreements: Vec<String>) {
        self.tried += tried;
        self.disagreements.extend(disagreements);
    }

    /// Prints the count; fails on any disagreement, or when fewer cases were tried than there are.
    pub fn finish(self, expected: usize) {
        eprintln!("{}: {} tried, {} disagree", self.what, self.tried, self.disagreements.len());
        assert!(self.tried >= expected, "{}: only {} cases were tried", self.what, self.tried);
        let shown: Vec<_> = self.disagreements.iter().take(30).collect();
        assert!(shown.is_empty(), "{}: {shown:#?}", self.what);
    }
}
