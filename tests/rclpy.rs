//! Tests of the node with real rclpy: runs pytest in `tests/rclpy/` against the binary.

#![cfg(feature = "ros")]

use std::io::Write;
use std::process::Command;

const SKIP: &str = "CLEARANCE_SKIP_RCLPY";

/// Tests mostly wait: two parts at once take little more than half the time.
#[test]
fn rclpy_part_1() {
    run("1/2");
}

#[test]
fn rclpy_part_2() {
    run("2/2");
}

/// Where the DDS library would cut long answers into pieces that nobody can read.
#[test]
fn rclpy_across_ethernet() {
    run_tests("rclpy across Ethernet", &["-k", "test_states or whole"], &[("CLEARANCE_NETWORK", "ethernet")]);
}

/// The other distribution: what is said when nothing is known, services, the action, parameters, how topics match.
#[test]
fn rclpy_of_jazzy() {
    const SOME: &str = "fail_safe or test_states or trajectory_action or test_parameters or test_graph";
    run_tests("rclpy of Jazzy", &["-k", SOME], &[("CLEARANCE_ROS", "jazzy")]);
}

/// Every row of `benches/node` once, whatever the machine takes for it.
#[test]
fn node_benchmarks_on_trial() {
    let out = std::env::temp_dir().join(format!("clearance-node-benchmarks-{}.md", std::process::id()));
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/benches/node/run.sh");
    let arguments = ["--trial", "--binary", env!("CARGO_BIN_EXE_clearance"), "--out"];
    if is_skipped() {
        return;
    }
    let output = Command::new(script).args(arguments).arg(&out).output().expect("benches/node/run.sh starts");
    assert!(output.status.success(), "{}: {}", output.status, String::from_utf8_lossy(&output.stderr));
    let report = std::fs::read_to_string(&out).expect("a report is written");
    std::fs::remove_file(&out).expect("it is there");
    let rows = report.lines().filter(|line| line.starts_with("| ") && !line.starts_with("| measure"));
    assert_eq!(rows.count(), 9, "{report}");
    assert!(!report.contains("not measured"), "{report}");
}

fn run(part: &str) {
    run_tests(&format!("rclpy, part {part}"), &["--part", part], &[]);
}

fn run_tests(title: &str, arguments: &[&str], environment: &[(&str, &str)]) {
    /// What `run.sh` says where a machine has no such network, or not the one Python that a distribution has wheels for.
    const NO_SUCH_NETWORK: i32 = 77;
    const NO_SUCH_PYTHON: i32 = 76;
    if is_skipped() {
        return;
    }
    let output = Command::new(concat!(env!("CARGO_MANIFEST_DIR"), "/tests/rclpy/run.sh"))
        .args(arguments)
        .envs(environment.iter().copied())
        .env("CLEARANCE_BIN", env!("CARGO_BIN_EXE_clearance"))
        .output()
        .expect("tests/rclpy/run.sh starts");
    let stdout = String::from_utf8_lossy(&output.stdout);
    let stderr = String::from_utf8_lossy(&output.stderr);

    let is_jazzy = environment.contains(&("CLEARANCE_ROS", "jazzy"));
    let missing = match output.status.code() {
        Some(NO_SUCH_NETWORK) => Some("this machine refuses such interfaces"),
        Some(NO_SUCH_PYTHON) if is_jazzy => Some("this machine lacks its Python"),
        _ => None,
    };
    if let Some(missing) = missing {
        return announce(&format!("\n*** SKIPPED: {title}, because {missing}: {stderr} ***\n"));
    }
    let passed = passed_tests(&stdout);
    assert!(
        output.status.success() && passed > 0,
        "the tests with rclpy did not pass ({}; {passed} passed); {SKIP}=1 skips them\n\
         --- stderr ---\n{stderr}\n--- stdout ---\n{stdout}",
        output.status,
    );
    announce(&format!("{title}: {passed} tests passed"));
}

fn is_skipped() -> bool {
    let skipped = std::env::var(SKIP).is_ok_and(|value| value == "1");
    if skipped {
        announce(&format!("\n*** SKIPPED: the tests with rclpy did not run, because {SKIP}=1 ***\n"));
    }
    skipped
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
    assert_eq!(passed_tests(""), 0);
}
