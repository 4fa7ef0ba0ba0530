//! What a checker is asked about a state.

use super::collision_checker::CollisionChecker;
use super::pair::{Pair, PairInfo};
use super::report::{Body, CollisionReport, PairDistance, Question};
use super::workspace::Workspace;
use crate::constants::CONTACT_DISTANCE;
use crate::math::MatrixPose;
use crate::query::Work;
use crate::robot::{Configuration, Frame};
use crate::simd::{LANES, dispatch_lean};

impl CollisionChecker {
    /// Whether every pair is proven apart; stops at the first that is not.
    #[must_use]
    pub fn is_free(&self, q: &Configuration, workspace: &mut Workspace) -> bool {
        if workspace.stream_of(self.identity).is_some() {
            self.candidates(q, CONTACT_DISTANCE, workspace);
            let hit = (0..workspace.queue.len()).any(|k| self.touches(workspace.queue[k].1, workspace));
            self.settle(workspace);
            return !hit;
        }
        self.place_and_screen(q, workspace);
        let Workspace { frames, near, scratch, .. } = workspace;
        !near_pairs(near).any(|i| self.pair(i, frames).touches(scratch))
    }

    /// Answers `question` about the state `q`.
    #[must_use]
    pub fn check(&self, q: &Configuration, question: Question, workspace: &mut Workspace) -> CollisionReport {
        let mut report = CollisionReport::default();
        workspace.scratch.work = Work::default();
        match question {
            Question::Free => {
                self.candidates(q, CONTACT_DISTANCE, workspace);
                self.first_hits(workspace, &mut report);
            }
            Question::Pairs => {
                self.candidates(q, CONTACT_DISTANCE, workspace);
                self.all_hits(workspace, &mut report);
            }
            Question::Distance { limit } => {
                self.candidates(q, limit, workspace);
                self.least_distance(limit, workspace, &mut report);
                // pairs that touch are looked for where there are any
                if report.nearest.is_some_and(|nearest| nearest.distance == 0.0) {
                    self.candidates(q, CONTACT_DISTANCE, workspace);
                    self.first_hits(workspace, &mut report);
                    report.believe_contact();
                }
            }
            Question::PairDistances { limit } => {
                self.candidates(q, limit, workspace);
                self.distances(limit, workspace, &mut report);
            }
            Question::Survey { influence_distance, limit } => {
                self.candidates(q, influence_distance, workspace);
                self.distances(influence_distance, workspace, &mut report);
                if report.nearest.is_none() && limit > influence_distance {
                    self.candidates(q, limit, workspace);
                    self.least_distance(limit, workspace, &mut report);
                    report.believe_contact();
                }
            }
        }
        self.settle(workspace);
        report.work = workspace.scratch.work;
        report
    }

    /// Queues the pairs that may be within `limit` (m), in their order, with numbers (m) never larger than their distances;
    /// if there are any, all bodies are placed.
    fn candidates(&self, q: &Configuration, limit: f64, workspace: &mut Workspace) {
        let limit = limit.max(CONTACT_DISTANCE);
        workspace.queue.clear();
        if workspace.stream_of(self.identity).is_some() {
            return self.candidates_of_stream(q, limit, workspace);
        }
        self.place(q, workspace);
        self.bound(workspace);
        let Workspace { bounds, queue, .. } = workspace;
        let lower = self.infos.iter().enumerate().map(|(i, info)| (lower_bound(bounds, i, info), i));
        queue.extend(lower.filter(|(lower, _)| *lower <= limit));
    }

    /// As [`Self::candidates`], from what the last states left, and from capsules where that does not suffice.
    fn candidates_of_stream(&self, q: &Configuration, limit: f64, workspace: &mut Workspace) {
        let Some(stream) = workspace.stream_of(self.identity) else { return };
        stream.advance(&self.rates, q.positions());
        if stream.all_beyond(limit) {
            return;
        }
        let unclear = (0..self.infos.len()).any(|i| stream.is_unclear(i, limit));
        self.place(q, workspace);
        if unclear {
            self.bound(workspace);
        }
        let Workspace { bounds, queue, stream, .. } = workspace;
        let Some(stream) = stream else { return };
        for (i, info) in self.infos.iter().enumerate() {
            if unclear {
                stream.learn(i, lower_bound(bounds, i, info));
            }
            let lower = stream.lower(i);
            if lower <= limit {
                queue.push((lower, i));
            }
        }
    }

    /// Lets a stream note what was learned.
    fn settle(&self, workspace: &mut Workspace) {
        if let Some(stream) = workspace.stream_of(self.identity) {
            stream.settle();
        }
    }

    /// Places all bodies.
    fn place(&self, q: &Configuration, workspace: &mut Workspace) {
        let Workspace { frames, scratch, .. } = workspace;
        dispatch_lean!(scratch.level(), simd => self.chain.frames_of_one(simd, q.positions(), frames));
    }

    /// Places all bodies, and finds the pairs whose capsules do not prove them apart.
    fn place_and_screen(&self, q: &Configuration, workspace: &mut Workspace) {
        let Workspace { frames, segments, near, scratch, .. } = workspace;
        scratch.work.volume_tests += self.infos.len() as u64;
        let margin = self.largest_padding + CONTACT_DISTANCE;
        dispatch_lean!(scratch.level(), simd => {
            self.chain.frames_of_one(simd, q.positions(), frames);
            self.capsules.place(frames, segments);
            self.capsules.near_one(simd, segments, margin, near);
        });
    }

    /// Bounds the distances of all pairs by their capsules.
    fn bound(&self, workspace: &mut Workspace) {
        let Workspace { frames, segments, bounds, scratch, .. } = workspace;
        scratch.work.volume_tests += self.infos.len() as u64;
        dispatch_lean!(scratch.level(), simd => {
            self.capsules.place(frames, segments);
            self.capsules.lower_bounds_one(simd, segments, bounds);
        });
    }

    /// The first colliding pair of links, and the first of a link and an obstacle.
    fn first_hits(&self, workspace: &mut Workspace, report: &mut CollisionReport) {
        for k in 0..workspace.queue.len() {
            let (_, i) = workspace.queue[k];
            let known = if i < self.pairs().self_pairs().len() {
                report.self_collision
            } else {
                report.world_collision
            };
            if !known && self.touches(i, workspace) {
                report.add_hit(self.infos[i].ids);
            }
        }
    }

    fn all_hits(&self, workspace: &mut Workspace, report: &mut CollisionReport) {
        for k in 0..workspace.queue.len() {
            let (_, i) = workspace.queue[k];
            if self.touches(i, workspace) {
                report.add_hit(self.infos[i].ids);
            }
        }
    }

    /// The least distance of all pairs; pairs that may be nearer are asked first, and each only up to the least so far.
    fn least_distance(&self, limit: f64, workspace: &mut Workspace, report: &mut CollisionReport) {
        workspace.queue.sort_unstable_by(|x, y| x.0.total_cmp(&y.0).then(x.1.cmp(&y.1)));
        let mut nearest: Option<(f64, usize, PairDistance)> = None;
        for k in 0..workspace.queue.len() {
            let (lower, i) = workspace.queue[k];
            let bound = nearest.map_or(limit.max(CONTACT_DISTANCE), |(distance, ..)| distance);
            if lower > bound || bound == 0.0 {
                break;
            }
            if let Some(found) = self.distance(i, bound, workspace)
                && nearest.is_none_or(|(distance, index, _)| (found.distance, i) < (distance, index))
            {
                nearest = Some((found.distance, i, found));
            }
        }
        report.nearest = nearest.map(|(.., found)| found);
    }

    /// Every pair's distance up to `limit`.
    fn distances(&self, limit: f64, workspace: &mut Workspace, report: &mut CollisionReport) {
        for k in 0..workspace.queue.len() {
            let (_, i) = workspace.queue[k];
            let Some(found) = self.distance(i, limit, workspace) else { continue };
            if found.distance == 0.0 {
                report.add_hit(self.infos[i].ids);
            }
            if report.nearest.is_none_or(|n| found.distance < n.distance) {
                report.nearest = Some(found);
            }
            report.pair_distances.push(found);
        }
    }

    /// Whether a padded pair touches.
    fn touches(&self, index: usize, workspace: &mut Workspace) -> bool {
        let Workspace { frames, scratch, stream, .. } = workspace;
        let pair = self.pair(index, frames);
        match stream.as_mut().filter(|s| s.is_of(self.identity)) {
            Some(stream) => {
                let touches = pair.touches_remembering(stream.memory(index), scratch);
                stream.learn_from_memory(index, &pair);
                touches
            }
            None => pair.touches(scratch),
        }
    }

    /// A pair's padded distance, unless it is proven larger than `limit`.
    fn distance(&self, index: usize, limit: f64, workspace: &mut Workspace) -> Option<PairDistance> {
        let Workspace { frames, scratch, stream, .. } = workspace;
        let pair = self.pair(index, frames);
        let limit = limit + pair.info.padding;
        let found = match stream.as_mut().filter(|s| s.is_of(self.identity)) {
            Some(stream) => {
                let found = pair.separation_remembering(limit, stream.memory(index), scratch);
                stream.learn_from_memory(index, &pair);
                found
            }
            None => pair.separation(limit, scratch),
        };
        found.map(|raw| pair.padded(&raw))
    }

    /// Pair number `index` of the pair list.
    fn pair(&self, index: usize, frames: &[Frame<f64>]) -> Pair<'_> {
        self.pair_with(index, |body| frames[body])
    }

    /// As [`Self::pair`], with the frames of the chain's bodies.
    pub(super) fn pair_with(&self, index: usize, frame: impl Fn(usize) -> Frame<f64>) -> Pair<'_> {
        let info = &self.infos[index];
        let rider = |i: usize| self.riders[i].as_ref().expect("pairs name only bodies with geometry");
        let (a, b) = (rider(info.bodies.0), rider(info.bodies.1));
        let (pose_ra, pose_rb) = (MatrixPose::from(&frame(a.body)), MatrixPose::from(&frame(b.body)));
        Pair { info, bodies: (&a.solid, &b.solid), pose_ra, pose_ab: pose_ra.relative(&pose_rb) }
    }
}

/// The numbers of the pairs whose bits are set.
fn near_pairs(near: &[u8]) -> impl Iterator<Item = usize> {
    near.iter().enumerate().flat_map(|(group, &bits)| {
        (0..LANES).filter(move |lane| bits & (1 << lane) != 0).map(move |lane| group * LANES + lane)
    })
}

/// The bound of a pair's padded distance.
fn lower_bound(bounds: &[[f32; LANES]], index: usize, info: &PairInfo) -> f64 {
    (f64::from(bounds[index / LANES][index % LANES]) - info.padding).max(0.0)
}

impl CollisionReport {
    /// Whether a collision with the same kind of body as `other` is known.
    fn hits_like(&self, other: Body) -> bool {
        match other {
            Body::Link(_) => self.self_collision,
            Body::Obstacle(_) => self.world_collision,
        }
    }

    /// Where two methods could differ, the one that saw contact is believed.
    fn believe_contact(&mut self) {
        if let Some(touching) = self.nearest.filter(|n| n.distance == 0.0)
            && !self.hits_like(touching.b)
        {
            self.add_hit((touching.a, touching.b));
        }
    }

    fn add_hit(&mut self, pair: (Body, Body)) {
        match pair.1 {
            Body::Link(_) => self.self_collision = true,
            Body::Obstacle(_) => self.world_collision = true,
        }
        self.colliding_pairs.push(pair);
    }
}
