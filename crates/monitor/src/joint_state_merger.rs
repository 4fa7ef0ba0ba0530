//! Merges joint states into a configuration, or returns why that is not possible.

use std::collections::{BTreeMap, HashMap};

use clearance_geometry::constants::LARGEST_COORDINATE;
use clearance_geometry::math::{Extremes, without_whole_turns};
use clearance_robot::{Configuration, RobotModel, check_name_length, quoted, quoted_list};

use super::contribution::{Contribution, Contributions};
use super::mimic_reports::{MimicJoint, MimicReports, Naming};
use super::received_states::{LAG, ReceivedState, SAME_TIME};
use super::transform_joints::{PlacedPositions, TransformReading};
use super::{JointStateInput, MonitorSettings, Reason, SourceId, Time};

/// Tolerance (rad, m) between two publishers' reports of a joint with almost the same time (s); the joint's motion
/// during a lag is added.
const CONTRADICTION: f64 = 0.05;

/// Limits for unknown joint names that are stored of a message, and for their length: the message may be another
/// robot's.
const MOST_UNKNOWN_JOINTS: usize = 1000;
const LONGEST_NAME: usize = 100;

/// Meaning of a name in a joint state.
#[derive(Clone, Copy, Debug)]
enum Slot {
    /// The position with this index in a configuration.
    Position(usize),
    /// The mimic joint with this index among the robot's mimic joints.
    Mimic(usize),
    /// A joint without a position under this name.
    Nothing,
}

/// Message index of positions that come from `tf`.
const BY_TF: usize = usize::MAX;

/// Reads joint states for one robot.
#[derive(Clone, Debug)]
pub(super) struct JointStateMerger {
    slots: HashMap<String, Slot>,
    /// By position: whether values that differ by a full turn are equivalent, also for the joints that mimic it.
    turns: Vec<bool>,
    mimic_joints: Vec<MimicJoint>,
}

/// A merged configuration, with warnings about its messages.
#[derive(Clone, Debug)]
pub(super) struct MergedState {
    pub configuration: Configuration,
    /// Velocity of each position, if all are given and finite.
    pub velocities: Option<Vec<f64>>,
    /// The same, with velocities of other streams computed from successive messages.
    pub rates: Option<Vec<f64>>,
    /// Whether the rates can be used for each joint: they come from several streams, or from one stream with
    /// velocities.
    pub are_of_joints: bool,
    /// By position: the stamp of its message; `None` for positions from `tf`.
    pub measured: Vec<Option<Time>>,
    /// Difference (s) between the times of measurement of the joints.
    pub spread: f64,
    pub warnings: Vec<String>,
}

impl JointStateMerger {
    pub fn new(robot: &RobotModel) -> Self {
        let (mut slots, mut mimic_joints) = (HashMap::new(), Vec::new());
        for id in robot.joint_ids() {
            let mimic_joint = MimicJoint::of(robot, id);
            let slot = mimic_joint.as_ref().map_or(Slot::Nothing, |_| Slot::Mimic(mimic_joints.len()));
            mimic_joints.extend(mimic_joint);
            slots.insert(robot.joint(id).name.clone(), slot);
        }
        for (index, name) in robot.position_names().iter().enumerate() {
            slots.insert(name.clone(), Slot::Position(index));
        }
        Self { slots, turns: robot.whole_turns(), mimic_joints }
    }

    /// By position: whether full turns make no difference.
    pub fn turns(&self) -> &[bool] {
        &self.turns
    }

    /// Index of the position with this name in a joint state.
    pub fn position_index(&self, name: &str) -> Option<usize> {
        match self.slots.get(name) {
            Some(&Slot::Position(index)) => Some(index),
            _ => None,
        }
    }

    /// Merges messages, given in the order of reception. For each joint, the last message with its name counts, unless
    /// its position comes from `tf`. Also returns the messages in use.
    pub fn read(
        &self,
        robot: &RobotModel,
        received: &[ReceivedState],
        is_fresh: impl Fn(&ReceivedState) -> bool,
        from_transforms: TransformReading,
        settings: &MonitorSettings,
    ) -> (Result<MergedState, Reason>, Contributions) {
        let mut merge = Merge::new(self, &settings.joint_prefix);
        merge.place(&from_transforms.placed);
        for (message, received) in received.iter().enumerate().rev() {
            merge.take(message, received, is_fresh(received));
        }
        let contributions = std::mem::take(&mut merge.contributions);
        let mimic_is_unknown = settings.mimic_contradiction_is_unknown;
        (merge.finish(robot, from_transforms.unknown, (&contributions, mimic_is_unknown)), contributions)
    }
}

/// A message during the processing of its names.
struct Message<'h> {
    number: usize,
    received: &'h ReceivedState,
    is_fresh: bool,
    fault: Option<Reason>,
    /// Indices of the positions for which it is the last message.
    mine: Vec<usize>,
    /// Mimic joints that it names, with their indices in the message.
    mimic_joints: Vec<(usize, usize)>,
    /// Positions in it, with which mimic joints have to agree.
    leaders: Vec<(usize, f64)>,
    /// Whether a newer message names one of its joints.
    is_superseded: bool,
    /// Whether it is the last message with the name of a mimic joint.
    decides_mimic_joints: bool,
}

impl Message<'_> {
    /// Whether it has a position for each name.
    fn is_whole(&self) -> bool {
        self.received.input.names.len() == self.received.input.positions.len()
    }

    fn note_twice(&mut self, place: usize) {
        let twice = format!("joint {} stands in it twice", quoted(&self.received.input.names[place]));
        self.fault = first(self.fault.take(), Some(Reason::Malformed(twice)));
    }

    /// Records an error of one of its positions, if it has one for each name.
    fn note_value(&mut self, place: usize) {
        if self.is_whole() {
            let JointStateInput { names, positions, .. } = &self.received.input;
            self.fault = first(self.fault.take(), fault_of(&names[place], positions[place]));
        }
    }
}

/// Report of one position by a publisher.
struct PositionReport {
    source: SourceId,
    stamp: Time,
    position: f64,
    rate: f64,
}

/// Merge of messages into one state, the newest first.
struct Merge<'t> {
    joint_state_merger: &'t JointStateMerger,
    /// Prefix of the robot's joint names; other names belong to another robot.
    prefix: &'t str,
    /// By position: index of the message in use.
    named_by: Vec<Option<usize>>,
    /// By position: publisher and stamp of that message.
    sources: Vec<Option<(SourceId, Time)>>,
    positions: Vec<f64>,
    velocities: Vec<f64>,
    rates: Vec<f64>,
    mimic: MimicReports<'t>,
    contributions: Contributions,
    /// Error of the newest message with an error.
    fault: Option<Reason>,
    unknown_joints: Vec<String>,
    warnings: Vec<String>,
    /// By position: the two contradicting values.
    contradictions: BTreeMap<usize, [f64; 2]>,
}

impl<'t> Merge<'t> {
    fn new(joint_state_merger: &'t JointStateMerger, prefix: &'t str) -> Self {
        let count = joint_state_merger.turns.len();
        Self {
            joint_state_merger,
            prefix,
            named_by: vec![None; count],
            sources: vec![None; count],
            positions: vec![f64::NAN; count],
            velocities: vec![f64::NAN; count],
            rates: vec![f64::NAN; count],
            mimic: MimicReports::new(&joint_state_merger.mimic_joints),
            contributions: Contributions::default(),
            fault: None,
            unknown_joints: Vec::new(),
            warnings: Vec::new(),
            contradictions: BTreeMap::new(),
        }
    }

    /// Takes the positions from `tf`; joint states do not affect them.
    fn place(&mut self, placed: &[PlacedPositions]) {
        for PlacedPositions { first, positions } in placed {
            for (index, &position) in positions.iter().enumerate().map(|(i, p)| (first + i, p)) {
                self.named_by[index] = Some(BY_TF);
                self.positions[index] = position;
            }
        }
    }

    fn take(&mut self, number: usize, received: &ReceivedState, is_fresh: bool) {
        let JointStateInput { names, positions, stamp, .. } = &received.input;
        let is_whole = names.len() == positions.len();
        let mut fault = received.behind.map(|behind| Reason::OutOfOrder { behind });
        if !is_whole {
            let counts = format!("it has {} names and {} positions", names.len(), positions.len());
            fault = first(fault, Some(Reason::Malformed(counts)));
        }
        if let Some(Err(excess)) = names.iter().map(|name| check_name_length(name)).find(Result::is_err) {
            fault = first(fault, Some(Reason::Malformed(excess)));
        }
        let mut message = Message {
            number,
            received,
            is_fresh,
            fault,
            mine: Vec::new(),
            mimic_joints: Vec::new(),
            leaders: Vec::new(),
            is_superseded: false,
            decides_mimic_joints: false,
        };
        let mut unknown_joints = Vec::new();
        for (place, name) in names.iter().enumerate() {
            match self.joint_state_merger.slots.get(name) {
                Some(&Slot::Position(index)) => self.take_position(&mut message, index, place),
                Some(&Slot::Mimic(index)) => self.take_mimic_joint(&mut message, index, place),
                None if unknown_joints.len() < MOST_UNKNOWN_JOINTS && name.starts_with(self.prefix) => {
                    unknown_joints.push(name.chars().take(LONGEST_NAME).collect());
                }
                Some(Slot::Nothing) | None => {}
            }
        }
        let Message { mine, mimic_joints, leaders, is_superseded, decides_mimic_joints, fault, .. } = message;
        if is_whole && is_fresh {
            self.mimic.take(received, &mimic_joints, &leaders);
        }
        if !mine.is_empty() || (is_fresh && !is_superseded) {
            self.unknown_joints.append(&mut unknown_joints);
        }
        if !mine.is_empty() || (is_fresh && decides_mimic_joints) {
            self.fault = first(self.fault.take(), fault);
        } else if is_fresh && !is_superseded && !is_whole {
            self.note_malformed_unknown(names, fault);
        }
        if mine.is_empty() {
            return;
        }
        if *stamp == Time::ZERO {
            let warning = "the joint state has no stamp: it counts as measured when it came";
            self.warnings.push(warning.to_owned());
        }
        let ReceivedState { stamp, at, .. } = *received;
        self.contributions.0.push(Contribution { stamp, at, positions: mine });
    }

    fn take_position(&mut self, message: &mut Message, index: usize, place: usize) {
        let &mut Message { number, received, is_fresh, .. } = message;
        let is_whole = message.is_whole();
        let JointStateInput { names, positions, velocities, .. } = &received.input;
        let rate = received.rates.get(place).copied().unwrap_or(f64::NAN);
        if is_whole && !self.joint_state_merger.mimic_joints.is_empty() {
            message.leaders.push((index, positions[place]));
        }
        match self.named_by[index] {
            Some(other) if other == number => message.note_twice(place),
            Some(_) => {
                message.is_superseded = true;
                if is_whole && is_fresh {
                    let (source, stamp) = (received.input.source, received.stamp);
                    let report = PositionReport { source, stamp, position: positions[place], rate };
                    self.note_contradiction(index, report);
                }
            }
            None => {
                self.named_by[index] = Some(number);
                self.sources[index] = Some((received.input.source, received.stamp));
                message.mine.push(index);
                if is_whole {
                    self.positions[index] = positions[place];
                }
                message.note_value(place);
                let moves = velocities.len() == names.len();
                self.velocities[index] = if moves { velocities[place] } else { f64::NAN };
                self.rates[index] = rate;
            }
        }
    }

    fn take_mimic_joint(&mut self, message: &mut Message, index: usize, place: usize) {
        match self.mimic.note_name(index, message.number) {
            Naming::Twice => message.note_twice(place),
            Naming::Superseded => message.mimic_joints.push((index, place)),
            Naming::InForce => {
                message.mimic_joints.push((index, place));
                message.decides_mimic_joints = true;
                message.note_value(place);
            }
        }
    }

    /// Warns about a malformed message that names no joint of the robot, unless its names have another robot's prefix.
    /// Such a message does not make the status UNKNOWN.
    fn note_malformed_unknown(&mut self, names: &[String], fault: Option<Reason>) {
        let is_of_another = !names.is_empty() && !names.iter().any(|name| name.starts_with(self.prefix));
        if let Some(Reason::Malformed(what)) = fault.filter(|_| !is_of_another) {
            self.warnings
                .push(format!("a joint state about none of the robot's joints is malformed: {what}"));
        }
    }

    /// Detects that another publisher reports a different position of a joint. One of the two is wrong, and which one
    /// is in use is random.
    fn note_contradiction(
        &mut self,
        index: usize,
        PositionReport { source, stamp, position, rate }: PositionReport,
    ) {
        let Some((other, sources)) = self.sources[index] else { return };
        let counts = self.positions[index];
        let at_once = other != source && sources.seconds_since(stamp).abs() < SAME_TIME;
        let rates = [rate, self.rates[index]].into_iter().filter(|rate| rate.is_finite());
        let fastest = rates.map(f64::abs).fold(0.0, f64::greater);
        let way = position - counts;
        let way = if self.joint_state_merger.turns[index] { without_whole_turns(way) } else { way };
        if at_once && way.abs() > CONTRADICTION + fastest * LAG {
            self.contradictions.entry(index).or_insert([counts, position]);
        }
    }

    fn finish(
        mut self,
        robot: &RobotModel,
        unplaced: Option<Reason>,
        (contributions, mimic_is_unknown): (&Contributions, bool),
    ) -> Result<MergedState, Reason> {
        if let Some(fault) = self.fault.or(unplaced) {
            return Err(fault);
        }
        let names = robot.position_names().iter().zip(&self.named_by);
        let missing: Vec<String> =
            names.filter(|(_, by)| by.is_none()).map(|(name, _)| name.clone()).collect();
        if !missing.is_empty() {
            return Err(Reason::Partial { missing });
        }
        if let Some((&index, &positions)) = self.contradictions.first_key_value() {
            let joint = robot.position_names()[index].clone();
            return Err(Reason::Contradiction { joint, positions, more: self.contradictions.len() - 1 });
        }
        let mimic = self.mimic.contradictions(&self.positions, &self.rates, &self.sources);
        if let Some(contradiction) = mimic.first().filter(|_| mimic_is_unknown) {
            return Err(contradiction.reason(robot, mimic.len() - 1));
        }
        let configuration =
            (robot.configuration(&self.positions)).map_err(|error| Reason::Malformed(error.to_string()))?;
        self.warnings.extend(robot.outside_limits(configuration.positions()).map(|joint| joint.to_string()));
        if !self.unknown_joints.is_empty() {
            self.unknown_joints.sort_unstable();
            self.unknown_joints.dedup();
            self.warnings.push(format!("the robot has no joint {}", quoted_list(&self.unknown_joints)));
        }
        self.warnings.extend(mimic.iter().map(|contradiction| contradiction.reason(robot, 0).to_string()));
        let all = |numbers: Vec<f64>| numbers.iter().all(|v| v.is_finite()).then_some(numbers);
        let velocities = all(self.velocities);
        // for one stream without velocities, the motion follows from its complete states
        let are_of_joints = velocities.is_some() || contributions.0.len() > 1;
        let rates = all(self.rates);
        Ok(MergedState {
            configuration,
            velocities,
            rates,
            are_of_joints,
            measured: self.sources.iter().map(|sources| sources.map(|(_, stamp)| stamp)).collect(),
            spread: contributions.spread(),
            warnings: self.warnings,
        })
    }
}

/// The fault to report of two: the one that is earlier in the table of faults; of the same kind, the earlier one.
fn first(fault: Option<Reason>, other: Option<Reason>) -> Option<Reason> {
    let rank = |fault: &Reason| match fault {
        Reason::OutOfOrder { .. } => 0,
        Reason::Malformed(_) => 1,
        _ => 2,
    };
    fault.into_iter().chain(other).min_by_key(rank)
}

fn fault_of(name: &str, value: f64) -> Option<Reason> {
    if !value.is_finite() {
        return Some(Reason::NonFinite { joint: name.to_owned(), value });
    }
    let is_far = value.abs() > LARGEST_COORDINATE;
    is_far.then(|| Reason::Malformed(format!("joint {} is at {value:e}", quoted(name))))
}
