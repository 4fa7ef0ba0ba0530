//! Tests of the limits of recordings: full queue, longest duration, existing files, full disk, removed files.

use std::time::Instant;

use super::*;
use crate::threading::mailbox;

#[test]
fn what_does_not_fit_is_lost_and_counted_and_nobody_waits() {
    let (items, items_in) = mailbox::bounded(2);
    let backlog = Arc::new(Backlog::default());
    let recording = RecorderHandle::to(items, Arc::clone(&backlog));
    for _ in 0..5 {
        recording.note(|| RecordedEvent::MonitorEvent(RecordedMonitorEvent::World));
    }
    assert_eq!(backlog.lost.load(std::sync::atomic::Ordering::Relaxed), 3);
    drop(items_in);
    recording.note(|| RecordedEvent::MonitorEvent(RecordedMonitorEvent::World));
    assert_eq!(backlog.lost.load(std::sync::atomic::Ordering::Relaxed), 3, "nobody records any more");
    assert!(!RecorderHandle::default().is_on());
    RecorderHandle::default().note(|| panic!("nothing is made that nobody records"));
}

#[test]
fn behind_what_was_lost_nothing_is_run() {
    let folder = tempfile::tempdir().unwrap();
    let mut cell = Cell::start(folder.path());
    cell.turn(0.1);
    cell.recording.lose(3);
    cell.turn(0.2);
    let fault = cell.ended().unwrap_err();
    assert!(fault.contains("record.mcap is incomplete: the recording misses 3 steps"), "{fault}");
    let outcome = again(&folder.path().join("record.mcap")).unwrap();
    assert_eq!(outcome.lost, Some(3));
    assert!(outcome.same <= 1);
}

#[test]
fn a_recording_ends_in_time_and_never_takes_the_place_of_another() {
    let folder = tempfile::tempdir().unwrap();
    let mut first = Cell::limited(folder.path(), 0.001);
    first.turn(0.0);
    let deadline = Instant::now() + Duration::from_secs(60);
    while !first.recorder.has_ended() {
        assert!(Instant::now() < deadline, "the recording goes on");
        std::thread::yield_now();
    }
    // the recorder has ended; further events cause no error
    first.turn(0.1);
    first.end();
    let mut second = Cell::start(folder.path());
    second.turn(0.0);
    second.turn(0.1);
    second.end();
    let outcome = again(&folder.path().join("record.mcap")).unwrap();
    assert!(outcome.same <= 1 && !outcome.cut_off, "{outcome:?}");
    assert_eq!(again(&folder.path().join("record_1.mcap")).unwrap().same, 2);
}

/// Waits for the recorder's fault and returns it.
fn fault(recording: &RecorderHandle) -> String {
    let end = Instant::now() + Duration::from_secs(30);
    while Instant::now() < end {
        if let Some(fault) = recording.fault() {
            return fault;
        }
        recording.note(|| RecordedEvent::MonitorEvent(RecordedMonitorEvent::World));
        std::thread::sleep(Duration::from_millis(5));
    }
    panic!("no fault of the recording is told");
}

/// A recording to a disk that is full.
fn on_a_full_disk() -> (RecorderHandle, Recorder) {
    let path = PathBuf::from("/dev/full");
    let file = std::fs::OpenOptions::new().write(true).open(&path).unwrap();
    let settings = RecordingSettings { file: path.clone(), max_size: 0.0, max_duration: 0.0 };
    let names = Names::new("clearance", &[]).unwrap();
    let node = RecordedNode {
        names: &names,
        inputs: CommandLineInputs::default(),
        parameters: &Parameters::default(),
    };
    Recorder::write_to(file, path, &settings, node).unwrap()
}

#[test]
fn a_disk_that_is_full_is_a_fault_of_the_recording() {
    let (recording, recorder) = on_a_full_disk();
    let fault = fault(&recording);
    assert!(fault.contains("recording to /dev/full ended: "), "{fault}");
    assert!(fault.contains("No space left on device"), "{fault}");
    assert_eq!(recorder.finish(), Err(fault));
    assert!(recording.fault().is_some(), "it lasts");
}

#[test]
fn a_disk_that_is_full_at_the_end_is_a_fault_too() {
    // all of this recording waits in memory until its end
    let (_, recorder) = on_a_full_disk();
    let fault = recorder.finish().unwrap_err();
    assert!(fault.contains("ended: ") && fault.contains("No space left on device"), "{fault}");
}

#[test]
fn a_file_that_is_removed_is_no_complete_recording() {
    let folder = tempfile::tempdir().unwrap();
    let mut cell = Cell::start(folder.path());
    cell.turn(0.0);
    std::fs::remove_file(folder.path().join("record.mcap")).unwrap();
    assert!(cell.ended().unwrap_err().ends_with("record.mcap is incomplete: it was removed"));
}

#[test]
fn a_recording_without_a_file_of_the_robot_is_incomplete() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("record.mcap");
    let settings = RecordingSettings { file, max_size: 0.0, max_duration: 0.0 };
    let names = Names::new("clearance", &[]).unwrap();
    let files = vec![folder.path().join("gone.urdf")];
    let inputs = CommandLineInputs { files, ..CommandLineInputs::default() };
    let node = RecordedNode { names: &names, inputs, parameters: &Parameters::default() };
    let (_, recorder) = Recorder::start(&settings, node).unwrap();
    let fault = recorder.finish().unwrap_err();
    assert!(fault.contains("the recording lacks") && fault.contains("gone.urdf"), "{fault}");
}

#[test]
fn a_file_that_is_removed_or_moved_is_a_fault_of_the_recording_while_it_is_gone() {
    let folder = tempfile::tempdir().unwrap();
    let cell = Cell::start(folder.path());
    let (file, elsewhere) = (folder.path().join("record.mcap"), folder.path().join("other.mcap"));
    assert_eq!(cell.recording.fault(), None);
    std::fs::rename(&file, &elsewhere).unwrap();
    let fault = fault(&cell.recording);
    assert!(fault.contains("record.mcap was moved or removed"), "{fault}");
    std::fs::rename(&elsewhere, &file).unwrap();
    let end = Instant::now() + Duration::from_secs(30);
    while cell.recording.fault().is_some() {
        assert!(Instant::now() < end, "the fault is told though the file is back");
        std::thread::sleep(Duration::from_millis(5));
    }
    cell.end();
}
