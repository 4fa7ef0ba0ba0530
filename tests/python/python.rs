//! Tests of the Python package: `tests/python/run.sh` installs it in a fresh virtual environment and runs pytest.

use std::io::Write;
use std::path::Path;
use std::process::Command;

const SKIP: &str = "CLEARANCE_SKIP_PYTHON";

#[test]
fn python_package() {
    if std::env::var(SKIP).is_ok_and(|value| value == "1") {
        return announce(&format!(
            "\n*** SKIPPED: the tests of the Python package did not run, because {SKIP}=1 ***\n"
        ));
    }
    let built = std::env::current_exe().expect("this test has a path");
    let library = built.with_file_name(format!(
        "{}clearance_python{}",
        std::env::consts::DLL_PREFIX,
        std::env::consts::DLL_SUFFIX
    ));
    assert!(library.is_file(), "cargo has not built {}", library.display());
    let output = Command::new(Path::new(env!("CARGO_MANIFEST_DIR")).join("run.sh"))
        .env("CLEARANCE_PYTHON_LIBRARY", library)
        .output()
        .expect("tests/python/run.sh starts");
    let stdout = String::from_utf8_lossy(&output.stdout);
    let passed = passed_tests(&stdout);
    assert!(
        output.status.success() && passed > 0,
        "the tests of the Python package did not pass ({}; {passed} passed); {SKIP}=1 skips them\n\
         --- stderr ---\n{}\n--- stdout ---\n{stdout}",
        output.status,
        String::from_utf8_lossy(&output.stderr),
    );
    announce(&format!("Python package: {passed} tests passed"));
}

/// Past the capture of the test harness, which shows only what failed tests print.
fn announce(text: &str) {
    let _ = writeln!(std::io::stderr(), "{text}");
}

/// The count in the last line of pytest, as in `== 3 passed, 1 warning in 0.5s ==`.
fn passed_tests(stdout: &str) -> usize {
    let summary = stdout.lines().rfind(|line| !line.trim().is_empty()).unwrap_or_default();
    let words: Vec<_> = summary.split([' ', ',']).collect();
    words.windows(2).find(|pair| pair[1] == "passed").and_then(|pair| pair[0].parse().ok()).unwrap_or(0)
}

#[test]
fn reads_the_count_from_the_summary_of_pytest() {
    assert_eq!(passed_tests("....\n===== 4 passed, 1 warning in 0.52s =====\n"), 4);
    assert_eq!(passed_tests("===== 1 failed, 21 passed in 9.10s =====\n\n"), 21);
    assert_eq!(passed_tests("===== no tests ran in 0.01s =====\n"), 0);
}
