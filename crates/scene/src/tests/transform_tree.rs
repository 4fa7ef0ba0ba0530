//! Tests of the transform tree: history of replaced transforms, and transforms older than the stored one.

use clearance_geometry::math::Pose;

use crate::{NumberedPose, Transform, TransformTree};

use super::seconds;

fn insert(tree: &mut TransformTree, frame: &str, parent: &str, time: f64) {
    let (parent, pose_pf) = (parent.to_owned(), Pose::translation(time, 0.0, 0.0));
    assert!(tree.insert(frame, Transform { parent, pose_pf, stamp: Some(seconds(time)) }));
}

/// The positions along x of the poses since a transform.
fn since(tree: &TransformTree, frame: &str, number: u64) -> Option<Vec<f64>> {
    let x = |pose: &NumberedPose| pose.pose_pf.translation.x;
    Some(tree.poses_since(frame, number)?.iter().map(x).collect())
}

#[test]
fn late_readers_get_all_poses_and_the_one_before() {
    let mut tree = TransformTree::default();
    for time in [1.0, 2.0, 3.0] {
        insert(&mut tree, "base", "odom", time);
        insert(&mut tree, "odom", "map", 10.0 * time);
    }
    let read = tree.stored();
    assert_eq!(since(&tree, "base", 0).unwrap(), [1.0, 2.0, 3.0]);
    assert_eq!(since(&tree, "base", read).unwrap(), [3.0]);
    for time in [4.0, 5.0] {
        insert(&mut tree, "base", "odom", time);
    }
    assert_eq!(since(&tree, "base", read).unwrap(), [3.0, 4.0, 5.0]);
    assert_eq!(since(&tree, "odom", read).unwrap(), [30.0]);
    assert_eq!(since(&tree.latest(), "base", read).unwrap(), [5.0]);
    assert_eq!(since(&tree, "nothing", 0).unwrap(), Vec::<f64>::new());
}

#[test]
fn what_is_not_kept_is_not_passed_over_in_silence() {
    let mut tree = TransformTree::default();
    insert(&mut tree, "base", "odom", 1.0);
    let read = tree.stored();
    for i in 0..300 {
        insert(&mut tree, "base", "odom", 2.0 + 0.01 * f64::from(i));
    }
    assert_eq!(since(&tree, "base", read), None);
    assert!(since(&tree, "base", tree.stored() - 9).unwrap().len() == 10);
    // of very many frames, few poses are kept
    for round in 1..=100 {
        for frame in 0..1000 {
            insert(&mut tree, &format!("frame {frame}"), "odom", f64::from(round));
        }
    }
    assert_eq!(since(&tree, "frame 999", 0), None);
    assert!(since(&tree, "frame 999", tree.stored() - 10_000).is_some(), "some of each frame");
    assert!(since(&tree, "frame 999", tree.stored() - 1).is_some());
    // another parent
    let read = tree.stored();
    insert(&mut tree, "base", "odom", 9.0);
    insert(&mut tree, "base", "map", 10.0);
    assert_eq!(since(&tree, "base", read), None);
    assert_eq!(since(&tree, "base", tree.stored()).unwrap(), [10.0]);
    // two poses with one stamp
    let read = tree.stored();
    insert(&mut tree, "base", "map", 11.0);
    let pose_pf = Pose::translation(99.0, 0.0, 0.0);
    tree.insert("base", Transform { parent: "map".to_owned(), pose_pf, stamp: Some(seconds(11.0)) });
    assert_eq!(since(&tree, "base", read), None);
    assert_eq!(since(&tree, "base", tree.stored()).unwrap(), [99.0]);
    // the same pose again is no other one
    let read = tree.stored();
    tree.insert("base", Transform { parent: "map".to_owned(), pose_pf, stamp: Some(seconds(11.0)) });
    assert_eq!(since(&tree, "base", read).unwrap(), [99.0]);
}

#[test]
fn an_older_transform_replaces_a_newer_one_only_if_the_clock_was_set_back() {
    // stamps and times of reception (s) of two transforms; returns the stamp of the stored one
    let stored = |[first, second]: [(f64, Option<f64>); 2]| {
        let mut tree = TransformTree::default();
        for (time, received) in [first, second] {
            let (parent, pose_pf) = ("map".to_owned(), Pose::translation(time, 0.0, 0.0));
            let transform = Transform { parent, pose_pf, stamp: Some(seconds(time)) };
            assert!(tree.insert_received("base", transform, received.map(seconds)));
        }
        since(&tree, "base", tree.stored()).unwrap()
    };
    for late in [99.9, 99.0, 98.9, 95.0, 1.0] {
        assert_eq!(stored([(100.0, Some(100.0)), (late, Some(100.2))]), [100.0], "{late}");
        assert_eq!(stored([(100.0, None), (late, None)]), [100.0], "{late} without a clock");
    }
    for again in [4.9, 98.0] {
        assert_eq!(stored([(100.0, Some(100.0)), (again, Some(again))]), [again], "the clock was set back");
    }
    assert_eq!(stored([(500.0, Some(100.0)), (100.1, Some(100.1))]), [100.1], "a stamp of another clock");
    assert_eq!(stored([(100.9, Some(100.0)), (100.1, Some(100.1))]), [100.9], "within the largest lead");
}
