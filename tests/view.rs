//! Tests of the live view in a headless browser: runs `tests/view/` against the binary.

#![cfg(feature = "ros")]

use std::io::Write;
use std::process::Command;

const SKIP: &str = "CLEARANCE_SKIP_VIEW";

#[test]
fn browser() {
    if std::env::var(SKIP).is_ok_and(|value| value == "1") {
        announce(&format!("\n*** SKIPPED: the tests with a browser did not run, because {SKIP}=1 ***\n"));
        return;
    }
    let output = Command::new(concat!(env!("CARGO_MANIFEST_DIR"), "/tests/view/run.sh"))
        .env("CLEARANCE_BIN", env!("CARGO_BIN_EXE_clearance"))
        .output()
        .expect("tests/view/run.sh starts");
    let stdout = String::from_utf8_lossy(&output.stdout);
    let stderr = String::from_utf8_lossy(&output.stderr);

    let passed = passed_tests(&stdout);
    assert!(
        output.status.success() && passed > 0,
        "the tests with a browser did not pass ({}; {passed} passed); {SKIP}=1 skips them\n\
         --- stderr ---\n{stderr}\n--- stdout ---\n{stdout}",
        output.status,
    );
    announce(&format!("view: {passed} tests passed"));
}

/// Past the capture of the test harness, which shows only what failed tests print.
fn announce(text: &str) {
    let _ = writeln!(std::io::stderr(), "{text}");
}

/// The count in the summary of node's TAP reporter, as in `# pass 5`.
fn passed_tests(stdout: &str) -> usize {
    let count = stdout.lines().find_map(|line| line.strip_prefix("# pass "));
    count.and_then(|count| count.trim().parse().ok()).unwrap_or(0)
}

#[test]
fn reads_the_count_from_the_summary_of_tap() {
    assert_eq!(passed_tests("1..2\n# tests 2\n# pass 2\n# fail 0\n"), 2);
    assert_eq!(passed_tests("# pass 0\n"), 0);
    assert_eq!(passed_tests(""), 0);
}
