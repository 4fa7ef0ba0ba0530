//! Tests of recordings with contacts: the replay has the same contacts.

use super::*;

/// The rod's tip turns through a ball, with contacts of each state.
#[test]
fn contacts_are_the_same_again() {
    let folder = tempfile::tempdir().unwrap();
    let mut cell = Cell::start(folder.path());
    cell.transform();
    cell.turn(0.3);
    cell.cloud();
    cell.ball(1.0);
    cell.change(|p| p.contacts_per_pair = 3);
    let mut found = 0;
    for i in 0..20 {
        let evaluation = cell.turn(0.2 + 0.01 * f64::from(i));
        found += evaluation.checked_state.map_or(0, |checked_state| checked_state.contacts.len());
    }
    assert!(found > 3, "{found} contacts");
    cell.change(|p| p.contacts_per_pair = 0);
    assert!(cell.turn(0.3).checked_state.unwrap().contacts.is_empty());
    cell.end();
    let outcome = again(&folder.path().join("record.mcap")).unwrap();
    assert_eq!((outcome.same, outcome.late, outcome.difference), (22, 0, None));
}
