//! Tests of the allowed collision matrix of a scene: replaced, cleaned of removed objects, written again.

use super::*;

#[test]
fn a_matrix_takes_the_place_of_the_one_before_and_loses_what_is_removed() {
    let mut cell = Cell::new();
    cell.object(add("a", "", Pose::identity())).unwrap();
    let with = |matrix| SceneChange { matrix, ..difference(vec![], vec![]) };
    let warnings = cell.scene(with(entries(&["hand", "a"], true))).unwrap();
    assert!(warnings[0].contains("takes the place of all entries"));
    let allows = |cell: &Cell, a: &str, b: &str| cell.scene.matrix.as_ref().unwrap().allows(a, b);
    assert!(allows(&cell, "a", "hand"));
    cell.scene(difference(vec![add("b", "", Pose::identity())], vec![])).unwrap();
    assert!(allows(&cell, "a", "hand"), "a difference without a matrix leaves it alone");
    cell.object(remove("a")).unwrap();
    cell.object(add("a", "", Pose::identity())).unwrap();
    assert!(!allows(&cell, "a", "hand"), "another object of the name is another thing");
    cell.scene(with(entries(&["b", "hand"], true))).unwrap();
    assert!(allows(&cell, "b", "hand"));

    let mut defaults = MatrixEntries::default();
    (defaults.default_entry_names, defaults.default_entry_values) = (vec!["a".to_owned()], vec![true]);
    assert!(cell.scene(with(defaults)).unwrap()[0].contains("default entries alone"));
    assert!(!allows(&cell, "a", "hand"));
    let mut broken = entries(&["b", "hand"], true);
    broken.entry_values.pop();
    cell.assert_rejected(
        &SceneUpdate::Scene(Box::new(with(broken))),
        None,
        "allowed_collision_matrix: 2 entry_names",
    );
}

/// `AllowedCollisionMatrix::removeEntry` removes entries of pairs, and leaves default entries.
#[test]
fn defaults_of_a_removed_object_hold_for_the_next_one_of_its_name() {
    let mut given = entries(&["a", "hand"], true);
    given.default_entry_names = vec!["a".to_owned(), "hand".to_owned()];
    given.default_entry_values = vec![false, true];
    for removal in [remove("a"), remove("")] {
        let mut cell = Cell::new();
        cell.object(add("a", "", Pose::identity())).unwrap();
        cell.scene(SceneChange { matrix: given.clone(), ..difference(vec![], vec![]) }).unwrap();
        cell.object(removal).unwrap();
        cell.object(add("a", "", Pose::identity())).unwrap();
        let matrix = cell.scene.matrix.as_ref().unwrap();
        assert!(!matrix.has_entries("a") && matrix.mentions("a") && !matrix.allows("a", "hand"));
        assert!(matrix.allows("b", "hand"));
    }
}

#[test]
fn matrices_go_both_ways() {
    let mut given = entries(&["a", "b", "c"], false);
    given.entry_values[0][2] = true;
    given.entry_values[2][0] = true;
    (given.default_entry_names, given.default_entry_values) = (vec!["d".to_owned()], vec![true]);
    let matrix = AllowedCollisionMatrix::from_entries(&given).unwrap();
    assert_eq!(matrix.to_entries(), given);
}
