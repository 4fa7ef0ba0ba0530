//! `/diagnostics`: status and statistics of the node and the robot.

use std::time::Duration;

use clearance_checker::PairKind;
use clearance_geometry::math::Extremes;
use clearance_monitor::{Evaluation, Reason, Status, Time};
use ros2_interfaces_jazzy_serde::diagnostic_msgs::msg::{DiagnosticArray, DiagnosticStatus, KeyValue};
use ros2_interfaces_jazzy_serde::std_msgs::msg::Header;

use crate::messages::time_and_geometry::stamp_message;
use crate::monitor_events::cloud_report::CloudReport;
use crate::topics::activity::Activity;
use crate::topics::latencies::Latencies;

/// Diagnostics message: the current evaluation, the counters of the last `interval`, the error of the last model if it
/// was rejected, and the last point cloud of each topic.
#[must_use]
pub fn diagnostics(
    node: &str,
    now: Time,
    evaluation: &Evaluation,
    activity: &Activity,
    interval: Duration,
    model_fault: Option<&str>,
    clouds: &[(String, CloudReport)],
) -> DiagnosticArray {
    let mut values = values(evaluation, activity, interval, model_fault);
    values.extend(clouds.iter().flat_map(|(topic, report)| cloud_values(topic, report)));
    let status = DiagnosticStatus {
        level: level(evaluation, model_fault),
        name: format!("{}: collision monitor", node.trim_start_matches('/')),
        message: message(evaluation, model_fault),
        hardware_id: (evaluation.revision.as_ref())
            .map_or_else(String::new, |r| r.checker.robot().name().to_owned()),
        values,
    };
    let header = Header { stamp: stamp_message(now), frame_id: String::new() };
    DiagnosticArray { header, status: vec![status] }
}

fn level(evaluation: &Evaluation, model_fault: Option<&str>) -> u8 {
    match &evaluation.status {
        Status::Unknown(Reason::Stale { .. } | Reason::NoJointState | Reason::NoClock) => {
            DiagnosticStatus::STALE
        }
        // the user disabled the check on purpose
        Status::Unknown(Reason::Disabled) => DiagnosticStatus::WARN,
        Status::Unknown(_) | Status::Colliding => DiagnosticStatus::ERROR,
        Status::Free if evaluation.warnings.is_empty() && model_fault.is_none() => DiagnosticStatus::OK,
        Status::Free => DiagnosticStatus::WARN,
    }
}

fn message(evaluation: &Evaluation, model_fault: Option<&str>) -> String {
    let message = match &evaluation.status {
        Status::Free => match nearest(evaluation) {
            Some(nearest) => format!("free; nearest: {nearest}"),
            None => "free; nothing is near".to_owned(),
        },
        Status::Colliding => format!("colliding: {}", colliding(evaluation)),
        Status::Unknown(reason) => reason.to_string(),
    };
    match model_fault {
        // without any model, the reason already contains this fault
        Some(fault) if evaluation.revision.is_some() => {
            format!("{message}; the last model was rejected: {fault}")
        }
        _ => message,
    }
}

fn nearest(evaluation: &Evaluation) -> Option<String> {
    let nearest = evaluation.checked_state.as_ref()?.report.nearest?;
    let checker = &evaluation.revision.as_ref()?.checker;
    let (a, b) = (checker.body_name(nearest.a), checker.body_name(nearest.b));
    Some(format!("{a} and {b}, {:.4} m", nearest.distance))
}

fn colliding(evaluation: &Evaluation) -> String {
    const NAMED: usize = 5;
    let (Some(checked_state), Some(revision)) = (&evaluation.checked_state, &evaluation.revision) else {
        return String::new();
    };
    if let Some(passage) = evaluation.contact_since_previous() {
        return evaluation.passage_text(passage).unwrap_or_default();
    }
    let pairs = &checked_state.report.colliding_pairs;
    let name = |body| revision.checker.body_name(body);
    let mut named: Vec<String> =
        pairs.iter().take(NAMED).map(|&(a, b)| format!("{} and {}", name(a), name(b))).collect();
    if pairs.len() > NAMED {
        named.push(format!("{} more pairs", pairs.len() - NAMED));
    }
    named.join(", ")
}

fn values(
    evaluation: &Evaluation,
    activity: &Activity,
    interval: Duration,
    model_fault: Option<&str>,
) -> Vec<KeyValue> {
    let mut values = Vec::new();
    let mut add = |key: &str, value: String| values.push(KeyValue { key: key.to_owned(), value });
    add("status", evaluation.status.word().to_owned());
    if let Some(reason) = evaluation.status.reason() {
        add("reason", reason.code().to_owned());
    }
    if let Some(revision) = &evaluation.revision {
        add("model", revision.checker.robot().name().to_owned());
        add("model revision", revision.model.to_string());
        add("world revision", revision.world.to_string());
        add("obstacles", revision.checker.world().len().to_string());
        add("pairs checked", revision.checker.pairs().len().to_string());
        let skipped: usize = revision.checker.pairs().skipped().map(|(_, count)| count).sum();
        add("pairs skipped", skipped.to_string());
    }
    if let Some(age) = evaluation.age {
        add("age of the joint state (s)", format!("{age:.3}"));
    }
    add("least distance (m)", format!("{:.4}", evaluation.distance()));
    add("self distance (m)", format!("{:.4}", evaluation.distance_of(PairKind::SelfPair)));
    add("world distance (m)", format!("{:.4}", evaluation.distance_of(PairKind::WorldPair)));
    if let Some(checked_state) = &evaluation.checked_state {
        add("distances", if checked_state.is_exact { "exact" } else { "lower bounds" }.to_owned());
    }
    add("speed scale", format!("{:.3}", evaluation.speed_scale));
    let Activity { recent, total } = activity;
    #[expect(clippy::cast_precision_loss, reason = "far fewer than 2^52 arrive in a second")]
    let rate = recent.received() as f64 / interval.as_secs_f64().greater(1e-3);
    add("joint states per second", format!("{rate:.1}"));
    let mean = recent.compute_time / recent.checks.max(1);
    add("mean compute time (ms)", milliseconds(mean));
    add("longest compute time (ms)", milliseconds(recent.longest_compute_time));
    for (period, counters) in [("", recent), (" since start", total)] {
        for (name, value) in latency_values(&counters.latencies) {
            add(&format!("latency{period}: {name} (ms)"), milliseconds(value));
        }
    }
    add("seconds of this report", format!("{:.3}", interval.as_secs_f64()));
    for (period, counters) in [(" in this report", recent), ("", total)] {
        add(&format!("joint states received{period}"), counters.received().to_string());
        add(&format!("joint states evaluated{period}"), counters.evaluated.to_string());
        add(&format!("joint states passed over{period}"), counters.skipped.to_string());
        add(&format!("joint states lost{period}"), counters.lost.to_string());
        add(&format!("messages dropped{period}"), counters.dropped.to_string());
    }
    for warning in evaluation.warnings.iter() {
        add("warning", warning.clone());
    }
    if let Some(fault) = model_fault {
        add("model rejected", fault.to_owned());
    }
    values
}

/// Time from the reception of a joint state to the publication of its result; empty without results.
fn latency_values(latencies: &Latencies) -> Vec<(&'static str, Duration)> {
    if latencies.is_empty() {
        return Vec::new();
    }
    vec![("median", latencies.quantile(0.5)), ("p99", latencies.quantile(0.99)), ("max", latencies.max())]
}

/// Report on the last point cloud of a topic.
fn cloud_values(topic: &str, report: &CloudReport) -> Vec<KeyValue> {
    let mut values = vec![
        ("points avoided", report.points.to_string()),
        ("points that are no place", report.not_finite.to_string()),
        ("points cropped", report.cropped.to_string()),
        ("points of the robot itself", report.of_robot.to_string()),
        ("latency (ms)", milliseconds(report.latency)),
    ];
    if let Some(fault) = &report.fault {
        values.push(("last cloud not taken", fault.clone()));
    }
    if let Some(cause) = &report.blind {
        values.push(("last cloud shows nothing of the environment", cause.clone()));
    }
    let named = |(key, value): (&str, String)| KeyValue { key: format!("{topic}: {key}"), value };
    values.into_iter().map(named).collect()
}

fn milliseconds(duration: Duration) -> String {
    format!("{:.3}", duration.as_secs_f64() * 1e3)
}
