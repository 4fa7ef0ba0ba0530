//! Tests of the architecture: which modules and crates may use which, and which files may do file I/O.

use std::path::Path;

/// The crates, and those of them that each may use.
const CRATES: [(&str, &[&str]); 18] = [
    ("geometry", &[]),
    ("files", &[]),
    ("proximity", &["geometry"]),
    ("robot", &["geometry", "files"]),
    ("scene", &["geometry", "files", "robot"]),
    ("motion", &["geometry", "files", "robot", "scene"]),
    ("checker", &["geometry", "proximity", "robot", "scene", "motion"]),
    ("lint", &["geometry", "robot"]),
    ("covers", &["geometry", "robot", "lint"]),
    ("planner", &["robot", "motion", "checker"]),
    ("verifier", &["geometry", "robot", "scene", "motion"]),
    ("collision_matrix", &["geometry", "proximity", "robot", "scene", "motion", "checker", "verifier"]),
    ("monitor", &["geometry", "proximity", "robot", "scene", "motion", "checker"]),
    ("view", &["geometry", "robot", "scene", "checker", "monitor"]),
    ("ros", &["geometry", "files", "proximity", "robot", "scene", "motion", "checker", "monitor", "view"]),
    // above the root package, which it uses like any other program
    ("bindings", &[]),
    ("python", &["bindings", "files", "view"]),
    ("c", &["bindings", "files"]),
];

/// Modules that share a crate, and those of them that each may use.
const MODULES: [(&str, &[&str]); 16] = [
    ("crates/geometry/src/constants", &[]),
    ("crates/geometry/src/math", &["constants"]),
    ("crates/geometry/src/simd", &[]),
    ("crates/files/src/input_files", &[]),
    ("crates/files/src/ply_format", &[]),
    ("crates/files/src/yaml", &["readable_text"]),
    ("crates/proximity/src/bounding_volume", &[]),
    ("crates/proximity/src/bvh", &["bounding_volume"]),
    ("crates/proximity/src/elements", &[]),
    ("crates/proximity/src/body", &["bounding_volume", "bvh", "elements"]),
    ("crates/proximity/src/narrow_phase", &["bounding_volume", "bvh", "elements", "body"]),
    ("crates/proximity/src/search", &["bounding_volume", "bvh", "elements", "body", "narrow_phase"]),
    ("crates/proximity/src/front", &["bounding_volume", "bvh", "elements", "body", "narrow_phase", "search"]),
    (
        "crates/proximity/src/queries",
        &["bounding_volume", "bvh", "elements", "body", "narrow_phase", "search"],
    ),
    ("crates/proximity/src/penetration_depth", &["elements", "body", "narrow_phase", "search"]),
    (
        "crates/proximity/src/contacts",
        &["bounding_volume", "bvh", "elements", "body", "narrow_phase", "search", "penetration_depth"],
    ),
];

/// Foreign crates that one manifest alone depends on.
const HOME_CRATES: [(&str, &str); 11] = [
    ("fearless_simd", "geometry"),
    ("urdf-rs", "robot"),
    ("roxmltree", "robot"),
    ("percent-encoding", "robot"),
    ("sha2", "motion"),
    ("ros2-client", "ros"),
    ("rustdds", "ros"),
    ("ros2-interfaces-jazzy-serde", "ros"),
    ("hyper", "view"),
    ("pyo3", "python"),
    ("numpy", "python"),
];

/// A foreign crate and the one file or folder of its crate that names it.
const HOMES: [(&str, &str); 20] = [
    ("base64", "crates/robot/src/mesh_formats/"),
    ("libc", "crates/files/src/input_files.rs"),
    ("fearless_simd", "crates/geometry/src/simd/"),
    ("parry3d_f64", "crates/proximity/src/penetration_depth/tests.rs"),
    ("stl_io", "crates/robot/src/mesh_formats/"),
    ("tobj", "crates/robot/src/mesh_formats/"),
    ("hyper", "crates/view/src/"),
    ("smol_hyper", "crates/view/src/"),
    ("http_body_util", "crates/view/src/"),
    ("arc_swap", "crates/view/src/"),
    ("mcap", "crates/ros/src/recording/"),
    ("hdrhistogram", "crates/ros/src/topics/latencies.rs"),
    ("strsim", "crates/ros/src/parameters/"),
    ("sysinfo", "crates/ros/src/node/memory_limit.rs"),
    ("cdr_encoding", "crates/ros/src/dds/cdr.rs"),
    ("byteorder", "crates/ros/src/dds/cdr.rs"),
    ("clap", "src/cli/"),
    ("indicatif", "src/cli/"),
    ("csv", "src/cli/"),
    ("cpu_time", "src/cli/"),
];

/// Words that open, list or write files, and the files that may use them: the bounded reader, and what creates new files.
const OPENING: [&str; 7] =
    ["File::open", "File::options", "File::create", "fs::read", "fs::write", "OpenOptions", "io::stdin"];
const MAY_OPEN: [&str; 3] = [
    "crates/files/src/input_files.rs",
    "crates/ros/src/recording/recorder.rs",
    "crates/ros/src/recording/save.rs",
];

/// What breaks the rules in a source file given by its path from the project's root.
fn violations(path: &str, text: &str) -> Vec<String> {
    let code: String =
        text.lines().map(|l| l.split("//").next().unwrap_or("")).collect::<Vec<_>>().join("\n");
    let mut found = vec![];
    if let Some((module, allowed)) = MODULES.iter().find(|(module, _)| path.starts_with(module)) {
        let own = module.rsplit('/').next().unwrap_or("");
        let shared: Vec<&str> = MODULES.iter().filter_map(|(m, _)| m.rsplit('/').next()).collect();
        for used in used_modules(&code) {
            if used != own && shared.contains(&used.as_str()) && !allowed.contains(&used.as_str()) {
                found.push(format!("{path}: {own} uses {used}"));
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
            found.push(format!("{path}: {word}; input files are read by clearance_files::input_files"));
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
fn modules_and_foreign_crates_stay_in_their_places() {
    let mut files = vec![];
    for folder in ["src", "crates"] {
        sources(&Path::new(env!("CARGO_MANIFEST_DIR")).join(folder), &mut files);
    }
    assert!(files.len() > 50, "only {} files", files.len());
    let found: Vec<_> = files.iter().flat_map(|(path, text)| violations(path, text)).collect();
    assert!(found.is_empty(), "{found:#?}");
}

#[test]
fn a_planted_use_is_found() {
    for (path, planted) in [
        ("crates/proximity/src/bounding_volume/obb.rs", "use crate::bvh::Tree;"),
        ("crates/geometry/src/math/mod.rs", "use crate::simd::Level;"),
        ("crates/proximity/src/queries/collide.rs", "use parry3d_f64::query::gjk;"),
        ("crates/robot/src/urdf_reader.rs", "use stl_io::read_stl;"),
        ("src/cli/states.rs", "let text = std::fs::read_to_string(path)?;"),
        ("crates/robot/src/loaded_mesh.rs", "let file = File::open(path)?;"),
        ("src/cli/motion.rs", "std::fs::write(path, text)?;"),
    ] {
        assert_eq!(violations(path, planted).len(), 1, "{path}: {planted}");
    }
    assert!(violations("crates/proximity/src/bvh/tree.rs", "use crate::bounding_volume::Obb;").is_empty());
    assert!(violations("src/cli/states.rs", "#[cfg(test)] mod tests { fs::read(path) }").is_empty());
}

/// The crates of this project that a manifest depends on.
fn dependencies(manifest: &str) -> Vec<&str> {
    let names = manifest.lines().filter_map(|line| line.strip_prefix("clearance-")?.split(['.', ' ']).next());
    names.collect()
}

/// The sections of a manifest about dependencies of the product, not of its tests.
fn manifest(of: &Path) -> String {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(of).join("Cargo.toml");
    let text = std::fs::read_to_string(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    product_dependencies(&text)
}

fn product_dependencies(manifest: &str) -> String {
    let sections = manifest.split("\n[").filter(|section| {
        let title = section.split(']').next().unwrap_or("");
        title.ends_with("dependencies")
            && !title.ends_with("dev-dependencies")
            && !title.starts_with("workspace")
    });
    sections.collect::<Vec<_>>().join("\n[")
}

#[test]
fn crates_depend_on_those_above_them_alone() {
    let crates = Path::new("crates");
    for (name, allowed) in CRATES {
        assert_eq!(dependencies(&manifest(&crates.join(name))), allowed, "{name}");
    }
    for (name, home) in HOME_CRATES {
        let lists = |of: &Path| {
            manifest(of).lines().any(|line| {
                line.split([' ', '.']).next() == Some(name) || line.contains(&format!("\"{name}\""))
            })
        };
        let found: Vec<_> = CRATES.iter().map(|(of, _)| *of).filter(|of| lists(&crates.join(of))).collect();
        assert_eq!(found, [home], "{name}");
        assert!(!lists(Path::new("")), "the root package names {name}");
    }
    let planted = "[package]\n[dependencies]\nclearance-robot.workspace = true\nlog = \"1\"\n[target.'cfg(unix)'.dependencies]\n\
                   clearance-scene = \"1\"\n[dev-dependencies]\nclearance-ros = \"1\"\n[lints]\n";
    assert_eq!(dependencies(&product_dependencies(planted)), ["robot", "scene"]);
}
