//! Tests of the replay of files with several runs of a node.

use super::*;
use crate::recording::mcap_file::{Entry, RecordingFile};
use crate::recording::save::RecordingCopy;
use crate::recording::step::RecordStep;

/// Records a short run in a folder of its own; returns its file.
fn short_run(folder: &Path) -> PathBuf {
    std::fs::create_dir(folder).unwrap();
    let mut cell = Cell::start(folder);
    cell.turn(0.1);
    cell.turn(0.2);
    cell.end();
    folder.join("record.mcap")
}

/// Copies recordings into one file, one after the other, with the steps of the second one for which `is_copied`.
fn join(first: &Path, second: &Path, to: &Path, is_copied: impl Fn(&RecordStep) -> bool) {
    let mut copy = RecordingCopy::create(to).unwrap();
    for file in [first, second] {
        let mut source = RecordingFile::open(file).unwrap();
        while let Some(entry) = source.next().unwrap() {
            match entry {
                Entry::Attachment { name, data } => copy.attachment(name, data).unwrap(),
                Entry::RecordStep { step, .. } if file == second && !is_copied(&step) => {}
                Entry::RecordStep { messages, itself, .. } => {
                    for message in messages.iter().chain([&itself]) {
                        copy.message(message).unwrap();
                    }
                }
            }
        }
    }
    copy.complete().unwrap();
}

#[test]
fn a_second_run_is_reported_and_never_left_out() {
    let folder = tempfile::tempdir().unwrap();
    let [first, second] = ["first", "second"].map(|name| short_run(&folder.path().join(name)));
    let both = folder.path().join("both.mcap");
    join(&first, &second, &both, |_| true);
    let error = again(&both).unwrap_err();
    assert!(error.contains("both.mcap: holds a second run (of /clearance, from 1"), "{error}");
    assert!(error.contains("split the file there"), "{error}");

    let without_beginning = folder.path().join("without_beginning.mcap");
    join(&first, &second, &without_beginning, |step| !matches!(step, RecordStep::Started { .. }));
    let error = again(&without_beginning).unwrap_err();
    assert!(error.contains("holds steps of a second run (from 1"), "{error}");

    let alone = folder.path().join("alone.mcap");
    join(&first, &second, &alone, |_| false);
    assert_eq!(again(&alone).unwrap().same, 2);
}
