//! From names and numbers to a configuration, or why not.

use std::collections::{BTreeMap, HashMap};

use super::contribution::{Contribution, Contributions};
use super::hearing::Heard;
use super::placement::Placed;
use super::{JointStateInput, Reason, SourceId, Time};
use crate::constants::LARGEST_COORDINATE;
use crate::math::{Extremes, without_whole_turns};
use crate::robot::{Configuration, JointId, JointKind, RobotModel, check_name_length};
use crate::robot::{quoted, quoted_list};

/// How far a joint that follows others may be reported from where it should be without a word (rad; m of one that slides): gears have play.
const MIMIC_SLACK: f64 = 0.02;
const SLIDING_MIMIC_SLACK: f64 = 0.002;

/// How far apart (rad, m) two publishers may report a joint at about the same time (s), beside the way it goes while one of them lags.
const CONTRADICTION: f64 = 0.05;
const SAME_TIME: f64 = 0.1;

/// How much older (s) than another's may be what somebody publishes who passes on what he heard, ten times a second.
const LAG: f64 = 0.2;

/// Names without a joint that are kept of a message at most, and their letters: it may be a stranger's.
const MOST_STRANGERS: usize = 1000;
const LONGEST_NAME: usize = 100;

/// What a name in a joint state stands for.
#[derive(Clone, Copy, Debug)]
enum Slot {
    /// The number with this index in a configuration.
    Position(usize),
    /// A joint whose position follows from another.
    Follows(JointId),
    /// A joint without a position under this name.
    Nothing,
}

/// In the place of a message: what is named by none.
const BY_TF: usize = usize::MAX;

/// Reads joint states for one robot.
#[derive(Clone, Debug)]
pub(super) struct Tracker {
    slots: HashMap<String, Slot>,
    /// By position: whether a whole turn changes nothing, also of what follows.
    turns: Vec<bool>,
}

/// A configuration, and what was odd about its messages.
#[derive(Clone, Debug)]
pub(super) struct Reading {
    pub configuration: Configuration,
    /// One for each position, if all are given and finite.
    pub velocities: Option<Vec<f64>>,
    /// The same, where streams give none by what they said before.
    pub rates: Option<Vec<f64>>,
    /// Whether these rates are of streams that know them differently, or of one that gives them itself.
    pub are_of_joints: bool,
    /// By position: the stamp of what names it; none of what `tf` places.
    pub measured: Vec<Option<Time>>,
    /// How far (s) the times are apart at which joints were measured.
    pub spread: f64,
    pub warnings: Vec<String>,
}

impl Tracker {
    pub fn new(robot: &RobotModel) -> Self {
        let slot = |id| if robot.joint(id).mimic.is_some() { Slot::Follows(id) } else { Slot::Nothing };
        let mut slots: HashMap<String, Slot> =
            robot.joint_ids().map(|id| (robot.joint(id).name.clone(), slot(id))).collect();
        for (index, name) in robot.position_names().iter().enumerate() {
            slots.insert(name.clone(), Slot::Position(index));
        }
        Self { slots, turns: robot.whole_turns() }
    }

    /// Merges messages, in the order in which they came: of each joint, the last one that names it counts, unless `tf` places it.
    /// Also tells which those are.
    pub fn read(
        &self,
        robot: &RobotModel,
        heard: &[Heard],
        is_fresh: impl Fn(&Heard) -> bool,
        (placed, unplaced): (Vec<Placed>, Option<Reason>),
        prefix: &str,
    ) -> (Result<Reading, Reason>, Contributions) {
        let mut merge = Merge::new(self, prefix);
        merge.place(&placed);
        for (message, heard) in heard.iter().enumerate().rev() {
            merge.take(message, heard, is_fresh(heard));
        }
        let contributions = std::mem::take(&mut merge.contributions);
        (merge.finish(robot, unplaced, &contributions), contributions)
    }
}

/// Messages that become one state, the newest first.
struct Merge<'t> {
    tracker: &'t Tracker,
    /// Names that do not begin with this are another robot's.
    prefix: &'t str,
    /// By position: the message that counts, and what it says.
    named_by: Vec<Option<usize>>,
    /// By position: who said so, and of which time.
    told: Vec<Option<(SourceId, Time)>>,
    positions: Vec<f64>,
    velocities: Vec<f64>,
    rates: Vec<f64>,
    followers: Vec<(JointId, f64)>,
    contributions: Contributions,
    /// What is wrong with the newest message of which something is.
    fault: Option<Reason>,
    strangers: Vec<String>,
    warnings: Vec<String>,
    /// By position: between which publishers there is one.
    contradictions: BTreeMap<usize, [f64; 2]>,
}

impl<'t> Merge<'t> {
    fn new(tracker: &'t Tracker, prefix: &'t str) -> Self {
        let count = tracker.turns.len();
        Self {
            tracker,
            prefix,
            named_by: vec![None; count],
            told: vec![None; count],
            positions: vec![f64::NAN; count],
            velocities: vec![f64::NAN; count],
            rates: vec![f64::NAN; count],
            followers: Vec::new(),
            contributions: Contributions::default(),
            fault: None,
            strangers: Vec::new(),
            warnings: Vec::new(),
            contradictions: BTreeMap::new(),
        }
    }

    /// Takes the positions that `tf` tells; what joint states say about them counts for nothing.
    fn place(&mut self, placed: &[Placed]) {
        for (first, positions) in placed {
            for (index, &position) in positions.iter().enumerate().map(|(i, p)| (first + i, p)) {
                self.named_by[index] = Some(BY_TF);
                self.positions[index] = position;
            }
        }
    }

    fn take(&mut self, message: usize, heard: &Heard, is_fresh: bool) {
        let JointStateInput { names, positions, velocities, stamp, .. } = &heard.input;
        let is_whole = names.len() == positions.len();
        let moves = velocities.len() == names.len();
        let mut fault = heard.behind.map(|behind| Reason::OutOfOrder { behind });
        if !is_whole {
            let counts = format!("it has {} names and {} positions", names.len(), positions.len());
            fault = first(fault, Some(Reason::Malformed(counts)));
        }
        if let Some(Err(excess)) = names.iter().map(|name| check_name_length(name)).find(Result::is_err) {
            fault = first(fault, Some(Reason::Malformed(excess)));
        }
        let (mut mine, mut followers, mut strangers) = (Vec::new(), Vec::new(), Vec::new());
        let mut is_superseded = false;
        for (i, name) in names.iter().enumerate() {
            match self.tracker.slots.get(name) {
                Some(&Slot::Position(index)) => match self.named_by[index] {
                    Some(other) if other == message => {
                        let twice = format!("joint {} stands in it twice", quoted(name));
                        fault = first(fault, Some(Reason::Malformed(twice)));
                    }
                    Some(_) => {
                        is_superseded = true;
                        if is_whole && is_fresh {
                            let rate = heard.rates.get(i).copied().unwrap_or(f64::NAN);
                            self.note_contradiction(
                                index,
                                (heard.input.source, heard.stamp),
                                (positions[i], rate),
                            );
                        }
                    }
                    None => {
                        self.named_by[index] = Some(message);
                        self.told[index] = Some((heard.input.source, heard.stamp));
                        mine.push(index);
                        if is_whole {
                            self.positions[index] = positions[i];
                            fault = first(fault, fault_of(name, positions[i]));
                        }
                        self.velocities[index] = if moves { velocities[i] } else { f64::NAN };
                        self.rates[index] = heard.rates.get(i).copied().unwrap_or(f64::NAN);
                    }
                },
                Some(&Slot::Follows(joint)) if is_whole && followers.len() < self.tracker.slots.len() => {
                    followers.push((joint, positions[i]));
                }
                None if strangers.len() < MOST_STRANGERS && name.starts_with(self.prefix) => {
                    strangers.push(name.chars().take(LONGEST_NAME).collect());
                }
                Some(_) | None => {}
            }
        }
        let counts = !mine.is_empty() || (is_fresh && !is_superseded);
        if !counts {
            return;
        }
        self.strangers.append(&mut strangers);
        if is_fresh {
            followers.retain(|(joint, _)| self.followers.iter().all(|(known, _)| known != joint));
            self.followers.append(&mut followers);
        }
        if mine.is_empty() {
            let is_of_another = !names.is_empty() && !names.iter().any(|name| name.starts_with(self.prefix));
            if !is_whole
                && !is_of_another
                && let Some(Reason::Malformed(what)) = fault
            {
                self.warnings
                    .push(format!("a joint state about none of the robot's joints is malformed: {what}"));
            }
            return;
        }
        if *stamp == Time::ZERO {
            let warning = "the joint state has no stamp: it counts as measured when it came";
            self.warnings.push(warning.to_owned());
        }
        self.fault = first(self.fault.take(), fault);
        let Heard { stamp, at, .. } = *heard;
        self.contributions.0.push(Contribution { stamp, at, positions: mine });
    }

    /// Another publisher may say something else about a joint: one of the two is wrong, and which counts is chance.
    fn note_contradiction(
        &mut self,
        index: usize,
        (source, stamp): (SourceId, Time),
        (position, rate): (f64, f64),
    ) {
        let Some((other, told)) = self.told[index] else { return };
        let counts = self.positions[index];
        let at_once = other != source && told.seconds_since(stamp).abs() < SAME_TIME;
        let rates = [rate, self.rates[index]].into_iter().filter(|rate| rate.is_finite());
        let fastest = rates.map(f64::abs).fold(0.0, f64::greater);
        let way = position - counts;
        let way = if self.tracker.turns[index] { without_whole_turns(way) } else { way };
        if at_once && way.abs() > CONTRADICTION + fastest * LAG {
            self.contradictions.entry(index).or_insert([counts, position]);
        }
    }

    fn finish(
        mut self,
        robot: &RobotModel,
        unplaced: Option<Reason>,
        contributions: &Contributions,
    ) -> Result<Reading, Reason> {
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
        let configuration =
            (robot.configuration(&self.positions)).map_err(|error| Reason::Malformed(error.to_string()))?;
        self.warnings.extend(robot.outside_limits(configuration.positions()).map(|joint| joint.to_string()));
        if !self.strangers.is_empty() {
            self.strangers.sort_unstable();
            self.strangers.dedup();
            self.warnings.push(format!("the robot has no joint {}", quoted_list(&self.strangers)));
        }
        self.warnings.extend(mimic_warnings(robot, &configuration, &self.followers));
        let all = |numbers: Vec<f64>| numbers.iter().all(|v| v.is_finite()).then_some(numbers);
        let velocities = all(self.velocities);
        // of one stream that gives no velocities whole states tell the way
        let are_of_joints = velocities.is_some() || contributions.0.len() > 1;
        let rates = all(self.rates);
        Ok(Reading {
            configuration,
            velocities,
            rates,
            are_of_joints,
            measured: self.told.iter().map(|told| told.map(|(_, stamp)| stamp)).collect(),
            spread: contributions.spread(),
            warnings: self.warnings,
        })
    }
}

/// Which of two faults is told: the one that stands first in the table of faults, and of the same kind the earlier one.
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

/// Joints that are reported elsewhere than where the joint they follow takes them: they are checked there.
fn mimic_warnings(
    robot: &RobotModel,
    configuration: &Configuration,
    followers: &[(JointId, f64)],
) -> Vec<String> {
    (followers.iter())
        .filter_map(|&(joint, reported)| {
            let position = robot.joint_position(configuration, joint)?;
            let robot_joint = robot.joint(joint);
            let slides = matches!(robot_joint.kind, JointKind::Prismatic(_));
            let slack = if slides { SLIDING_MIMIC_SLACK } else { MIMIC_SLACK };
            let apart = !reported.is_finite() || (reported - position).abs() > slack;
            let leader = &robot.joint(robot_joint.mimic?.joint).name;
            apart.then(|| {
                format!(
                    "joint '{}' is reported at {reported}, but it mimics '{leader}' and is checked at {position}",
                    robot_joint.name
                )
            })
        })
        .collect()
}
