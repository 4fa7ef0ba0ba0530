//! Regression tests that replay the recordings in `tests/replays/`, and expect the recorded results.
//!
//! `clearance replay FILE --save-test tests/replays/NAME` adds one.

use std::path::Path;
use std::process::Command;

use crate::program::Folder;

#[test]
fn every_recording_gives_the_answers_that_stand_in_it() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/replays");
    let mut run = 0;
    for case in std::fs::read_dir(folder).unwrap() {
        let recording = case.unwrap().path().join("recording.mcap");
        if !recording.exists() {
            continue;
        }
        let replay =
            Command::new(env!("CARGO_BIN_EXE_clearance")).arg("replay").arg(&recording).output().unwrap();
        let [stdout, stderr] = [&replay.stdout, &replay.stderr].map(|bytes| String::from_utf8_lossy(bytes));
        assert!(replay.status.success(), "{}:\n{stdout}{stderr}", recording.display());
        run += 1;
    }
    assert!(run > 0, "no recording was found");
}

#[test]
fn a_test_that_is_not_saved_is_reported() {
    let recording = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("tests/replays/two_link_in_a_changing_world/recording.mcap");
    let folder = Folder::new();
    let output = folder.run(&["replay", &recording.display().to_string(), "--save-test", "saved"]);
    let message = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(0), "{message}");
    assert!(message.contains("nothing is saved to saved: no result differs"), "{message}");
    assert!(!folder.path("saved").exists());
}
