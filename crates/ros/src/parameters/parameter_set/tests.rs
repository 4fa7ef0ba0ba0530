//! Tests of the parameter set: defaults in `config/clearance.yaml`, rejected values, changes of a running node.

use super::*;
use crate::parameters::assignment::{assign, set_live};
use crate::parameters::declaration::Range;
use crate::parameters::declarations::DECLARATIONS;
use crate::parameters::declarations::declaration_of;
use crate::parameters::parameter_value;
use crate::parameters::parameter_value::Value;

const MANUAL: &str = include_str!("../../../../../config/clearance.yaml");

/// Comment directly above a parameter in the manual.
fn comment_above(name: &str) -> String {
    let lines: Vec<&str> = MANUAL.lines().map(str::trim).collect();
    let line = lines.iter().position(|line| line.starts_with(&format!("{name}:"))).unwrap();
    let above = lines[..line].iter().rposition(|line| !line.starts_with('#')).unwrap();
    lines[above + 1..line].iter().map(|line| line.trim_start_matches('#')).collect()
}

/// Parameters that all differ from their defaults, as far as a list can.
fn declaration_test_start(name: &str) -> Parameters {
    let mut parameters = Parameters::default();
    match name {
        "point_cloud_topics" => parameters.point_cloud_topics = vec!["/clouds".to_owned()],
        "obstacle_limits" => parameters.obstacle_limits = vec!["cart 1 2".to_owned()],
        "ssm_obstacle_speeds" => parameters.ssm_obstacle_speeds = vec!["cart 1".to_owned()],
        "ssm_resting_obstacles" => parameters.ssm_resting_obstacles = vec!["table".to_owned()],
        "transform_joints" => parameters.transform_joints = vec!["base".to_owned()],
        _ => {}
    }
    parameters
}

/// Sets one parameter.
fn set(parameters: &mut Parameters, name: &str, value: &Value) -> Result<(), String> {
    let mut changed = parameters.clone();
    assign(&mut changed, name, value)?;
    changed.check_together()?;
    *parameters = changed;
    Ok(())
}

#[test]
fn the_manual_holds_every_parameter_with_its_default_unit_and_range() {
    let manual: serde_json::Value = serde_saphyr::from_str(MANUAL).unwrap();
    let values = manual["/**/clearance"]["ros__parameters"].as_object().unwrap();
    let defaults = Parameters::default();
    for declaration in DECLARATIONS.iter() {
        let name = declaration.name;
        let mut as_written = declaration_test_start(name);
        set(&mut as_written, name, &parameter_value::from_node(&values[name])).unwrap();
        assert_eq!(declaration.get(&as_written), declaration.get(&defaults), "{name}");
        let begins = match declaration.range {
            Range::Bool => " true or false.".to_owned(),
            Range::Double { from, to } => format!(" {}, {from} to {to}.", declaration.unit),
            Range::Integer { from, to } => format!(" A whole number, {from} to {to}."),
            Range::Word(words) => format!(" {}.", words.join(" or ")),
            Range::Text => " A file.".to_owned(),
            Range::Service => " A service.".to_owned(),
            Range::Prefix => " A text.".to_owned(),
            Range::Volumes => " Kinds of volumes.".to_owned(),
            Range::Names(what) => format!(" A list of {what}."),
            Range::ObstacleLimits => " A list of texts 'NAME SPEED ACCELERATION'.".to_owned(),
            Range::ObstacleSpeeds => " A list of texts 'NAME SPEED'.".to_owned(),
            Range::Point => format!(" {}, three numbers or none.", declaration.unit),
        };
        let comment = comment_above(name);
        assert!(comment.starts_with(&begins), "{name} should begin with '{begins}': {comment}");
    }
    assert_eq!(values.len(), DECLARATIONS.len());
}

#[test]
fn a_rejected_value_is_named_with_its_reason_and_changes_nothing() {
    for (name, value, reason) in [
        ("padding", Value::Double(-0.1), "from 0 to 1 m, but -0.1"),
        ("padding", Value::Double(f64::NAN), "NaN"),
        ("heartbeat_rate", Value::Integer(0), "from 0.1 to 1000 Hz, but 0"),
        ("stale_after", Value::Text("long".into()), "a string"),
        ("publish_markers", Value::Integer(1), "an integer"),
        ("padding", Value::Other("an array"), "an array"),
        ("slowdown_trigger_count", Value::Integer(0), "from 1 to 1000, but 0"),
        ("slowdown_trigger_count", Value::Integer(-1), "from 1 to 1000, but -1"),
        ("slowdown_trigger_count", Value::Double(2.0), "is an integer, but a double"),
        ("joint_prefix", Value::Text("a b".into()), "letters, digits"),
        ("link_prefix", Value::Integer(1), "is a string, but an integer"),
        ("speed", Value::Bool(true), "'speed'"),
        ("link_volume_level", Value::Integer(21), "from -1 to 20, but 21"),
        ("link_volume_level", Value::Double(1.0), "a double"),
        ("unknown_space", Value::Text("full".into()), "free or occupied, but 'full'"),
        ("unknown_space", Value::Bool(true), "a bool"),
        (
            "volumes",
            Value::Text("sphere".into()),
            "'sphere' is no kind of bounding volume; there are obb, rss",
        ),
        ("volumes", Value::Text("rss,tip=ball".into()), "link 'tip': 'ball' is no kind"),
        ("volumes", Value::Integer(1), "is a string, but an integer"),
        ("point_cloud_topics", Value::Text("/a".into()), "a list of strings, but a string"),
        ("point_cloud_topics", Value::Texts(vec!["/a".into(), "/a".into()]), "twice"),
        ("point_cloud_topics", Value::Texts(vec!["a//b".into()]), "'a//b' is no name of a topic"),
        ("point_cloud_topics", Value::Texts(vec!["bad topic".into()]), "only letters"),
        ("point_cloud_topics", Value::Texts((0..40).map(|i| format!("/cloud{i}")).collect()), "at most 32"),
        ("planning_scene_service", Value::Text("/a//b".into()), "'/a//b' is no name of a service"),
        ("planning_scene_service", Value::Bool(true), "is a string, but a bool"),
        ("cloud_crop_min", Value::Doubles(vec![0.0; 2]), "three finite numbers"),
        ("cloud_crop_min", Value::Doubles(vec![0.0, f64::NAN, 0.0]), "three finite numbers"),
    ] {
        let mut parameters = Parameters::default();
        let error = set(&mut parameters, name, &value).unwrap_err();
        assert!(error.contains(name) && error.contains(reason), "{error}");
        assert_eq!(parameters, Parameters::default());
    }
    let mut parameters = Parameters::default();
    set(&mut parameters, "cloud_crop_min", &Value::Doubles(vec![0.0; 3])).unwrap();
    let error = set(&mut parameters, "cloud_crop_max", &Value::Doubles(vec![1.0, 0.0, 1.0])).unwrap_err();
    assert!(error.contains("must be below"), "{error}");
    set(&mut parameters, "cloud_crop_max", &Value::EmptyList).unwrap();
    set(&mut parameters, "heartbeat_rate", &Value::Integer(20)).unwrap();
    assert_eq!(declaration_of("heartbeat_rate").unwrap().get(&parameters), Value::Double(20.0));
}

#[test]
fn speed_and_separation_monitoring_needs_the_numbers_of_the_robot() {
    let mut parameters = Parameters::default();
    let ssm = ("speed_mode".to_owned(), Value::Text("ssm".to_owned()));
    let number = |name: &str, value: f64| (name.to_owned(), Value::Double(value));
    assert_eq!(parameters.monitor_settings().speed.separation, None);
    let given = ["ssm_robot_speed", "ssm_reaction_time", "ssm_deceleration"];
    for missing in given {
        let others = given.iter().filter(|name| **name != missing).map(|name| number(name, 0.5));
        let error = set_live(&mut parameters, &[ssm.clone()].into_iter().chain(others).collect::<Vec<_>>());
        let error = error.unwrap_err();
        assert!(error.contains(&format!("needs {missing} above 0")) && error.contains("together"), "{error}");
    }
    let all = [ssm, number(given[0], 1.0), number(given[1], 0.1), number(given[2], 2.0)];
    set_live(&mut parameters, &all).unwrap();
    set_live(&mut parameters, &[number("ssm_human_uncertainty", 0.1), number("ssm_intrusion_distance", 0.2)])
        .unwrap();
    let separation = parameters.monitor_settings().speed.separation.unwrap();
    assert!((separation.usual.margin - 0.3).abs() < 1e-12 && separation.usual.human_speed > 1.5);
    let before = parameters.clone();
    let error = set_live(&mut parameters, &[number(given[2], 0.01)]).unwrap_err();
    assert!(error.contains("up to 210") && error.contains("at most 10 m"), "{error}");
    assert!(set_live(&mut parameters, &[number(given[0], 0.0)]).is_err());
    let wrong = [("speed_mode".to_owned(), Value::Text("fast".to_owned()))];
    assert!(set_live(&mut parameters, &wrong).unwrap_err().contains("distances or ssm, but 'fast'"));
    assert_eq!(parameters, before);
}

/// Values that are set together are checked together.
#[test]
fn parameters_of_a_node_that_runs_change_together() {
    let corner = |name: &str, x: f64| (name.to_owned(), Value::Doubles(vec![x; 3]));
    let mut parameters = Parameters::default();
    set_live(&mut parameters, &[corner("cloud_crop_min", -1.0), corner("cloud_crop_max", 1.0)]).unwrap();
    set_live(&mut parameters, &[corner("cloud_crop_min", 2.0), corner("cloud_crop_max", 3.0)]).unwrap();
    let before = parameters.clone();
    let wrong = [corner("cloud_crop_min", 5.0), corner("cloud_crop_max", 4.0)];
    assert!(set_live(&mut parameters, &wrong).unwrap_err().contains("must be below"));
    let late = [("use_realtime_priority".to_owned(), Value::Bool(true))];
    assert!(set_live(&mut parameters, &late).unwrap_err().contains("at the start only"));
    assert_eq!(parameters, before);
    set_live(&mut parameters, &[("use_realtime_priority".to_owned(), Value::Bool(false))]).unwrap();
}
