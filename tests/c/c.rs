//! Tests of the C and C++ interface: CMake installs it, gcc, g++ and clang compile programs that use it.

mod header;
mod installation;
mod rust_results;

use std::io::Write;
use std::num::NonZero;
use std::path::Path;
use std::process::Command;
use std::sync::atomic::{AtomicUsize, Ordering};

use installation::Installation;

const SKIP: &str = "CLEARANCE_SKIP_C";

/// Warnings are errors.
const WARNINGS: [&str; 4] = ["-Wall", "-Wextra", "-Werror", "-pedantic"];
/// `fmod` and the like are no part of C99 without it.
const C: [&str; 2] = ["-std=c99", "-D_POSIX_C_SOURCE=200809L"];
const CPP: [&str; 2] = ["-std=c++17", "-Wshadow"];
const SANITIZERS: [&str; 4] =
    ["-fsanitize=address,undefined", "-fno-sanitize-recover=all", "-fno-omit-frame-pointer", "-g"];

#[test]
fn c_and_cpp_interface() {
    if std::env::var(SKIP).is_ok_and(|value| value == "1") {
        return announce(&format!(
            "\n*** SKIPPED: the tests of the C and C++ interface did not run, because {SKIP}=1 ***\n"
        ));
    }
    for tool in ["gcc", "g++", "cmake", "pkg-config"] {
        assert!(
            exists(tool),
            "the tests of the C and C++ interface need {tool}: apt-get install g++ cmake pkg-config; {SKIP}=1 skips them"
        );
    }
    let installed = Installation::new();
    let truth = installed.folder().join("rust_results.txt");
    std::fs::write(&truth, rust_results::text()).expect("the results are written");
    let truth = truth.to_str().expect("the temporary folder is UTF-8");

    let shared = installed.shared();
    let mut programs = vec![
        Program { compiler: "gcc", name: "flow", options: vec![&C, &shared], arguments: vec![] },
        Program {
            compiler: "gcc",
            name: "errors",
            options: vec![&C, &SANITIZERS, &shared],
            arguments: vec![],
        },
        Program {
            compiler: "g++",
            name: "objects",
            options: vec![&CPP, &SANITIZERS, &shared],
            arguments: vec![],
        },
        Program {
            compiler: "g++",
            name: "truth",
            options: vec![&CPP, &SANITIZERS, &shared],
            arguments: vec![truth],
        },
    ];
    let archive = installed.archive();
    programs.push(Program { compiler: "gcc", name: "flow", options: vec![&C, &archive], arguments: vec![] });
    if exists("clang++") {
        let (c, cpp) = (vec![&C[..], &SANITIZERS, &shared], vec![&CPP[..], &shared]);
        programs.push(Program { compiler: "clang", name: "flow", options: c, arguments: vec![] });
        programs.push(Program { compiler: "clang++", name: "objects", options: cpp, arguments: vec![] });
    } else {
        announce("C and C++ interface: clang++ is not installed, gcc alone was tested");
    }
    let folders = ompl_folders();
    let folders: Option<Vec<&str>> =
        folders.as_ref().map(|folders| folders.iter().map(String::as_str).collect());
    if let Some(folders) = &folders {
        let options = vec![&CPP[..], &shared, folders, &["-lompl"]];
        programs.push(Program { compiler: "g++", name: "ompl", options, arguments: vec![] });
    } else {
        announce("C and C++ interface: OMPL is not installed, clearance/ompl.hpp was not tested");
    }
    run_all(&installed, &programs);
    installed.examples(folders.is_some());
    installed.absolute_folders_are_rejected();
    announce("C and C++ interface: all programs passed");
}

/// A program of this folder, how it is compiled and run.
struct Program<'a> {
    compiler: &'a str,
    name: &'a str,
    options: Vec<&'a [&'a str]>,
    arguments: Vec<&'a str>,
}

/// Compiles and runs programs, as many at a time as there are cores. The sanitizers find reads of freed memory and leaks in the C++ layer
/// and in the programs, and results that outlive their query.
fn run_all(installed: &Installation, programs: &[Program<'_>]) {
    let next = AtomicUsize::new(0);
    let work = || {
        loop {
            let index = next.fetch_add(1, Ordering::Relaxed);
            let Some(Program { compiler, name, options, arguments }) = programs.get(index) else { return };
            let made = installed.folder().join(format!("{index} {name}"));
            installed.compile(compiler, name, &[options.as_slice(), &[&WARNINGS]].concat(), &made);
            installed.run(name, &made, arguments);
        }
    };
    std::thread::scope(|scope| {
        for _ in 0..std::thread::available_parallelism().map_or(1, NonZero::get) {
            scope.spawn(work);
        }
    });
}

/// Options for OMPL's headers; none where it is not installed. Its other flags are not used: they ask for C++14, and list libraries of
/// Boost that Debian's libompl-dev does not bring.
fn ompl_folders() -> Option<Vec<String>> {
    let output = Command::new("pkg-config").args(["--cflags-only-I", "ompl"]).output();
    let output = output.ok().filter(|output| output.status.success())?;
    let flags = String::from_utf8_lossy(&output.stdout).into_owned();
    // its own headers have warnings
    Some(flags.split_whitespace().map(|flag| flag.replacen("-I", "-isystem", 1)).collect())
}

fn exists(tool: &str) -> bool {
    let paths = std::env::var_os("PATH").unwrap_or_default();
    std::env::split_paths(&paths).any(|folder| folder.join(tool).is_file())
}

/// Runs a command and fails with its output if it fails.
fn output_of(what: &str, command: &mut Command) -> String {
    let output = command.output().unwrap_or_else(|why| panic!("{what}: {command:?} does not start: {why}"));
    let (stdout, stderr) = (String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
    assert!(
        output.status.success(),
        "{what}: {command:?} failed ({})\n--- stderr ---\n{stderr}\n--- stdout ---\n{stdout}",
        output.status
    );
    stdout.into_owned()
}

fn root() -> &'static Path {
    Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../.."))
}

/// Past the capture of the test harness, which shows only what failed tests print.
fn announce(text: &str) {
    let _ = writeln!(std::io::stderr(), "{text}");
}

/// A path whose proof is not complete in time is found without certificate; every other missing certificate is an error.
#[test]
fn a_path_without_the_requested_certificate_has_a_reason() {
    use clearance::{MotionOptions, MotionSegment, Trajectory};
    use clearance_c::planning::certified;
    let (checker, robot) = rust_results::checker();
    let start = robot.configuration_from_names([("joint2", 0.1), ("joint4", -1.6)]).expect("a state");
    let end = robot.configuration_from_names([("joint2", 0.2), ("joint4", -1.7)]).expect("a state");
    let path = Trajectory::of_segments(vec![MotionSegment::straight(&robot, &start, &end)]).expect("a path");
    let proof_with =
        |options: MotionOptions| checker.certify_trajectory(&path, &options, &mut checker.workspace());
    let in_time = certified(Some(proof_with(MotionOptions::default()))).expect("the path is free");
    assert!(in_time.0 == c"found" && in_time.1.is_some());
    let over = MotionOptions { deadline: Some(std::time::Instant::now()), ..MotionOptions::default() };
    let late = certified(Some(proof_with(over))).expect("a path");
    assert!(late.0 == c"found_without_certificate" && late.1.is_none());
    let used_up = MotionOptions { budget: 1, ..MotionOptions::default() };
    let why = certified(Some(proof_with(used_up))).expect_err("there is no certificate").to_string();
    assert!(why.contains("no certificate of it") && why.contains("Budget"), "{why}");
    assert_eq!(certified(None).expect("no proof was asked for").0, c"found");
}

/// No panic leaves a function that C calls.
#[test]
fn a_panic_becomes_a_status() {
    use clearance_c::status::{call, call_for, clearance_last_error, clearance_status};
    use std::ffi::CStr;
    assert_eq!(call(|_| panic!("planted")), clearance_status::Internal);
    assert_eq!(call_for(7, |_| panic!("planted")), 7);
    let pointer = clearance_last_error();
    #[allow(unsafe_code, reason = "reads the text as C does")]
    // SAFETY: the text is valid until the next failing call in this thread
    let text = unsafe { CStr::from_ptr(pointer) }.to_str().expect("the text is UTF-8");
    assert_eq!(text, "internal error, please report it: planted");
}
