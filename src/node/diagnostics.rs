//! `/diagnostics`: how the node and its robot are, in numbers.

use std::time::Duration;

use ros2_interfaces_jazzy_serde::diagnostic_msgs::msg::{DiagnosticArray, DiagnosticStatus, KeyValue};
use ros2_interfaces_jazzy_serde::std_msgs::msg::Header;

use super::messages::stamp_message;
use super::scene::CloudReport;
use crate::monitor::{Judgement, Reason, Status, Time};

/// What happened since the last report.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Activity {
    /// Joint states that came.
    pub heard: u32,
    /// Joint states that a newer one overtook before they could be judged.
    pub passed_over: u32,
    /// Messages that a subscriber's full window kept from being sent.
    pub dropped: u32,
    pub checks: u32,
    pub compute_time: Duration,
    pub longest_compute_time: Duration,
}

impl Activity {
    /// A joint state was judged.
    pub fn note_judged(&mut self, judgement: &Judgement) {
        self.heard += 1;
        if let Some(evidence) = &judgement.evidence {
            self.checks += 1;
            self.compute_time += evidence.compute_time;
            self.longest_compute_time = self.longest_compute_time.max(evidence.compute_time);
        }
    }
}

/// A report: what is known, what happened in the last `interval`, what was wrong with the last model if it was refused, and what
/// became of the last cloud of each topic.
#[must_use]
pub fn diagnostics(
    node: &str,
    now: Time,
    judgement: &Judgement,
    activity: &Activity,
    interval: Duration,
    model_fault: Option<&str>,
    clouds: &[(String, CloudReport)],
) -> DiagnosticArray {
    let mut values = values(judgement, activity, interval, model_fault);
    values.extend(clouds.iter().flat_map(|(topic, report)| cloud_values(topic, report)));
    let status = DiagnosticStatus {
        level: level(judgement, model_fault),
        name: format!("{}: collision monitor", node.trim_start_matches('/')),
        message: message(judgement, model_fault),
        hardware_id: (judgement.revision.as_ref())
            .map_or_else(String::new, |r| r.checker.robot().name().to_owned()),
        values,
    };
    let header = Header { stamp: stamp_message(now), frame_id: String::new() };
    DiagnosticArray { header, status: vec![status] }
}

fn level(judgement: &Judgement, model_fault: Option<&str>) -> u8 {
    match &judgement.status {
        Status::Unknown(Reason::Stale { .. } | Reason::NoJointState | Reason::NoClock) => {
            DiagnosticStatus::STALE
        }
        // someone meant it to be so
        Status::Unknown(Reason::Disabled) => DiagnosticStatus::WARN,
        Status::Unknown(_) | Status::Colliding => DiagnosticStatus::ERROR,
        Status::Free if judgement.warnings.is_empty() && model_fault.is_none() => DiagnosticStatus::OK,
        Status::Free => DiagnosticStatus::WARN,
    }
}

fn message(judgement: &Judgement, model_fault: Option<&str>) -> String {
    let message = match &judgement.status {
        Status::Free => match nearest(judgement) {
            Some(nearest) => format!("free; nearest: {nearest}"),
            None => "free; nothing is near".to_owned(),
        },
        Status::Colliding => format!("colliding: {}", colliding(judgement)),
        Status::Unknown(reason) => reason.to_string(),
    };
    match model_fault {
        // without any model the reason says it already
        Some(fault) if judgement.revision.is_some() => {
            format!("{message}; the last model was refused: {fault}")
        }
        _ => message,
    }
}

fn nearest(judgement: &Judgement) -> Option<String> {
    let nearest = judgement.evidence.as_ref()?.report.nearest?;
    let checker = &judgement.revision.as_ref()?.checker;
    let (a, b) = (checker.body_name(nearest.a), checker.body_name(nearest.b));
    Some(format!("{a} and {b}, {:.4} m", nearest.distance))
}

fn colliding(judgement: &Judgement) -> String {
    const NAMED: usize = 5;
    let (Some(evidence), Some(revision)) = (&judgement.evidence, &judgement.revision) else {
        return String::new();
    };
    let pairs = &evidence.report.colliding_pairs;
    let name = |body| revision.checker.body_name(body);
    let mut named: Vec<String> =
        pairs.iter().take(NAMED).map(|&(a, b)| format!("{} and {}", name(a), name(b))).collect();
    if pairs.len() > NAMED {
        named.push(format!("{} more pairs", pairs.len() - NAMED));
    }
    named.join(", ")
}

fn values(
    judgement: &Judgement,
    activity: &Activity,
    interval: Duration,
    model_fault: Option<&str>,
) -> Vec<KeyValue> {
    let mut values = Vec::new();
    let mut tell = |key: &str, value: String| values.push(KeyValue { key: key.to_owned(), value });
    tell("status", judgement.status.word().to_owned());
    if let Some(reason) = judgement.status.reason() {
        tell("reason", reason.code().to_owned());
    }
    if let Some(revision) = &judgement.revision {
        tell("model", revision.checker.robot().name().to_owned());
        tell("model revision", revision.model.to_string());
        tell("world revision", revision.world.to_string());
        tell("obstacles", revision.checker.world().len().to_string());
        tell("pairs checked", revision.checker.pairs().len().to_string());
        let skipped: usize = revision.checker.pairs().skipped().map(|(_, count)| count).sum();
        tell("pairs skipped", skipped.to_string());
    }
    if let Some(age) = judgement.age {
        tell("age of the joint state (s)", format!("{age:.3}"));
    }
    tell("least distance (m)", format!("{:.4}", judgement.distance()));
    let rate = f64::from(activity.heard) / interval.as_secs_f64().max(1e-3);
    tell("joint states per second", format!("{rate:.1}"));
    let mean = activity.compute_time / activity.checks.max(1);
    tell("mean compute time (ms)", milliseconds(mean));
    tell("longest compute time (ms)", milliseconds(activity.longest_compute_time));
    tell("joint states passed over", activity.passed_over.to_string());
    tell("speed scale", format!("{:.3}", judgement.speed_scale));
    tell("messages dropped", activity.dropped.to_string());
    for warning in judgement.warnings.iter() {
        tell("warning", warning.clone());
    }
    if let Some(fault) = model_fault {
        tell("model refused", fault.to_owned());
    }
    values
}

/// What became of the last cloud of a topic.
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
    let tell = |(key, value): (&str, String)| KeyValue { key: format!("{topic}: {key}"), value };
    values.into_iter().map(tell).collect()
}

fn milliseconds(duration: Duration) -> String {
    format!("{:.3}", duration.as_secs_f64() * 1e3)
}
