//! The C and C++ interface as its users meet it: installed by CMake, used by programs of gcc, g++ and clang.

mod header;
mod installation;
mod rust_results;

use std::io::Write;
use std::path::Path;
use std::process::Command;

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
    for program in ["flow", "errors"] {
        installed.run(program, &installed.compile("gcc", program, &[&C, &WARNINGS, &shared]), &[]);
    }
    for (program, arguments) in [("objects", &[][..]), ("truth", &[truth][..])] {
        let options: [&[&str]; 3] = [&CPP, &WARNINGS, &shared];
        installed.run(program, &installed.compile("g++", program, &options), arguments);
    }
    sanitized(&installed, truth);
    let archive = installed.archive();
    installed.run("flow", &installed.compile("gcc", "flow", &[&C, &WARNINGS, &archive]), &[]);
    if exists("clang++") {
        let options: [&[&str]; 3] = [&CPP, &WARNINGS, &shared];
        installed.run("objects", &installed.compile("clang++", "objects", &options), &[]);
        installed.run("flow", &installed.compile("clang", "flow", &[&C, &WARNINGS, &shared]), &[]);
    } else {
        announce("C and C++ interface: clang++ is not installed, g++ alone was tested");
    }
    let has_ompl = has_ompl();
    if has_ompl {
        ompl(&installed);
    } else {
        announce("C and C++ interface: OMPL is not installed, clearance/ompl.hpp was not tested");
    }
    installed.examples(has_ompl);
    announce("C and C++ interface: all programs passed");
}

fn has_ompl() -> bool {
    let status = Command::new("pkg-config").args(["--exists", "ompl"]).status();
    status.is_ok_and(|status| status.success())
}

/// Planners of OMPL with proven motions.
fn ompl(installed: &Installation) {
    // not its other flags: they ask for C++14, and list libraries of Boost that Debian's libompl-dev does not bring
    let folders = output_of("folders of OMPL", Command::new("pkg-config").args(["--cflags-only-I", "ompl"]));
    // its own headers have warnings
    let folders: Vec<String> =
        folders.split_whitespace().map(|flag| flag.replacen("-I", "-isystem", 1)).collect();
    let folders: Vec<&str> = folders.iter().map(String::as_str).collect();
    let options: [&[&str]; 5] = [&CPP, &WARNINGS, &installed.shared(), &folders, &["-lompl"]];
    installed.run("ompl", &installed.compile("g++", "ompl", &options), &[]);
}

/// Reads of freed memory and leaks in the C++ layer and in the programs, and results that outlive their query.
fn sanitized(installed: &Installation, truth: &str) {
    let shared = installed.shared();
    for (compiler, program, language, arguments) in [
        ("gcc", "flow", &C, &[][..]),
        ("gcc", "errors", &C, &[][..]),
        ("g++", "objects", &CPP, &[][..]),
        ("g++", "truth", &CPP, &[truth][..]),
    ] {
        let options: [&[&str]; 4] = [language, &WARNINGS, &SANITIZERS, &shared];
        installed.run(program, &installed.compile(compiler, program, &options), arguments);
    }
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
