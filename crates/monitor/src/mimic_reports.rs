//! Reported positions of mimic joints. Checks use the position that follows from the leader joint, so the reports have
//! to agree with it.

use clearance_geometry::math::{Extremes, without_whole_turns};
use clearance_robot::{JointId, JointKind, RobotModel};

use super::received_states::{LAG, ReceivedState, SAME_TIME};
use super::{Reason, SourceId, Time};

/// Tolerance (rad; m for a sliding joint) between the reported position of a mimic joint and the position that follows
/// from its leader. Gears have play, and fingers are elastic.
const MIMIC_SLACK: f64 = 0.02;
const SLIDING_MIMIC_SLACK: f64 = 0.002;

/// Largest motion (rad; m for a sliding joint) of a mimic joint between its report and another message's report of its
/// leader.
const LONGEST_MOTION: f64 = 0.5;
const LONGEST_SLIDING_MOTION: f64 = 0.05;

/// A mimic joint, prepared for comparisons.
#[derive(Clone, Debug)]
pub(super) struct MimicJoint {
    joint: JointId,
    /// Index of the leader's position; `None`: the leader is fixed.
    leader: Option<usize>,
    multiplier: f64,
    offset: f64,
    slides: bool,
    /// Whether positions of this joint that differ by a full turn are equivalent.
    turns: bool,
}

impl MimicJoint {
    pub fn of(robot: &RobotModel, joint: JointId) -> Option<Self> {
        let mimic = robot.joint(joint).mimic?;
        let is_fixed = robot.joint(mimic.joint).kind == JointKind::Fixed;
        Some(Self {
            joint,
            leader: robot.first_position(mimic.joint).filter(|_| !is_fixed),
            multiplier: if is_fixed { 0.0 } else { mimic.multiplier },
            offset: mimic.offset,
            slides: matches!(robot.joint(joint).kind, JointKind::Prismatic(_)),
            turns: matches!(robot.joint(joint).kind, JointKind::Continuous(_)),
        })
    }

    fn expected(&self, leader: f64) -> f64 {
        if self.multiplier == 0.0 { self.offset } else { self.multiplier * leader + self.offset }
    }

    fn agrees(&self, reported: f64, expected: f64, way: f64) -> bool {
        let (slack, longest) = if self.slides {
            (SLIDING_MIMIC_SLACK, LONGEST_SLIDING_MOTION)
        } else {
            (MIMIC_SLACK, LONGEST_MOTION)
        };
        let apart = reported - expected;
        let apart = if self.turns { without_whole_turns(apart) } else { apart };
        // NaN never agrees
        apart.abs() <= slack + way.lesser(longest)
    }
}

/// Report of one mimic joint in one message.
#[derive(Clone, Copy, Debug)]
struct Report {
    mimic_joint: usize,
    stamp: Time,
    position: f64,
    rate: f64,
    /// Position of the leader in the same message, if it names the leader.
    leader: Option<f64>,
}

/// Result of a name of a mimic joint in a message; messages are processed newest first.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Naming {
    /// No newer message names the joint: this report is in force.
    InForce,
    Superseded,
    /// The message has named it before.
    Twice,
}

/// Latest reports of mimic joints: the newest of each joint, and those of other publishers of about the same time.
#[derive(Debug)]
pub(super) struct MimicReports<'t> {
    mimic_joints: &'t [MimicJoint],
    /// By mimic joint: the last processed message with its name.
    named_by: Vec<Option<usize>>,
    /// By mimic joint: publisher and stamp of the report in force.
    in_force: Vec<Option<(SourceId, Time)>>,
    reports: Vec<Report>,
}

impl<'t> MimicReports<'t> {
    pub fn new(mimic_joints: &'t [MimicJoint]) -> Self {
        let count = mimic_joints.len();
        Self { mimic_joints, named_by: vec![None; count], in_force: vec![None; count], reports: Vec::new() }
    }

    pub fn note_name(&mut self, mimic_joint: usize, message: usize) -> Naming {
        match self.named_by[mimic_joint].replace(message) {
            None => Naming::InForce,
            Some(last) if last == message => Naming::Twice,
            Some(_) => Naming::Superseded,
        }
    }

    /// Processes one message. `named` contains mimic joints with their index in the message, `leaders` the positions of
    /// leaders in it.
    pub fn take(&mut self, received: &ReceivedState, named: &[(usize, usize)], leaders: &[(usize, f64)]) {
        let (source, stamp) = (received.input.source, received.stamp);
        for &(mimic_joint, place) in named {
            let in_force = *self.in_force[mimic_joint].get_or_insert((source, stamp));
            let is_at_once = in_force.1.seconds_since(stamp).abs() < SAME_TIME;
            if in_force != (source, stamp) && (in_force.0 == source || !is_at_once) {
                continue;
            }
            let of_leader = |index| leaders.iter().find(|(leader, _)| *leader == index).map(|(_, q)| *q);
            self.reports.push(Report {
                mimic_joint,
                stamp,
                position: received.input.positions[place],
                rate: received.rates.get(place).copied().unwrap_or(f64::NAN),
                leader: self.mimic_joints[mimic_joint].leader.and_then(of_leader),
            });
        }
    }

    /// Reports that disagree with their leaders, at most one for each joint: the reported position, and the position
    /// that follows from the leader. Indexed by position: `positions` of leaders, their `rates`, and the stamps
    /// `sources` of their messages.
    pub fn contradictions(
        &self,
        positions: &[f64],
        rates: &[f64],
        sources: &[Option<(SourceId, Time)>],
    ) -> Vec<MimicContradiction> {
        let mut found: Vec<MimicContradiction> = Vec::new();
        for report in &self.reports {
            let mimic_joint = &self.mimic_joints[report.mimic_joint];
            let (expected, way) = match (report.leader, mimic_joint.leader) {
                (Some(leader), _) => (mimic_joint.expected(leader), 0.0),
                (None, None) => (mimic_joint.offset, 0.0),
                (None, Some(index)) => {
                    let apart =
                        sources[index].map_or(0.0, |(_, stamp)| stamp.seconds_since(report.stamp).abs());
                    let rates = [report.rate, mimic_joint.multiplier * rates[index]];
                    let fastest = rates.into_iter().filter(|rate| rate.is_finite()).map(f64::abs);
                    let way = fastest.fold(0.0, f64::greater) * (apart + LAG);
                    (mimic_joint.expected(positions[index]), way)
                }
            };
            let is_known = found.iter().any(|contradiction| contradiction.joint == mimic_joint.joint);
            if !is_known && !mimic_joint.agrees(report.position, expected, way) {
                let positions = [report.position, expected];
                found.push(MimicContradiction { joint: mimic_joint.joint, positions });
            }
        }
        found
    }
}

/// A mimic joint whose reported position differs from the position that follows from its leader.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct MimicContradiction {
    joint: JointId,
    /// The reported position, and the position that follows from the leader.
    positions: [f64; 2],
}

impl MimicContradiction {
    /// Reason for the status UNKNOWN; there are `more` such joints.
    pub fn reason(&self, robot: &RobotModel, more: usize) -> Reason {
        let joint = robot.joint(self.joint);
        let leader = joint.mimic.map_or(String::new(), |mimic| robot.joint(mimic.joint).name.clone());
        Reason::MimicContradiction { joint: joint.name.clone(), leader, positions: self.positions, more }
    }
}
