//! Status of the robot: FREE, COLLIDING, or UNKNOWN with a reason; codes and texts of all reasons.

use std::fmt;

use clearance_robot::{quoted, quoted_list};

/// Status of the robot.
#[derive(Clone, Debug, PartialEq)]
pub enum Status {
    /// Every pair that has to be checked is free of contact.
    Free,
    /// At least one pair touches.
    Colliding,
    /// Neither is proven.
    Unknown(Reason),
}

impl Status {
    /// Whether the status is FREE.
    #[must_use]
    pub fn is_free(&self) -> bool {
        *self == Self::Free
    }

    /// Reason for UNKNOWN; `None` for the other statuses.
    #[must_use]
    pub fn reason(&self) -> Option<&Reason> {
        match self {
            Self::Unknown(reason) => Some(reason),
            Self::Free | Self::Colliding => None,
        }
    }

    /// `FREE`, `COLLIDING` or `UNKNOWN`.
    #[must_use]
    pub fn word(&self) -> &'static str {
        match self {
            Self::Free => "FREE",
            Self::Colliding => "COLLIDING",
            Self::Unknown(_) => "UNKNOWN",
        }
    }
}

/// Reason for the status UNKNOWN. Its text contains advice.
#[derive(Clone, Debug, PartialEq)]
pub enum Reason {
    /// No robot model has been loaded; `fault` is the error of the last rejected one.
    NoModel {
        /// Error of the last rejected model, if there was one.
        fault: Option<String>,
    },
    /// The process uses more memory than allowed (MiB), and is about to end.
    Memory {
        /// Memory of the process (MiB).
        used: u64,
        /// Its limit (MiB).
        limit: u64,
    },
    /// Checking was switched off.
    Disabled,
    /// Another robot was described, and its model is not built yet.
    ModelSwap,
    /// No link of the robot has collision geometry: there is nothing to check.
    NoGeometry,
    /// No joint state was received.
    NoJointState,
    /// Simulated time is in use, and none was received.
    NoClock,
    /// The clock was set back by `back` seconds, and no joint state has been received since.
    ClockJump {
        /// Time (s) by which the clock was set back.
        back: f64,
    },
    /// The joint state is `age` seconds old, or none was received for this time; `also` is a further fault of it. If
    /// this applies to some joints only, `joints` names them.
    Stale {
        /// Names of the stale joints; empty if all are stale.
        joints: Vec<String>,
        /// Largest age (s).
        age: f64,
        /// Age limit (s).
        stale_after: f64,
        /// Further fault of the joint state.
        also: Option<Box<Reason>>,
    },
    /// The last evaluation was published `since` seconds ago, and is no longer valid.
    Overdue {
        /// Time (s) since the last evaluation.
        since: f64,
    },
    /// The stamp lies `ahead` seconds in the future.
    FutureStamp {
        /// Time (s) between now and the stamp.
        ahead: f64,
    },
    /// The stamp is `behind` seconds older than one that was evaluated before.
    OutOfOrder {
        /// Time (s) between the two stamps.
        behind: f64,
    },
    /// The joint state is invalid: numbers of names and positions differ, a name occurs twice or is too long, or a
    /// position is out of range.
    Malformed(String),
    /// A position is NaN or infinite.
    NonFinite {
        /// Name of the joint.
        joint: String,
        /// Its position.
        value: f64,
    },
    /// Some joints were never named by a joint state.
    Partial {
        /// Names of the positions without a value.
        missing: Vec<String>,
    },
    /// Two publishers report different positions of a joint at almost the same time; `more` counts further such joints.
    Contradiction {
        /// Name of the joint.
        joint: String,
        /// The two reported positions (rad, m).
        positions: [f64; 2],
        /// Number of further joints.
        more: usize,
    },
    /// A mimic joint is reported at the first of `positions`, while its leader takes it to the second; `more` counts
    /// further such joints.
    MimicContradiction {
        /// Name of the mimic joint.
        joint: String,
        /// Name of its leader.
        leader: String,
        /// The reported position and the expected one (rad, m).
        positions: [f64; 2],
        /// Number of further joints.
        more: usize,
    },
    /// `tf` does not contain the position of `joint`, the transform between the frames of its links.
    NoTransform {
        /// Name of the joint.
        joint: String,
        /// Names of the parent frame and the child frame.
        frames: [String; 2],
        /// Reason as text.
        why: String,
    },
    /// The last measurement of `source` is `age` seconds old, or there was none.
    StaleWorld {
        /// Name of the sensor or transform.
        source: String,
        /// Age (s) of its last measurement; `None` if there was none.
        age: Option<f64>,
        /// Age limit (s).
        ttl: f64,
    },
    /// The node has not moved obstacles to where `tf` has them.
    ObstaclesLag {
        /// Time (s) for which it has not.
        age: f64,
        /// Limit (s) of that time.
        ttl: f64,
    },
    /// The last message of a sensor, the topic `source`, contains no points of the surroundings; `cause` has the reason
    /// with counts. `more` counts further such sensors.
    BlindCloud {
        /// Topic of the sensor.
        source: String,
        /// Reason with counts.
        cause: String,
        /// Number of further sensors.
        more: usize,
    },
    /// An announced object is missing from the world, or is at another pose, because a change was rejected. `fault`
    /// names one such object and its error; `more` counts further ones.
    RejectedObstacle {
        /// The object and its error.
        fault: String,
        /// Number of further objects.
        more: usize,
    },
    /// Messages about the world were lost in transmission; `topics` has the topics with counts.
    LostMessages {
        /// Topics with the number of lost messages.
        topics: Vec<String>,
    },
    /// `waiting` messages about the world are not in force yet, the oldest one for `age` seconds.
    WorldUpdate {
        /// Number of messages.
        waiting: usize,
        /// Age (s) of the oldest one.
        age: f64,
    },
    /// The time limit of one evaluation passed while `open` pairs were undecided; `pair` is one of them.
    Deadline {
        /// Time limit (s).
        deadline: f64,
        /// Number of undecided pairs.
        open: usize,
        /// Names of the bodies of one undecided pair.
        pair: [String; 2],
    },
}

impl Reason {
    /// Stable identifier of the reason, for comparisons in programs; it never changes.
    #[must_use]
    pub fn code(&self) -> &'static str {
        match self {
            Self::NoModel { .. } => "no_model",
            Self::Memory { .. } => "memory",
            Self::Disabled => "disabled",
            Self::ModelSwap => "model_swap",
            Self::NoGeometry => "no_geometry",
            Self::NoJointState => "no_joint_state",
            Self::NoClock => "no_clock",
            Self::ClockJump { .. } => "clock_jump",
            Self::Stale { .. } | Self::Overdue { .. } => "stale",
            Self::FutureStamp { .. } => "future_stamp",
            Self::OutOfOrder { .. } => "out_of_order",
            Self::Malformed(_) => "malformed",
            Self::NonFinite { .. } => "non_finite",
            Self::Partial { .. } => "partial",
            Self::Contradiction { .. } | Self::MimicContradiction { .. } => "contradiction",
            Self::NoTransform { .. } => "no_transform",
            Self::StaleWorld { .. } | Self::ObstaclesLag { .. } => "stale_world",
            Self::BlindCloud { .. } => "blind_cloud",
            Self::RejectedObstacle { .. } => "rejected_obstacle",
            Self::LostMessages { .. } => "lost_messages",
            Self::WorldUpdate { .. } => "world_update",
            Self::Deadline { .. } => "deadline",
        }
    }

    /// Whether this reason is decided before joint states are considered.
    pub(super) fn precedes_joint_states(&self) -> bool {
        matches!(
            self,
            Self::Memory { .. } | Self::NoModel { .. } | Self::Disabled | Self::ModelSwap | Self::NoGeometry
        )
    }

    /// Whether joint states were received whose positions cannot be correct.
    #[must_use]
    pub fn is_about_positions(&self) -> bool {
        matches!(
            self,
            Self::Malformed(_)
                | Self::NonFinite { .. }
                | Self::Contradiction { .. }
                | Self::MimicContradiction { .. }
        ) || matches!(self, Self::Stale { also: Some(also), .. } if also.is_about_positions())
    }

    /// Whether the joint state may be correct, and only its time is not.
    pub(super) fn is_about_time(&self) -> bool {
        matches!(
            self,
            Self::NoClock | Self::Stale { .. } | Self::FutureStamp { .. } | Self::NoTransform { .. }
        )
    }
}

impl Reason {
    /// Formats reasons about reports that contradict each other.
    fn fmt_contradiction(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Contradiction { joint, positions: [a, b], more } => {
                write!(
                    f,
                    "joint {} is reported at {a} and at {b} by two publishers at about the same time",
                    quoted(joint)
                )?;
                if *more > 0 {
                    write!(f, ", and {more} more joints are contradicted, too")?;
                }
                f.write_str(": is one of the two left over?")
            }
            Self::MimicContradiction { joint, leader, positions: [reported, expected], more } => {
                write!(
                    f,
                    "joint {} is reported at {reported}, but it mimics {} and would be checked at {expected}",
                    quoted(joint),
                    quoted(leader)
                )?;
                if *more > 0 {
                    write!(f, ", and {more} more mimic joints are reported elsewhere, too")?;
                }
                f.write_str(": does the mimic of the URDF fit the mechanism?")
            }
            _ => Ok(()),
        }
    }

    /// Formats reasons about an incomplete world.
    fn fmt_incomplete(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::BlindCloud { source, cause, more } => {
                write!(
                    f,
                    "the last message of {} shows nothing of the environment: {cause}",
                    quoted(source)
                )?;
                if *more > 0 {
                    write!(f, "; {more} more sensors are blind")?;
                }
                f.write_str(": is the sensor covered, or a crop box set wrongly?")
            }
            Self::RejectedObstacle { fault, more } => {
                write!(f, "the world is incomplete, because a part of it was rejected: {fault}")?;
                if *more > 0 {
                    write!(f, "; and {more} more parts")?;
                }
                Ok(())
            }
            Self::LostMessages { topics } => write!(
                f,
                "the world is incomplete, because messages about it were lost: {}: publish a whole planning_scene",
                topics.join(", ")
            ),
            Self::WorldUpdate { waiting, age } => write!(
                f,
                "the world is being built: {waiting} messages about it are not in force yet, the oldest for {age:.3} s: are meshes so fine?"
            ),
            _ => Ok(()),
        }
    }
}

impl fmt::Display for Reason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoModel { fault: None } => f.write_str(
                "there is no robot model yet: give --urdf FILE, or publish the URDF on robot_description",
            ),
            Self::NoModel { fault: Some(fault) } => {
                write!(f, "there is no robot model: the last one was rejected: {fault}")
            }
            Self::Memory { used, limit } => write!(
                f,
                "the node takes {used} MiB of memory, and memory_limit is {limit} MiB: it ends, to be started again"
            ),
            Self::Disabled => f.write_str("checking is disabled: call ~/enable with data: true"),
            Self::ModelSwap => f.write_str(
                "another robot came on robot_description, and its model is still being built: the last one does not count any more",
            ),
            Self::NoGeometry => f.write_str(
                "no link of the robot has collision geometry, so that nothing can be checked: give its links <collision> elements",
            ),
            Self::NoJointState => f.write_str(
                "no joint state has arrived yet: is something publishing joint_states, under this name and namespace?",
            ),
            Self::NoClock => f.write_str(
                "use_sim_time is set, but nothing has arrived on /clock: start the simulation, or set use_sim_time to false",
            ),
            Self::ClockJump { back } => write!(
                f,
                "the clock was set back by {back:.3} s: earlier joint states do not count, and none has arrived since"
            ),
            Self::Stale { joints, age, stale_after, also } => {
                let of_joints = match joints.as_slice() {
                    [] => String::new(),
                    joints => format!(" that names {}", quoted_list(joints)),
                };
                write!(
                    f,
                    "the last joint state{of_joints} is {age:.3} s old, and stale_after is {stale_after} s: is the driver running?"
                )?;
                match also {
                    Some(reason) => write!(f, " It was not usable either: {reason}"),
                    None => Ok(()),
                }
            }
            Self::Overdue { since } => write!(
                f,
                "nothing has been evaluated for {since:.3} s, and the last result is too old to hold: do checks take so long?"
            ),
            Self::FutureStamp { ahead } => write!(
                f,
                "the joint state is stamped {ahead:.3} s in the future: synchronise the clocks, or set use_sim_time if its publisher does"
            ),
            Self::OutOfOrder { behind } => write!(
                f,
                "the joint state is {behind:.6} s older than one evaluated before from the same publisher"
            ),
            Self::Malformed(what) => write!(f, "the joint state is malformed: {what}"),
            Self::NonFinite { joint, value } => {
                write!(f, "joint '{joint}' has position {value}, which is not finite")
            }
            Self::Partial { missing } => {
                write!(f, "the joint state has no position of {}", quoted_list(missing))
            }
            Self::Contradiction { .. } | Self::MimicContradiction { .. } => self.fmt_contradiction(f),
            Self::NoTransform { joint, frames: [parent, child], why } => write!(
                f,
                "tf has no position of joint '{joint}', from the transform from '{parent}' to '{child}': {why}"
            ),
            Self::StaleWorld { source, age: None, .. } => {
                write!(f, "nothing has come from {} yet that can be used: is the sensor running?", quoted(source))
            }
            Self::StaleWorld { source, age: Some(age), ttl } => write!(
                f,
                "what {} saw is {age:.3} s old, and its time-to-live is {ttl} s: is the sensor running?",
                quoted(source)
            ),
            Self::ObstaclesLag { age, ttl } => write!(
                f,
                "obstacles have not been moved to where tf has them for {age:.3} s, and transform_ttl is {ttl} s: give the node more time"
            ),
            Self::BlindCloud { .. }
            | Self::RejectedObstacle { .. }
            | Self::LostMessages { .. }
            | Self::WorldUpdate { .. } => self.fmt_incomplete(f),
            Self::Deadline { deadline, open, pair: [a, b] } => write!(
                f,
                "check_deadline ({deadline} s) passed before {open} pairs were decided, such as that of {} and {}: allow more time, or simplify the meshes",
                quoted(a),
                quoted(b)
            ),
        }
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    /// The codes that [`super::Reason::code`] returns.
    fn codes() -> BTreeSet<&'static str> {
        let source = include_str!("status.rs");
        let (_, code) = source.split_once("pub fn code(&self)").unwrap();
        let (code, _) = code.split_once("    }\n\n").unwrap();
        let codes: BTreeSet<_> = code.split('"').skip(1).step_by(2).collect();
        assert!(codes.len() > 20 && codes.contains("no_model") && codes.contains("deadline"), "{codes:?}");
        codes
    }

    #[test]
    fn every_code_of_a_reason_stands_in_the_message_and_in_the_tables() {
        let message = include_str!("../../../interfaces/clearance_msgs/msg/CollisionState.msg");
        let (_, list) = message.split_once("the same as a stable identifier: ").unwrap();
        let (list, _) = list.split_once("; otherwise empty").unwrap();
        let words = list.split([',', ' ', '#', '\n']).filter(|word| !word.is_empty() && *word != "or");
        assert_eq!(words.collect::<BTreeSet<_>>(), codes(), "CollisionState.msg");

        let page = include_str!("../../../docs/reference/fail_safe.md");
        for (place, table) in [("monitor/lib.rs", include_str!("lib.rs")), ("fail_safe.md", page)] {
            let code = |line: &'static str| {
                line.split_once("| UNKNOWN | `")?.1.split_once('`').map(|(code, _)| code)
            };
            assert_eq!(table.lines().filter_map(code).collect::<BTreeSet<_>>(), codes(), "{place}");
        }
    }
}
