//! Workspace: scratch memory and stream memory of queries on one thread, owned by the caller.

use clearance_proximity::{Effort, Scratch, WitnessPairs, Work};
use clearance_robot::Configuration;

use crate::clearance::{Clearance, ClearanceOptions, ClearanceQuery};
use crate::collision_report::CollisionReport;
use crate::motion::{MotionScratch, MotionWorkspace};
use crate::pairs::{CheckedPairs, ObstacleScratch, PlacedRobot};
use crate::revision::Revision;
use crate::robot::{CandidatePair, PairPriority};
use crate::state::{
    BatchSearch, ContactSearch, DistanceScratch, PairEvaluation, QueriedState, StateQuery, Stream,
};

/// Scratch memory of one thread's queries. Its contents save work in the next query and change no exact result. If it
/// is passed to a checker other than its creator, it is adapted to that checker.
#[derive(Clone, Debug)]
pub struct Workspace {
    /// Identity of the checker it belongs to.
    checker: Revision,
    /// Poses of the robot in the last state.
    robot: PlacedRobot,
    /// Pairs to test.
    candidates: Vec<CandidatePair>,
    priority: PairPriority,
    obstacles: ObstacleScratch,
    distance: DistanceScratch,
    motion: MotionScratch,
    witnesses: WitnessPairs,
    /// Scratch memory of the narrow phase, with the work counts.
    scratch: Scratch,
    /// Memory for streams of states.
    stream: Option<Stream>,
}

/// The memory for queries on one state.
struct StateMemory<'a> {
    state: QueriedState<'a>,
    /// Of the search for the least distance.
    distance: &'a mut DistanceScratch,
    /// Of clearance queries.
    witnesses: &'a mut WitnessPairs,
}

impl Workspace {
    pub(crate) fn new(checker: Revision, pairs: &CheckedPairs, scratch: Scratch) -> Self {
        Self {
            checker,
            robot: PlacedRobot::new(pairs),
            candidates: Vec::with_capacity(pairs.count().min(1 << 12)),
            priority: PairPriority::new(),
            obstacles: ObstacleScratch::default(),
            distance: DistanceScratch::default(),
            motion: MotionScratch::default(),
            witnesses: WitnessPairs::default(),
            scratch,
            stream: None,
        }
    }

    /// Adds the memory for a stream of states.
    pub(crate) fn with_stream(self, pairs: &CheckedPairs) -> Self {
        let (self_pairs, parts) = (pairs.self_pairs().count(), pairs.robot().parts().len());
        Self { stream: Some(Stream::new(pairs.world().revision(), self_pairs, parts)), ..self }
    }

    /// Adapts the workspace to a checker; the memory of a stream stays with the other checker.
    pub(crate) fn adapt(&mut self, checker: Revision, pairs: &CheckedPairs) {
        if self.checker != checker {
            let scratch = std::mem::take(&mut self.scratch);
            let stream = self.stream.take();
            *self = Self { stream, ..Self::new(checker, pairs, scratch) };
        }
    }

    /// True if it holds the memory of a stream of states in this world.
    pub(crate) fn has_stream_of(&self, pairs: &CheckedPairs) -> bool {
        self.stream.as_ref().is_some_and(|stream| stream.is_of(pairs.world().revision()))
    }

    #[cfg(test)]
    pub(crate) fn stream(&self) -> Option<&Stream> {
        self.stream.as_ref()
    }

    /// Resets the work counts.
    pub(crate) fn reset_work(&mut self) {
        self.scratch.work = Work::default();
    }

    /// Work since the last reset.
    pub(crate) fn work(&self) -> Work {
        self.scratch.work
    }

    /// The memory for a query on one state. Queries with a deadline do not use a stream's memory.
    pub(crate) fn state_query<'a>(
        &'a mut self,
        pairs: &'a CheckedPairs,
        q: &'a Configuration,
        effort: &'a Effort,
        report: &'a mut CollisionReport,
    ) -> StateQuery<'a> {
        let StateMemory { state, distance, .. } = self.state_memory(pairs, q, effort.deadline.is_none());
        StateQuery { evaluation: PairEvaluation { state, effort, report }, distance }
    }

    /// The memory for a clearance query on one state, which does not use a stream's memory.
    pub(crate) fn clearance_query<'a>(
        &'a mut self,
        pairs: &'a CheckedPairs,
        q: &'a Configuration,
        options: &'a ClearanceOptions,
        result: &'a mut Clearance,
    ) -> ClearanceQuery<'a> {
        let StateMemory { state, witnesses, .. } = self.state_memory(pairs, q, false);
        ClearanceQuery { state, options, witnesses, result }
    }

    /// One state, queried without a stream's memory.
    pub(crate) fn queried_state<'a>(
        &'a mut self,
        pairs: &'a CheckedPairs,
        q: &'a Configuration,
    ) -> QueriedState<'a> {
        self.state_memory(pairs, q, false).state
    }

    fn state_memory<'a>(
        &'a mut self,
        pairs: &'a CheckedPairs,
        q: &'a Configuration,
        uses_stream: bool,
    ) -> StateMemory<'a> {
        let revision = pairs.world().revision();
        let state = QueriedState {
            pairs,
            q,
            robot: &mut self.robot,
            broad_phase: &mut self.obstacles.broad_phase,
            candidates: &mut self.candidates,
            scratch: &mut self.scratch,
            stream: self.stream.as_mut().filter(|stream| uses_stream && stream.is_of(revision)),
        };
        StateMemory { state, distance: &mut self.distance, witnesses: &mut self.witnesses }
    }

    /// The memory for a contact search in one state.
    pub(crate) fn contact_search<'a>(&'a mut self, pairs: &'a CheckedPairs) -> ContactSearch<'a> {
        ContactSearch {
            pairs,
            robot: &mut self.robot,
            priority: &mut self.priority,
            obstacles: &mut self.obstacles,
            scratch: &mut self.scratch,
            start: None,
        }
    }

    /// The memory for a contact search in many states.
    pub(crate) fn batch_search<'a>(&'a mut self, pairs: &'a CheckedPairs) -> BatchSearch<'a> {
        BatchSearch {
            pairs,
            priority: &mut self.priority,
            obstacles: &mut self.obstacles,
            candidates: &mut self.candidates,
            scratch: &mut self.scratch,
        }
    }

    /// The memory for a motion check.
    pub(crate) fn motion(&mut self) -> MotionWorkspace<'_> {
        MotionWorkspace {
            robot: &mut self.robot,
            priority: &mut self.priority,
            obstacles: &mut self.obstacles,
            scratch: &mut self.scratch,
            motion: &mut self.motion,
            candidates: &mut self.candidates,
            distance: &mut self.distance,
        }
    }

    /// Places the robot.
    pub(crate) fn place(&mut self, pairs: &CheckedPairs, q: &Configuration) -> (&PlacedRobot, &mut Scratch) {
        self.robot.place(pairs, q.positions(), self.scratch.level());
        (&self.robot, &mut self.scratch)
    }

    /// Uses the idle time before the next state of a stream, if there is one of this checker.
    pub(crate) fn prepare(&mut self, checker: Revision, pairs: &CheckedPairs) {
        let revision = pairs.world().revision();
        let is_own = |stream: &&mut Stream| self.checker == checker && stream.is_of(revision);
        if let Some(stream) = self.stream.as_mut().filter(is_own) {
            stream.prepare(pairs, &self.robot, &mut self.scratch);
        }
    }
}
