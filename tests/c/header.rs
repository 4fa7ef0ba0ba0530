//! Tests that the C header is the one generated from the code, and declares all functions.

use std::path::{Path, PathBuf};

/// Set to 1, the test writes the header.
const UPDATE: &str = "CLEARANCE_UPDATE_HEADER";

/// Files of the interface, in the order of the header.
const FILES: [&str; 15] = [
    "status.rs",
    "structs.rs",
    "robot.rs",
    "shapes.rs",
    "world.rs",
    "checker_options.rs",
    "checker.rs",
    "workspace.rs",
    "state_queries.rs",
    "motion_options.rs",
    "motion_queries.rs",
    "motion_distances.rs",
    "certificate.rs",
    "planning.rs",
    "recovery.rs",
];

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../crates/c")
}

/// The header that cbindgen makes of the code.
fn generated() -> String {
    let config = cbindgen::Config::from_file(folder().join("cbindgen.toml")).expect("cbindgen.toml is read");
    let mut builder = cbindgen::Builder::new().with_config(config);
    for file in FILES {
        builder = builder.with_src(folder().join("src").join(file));
    }
    let mut text = Vec::new();
    builder.generate().expect("the header is made").write(&mut text);
    String::from_utf8(text).expect("the header is text")
}

#[test]
fn header_is_made_from_the_code() {
    let (path, made) = (folder().join("include/clearance.h"), generated());
    if std::env::var(UPDATE).is_ok_and(|value| value == "1") {
        std::fs::write(&path, &made).expect("the header is written");
    }
    let kept = std::fs::read_to_string(&path).unwrap_or_default();
    let difference = kept.lines().zip(made.lines()).find(|(kept, made)| kept != made);
    assert!(
        kept == made,
        "crates/c/include/clearance.h does not fit the code: {UPDATE}=1 cargo test -p clearance-c-tests header; first difference: \
         {difference:?}"
    );
}

/// Every file with functions of the interface is listed above.
#[test]
fn header_has_all_functions() {
    let mut missing = Vec::new();
    for entry in std::fs::read_dir(folder().join("src")).expect("there are sources") {
        let path = entry.expect("a source").path();
        let text = std::fs::read_to_string(&path).expect("a source is text");
        let name = path.file_name().and_then(|name| name.to_str()).unwrap_or_default().to_owned();
        if text.contains("no_mangle") && !FILES.contains(&name.as_str()) {
            missing.push(name);
        }
    }
    assert!(missing.is_empty(), "not in the header: {missing:?}");
}
