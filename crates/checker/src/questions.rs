//! Queries of a checker on one state.

use clearance_geometry::constants::CONTACT_DISTANCE;
use clearance_geometry::math::Extremes;
use clearance_geometry::simd::{LANES, Simd, dispatch};
use clearance_proximity::{Effort, Work};
use clearance_robot::{Configuration, PlacedFrame};

use super::capsules::{PlacedSegment, up};
use super::collision_checker::CollisionChecker;
use super::pair::{Pair, PairInfo};
use super::report::{CollisionReport, Question};
use super::state_query::StateQuery;
use super::stream::{Due, Stream};
use super::workspace::{QueuedPair, Workspace};

/// Distance (m) beyond the requested limit up to which a stream searches for obstacles, so that the result lasts for some further states.
const WORLD_LOOK_AHEAD: f64 = 0.05;

impl CollisionChecker {
    /// True if every pair is proven apart; stops at the first that is not.
    #[must_use]
    pub fn is_free(&self, q: &Configuration, workspace: &mut Workspace) -> bool {
        self.suit(workspace);
        if workspace.stream_of(self.revision).is_some() {
            self.candidates(q, CONTACT_DISTANCE, workspace);
            let (effort, mut report) = (Effort::default(), CollisionReport::default());
            let mut asked = StateQuery { checker: self, q, effort: &effort, workspace, report: &mut report };
            let hit = (0..asked.workspace.queue.len()).any(|k| asked.touches(asked.workspace.queue[k]));
            self.settle(workspace);
            return !hit;
        }
        !self.is_hit(q, workspace)
    }

    /// True if a pair touches.
    fn is_hit(&self, q: &Configuration, workspace: &mut Workspace) -> bool {
        let level = workspace.scratch.level();
        dispatch!(level, simd => {
            self.place_and_screen(simd, q, workspace);
            if workspace.near.iter().any(|group| *group != 0) && self.hits_itself(workspace) {
                return true;
            }
            let Workspace { frames, segments, scratch, nearby, part_order, .. } = workspace;
            let segments = (&**segments, self.capsules.origin(|body| frames[body].frame()));
            let is_as_expected = self.reachable.expects(q.positions());
            let memory = (scratch, nearby, part_order);
            self.hits_obstacle(simd, (segments, is_as_expected), &|body| frames[body].frame(), memory)
        })
    }

    /// True if parts touch, given placed bodies and screened pairs; pairs that are likely to collide are tested first.
    #[inline(never)]
    fn hits_itself(&self, workspace: &mut Workspace) -> bool {
        let Workspace { frames, near, likely, scratch, .. } = workspace;
        let left = |i: usize| near[i / LANES] & (1 << (i % LANES)) != 0;
        for rank in 0.. {
            let Some(i) = likely.get(rank) else { break };
            if left(i) && self.pair(i, frames).touches(scratch) {
                likely.hit(i);
                return true;
            }
        }
        let unlikely =
            near_pairs(near).find(|i| !likely.contains(*i) && self.pair(*i, frames).touches(scratch));
        if let Some(hit) = unlikely {
            likely.hit(hit);
        }
        unlikely.is_some()
    }

    /// Evaluates `question` on the state `q`.
    #[must_use]
    pub fn check(&self, q: &Configuration, question: Question, workspace: &mut Workspace) -> CollisionReport {
        self.check_with(q, question, &Effort::default(), workspace)
    }

    /// As [`Self::check`], with tolerances for distances, or until a deadline. Pairs left open at the deadline are listed as undecided in
    /// the report, and the robot is not free. Queries with a deadline do not use a stream's memory. Results of a stream within a
    /// tolerance depend on earlier queries, and may include pairs of which only the lower bound is within the limit.
    #[must_use]
    pub fn check_with(
        &self,
        q: &Configuration,
        question: Question,
        effort: &Effort,
        workspace: &mut Workspace,
    ) -> CollisionReport {
        self.suit(workspace);
        let mut report = CollisionReport::default();
        workspace.scratch.work = Work::default();
        let stream = if effort.deadline.is_none() { None } else { workspace.stream.take() };
        StateQuery { checker: self, q, effort, workspace, report: &mut report }.answer(question);
        self.settle(workspace);
        workspace.stream = stream.or(workspace.stream.take());
        report.work = workspace.scratch.work;
        report
    }

    /// Uses the idle time before the next state: renews the memory of pairs that the next state will probably have to search, so that its
    /// result comes sooner. Changes no exact result.
    pub fn prepare(&self, workspace: &mut Workspace) {
        let Workspace { checker, frames, scratch, stream, .. } = workspace;
        let is_own = |stream: &&mut Stream| *checker == self.identity && stream.is_of(self.revision);
        let Some(stream) = stream.as_mut().filter(is_own) else { return };
        let before = scratch.work.cost();
        while let Some(Due { index, limit, effort }) = stream.next_due() {
            let most = match effort.exact_cost {
                0 => u64::MAX,
                most => most.saturating_sub(scratch.work.cost() - before),
            };
            self.pair(index, frames).prepare(limit, (&effort, most), stream.memory(index), scratch);
        }
    }

    /// Adapts a workspace of another checker to this one; the memory of a stream stays with the other checker.
    pub(super) fn suit(&self, workspace: &mut Workspace) {
        if workspace.checker != self.identity {
            let scratch = std::mem::take(&mut workspace.scratch);
            let stream = workspace.stream.take();
            *workspace = Workspace { stream, ..self.workspace_with(scratch) };
        }
    }

    /// Queues the pairs that may be within `limit` (m), in their order, with lower bounds (m) on their distances; if there are any, all
    /// bodies are placed.
    pub(super) fn candidates(&self, q: &Configuration, limit: f64, workspace: &mut Workspace) {
        let limit = limit.greater(CONTACT_DISTANCE);
        if !self.self_candidates(q, limit, workspace) {
            return;
        }
        let Workspace { frames, queue, scratch, nearby, stream, .. } = workspace;
        let mut stream = stream.as_mut().filter(|stream| stream.is_of(self.revision));
        for part in 0..self.robot_bodies.len() {
            if stream.as_ref().is_some_and(|stream| stream.obstacles_beyond(part, limit)) {
                continue;
            }
            let capsule = self.capsule_of(part, &frames[self.robot_bodies[part].body].frame());
            let memory = (scratch.level(), &mut *nearby, &mut scratch.work);
            let begin = queue.len();
            match &mut stream {
                Some(stream) => {
                    let farther = limit + WORLD_LOOK_AHEAD;
                    self.obstacles_near(part, &capsule, farther, memory, queue);
                    stream.see(part, farther, &queue[begin..]);
                    let mut rank = 0;
                    queue.retain(|pair| {
                        rank += 1;
                        rank <= begin || pair.lower <= limit
                    });
                }
                None => self.obstacles_near(part, &capsule, limit, memory, queue),
            }
        }
    }

    /// As [`Self::candidates`], for self pairs only; returns true if any pair may be within the limit.
    pub(super) fn self_candidates(&self, q: &Configuration, limit: f64, workspace: &mut Workspace) -> bool {
        workspace.queue.clear();
        if workspace.stream_of(self.revision).is_some() {
            return self.self_candidates_of_stream(q, limit, workspace);
        }
        self.place(q, workspace);
        self.bound(workspace);
        let Workspace { bounds, queue, .. } = workspace;
        let pairs = self.infos.iter().enumerate();
        let bounded =
            pairs.map(|(index, info)| QueuedPair { lower: lower_bound(bounds, index, info), index });
        queue.extend(bounded.filter(|pair| pair.lower <= limit));
        true
    }

    /// As [`Self::self_candidates`], from the memory of the last states, and from capsules where that does not suffice.
    fn self_candidates_of_stream(&self, q: &Configuration, limit: f64, workspace: &mut Workspace) -> bool {
        let Some(stream) = workspace.stream_of(self.revision) else { return false };
        stream.advance(&self.rates, q.positions());
        if stream.all_beyond(limit) {
            return false;
        }
        let unclear = (0..self.infos.len()).any(|i| stream.is_unclear(i, limit));
        self.place(q, workspace);
        if unclear {
            self.bound(workspace);
        }
        let Workspace { bounds, queue, stream, .. } = workspace;
        let Some(stream) = stream else { return false };
        for (index, info) in self.infos.iter().enumerate() {
            if unclear {
                stream.learn(index, lower_bound(bounds, index, info));
            }
            let lower = stream.lower(index);
            if lower <= limit {
                queue.push(QueuedPair { lower: lower.greater(0.0), index });
            }
        }
        true
    }

    /// Updates the memory of a stream with the new results.
    pub(super) fn settle(&self, workspace: &mut Workspace) {
        if let Some(stream) = workspace.stream_of(self.revision) {
            stream.settle();
        }
    }

    /// Places all bodies.
    pub(super) fn place(&self, q: &Configuration, workspace: &mut Workspace) {
        let Workspace { frames, scratch, .. } = workspace;
        dispatch!(scratch.level(), simd => self.chain.frames_of_one(simd, q.positions(), frames, |_, _| {}));
    }

    /// Places all bodies and the capsules on them.
    #[inline(always)]
    pub(super) fn place_one<S: Simd>(
        &self,
        simd: S,
        positions: &[f64],
        frames: &mut [PlacedFrame],
        segments: &mut [PlacedSegment],
    ) {
        let mut placing = self.capsules.placing(simd, segments);
        self.chain.frames_of_one(
            simd,
            positions,
            frames,
            #[inline(always)]
            |body, columns| placing.place(simd, body, columns),
        );
    }

    /// Places all bodies, and computes the pairs whose capsules do not prove them apart.
    #[inline(always)]
    fn place_and_screen<S: Simd>(&self, simd: S, q: &Configuration, workspace: &mut Workspace) {
        let Workspace { frames, segments, near, scratch, .. } = workspace;
        scratch.work.volume_tests += self.infos.len() as u64;
        let margin = [up(self.largest_padding + CONTACT_DISTANCE); LANES];
        self.place_one(simd, q.positions(), frames, segments);
        self.capsules.near_one(
            simd,
            segments,
            #[inline(always)]
            |_| margin,
            near,
        );
    }

    /// Bounds the distances of all pairs by their capsules.
    fn bound(&self, workspace: &mut Workspace) {
        let Workspace { frames, segments, bounds, scratch, .. } = workspace;
        scratch.work.volume_tests += self.infos.len() as u64;
        dispatch!(scratch.level(), simd => {
            self.capsules.place_one(simd, frames, segments);
            self.capsules.lower_bounds_one(simd, segments, bounds);
        });
    }

    /// Pair number `index` of the pair list.
    pub(super) fn pair(&self, index: usize, frames: &[PlacedFrame]) -> Pair<'_> {
        self.pair_with(index, |body| frames[body].frame())
    }
}

/// The numbers of the pairs whose bits are set.
pub(super) fn near_pairs(near: &[u8]) -> impl Iterator<Item = usize> {
    near.iter().enumerate().flat_map(|(group, &bits)| {
        let mut left = bits;
        std::iter::from_fn(move || {
            let lane = (left != 0).then_some(left.trailing_zeros() as usize)?;
            left &= left - 1;
            Some(group * LANES + lane)
        })
    })
}

/// The bound of a pair's padded distance.
fn lower_bound(bounds: &[[f32; LANES]], index: usize, info: &PairInfo) -> f64 {
    (f64::from(bounds[index / LANES][index % LANES]) - info.padding).greater(0.0)
}
