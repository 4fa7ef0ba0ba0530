//! Tests of values by joint name: mimic joints and their leaders, contradictions, rates and tolerances.

use std::fmt::Write;

use proptest::prelude::*;

use super::*;
use crate::MeshFiles;

/// `(name, leader, multiplier, offset)`; a joint without a leader is free.
type Spec<'s> = (&'s str, Option<(&'s str, f64, f64)>);

fn robot(joints: &[Spec]) -> RobotModel {
    let mut urdf = "<robot name='r'><link name='base'/>".to_owned();
    for (name, leader) in joints {
        let mimic = leader.map(|(leader, multiplier, offset)| {
            format!("<mimic joint='{leader}' multiplier='{multiplier:?}' offset='{offset:?}'/>")
        });
        write!(
            urdf,
            "<link name='of_{name}'/><joint name='{name}' type='revolute'><parent link='base'/><child link='of_{name}'/>\
             <axis xyz='0 0 1'/><limit lower='-1' upper='1' effort='1' velocity='1'/>{}</joint>",
            mimic.unwrap_or_default()
        )
        .unwrap();
    }
    RobotModel::from_urdf(&(urdf + "</robot>"), &MeshFiles::default()).unwrap()
}

/// A free joint; a joint that mimics it at twice the distance in the other direction; a joint that mimics that one; and a joint that
/// never moves.
fn chain() -> RobotModel {
    robot(&[
        ("drive", None),
        ("back", Some(("drive", -2.0, 0.1))),
        ("far", Some(("back", 3.0, 0.0))),
        ("stands", Some(("drive", 0.0, 0.25))),
        ("other", None),
    ])
}

fn error(robot: &RobotModel, named: &[(&str, f64)]) -> String {
    robot.configuration_from_names(named.iter().copied()).unwrap_err().to_string()
}

fn positions(robot: &RobotModel, named: &[(&str, f64)]) -> Vec<f64> {
    robot.configuration_from_names(named.iter().copied()).unwrap().positions().to_vec()
}

#[test]
fn a_mimic_joint_alone_moves_its_leader() {
    let robot = chain();
    assert_eq!(positions(&robot, &[("back", -0.9)]), [0.5, 0.0]);
    let far = positions(&robot, &[("far", 3.0 * -0.9), ("other", 1.0)]);
    assert!((far[0] - 0.5).abs() < 1e-12 && far[1] == 1.0, "{far:?}");
    let rest = robot.configuration(&[0.7, 0.3]).unwrap();
    let over = robot.configuration_over(&rest, [("back", 0.1)]).unwrap();
    assert_eq!(over.positions(), [0.0, 0.3]);
}

#[test]
fn mimic_joints_that_agree_are_accepted_in_any_order() {
    let robot = chain();
    let named = [("far", -2.7), ("stands", 0.25), ("back", -0.9 + 1e-7), ("drive", 0.5)];
    assert_eq!(positions(&robot, &named), [0.5, 0.0]);
    assert_eq!(positions(&robot, &[("back", -0.9), ("far", -2.7)])[1], 0.0);
}

#[test]
fn a_contradiction_names_both_joints_and_both_values() {
    let robot = chain();
    for (named, words) in [
        (
            &[("back", 0.5), ("drive", 0.0)][..],
            &["'back'", "0.5", "'drive'", "position 0 makes that 0.1"][..],
        ),
        (&[("drive", 0.0), ("far", 0.0)], &["'far'", "'drive'", "0.3"]),
        (&[("back", 0.1), ("far", 3.0)], &["'back'", "0.1", "'drive'", "'far' has 3"]),
        (&[("stands", 0.3)], &["'stands'", "0.3", "'drive'", "0.25"]),
        (&[("back", 0.1 + 2e-6), ("drive", 0.0)], &["'back'"]),
    ] {
        let error = error(&robot, named);
        assert!(words.iter().all(|word| error.contains(word)), "{error} does not name {words:?}");
    }
}

#[test]
fn numbers_that_are_none_and_names_given_twice_are_rejected() {
    let robot = chain();
    assert!(error(&robot, &[("back", f64::NAN)]).contains("'back'"));
    assert!(error(&robot, &[("stands", f64::INFINITY)]).contains("'stands'"));
    assert!(error(&robot, &[("back", 0.1), ("back", 0.1)]).contains("'back' is given twice"));
    let named = robot.named_joints(["back", "drive"]).unwrap();
    for values in [&[0.1][..], &[0.1, 0.0, 0.0]] {
        let wrong = Err(ConfigurationError::WrongCount { given: values.len(), expected: 2 });
        assert_eq!(named.configuration(&robot.default_configuration(), values), wrong);
    }
    let tiny = self::robot(&[("drive", None), ("k", Some(("drive", 1e-300, 0.0)))]);
    assert!(error(&tiny, &[("k", 0.5)]).contains("'drive'"));
    assert!(error(&tiny, &[("k", 1e9)]).contains("'drive'"));
}

#[test]
fn rates_of_mimic_joints_are_those_of_their_leaders() {
    let robot = chain();
    let rates = |names: &[&str], values: &[f64], scale: f64| {
        let named = robot.named_joints(names.iter().copied()).unwrap();
        named.rates("velocity", values, scale).map_err(|error| error.to_string())
    };
    assert_eq!(rates(&["back"], &[3.0], 1.0), Ok(vec![Some(-1.5), None]));
    assert_eq!(rates(&["back", "drive", "stands"], &[3.0, -1.5, 0.0], 1.0), Ok(vec![Some(-1.5), None]));
    let error = rates(&["back", "drive"], &[3.0, 1.5], 1.0).unwrap_err();
    assert!(
        ["'back'", "'drive'", "velocity 3", "velocity 1.5", "-3"].iter().all(|w| error.contains(w)),
        "{error}"
    );
    assert!(rates(&["stands"], &[1.0], 1.0).unwrap_err().contains("'stands'"));
    // over a long time, a small difference adds up
    let nearly = [3.0 + 5e-7, -1.5];
    assert!(
        rates(&["back", "drive"], &nearly, 1.0).is_ok() && rates(&["back", "drive"], &nearly, 10.0).is_err()
    );
}

#[test]
fn tolerances_of_mimic_joints_count_for_their_leaders() {
    let robot = chain();
    let tolerances = |names: &[&str], values: &[f64]| {
        let named = robot.named_joints(names.iter().copied()).unwrap();
        named.tolerances(values).map_err(|error| error.to_string())
    };
    assert_eq!(tolerances(&["back"], &[0.5]), Ok(vec![0.25, 0.0]));
    assert_eq!(tolerances(&["drive", "back", "other"], &[0.1, 0.5, 1.0]), Ok(vec![0.25, 1.0]));
    assert_eq!(tolerances(&["drive", "back"], &[0.3, 0.5]), Ok(vec![0.3, 0.0]));
    assert_eq!(tolerances(&["stands", "drive"], &[0.0, 0.3]), Ok(vec![0.3, 0.0]));
    assert!(tolerances(&["stands"], &[0.1]).unwrap_err().contains("'stands'"));
    for bad in [-0.5, f64::NAN, f64::INFINITY] {
        assert!(tolerances(&["back"], &[bad]).unwrap_err().contains("'back'"), "{bad}");
        assert!(tolerances(&["drive"], &[bad]).unwrap_err().contains("'drive'"), "{bad}");
    }
}

#[test]
fn joints_that_mimic_have_limits_of_their_own() {
    let robot = chain();
    let outside = |drive: f64| -> Vec<String> {
        robot.outside_limits(&[drive, 0.0]).map(|joint| joint.to_string()).collect()
    };
    assert!(outside(0.1).is_empty());
    let names = outside(0.7);
    assert_eq!(names.len(), 2, "{names:?}");
    assert!(names[0].contains("'back' is at -1.29") && names[1].contains("'far'"), "{names:?}");
}

/// Up to eight joints, of which each may mimic an earlier one.
fn random_robots() -> impl Strategy<Value = Vec<Option<(usize, f64, f64)>>> {
    let multiplier = prop_oneof![1 => Just(0.0), 6 => 0.1..3.0_f64, 6 => -3.0..-0.1_f64];
    let mimic = (any::<prop::sample::Index>(), multiplier, -1.0..1.0_f64);
    let joint = prop::option::weighted(0.7, mimic);
    prop::collection::vec(joint, 1..8).prop_map(|joints| {
        let indexed = joints.into_iter().enumerate();
        indexed.map(|(i, mimic)| mimic.filter(|_| i > 0).map(|(of, m, o)| (of.index(i), m, o))).collect()
    })
}

proptest! {
    /// Joints named with consistent values, in any order, all get these values. An inconsistent value is rejected, or moves the joint
    /// there.
    #[test]
    fn every_value_that_is_given_is_where_its_joint_is(
        joints in random_robots(),
        drives in prop::collection::vec(-2.0..2.0_f64, 8),
        order in Just((0..8_usize).collect::<Vec<_>>()).prop_shuffle(),
        count in 1..8_usize,
        off in prop::option::of(0.001..1.0_f64),
    ) {
        let names: Vec<String> = (0..joints.len()).map(|i| format!("j{i}")).collect();
        let specs: Vec<Spec> = joints.iter().enumerate()
            .map(|(i, mimic)| (names[i].as_str(), mimic.map(|(of, m, o)| (names[of].as_str(), m, o))))
            .collect();
        let robot = robot(&specs);
        let q = robot.configuration(&drives[..robot.position_names().len()]).unwrap();
        let at = |q: &Configuration, name: &str| robot.joint_position(q, robot.joint_by_name(name).unwrap()).unwrap();
        let chosen: Vec<&str> = order.iter().filter_map(|i| names.get(*i)).take(count).map(String::as_str).collect();
        let mut values: Vec<f64> = chosen.iter().map(|name| at(&q, name)).collect();
        if let Some(off) = off {
            values[0] += off;
        }
        let named = robot.named_joints(chosen.iter().copied()).unwrap();
        match named.configuration(&robot.default_configuration(), &values) {
            Ok(found) => for (name, value) in chosen.iter().zip(&values) {
                prop_assert!((at(&found, name) - value).abs() <= MIMIC_TOLERANCE);
            },
            Err(error) => prop_assert!(
                off.is_some() && matches!(error, ConfigurationError::Mimic(_)), "{error}"
            ),
        }
    }
}
