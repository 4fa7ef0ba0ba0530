//! A root that drives, and obstacles that stay.

use super::*;

/// The robot's root drives along x through what `tf` calls `map`, or below `map` through `odom`.
fn drive(cell: &mut Cell, x: f64) -> bool {
    let transform = |parent: &str, x| Transform {
        parent: parent.to_owned(),
        pose_pf: at(x, 0.0, 0.0),
        stamp: Some(seconds(99.9 + 1e-3 * x)),
    };
    cell.transforms.note("base", transform("odom", x));
    cell.transforms.note("odom", Transform { stamp: None, ..transform("map", 0.0) });
    let is_due = cell.scene.grounds(&cell.robot).are_elsewhere(&cell.transforms);
    let context = SceneContext::new(&cell.robot, None, &cell.transforms, Some(seconds(100.0)), 1.0);
    let moved = cell.scene.follow_frames(&context);
    assert!(is_due || !moved);
    assert!(!cell.scene.grounds(&cell.robot).are_elsewhere(&cell.transforms));
    moved
}

#[test]
fn obstacles_stay_where_they_are_while_the_robot_drives() {
    let mut cell = Cell::new();
    // before tf says anything, what stands in the parent of the virtual joint is where it is if the robot stands at zero
    cell.object(add("early", "map", at(5.0, 0.0, 0.0))).unwrap();
    cell.object(add("beside", "", at(7.0, 0.0, 0.0))).unwrap();
    assert!(drive(&mut cell, 1.0));
    assert_eq!(cell.places("early"), [[4.0, 0.0, 0.0]]);
    assert_eq!(cell.places("beside"), [[7.0, 0.0, 0.0]], "nobody knows where the root was before");
    cell.object(add("table", "odom", at(5.0, 0.0, 0.0))).unwrap();
    cell.object(add("crate", "base", at(2.0, 0.0, 0.0))).unwrap();
    cell.attach(hold("flange", add("part", "base", at(3.0, 0.0, 0.0)))).unwrap();
    assert!(!drive(&mut cell, 1.0 + 1e-6));
    assert!(drive(&mut cell, 2.0));
    let xs = |cell: &Cell| ["early", "beside", "table", "crate"].map(|name| cell.places(name)[0][0]);
    assert_eq!(xs(&cell), [3.0, 6.0, 3.0, 1.0]);
    // what a link holds rides along, and stays where it is put down
    cell.attach(hold("", ObjectChange::named("part", Operation::Remove))).unwrap();
    assert_eq!(cell.places("part"), [[3.0, 0.0, 0.0]]);
    assert!(drive(&mut cell, 3.0));
    assert_eq!((xs(&cell), cell.places("part")[0][0]), ([2.0, 5.0, 2.0, 0.0], 2.0));
    // what is moved stands where it was put
    cell.object(shift("table", "hand", at(0.0, 0.0, 0.0))).unwrap();
    cell.object(remove("crate")).unwrap();
    assert!(drive(&mut cell, 4.0));
    assert_eq!(cell.places("table"), [[0.0, 0.0, 3.0]]);
    cell.object(remove("")).unwrap();
    assert!(!drive(&mut cell, 5.0));
}
