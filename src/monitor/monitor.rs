//! The monitor: joint states and heartbeats in, judgements out.

use std::collections::BTreeSet;
use std::sync::Arc;
use std::time::Duration;

use super::look_ahead::Lookout;
use super::stamp_order::StampOrder;
use super::tracker::{Reading, Tracker};
use super::{Evidence, JointStateInput, Judgement, MonitorSettings, Now, Reason, Revision, Status, Time};
use crate::checker::{CollisionChecker, CollisionReport, Question, Workspace};
use crate::robot::LinkPoses;

/// Time since any fixed moment; it is read before and after each check.
pub type Stopwatch = fn() -> Duration;

/// Decides what is known about one robot.
#[derive(Debug)]
pub struct Monitor {
    settings: MonitorSettings,
    stopwatch: Stopwatch,
    enabled: bool,
    subject: Option<Subject>,
    /// Another model is being built, and the subject's does not count any more.
    swapping: bool,
    /// What was wrong with the last model offered, while there is none.
    model_fault: Option<String>,
    /// What was refused of the last changes of the world.
    world_faults: Vec<String>,
    order: StampOrder,
    heard: Option<Heard>,
    /// By how much (s) the clock was set back since the last joint state, if it was.
    set_back: Option<f64>,
    verdict: Verdict,
    /// The model or a setting changed since the verdict.
    outdated: bool,
    said_at: Option<Duration>,
    latest_ros_time: Option<Time>,
}

/// The robot and world to check, and what checking them needs.
#[derive(Debug)]
struct Subject {
    revision: Arc<Revision>,
    tracker: Tracker,
    workspace: Workspace,
    lookout: Lookout,
}

/// The last joint state.
#[derive(Debug)]
struct Heard {
    input: JointStateInput,
    /// The stamp that counts: its own, or when it came if it has none.
    stamp: Time,
    /// When it came, by the steady clock.
    at: Duration,
    /// How much older (s) it is than the last judged one of its publisher, if it is.
    behind: Option<f64>,
}

/// A judgement but for its age.
#[derive(Debug)]
struct Verdict {
    status: Status,
    evidence: Option<Arc<Evidence>>,
    warnings: Vec<String>,
}

impl Verdict {
    fn unknown(reason: Reason) -> Self {
        Self { status: Status::Unknown(reason), evidence: None, warnings: Vec::new() }
    }
}

impl Monitor {
    #[must_use]
    pub fn new(settings: MonitorSettings, stopwatch: Stopwatch) -> Self {
        Self {
            settings,
            stopwatch,
            enabled: true,
            subject: None,
            swapping: false,
            model_fault: None,
            world_faults: Vec::new(),
            order: StampOrder::default(),
            heard: None,
            set_back: None,
            verdict: Verdict::unknown(Reason::NoModel { fault: None }),
            outdated: true,
            said_at: None,
            latest_ros_time: None,
        }
    }

    /// From now on this robot and world are checked; the last joint state is judged again at the next heartbeat.
    pub fn set_checker(&mut self, revision: Arc<Revision>) {
        self.subject = Some(Subject {
            tracker: Tracker::new(revision.checker.robot()),
            workspace: revision.checker.streaming_workspace(),
            lookout: Lookout::new(&revision.checker),
            revision,
        });
        self.model_fault = None;
        self.swapping = false;
        self.outdated = true;
    }

    /// Another robot was described: until its checker comes, or it is refused, nothing is known.
    pub fn note_model_swap(&mut self) {
        self.swapping = true;
        self.outdated = true;
    }

    /// A model was refused. The one in use, if any, stays.
    pub fn note_model_fault(&mut self, fault: String) {
        self.model_fault = Some(fault);
        self.swapping = false;
        self.outdated = true;
    }

    /// Turns checking off and on; while it is off, nothing is known.
    pub fn set_enabled(&mut self, enabled: bool) {
        self.enabled = enabled;
        self.outdated = true;
    }

    /// What was refused of the last changes of the world; the rest of the world stays in use.
    pub fn note_world_faults(&mut self, faults: Vec<String>) {
        self.world_faults = faults;
    }

    pub fn set_settings(&mut self, settings: MonitorSettings) {
        self.settings = settings;
        self.outdated = true;
    }

    /// Judges a joint state.
    pub fn on_joint_state(&mut self, input: JointStateInput, now: Now) -> Judgement {
        self.note_clock(now);
        let stamp = match (input.stamp, now.ros) {
            (Time::ZERO, Some(now)) => now,
            (stamp, _) => stamp,
        };
        let newest = self.order.newest(input.source).filter(|_| input.stamp != Time::ZERO);
        let behind = newest.map(|newest| newest.seconds_since(stamp)).filter(|&behind| behind > 0.0);
        self.heard = Some(Heard { input, stamp, at: now.steady, behind });
        self.set_back = None;
        self.judge(now);
        self.say(now)
    }

    /// Says the last judgement again, or that it is stale; judges anew when the model, a setting or the clock changed.
    pub fn on_heartbeat(&mut self, now: Now) -> Judgement {
        self.note_clock(now);
        let waits_for_clock = self.verdict.status.reason().is_some_and(Reason::is_about_time);
        if self.outdated || waits_for_clock {
            self.judge(now);
        }
        self.say(now)
    }

    /// How long nothing needs to be said, if no joint state comes.
    #[must_use]
    pub fn time_to_heartbeat(&self, now: Now) -> Duration {
        let Some(said_at) = self.said_at.filter(|_| !self.outdated) else {
            return Duration::ZERO;
        };
        let heartbeat = (said_at + self.settings.heartbeat_period()).saturating_sub(now.steady);
        // the moment at which a judgement becomes stale is news
        let judged = self.heard.as_ref().filter(|_| self.verdict.evidence.is_some());
        let stale = judged.and_then(|heard| {
            let sources = self.subject.iter().flat_map(|subject| &subject.revision.sources);
            let of_world = sources.filter_map(|source| source.time_to_stale(now));
            heard.time_to_stale(now, &self.settings).into_iter().chain(of_world).min()
        });
        stale.map_or(heartbeat, |stale| heartbeat.min(stale))
    }

    /// Stamps judged before a clock was set back order nothing any more; what was heard long before by that clock counts no more.
    fn note_clock(&mut self, now: Now) {
        if now.ros < self.latest_ros_time {
            self.order.clear();
        }
        if let (Some(before), Some(ros)) = (self.latest_ros_time, now.ros) {
            let back = before.seconds_since(ros);
            if back > self.settings.stale_after && self.heard.take().is_some() {
                self.set_back = Some(back);
                self.outdated = true;
            }
        }
        self.latest_ros_time = now.ros;
    }

    fn judge(&mut self, now: Now) {
        self.outdated = false;
        self.verdict = self.decide(now).unwrap_or_else(Verdict::unknown);
    }

    fn decide(&mut self, now: Now) -> Result<Verdict, Reason> {
        if !self.enabled {
            return Err(Reason::Disabled);
        }
        let fault = self.model_fault.clone();
        let subject = self.subject.as_mut().ok_or(Reason::NoModel { fault })?;
        if self.swapping {
            return Err(Reason::ModelSwap);
        }
        let unheard = self.set_back.map_or(Reason::NoJointState, |back| Reason::ClockJump { back });
        let heard = self.heard.as_ref().ok_or(unheard)?;
        if let Some(behind) = heard.behind {
            return Err(Reason::OutOfOrder { behind });
        }
        let mut reading = subject.tracker.read(subject.revision.checker.robot(), &heard.input)?;
        if heard.input.stamp == Time::ZERO {
            let warning = "the joint state has no stamp: it counts as measured when it came";
            reading.warnings.push(warning.to_owned());
        }
        // checking what is stale already would be wasted
        heard.freshness(now, &self.settings)?;
        let verdict = subject.judge(reading, &self.settings, self.stopwatch);
        if heard.input.stamp != Time::ZERO {
            self.order.note(heard.input.source, heard.stamp);
        }
        Ok(verdict)
    }

    /// The verdict as it holds now: what was right when it was judged may have become stale.
    fn say(&mut self, now: Now) -> Judgement {
        self.said_at = Some(now.steady);
        let subject = self.subject.as_ref();
        let unheeded = self.verdict.status.reason().is_some_and(Reason::precedes_joint_states);
        let stale = (self.heard.as_ref().filter(|_| !unheeded))
            .and_then(|heard| heard.freshness(now, &self.settings).err());
        let stale_world = subject.and_then(|subject| subject.revision.stale_world(now));
        let placement = self.verdict.evidence.clone().filter(|_| stale.is_none());
        let status = match (stale, &stale_world) {
            (Some(reason), _) => Status::Unknown(self.with_other_fault(reason)),
            (None, Some(reason)) if placement.is_some() => Status::Unknown(reason.clone()),
            (None, _) => self.verdict.status.clone(),
        };
        let of_revision = subject.iter().flat_map(|subject| &subject.revision.warnings);
        let of_model = (self.model_fault.as_ref().filter(|_| subject.is_some()))
            .map(|fault| format!("the last robot description was refused, and the one before counts: {fault}"));
        let of_world = of_revision.chain(&self.world_faults);
        let warnings = self.verdict.warnings.iter().chain(of_world).cloned().chain(of_model);
        Judgement {
            evidence: placement.clone().filter(|_| status.reason().is_none()),
            status,
            placement,
            stale_world,
            stamp: self.heard.as_ref().map(|heard| heard.stamp),
            age: self.heard.as_ref().map(|heard| heard.age(now)),
            revision: subject.map(|subject| Arc::clone(&subject.revision)),
            warnings: warnings.collect(),
        }
    }

    /// A stale joint state that could not be judged when it was fresh has two faults.
    fn with_other_fault(&self, reason: Reason) -> Reason {
        match (reason, self.verdict.status.reason()) {
            (Reason::Stale { age, stale_after, .. }, Some(other))
                if !matches!(other, Reason::Stale { .. } | Reason::FutureStamp { .. }) =>
            {
                Reason::Stale { age, stale_after, also: Some(Box::new(other.clone())) }
            }
            (reason, _) => reason,
        }
    }
}

impl Subject {
    /// What a check of a whole joint state finds.
    fn judge(&mut self, reading: Reading, settings: &MonitorSettings, stopwatch: Stopwatch) -> Verdict {
        let Reading { configuration, velocities, mut warnings } = reading;
        let checker = &self.revision.checker;
        let started = stopwatch();
        let survey = Question::Survey {
            influence_distance: settings.influence_distance,
            limit: settings.distance_limit,
        };
        let effort = settings.effort();
        let report = checker.check_with(&configuration, survey, &effort, &mut self.workspace);
        let mut look_ahead = None;
        if settings.look_ahead_horizon > 0.0 && effort.is_over() {
            warnings.push("the time to contact is not known: check_deadline has passed".to_owned());
        } else if settings.look_ahead_horizon > 0.0 {
            let state = (&configuration, velocities.as_deref());
            match self.lookout.look(checker, state, &report, settings) {
                Ok(found) => look_ahead = Some(found),
                Err(why) => warnings.push(why),
            }
        }
        let compute_time = stopwatch().saturating_sub(started);
        let status = status_of(&report, checker, settings);
        let mut poses = LinkPoses::new(checker.robot());
        checker.robot().forward_kinematics(&configuration, &mut poses);
        let evidence = Some(Arc::new(Evidence { report, configuration, poses, look_ahead, compute_time }));
        Verdict { status, evidence, warnings }
    }
}

/// A pair that touches is told even if others are open; with any open pair, distances are not known to be the least.
fn status_of(report: &CollisionReport, checker: &CollisionChecker, settings: &MonitorSettings) -> Status {
    if report.self_collision || report.world_collision {
        return Status::Colliding;
    }
    let open: BTreeSet<_> = report.undecided.iter().map(|pair| (pair.a, pair.b)).collect();
    match open.first() {
        None => Status::Free,
        Some(&(a, b)) => Status::Unknown(Reason::Deadline {
            deadline: settings.check_deadline,
            open: open.len(),
            pair: [a, b].map(|body| checker.body_name(body).to_owned()),
        }),
    }
}

impl Heard {
    /// Age (s) by its stamp, or since it came when no ROS time is known.
    fn age(&self, now: Now) -> f64 {
        match now.ros {
            Some(ros) => ros.seconds_since(self.stamp),
            None => self.silence(now),
        }
    }

    /// How long (s) ago it came.
    fn silence(&self, now: Now) -> f64 {
        now.steady.saturating_sub(self.at).as_secs_f64()
    }

    /// Whether it still says something about the robot.
    fn freshness(&self, now: Now, settings: &MonitorSettings) -> Result<(), Reason> {
        let stale_after = settings.stale_after;
        let age = now.ros.ok_or(Reason::NoClock)?.seconds_since(self.stamp);
        let older = age.max(self.silence(now));
        if older > stale_after {
            Err(Reason::Stale { age: older, stale_after, also: None })
        } else if -age > stale_after {
            Err(Reason::FutureStamp { ahead: -age })
        } else {
            Ok(())
        }
    }

    /// How long it stays fresh, if it is.
    fn time_to_stale(&self, now: Now, settings: &MonitorSettings) -> Option<Duration> {
        self.freshness(now, settings).ok()?;
        let left = settings.stale_after - self.age(now).max(self.silence(now));
        // a little later, so that it is stale then whatever way rounding goes
        Some(Duration::try_from_secs_f64(left).ok()? + Duration::from_millis(1))
    }
}
