//! Regression tests: replays the recordings in `tests/replays/`, and expects the recorded results.
//!
//! `clearance replay FILE --save-test tests/replays/NAME` adds one.

use std::path::Path;
use std::process::Command;

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
