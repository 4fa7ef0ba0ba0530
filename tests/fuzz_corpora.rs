//! Tests that replay the inputs of the fuzz targets (`fuzz/`): no panic, and work in proportion to their size.

#![cfg(feature = "ros")]

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};

#[path = "../fuzz/src/inputs.rs"]
mod inputs;

use inputs::{TARGETS, Target};

/// Names another folder with a corpus for each target.
const CORPORA: &str = "CLEARANCE_FUZZ_CORPORA";

/// Work of one input at most, in allocations: for any input, and for each of its bytes.
const ALLOCATIONS: u64 = 100_000;
const ALLOCATIONS_PER_BYTE: u64 = 20;

/// Memory of one input at most, in bytes: for any input, and for each of its bytes.
const MEMORY: u64 = 128 << 20;
const MEMORY_PER_BYTE: u64 = 1000;

/// Panics so far, also those that the node's loader catches.
static PANICS: AtomicUsize = AtomicUsize::new(0);

#[test]
fn every_input_is_read_within_its_bounds() {
    let report = std::panic::take_hook();
    std::panic::set_hook(Box::new(move |panic| {
        PANICS.fetch_add(1, Ordering::Relaxed);
        report(panic);
    }));
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let corpora = std::env::var_os(CORPORA).map_or_else(|| root.join("fuzz/corpus"), PathBuf::from);
    let mut failures = Vec::new();
    for (name, target) in TARGETS {
        let files = files_below(&corpora.join(name));
        assert!(!files.is_empty(), "{} has no input", corpora.join(name).display());
        failures.extend(files.iter().filter_map(|file| fault(file, target)));
    }
    let hostile = files_below(&root.join("../shared/cases/hostile"));
    if hostile.is_empty() {
        eprintln!("NOT TESTED: the shared folder cases/hostile is not here");
    }
    failures.extend(hostile.iter().filter_map(|file| fault(file, target_of(file)?)));
    assert!(failures.is_empty(), "{}", failures.join("\n"));
}

#[test]
fn every_corpus_belongs_to_a_target() {
    let corpora = Path::new(env!("CARGO_MANIFEST_DIR")).join("fuzz/corpus");
    for folder in std::fs::read_dir(corpora).unwrap() {
        let name = folder.unwrap().file_name();
        assert!(TARGETS.iter().any(|(target, _)| name == *target), "fuzz/corpus/{}", name.display());
    }
}

/// Why an input fails, if it does.
fn fault(file: &Path, target: Target) -> Option<String> {
    let data = std::fs::read(file).unwrap();
    let panics = PANICS.load(Ordering::Relaxed);
    let work = allocation_counter::measure(|| {
        let _ = catch_unwind(AssertUnwindSafe(|| target(&data)));
    });
    let file = file.display();
    if PANICS.load(Ordering::Relaxed) > panics {
        return Some(format!("{file}: a panic"));
    }
    let bytes = data.len() as u64;
    let bounds = [
        ("allocations", work.count_total, ALLOCATIONS + ALLOCATIONS_PER_BYTE * bytes),
        ("bytes of memory", work.bytes_max, MEMORY + MEMORY_PER_BYTE * bytes),
    ];
    let exceeded = bounds.into_iter().find(|(_, taken, most)| taken > most);
    exceeded.map(|(unit, taken, most)| format!("{file}: {taken} {unit}, more than {most}"))
}

/// The target of a file by its name.
fn target_of(file: &Path) -> Option<Target> {
    let extension = file.extension()?.to_str()?.to_lowercase();
    let target = TARGETS.iter().find(|(name, _)| *name == extension);
    target.map(|(_, target)| *target)
}

fn files_below(folder: &Path) -> Vec<PathBuf> {
    let Ok(entries) = std::fs::read_dir(folder) else { return Vec::new() };
    let mut paths: Vec<PathBuf> = entries.map(|entry| entry.unwrap().path()).collect();
    paths.sort();
    paths.into_iter().flat_map(|path| if path.is_dir() { files_below(&path) } else { vec![path] }).collect()
}
