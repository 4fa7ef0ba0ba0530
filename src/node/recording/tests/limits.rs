//! What does not fit, is too long, or is there already.

use std::time::Instant;

use super::*;
use crate::node::mailbox;

#[test]
fn what_does_not_fit_is_lost_and_counted_and_nobody_waits() {
    let (items, items_in) = mailbox::bounded(2);
    let backlog = Arc::new(Backlog::default());
    let tape = Tape::to(items, Arc::clone(&backlog));
    for _ in 0..5 {
        tape.note(|| Happening::Told(Tidings::World));
    }
    assert_eq!(backlog.lost.load(std::sync::atomic::Ordering::Relaxed), 3);
    drop(items_in);
    tape.note(|| Happening::Told(Tidings::World));
    assert_eq!(backlog.lost.load(std::sync::atomic::Ordering::Relaxed), 3, "nobody records any more");
    assert!(!Tape::default().is_on());
    Tape::default().note(|| panic!("nothing is made that nobody records"));
}

#[test]
fn behind_what_was_lost_nothing_is_run() {
    let folder = tempfile::tempdir().unwrap();
    let mut cell = Cell::start(folder.path());
    cell.turn(0.1);
    cell.tape.lose(3);
    cell.turn(0.2);
    cell.end();
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
    // nobody listens any more, and nobody minds
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
