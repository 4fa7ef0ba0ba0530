//! Batch queries on many states: eight states in SIMD lanes, blocks of states distributed over threads.

use clearance_geometry::constants::CONTACT_DISTANCE;
use clearance_geometry::simd::prelude::*;
use clearance_geometry::simd::{LANES, Simd, dispatch, f32x8, f64x8};
use clearance_proximity::Scratch;
use clearance_robot::{Configuration, Frame};
use rayon::prelude::*;

use super::capsules::{Segment, up};
use super::collision_checker::CollisionChecker;
use super::pair_priority::PairPriority;
use super::report::{CollisionReport, Question};
use super::workspace::Workspace;

/// States that one thread takes at a time.
const BLOCK: usize = 256;

impl CollisionChecker {
    /// For each state, the result of [`Self::is_free`]. Results are the same for any number of threads.
    ///
    /// Runs on the threads of the rayon pool it is called in.
    #[must_use]
    pub fn are_free(&self, states: &[Configuration]) -> Vec<bool> {
        let mut free = vec![false; states.len()];
        (free.par_chunks_mut(BLOCK).zip(states.par_chunks(BLOCK))).for_each_init(
            || self.workspace(),
            |workspace, (free, states)| self.are_free_with(states, workspace, free),
        );
        free
    }

    /// As [`Self::are_free`], on this thread and with this workspace; writes to `free`, which is as long as `states`.
    ///
    /// # Panics
    /// When `free` is not as long as `states`.
    pub fn are_free_with(&self, states: &[Configuration], workspace: &mut Workspace, free: &mut [bool]) {
        assert_eq!(states.len(), free.len(), "an answer for every state");
        self.suit(workspace);
        let level = workspace.scratch.level();
        dispatch!(level, simd => self.free_eights(simd, states, workspace, free));
    }

    /// Number of pairs, over all states, that level 0 passes on to the hierarchies. Runs only kinematics and capsules, to measure their
    /// share of every check.
    pub fn count_near_pairs(&self, states: &[Configuration], workspace: &mut Workspace) -> u64 {
        let level = workspace.scratch.level();
        dispatch!(level, simd => {
            let mut eight = Eight::new(self, simd);
            let mut count = 0;
            for states in states.chunks(LANES) {
                self.screen_eight(simd, states, &mut eight);
                let lanes = u8::MAX >> (LANES - states.len());
                count += eight.near.iter().map(|near| u64::from((near & lanes).count_ones())).sum::<u64>();
                for lane in 0..states.len() {
                    count += self.count_near_obstacles(|body| eight.frame(body, lane), workspace);
                }
            }
            count
        })
    }

    fn count_near_obstacles(&self, frame: impl Fn(usize) -> Frame<f64>, workspace: &mut Workspace) -> u64 {
        let Workspace { scratch, nearby, queue, .. } = workspace;
        queue.clear();
        for (part, robot_body) in self.robot_bodies.iter().enumerate() {
            let capsule = self.capsule_of(part, &frame(robot_body.body));
            let memory = (scratch.level(), &mut *nearby, &mut scratch.work);
            self.obstacles_near(part, &capsule, CONTACT_DISTANCE, memory, queue);
        }
        queue.len() as u64
    }

    /// Evaluates `question` on each state, as [`Self::check`] does: the same reports, in the order of the states, for any number of
    /// threads.
    ///
    /// Runs on the threads of the rayon pool it is called in.
    #[must_use]
    pub fn check_states(&self, states: &[Configuration], question: Question) -> Vec<CollisionReport> {
        (states.par_iter())
            .with_min_len(16)
            .map_init(|| self.workspace(), |workspace, q| self.check(q, question, workspace))
            .collect()
    }

    /// Runs level 0 on eight states at once, then tests the remaining pairs one by one.
    #[inline(always)]
    fn free_eights<S: Simd>(
        &self,
        simd: S,
        states: &[Configuration],
        workspace: &mut Workspace,
        free: &mut [bool],
    ) {
        let Workspace { scratch, likely, nearby, part_order, .. } = workspace;
        let mut eight = Eight::new(self, simd);
        for (states, free) in states.chunks(LANES).zip(free.chunks_mut(LANES)) {
            self.screen_eight(simd, states, &mut eight);
            scratch.work.volume_tests += (self.infos.len() * states.len()) as u64;
            let all = u8::MAX >> (LANES - states.len());
            let mut hit = 0u8;
            for rank in 0.. {
                let Some(i) = likely.get(rank) else { break };
                let near = std::mem::take(&mut eight.near[i]);
                hit |= self.hits_of(i, near & all & !hit, &eight, scratch, likely);
            }
            for i in 0..eight.near.len() {
                hit |= self.hits_of(i, eight.near[i] & all & !hit, &eight, scratch, likely);
            }
            let origins = self.capsules.origin(|body| eight.frames[body]);
            let capsules = |part: usize| self.capsule_in_eight(simd, part, (eight.segments[part], origins));
            let memory = (&mut *scratch, &mut *nearby, &mut *part_order);
            hit |= self.states_that_hit(
                simd,
                (all & !hit, states.iter().all(|q| self.reachable.expects(q.positions()))),
                capsules,
                &|body, lane| eight.frame(body, lane),
                memory,
            );
            for (lane, free) in free.iter_mut().enumerate() {
                *free = hit & (1 << lane) == 0;
            }
        }
    }

    /// Bit mask of the states in which a pair touches.
    #[inline(always)]
    fn hits_of<S: Simd>(
        &self,
        pair: usize,
        mut states: u8,
        eight: &Eight<S>,
        scratch: &mut Scratch,
        likely: &mut PairPriority,
    ) -> u8 {
        let mut hit = 0;
        while states != 0 {
            let lane = states.trailing_zeros() as usize;
            states &= states - 1;
            if self.pair_with(pair, |body| eight.frame(body, lane)).touches(scratch) {
                hit |= 1 << lane;
                likely.hit(pair);
            }
        }
        hit
    }

    /// Level 0 of some states. A short block repeats its last state.
    #[inline(always)]
    fn screen_eight<S: Simd>(&self, simd: S, states: &[Configuration], eight: &mut Eight<S>) {
        let state = |lane: usize| states[lane.min(states.len() - 1)].positions();
        let [a, b, c, d] = [state(0), state(1), state(2), state(3)];
        let [e, f, g, h] = [state(4), state(5), state(6), state(7)];
        let margin = up(self.largest_padding + CONTACT_DISTANCE);
        eight.screen(
            simd,
            self,
            #[inline(always)]
            |i| f64x8::simd_from(simd, [a[i], b[i], c[i], d[i], e[i], f[i], g[i], h[i]]),
            #[inline(always)]
            |_| margin,
        );
    }
}

/// Scratch memory of eight states in lanes.
pub(super) struct Eight<S: Simd> {
    frames: Vec<Frame<f64x8<S>>>,
    segments: Vec<Segment<f32x8<S>>>,
    /// By self pair: a bit for each state in which it may be near.
    pub near: Vec<u8>,
}

impl<S: Simd> Eight<S> {
    pub fn new(checker: &CollisionChecker, simd: S) -> Self {
        let zero = f32x8::splat(simd, 0.0);
        let segment = Segment { centre: [zero; 3], half: [zero; 3] };
        Self {
            frames: vec![Frame::splat(simd, &Frame::IDENTITY); checker.chain.body_count()],
            segments: vec![segment; checker.capsules.capsule_count()],
            near: vec![0; checker.infos.len()],
        }
    }

    /// Level 0 on the positions: computes kinematics and the pairs that capsules do not prove farther apart than their margins (m).
    #[inline(always)]
    pub fn screen(
        &mut self,
        simd: S,
        checker: &CollisionChecker,
        positions: impl Fn(usize) -> f64x8<S>,
        margin: impl Fn(usize) -> f32,
    ) {
        checker.chain.frames(simd, positions, &mut self.frames);
        checker.capsules.place(&self.frames, &mut self.segments);
        checker.capsules.near(simd, &self.segments, margin, &mut self.near);
    }

    /// Pose of a body in one of the states.
    pub fn frame(&self, body: usize, lane: usize) -> Frame<f64> {
        let Frame { r: [x, y, z], t } = &self.frames[body];
        let taken = |v: &[f64x8<S>; 3]| [v[0][lane], v[1][lane], v[2][lane]];
        Frame { r: [taken(x), taken(y), taken(z)], t: taken(t) }
    }
}
