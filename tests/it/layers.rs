//! The architecture, enforced: a module uses only those above it, and each foreign crate has one home.

use std::collections::HashMap;
use std::path::Path;

/// A module and those it may use, as `lib.rs` lists them.
const LAYERS: [(&str, &[&str]); 18] = [
    ("constants", &[]),
    ("input_files", &[]),
    ("math", &["constants"]),
    ("ply_format", &[]),
    ("readable_text", &[]),
    ("simd", &[]),
    ("yaml", &[]),
    ("geometry", &["constants", "math"]),
    ("bounding_volume", &["constants", "math", "simd"]),
    ("bvh", &["constants", "math", "simd", "bounding_volume"]),
    ("query", &["constants", "math", "simd", "geometry", "bounding_volume", "bvh"]),
    ("robot", &["constants", "input_files", "math", "ply_format", "readable_text", "simd", "geometry"]),
    ("scene", &["constants", "math", "ply_format", "yaml", "geometry", "robot"]),
    ("motion", &["constants", "math", "readable_text", "yaml", "geometry", "robot", "scene"]),
    ("checker", &["constants", "math", "simd", "geometry", "bvh", "query", "robot", "scene", "motion"]),
    ("verifier", &["constants", "math", "geometry", "robot", "scene", "motion", "checker"]),
    ("monitor", &["constants", "math", "geometry", "query", "robot", "scene", "checker"]),
    (
        "node",
        &[
            "constants",
            "input_files",
            "math",
            "readable_text",
            "yaml",
            "geometry",
            "query",
            "robot",
            "scene",
            "motion",
            "checker",
            "monitor",
        ],
    ),
];

/// A foreign crate and the one place that names it.
const HOMES: [(&str, &str); 28] = [
    ("base64", "src/robot/mesh_formats/"),
    ("libc", "src/input_files.rs"),
    ("fearless_simd", "src/simd/"),
    ("parry3d_f64", "src/query/narrow_phase.rs"),
    ("urdf_rs", "src/robot/"),
    ("roxmltree", "src/robot/"),
    ("stl_io", "src/robot/mesh_formats/"),
    ("tobj", "src/robot/mesh_formats/"),
    ("percent_encoding", "src/robot/"),
    ("sha2", "src/motion/"),
    ("ros2_client", "src/node/"),
    ("rustdds", "src/node/"),
    ("ros2_interfaces_jazzy_serde", "src/node/"),
    ("smol", "src/node/"),
    ("hyper", "src/node/view/"),
    ("smol_hyper", "src/node/view/"),
    ("http_body_util", "src/node/view/"),
    ("arc_swap", "src/node/view/"),
    ("mcap", "src/node/recording/"),
    ("hdrhistogram", "src/node/activity.rs"),
    ("strsim", "src/node/parameters/"),
    ("sysinfo", "src/node/memory_limit.rs"),
    ("cdr_encoding", "src/node/cdr.rs"),
    ("byteorder", "src/node/cdr.rs"),
    ("clap", "src/cli/"),
    ("indicatif", "src/cli/"),
    ("csv", "src/cli/"),
    ("cpu_time", "src/cli/"),
];

/// Words that open, list or write files, and the files that may use them: the bounded reader, and what creates new files.
const OPENING: [&str; 7] =
    ["File::open", "File::options", "File::create", "fs::read", "fs::write", "OpenOptions", "io::stdin"];
const MAY_OPEN: [&str; 3] =
    ["src/input_files.rs", "src/node/recording/writer.rs", "src/node/recording/save.rs"];

/// What breaks the rules in a source file given by its path from the project's root.
fn violations(path: &str, text: &str) -> Vec<String> {
    let code: String =
        text.lines().map(|l| l.split("//").next().unwrap_or("")).collect::<Vec<_>>().join("\n");
    let module = path.trim_start_matches("src/").split(['/', '.']).next().unwrap_or("");
    let layers: HashMap<_, _> = LAYERS.into_iter().collect();
    let mut found = vec![];
    if let Some(allowed) = layers.get(module) {
        for used in used_modules(&code) {
            if used != module && layers.contains_key(used.as_str()) && !allowed.contains(&used.as_str()) {
                found.push(format!("{path}: {module} uses {used}"));
            }
        }
    }
    for (name, home) in HOMES {
        if code.contains(&format!("{name}::")) && !path.starts_with(home) {
            found.push(format!("{path}: names {name}, whose home is {home}"));
        }
    }
    let is_test = path.contains("/tests/") || path.ends_with("tests.rs") || path.ends_with("testing.rs");
    let product = code.split("#[cfg(test)]").next().unwrap_or("");
    for word in OPENING.into_iter().filter(|word| has_word(product, word)) {
        if !is_test && !MAY_OPEN.contains(&path) {
            found.push(format!("{path}: {word}; input files are read by crate::input_files"));
        }
    }
    found
}

/// Whether `word` stands in `code`, not as the end of a longer name.
fn has_word(code: &str, word: &str) -> bool {
    let begins = |at: usize| !code[..at].ends_with(|c: char| c.is_alphanumeric() || c == '_');
    code.match_indices(word).any(|(at, _)| begins(at))
}

/// Every module named after `crate::`, also inside braces.
fn used_modules(code: &str) -> Vec<String> {
    let first_word = |s: &str| s.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect::<String>();
    let mut used = vec![];
    for rest in code.split("crate::").skip(1) {
        match rest.strip_prefix('{') {
            Some(list) => used
                .extend(list.split(['}', ';']).next().unwrap_or("").split(',').map(|s| first_word(s.trim()))),
            None => used.push(first_word(rest)),
        }
    }
    used
}

fn sources(folder: &Path, files: &mut Vec<(String, String)>) {
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            sources(&path, files);
        } else if path.extension().is_some_and(|e| e == "rs") {
            let name = path.strip_prefix(env!("CARGO_MANIFEST_DIR")).unwrap().display().to_string();
            files.push((name, std::fs::read_to_string(&path).unwrap()));
        }
    }
}

#[test]
fn modules_use_only_those_above_them() {
    let mut files = vec![];
    sources(&Path::new(env!("CARGO_MANIFEST_DIR")).join("src"), &mut files);
    assert!(files.len() > 50, "only {} files", files.len());
    let found: Vec<_> = files.iter().flat_map(|(path, text)| violations(path, text)).collect();
    assert!(found.is_empty(), "{found:#?}");
}

#[test]
fn a_planted_use_is_found() {
    for (path, planted) in [
        ("src/bvh/tree.rs", "use crate::robot::LinkId;"),
        ("src/query/body.rs", "use crate::{math::Pose, checker::Settings};"),
        ("src/robot/model.rs", "fn f() { crate::bvh::Tree::build(&[]); }"),
        ("src/monitor/mod.rs", "use crate::node::run;"),
        ("src/query/collide.rs", "use parry3d_f64::query::gjk;"),
        ("src/checker/pairs.rs", "use urdf_rs::Robot;"),
        ("src/verifier/apart.rs", "use crate::query::CollisionBody;"),
        ("src/checker/fingerprint.rs", "use sha2::Sha256;"),
        ("src/monitor/monitor.rs", "use ros2_client::Node;"),
        ("src/cli/states.rs", "let text = std::fs::read_to_string(path)?;"),
        ("src/robot/loaded_mesh.rs", "let file = File::open(path)?;"),
        ("src/cli/motion.rs", "std::fs::write(path, text)?;"),
    ] {
        assert_eq!(violations(path, planted).len(), 1, "{path}: {planted}");
    }
    assert!(violations("src/query/body.rs", "use crate::bvh::Tree; // not crate::robot::X").is_empty());
    assert!(violations("src/cli/states.rs", "#[cfg(test)] mod tests { fs::read(path) }").is_empty());
}

#[test]
fn lib_lists_the_modules_in_this_order() {
    let lib = include_str!("../../src/lib.rs");
    let places: Vec<_> =
        LAYERS.iter().map(|(m, _)| lib.find(&format!("pub mod {m};")).unwrap_or(usize::MAX)).collect();
    let listed = &places[2..];
    assert!(listed.windows(2).all(|w| w[0] < w[1]), "{places:?}");
    assert!(!places.contains(&usize::MAX), "{places:?}");
}
