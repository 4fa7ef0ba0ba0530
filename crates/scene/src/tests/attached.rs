//! Tests of attached objects: attach, append, detach, reject.

use super::*;

#[test]
fn an_object_is_taken_up_carried_and_put_down() {
    let mut cell = Cell::new();
    let subframes = vec![("tip".to_owned(), at(0.0, 0.0, 0.5))];
    cell.object(ObjectChange { subframes, ..add("part", "hand", at(0.0, 0.0, -1.0)) }).unwrap();
    let attach = AttachedChange {
        touch_links: vec!["flange".to_owned(), "thumb".to_owned()],
        ..hold("hand", ObjectChange::named("part", Operation::Add))
    };
    assert!(cell.attach(attach).unwrap()[0].contains("touch_links: the robot has no link 'thumb'"));
    assert!(cell.names().is_empty());
    let held = Arc::clone(&cell.scene.world.attached()[0]);
    assert_eq!(held.pose_lo, at(0.0, 0.0, -1.0));
    assert!(held.may_touch("flange") && held.may_touch("hand") && !held.may_touch("base"));
    cell.object(add("under", "part/tip", at(0.0, 0.0, 0.0))).unwrap();
    assert_eq!(cell.places("under"), [[1.0, 0.0, 2.5]]);
    cell.refuses_object(add("part", "", at(0.0, 0.0, 0.0)), "id: it is attached to link 'hand'");

    // the hand is lifted by a metre
    let mut poses = LinkPoses::new(&cell.robot);
    cell.robot.forward_kinematics(&cell.robot.configuration(&[4.0]).unwrap(), &mut poses);
    cell.poses = Some(poses);
    cell.attach(hold("", ObjectChange::named("part", Operation::Remove))).unwrap();
    assert_eq!(cell.places("part"), [[1.0, 0.0, 3.0]]);
    assert!(cell.held().is_empty());
    let part = cell.scene.world.obstacle_by_name("part").unwrap();
    assert!(Arc::ptr_eq(&part.shapes, &held.shapes) && part.subframes.len() == 1);
}

#[test]
fn an_object_is_attached_with_shapes_of_its_own_and_extended() {
    let mut cell = Cell::new();
    cell.object(add("part", "", at(0.0, 0.0, 0.0))).unwrap();
    cell.attach(hold("hand", add("part", "base", at(1.0, 0.0, 5.0)))).unwrap();
    assert!(cell.names().is_empty());
    assert_eq!(cell.scene.world.attached()[0].pose_lo, at(0.0, 0.0, 2.0));
    let append = ObjectChange {
        operation: Operation::Append,
        shapes: vec![placed(at(0.0, 0.0, 1.0))],
        ..add("part", "hand", at(0.0, 0.0, 3.0))
    };
    cell.attach(hold("hand", append.clone())).unwrap();
    let held = &cell.scene.world.attached()[0];
    assert_eq!(held.pose_lo, at(0.0, 0.0, 3.0));
    assert_eq!(held.shapes.iter().map(|s| s.pose_os.translation.z).collect::<Vec<_>>(), [0.0, 1.0]);
    cell.refuses_attached(hold("flange", append.clone()), "link_name: it is attached to 'hand'");
    cell.attach(hold("hand", ObjectChange { pose_fo: Pose::identity(), ..append.clone() })).unwrap();
    let held = &cell.scene.world.attached()[0];
    assert_eq!((held.pose_lo, held.shapes.len()), (at(0.0, 0.0, 3.0), 3), "no pose is given");
    // a second ADD replaces it
    cell.attach(hold("flange", add("part", "flange", at(0.0, 0.0, 0.0)))).unwrap();
    assert_eq!((cell.held().len(), cell.scene.world.attached()[0].shapes.len()), (1, 1));

    // a pose in the frame of its link needs no joint state
    cell.poses = None;
    cell.attach(hold("hand", add("other", "hand", at(0.0, 0.0, 1.0)))).unwrap();
    cell.refuses_attached(
        hold("hand", add("third", "base", at(0.0, 0.0, 1.0))),
        "link_name: link 'hand' moves",
    );
    cell.object(ObjectChange::named("", Operation::Remove)).unwrap();
    cell.object(add("third", "", at(0.0, 0.0, 0.0))).unwrap();
    let warned = cell.attach(hold(
        "flange",
        ObjectChange { id: "third".to_owned(), frame: "flange".to_owned(), ..append },
    ));
    assert!(warned.unwrap()[0].contains("those it had in the world are gone"));
}

#[test]
fn all_objects_of_a_link_or_of_the_robot_are_put_down_together() {
    let mut cell = Cell::new();
    for (id, link) in [("a", "hand"), ("b", "flange"), ("c", "hand")] {
        cell.attach(hold(link, add(id, link, Pose::identity()))).unwrap();
    }
    let mut without = Cell { poses: None, ..Cell::new() };
    without.scene = cell.scene.clone();
    without.assert_rejected(
        &SceneUpdate::Attached(Box::new(hold("", remove("")))),
        Some("a"),
        "link_name: link 'hand' moves",
    );
    cell.attach(hold("hand", remove(""))).unwrap();
    assert_eq!((cell.held(), cell.places("c")), (vec!["b"], vec![[1.0, 0.0, 3.0]]));
    cell.attach(hold("", remove(""))).unwrap();
    assert_eq!(cell.names(), ["a", "b", "c"]);
    cell.attach(hold("", remove(""))).unwrap();
}

#[test]
fn broken_attachments_are_rejected_by_name() {
    let mut cell = Cell::new();
    cell.attach(hold("hand", add("held", "hand", Pose::identity()))).unwrap();
    let bare = |id: &str, operation| ObjectChange::named(id, operation);
    for (change, named) in [
        (hold("thumb", add("a", "", Pose::identity())), "link_name: the robot has no link 'thumb'"),
        (hold("", add("a", "", Pose::identity())), "link_name: the robot has no link ''"),
        (hold("hand", bare("a", Operation::Add)), "object: no shapes are given"),
        (hold("hand", bare("held", Operation::Append)), "object: no shapes are given"),
        (hold("hand", bare("held", Operation::Move)), "object.operation"),
        (hold("hand", bare("a", Operation::Remove)), "no link holds it"),
        (hold("flange", bare("held", Operation::Remove)), "attached to 'hand', not to 'flange'"),
        (hold("thumb", bare("held", Operation::Remove)), "link_name: the robot has no link 'thumb'"),
        (hold("thumb", bare("", Operation::Remove)), "link_name: the robot has no link 'thumb'"),
        (hold("hand", add("a", "nowhere", Pose::identity())), "header.frame_id: unknown frame"),
        (hold("hand", add("", "", Pose::identity())), "id is empty"),
        (hold("hand", add("flange", "", Pose::identity())), "id: the robot has a link"),
        (hold("hand", add(OCTOMAP, "", Pose::identity())), "belongs to what sensors see"),
    ] {
        cell.refuses_attached(change, named);
    }
}
