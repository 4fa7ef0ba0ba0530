//! Questions about states of a robot in a world.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use super::bodies::{Rider, link_padding, pair_infos, riders};
use super::capsules::{CapsulePairs, Segment};
use super::memory::Memories;
use super::pair::{Pair, PairInfo};
use super::report::{Body, CollisionReport, PairDistance, Question};
use super::settings::Settings;
use super::{AllowedCollisionMatrix, PairList, Workspace};
use crate::constants::CONTACT_DISTANCE;
use crate::math::MatrixPose;
use crate::query::{Scratch, Work};
use crate::robot::{Chain, Configuration, Frame, RobotModel};
use crate::simd::{LANES, dispatch_lean};
use crate::world::World;

/// A robot in a world, ready for questions from any number of threads: `Send + Sync`, no lock.
#[derive(Clone, Debug)]
pub struct CollisionChecker {
    robot: Arc<RobotModel>,
    world: World,
    settings: Settings,
    pairs: PairList,
    pub(super) chain: Chain,
    /// By link, then by obstacle; `None` without geometry.
    riders: Vec<Option<Rider>>,
    /// In the order of the pair list.
    pub(super) infos: Vec<PairInfo>,
    /// A capsule around each body, and the pairs of them in the order of the pair list.
    pub(super) capsules: CapsulePairs,
    /// The largest padding (m) of any pair.
    pub(super) largest_padding: f64,
    /// No two checkers built in one process have the same.
    identity: u64,
}

static BUILT: AtomicU64 = AtomicU64::new(0);

/// A setting that makes no sense for this robot.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SettingsError {
    #[error("padding is given for link '{0}', which the robot has not")]
    UnknownLink(String),
    #[error("padding{of} is {value}, but must be a finite number of metres, zero or more")]
    BadPadding { of: String, value: f64 },
}

impl CollisionChecker {
    /// Builds the hierarchies of every link and obstacle and decides the pairs, by SRDF or adjacency.
    pub fn new(robot: Arc<RobotModel>, world: &World, settings: Settings) -> Result<Self, SettingsError> {
        Self::with_matrix(robot, world, settings, None)
    }

    /// As [`Self::new`]; a scene's matrix, if given, decides the pairs instead of the SRDF.
    pub fn with_matrix(
        robot: Arc<RobotModel>,
        world: &World,
        settings: Settings,
        matrix: Option<&AllowedCollisionMatrix>,
    ) -> Result<Self, SettingsError> {
        let padding = link_padding(&robot, &settings)?;
        let pairs =
            PairList::new(&robot, world, matrix).restricted(settings.check_self, settings.check_world);
        let has_geometry: Vec<bool> = robot.links().iter().map(|l| !l.collisions.is_empty()).collect();
        let chain = robot.chain(&has_geometry);
        let riders = riders(&robot, world, &chain, settings.mesh_model);
        let infos = pair_infos(&pairs, robot.links().len(), &padding, &settings);
        let capsules = capsule_pairs(&riders, &infos);
        let largest_padding = infos.iter().map(|p| p.padding).fold(0.0, f64::max);
        let world = world.clone();
        let identity = BUILT.fetch_add(1, Ordering::Relaxed);
        Ok(Self { robot, world, settings, pairs, chain, riders, infos, capsules, largest_padding, identity })
    }

    #[must_use]
    pub fn robot(&self) -> &Arc<RobotModel> {
        &self.robot
    }

    #[must_use]
    pub fn world(&self) -> &World {
        &self.world
    }

    #[must_use]
    pub fn settings(&self) -> &Settings {
        &self.settings
    }

    #[must_use]
    pub fn pairs(&self) -> &PairList {
        &self.pairs
    }

    /// The name of a link or an obstacle.
    #[must_use]
    pub fn body_name(&self, body: Body) -> &str {
        match body {
            Body::Link(id) => &self.robot.link(id).name,
            Body::Obstacle(id) => &self.world.obstacle(id).name,
        }
    }

    /// Scratch memory for one thread.
    #[must_use]
    pub fn workspace(&self) -> Workspace {
        self.workspace_with(Scratch::default())
    }

    /// As [`Self::workspace`], but uses no instructions beyond those of every machine of this kind. Answers are the same,
    /// bit by bit.
    #[must_use]
    pub fn portable_workspace(&self) -> Workspace {
        self.workspace_with(Scratch::portable())
    }

    /// As [`Self::workspace`], for states that follow each other closely: what was found about one is used for the next, and
    /// only pairs for which it does not suffice are asked again. Reports are the same, but for the work they took.
    #[must_use]
    pub fn streaming_workspace(&self) -> Workspace {
        Workspace { memories: Some(Memories::new(self.identity, self.infos.len())), ..self.workspace() }
    }

    fn workspace_with(&self, scratch: Scratch) -> Workspace {
        let groups = self.capsules.group_count();
        Workspace {
            frames: vec![Frame::IDENTITY; self.chain.body_count()],
            segments: vec![Segment { centre: [0.0; 3], half: [0.0; 3] }; self.capsules.capsule_count()],
            near: vec![0; groups],
            bounds: vec![[0.0; LANES]; groups],
            queue: Vec::with_capacity(self.pairs.len()),
            scratch,
            memories: None,
        }
    }

    /// Whether every pair is proven apart; stops at the first that is not.
    #[must_use]
    pub fn is_free(&self, q: &Configuration, workspace: &mut Workspace) -> bool {
        self.place_and_screen(q, workspace);
        let Workspace { frames, near, scratch, memories, .. } = workspace;
        !near_pairs(near).any(|i| self.touches(i, frames, memories, scratch))
    }

    /// Answers `question` about the state `q`.
    #[must_use]
    pub fn check(&self, q: &Configuration, question: Question, workspace: &mut Workspace) -> CollisionReport {
        let mut report = CollisionReport::default();
        workspace.scratch.work = Work::default();
        match question {
            Question::Free => self.first_hits(q, workspace, &mut report),
            Question::Pairs => self.all_hits(q, workspace, &mut report),
            Question::Distance { limit } => {
                self.least_distance(q, limit, workspace, &mut report);
                // pairs that touch are looked for where there are any
                if report.nearest.is_some_and(|nearest| nearest.distance == 0.0) {
                    self.first_hits(q, workspace, &mut report);
                    report.believe_contact();
                }
            }
            Question::PairDistances { limit } => self.distances(q, limit, workspace, &mut report),
            Question::Survey { influence_distance, limit } => {
                self.distances(q, influence_distance, workspace, &mut report);
                if report.nearest.is_none() && limit > influence_distance {
                    self.least_distance(q, limit, workspace, &mut report);
                    report.believe_contact();
                }
            }
        }
        report.work = workspace.scratch.work;
        report
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

    /// Places all bodies, and bounds the distances of all pairs by their capsules.
    fn place_and_bound(&self, q: &Configuration, workspace: &mut Workspace) {
        let Workspace { frames, segments, bounds, scratch, .. } = workspace;
        scratch.work.volume_tests += self.infos.len() as u64;
        dispatch_lean!(scratch.level(), simd => {
            self.chain.frames_of_one(simd, q.positions(), frames);
            self.capsules.place(frames, segments);
            self.capsules.lower_bounds_one(simd, segments, bounds);
        });
    }

    /// The first colliding pair of links, and the first of a link and an obstacle.
    fn first_hits(&self, q: &Configuration, workspace: &mut Workspace, report: &mut CollisionReport) {
        self.place_and_screen(q, workspace);
        let Workspace { frames, near, scratch, memories, .. } = workspace;
        for i in near_pairs(near) {
            let known = if i < self.pairs.self_pairs().len() {
                report.self_collision
            } else {
                report.world_collision
            };
            if !known && self.touches(i, frames, memories, scratch) {
                report.add_hit(self.infos[i].ids);
            }
        }
    }

    fn all_hits(&self, q: &Configuration, workspace: &mut Workspace, report: &mut CollisionReport) {
        self.place_and_screen(q, workspace);
        let Workspace { frames, near, scratch, memories, .. } = workspace;
        for i in near_pairs(near) {
            if self.touches(i, frames, memories, scratch) {
                report.add_hit(self.infos[i].ids);
            }
        }
    }

    /// The least distance of all pairs; pairs that may be nearer are asked first, and each only up to the least so far.
    fn least_distance(
        &self,
        q: &Configuration,
        limit: f64,
        workspace: &mut Workspace,
        report: &mut CollisionReport,
    ) {
        self.place_and_bound(q, workspace);
        let Workspace { frames, bounds, queue, scratch, memories, .. } = workspace;
        let limit = limit.max(CONTACT_DISTANCE);
        queue.clear();
        for (i, info) in self.infos.iter().enumerate() {
            let lower = lower_bound(bounds, i, info);
            if lower <= limit {
                queue.push((lower, i));
            }
        }
        queue.sort_unstable_by(|x, y| x.0.total_cmp(&y.0).then(x.1.cmp(&y.1)));
        let mut nearest: Option<(f64, usize, PairDistance)> = None;
        for &(lower, i) in queue.iter() {
            let bound = nearest.map_or(limit, |(distance, ..)| distance);
            if lower > bound || bound == 0.0 {
                break;
            }
            if let Some(found) = self.distance(i, bound, frames, memories, scratch)
                && nearest.is_none_or(|(distance, index, _)| (found.distance, i) < (distance, index))
            {
                nearest = Some((found.distance, i, found));
            }
        }
        report.nearest = nearest.map(|(.., found)| found);
    }

    /// Every pair's distance up to `limit`.
    fn distances(
        &self,
        q: &Configuration,
        limit: f64,
        workspace: &mut Workspace,
        report: &mut CollisionReport,
    ) {
        self.place_and_bound(q, workspace);
        let Workspace { frames, bounds, scratch, memories, .. } = workspace;
        for (i, info) in self.infos.iter().enumerate() {
            if lower_bound(bounds, i, info) > limit.max(CONTACT_DISTANCE) {
                continue;
            }
            let Some(found) = self.distance(i, limit, frames, memories, scratch) else {
                continue;
            };
            if found.distance == 0.0 {
                report.add_hit(info.ids);
            }
            if report.nearest.is_none_or(|n| found.distance < n.distance) {
                report.nearest = Some(found);
            }
            report.pair_distances.push(found);
        }
    }

    /// Whether a padded pair touches.
    fn touches(
        &self,
        index: usize,
        frames: &[Frame<f64>],
        memories: &mut Option<Memories>,
        scratch: &mut Scratch,
    ) -> bool {
        let pair = self.pair(index, frames);
        match memories.as_mut().and_then(|m| m.of_pair(self.identity, index)) {
            Some(memory) => pair.touches_remembering(memory, scratch),
            None => pair.touches(scratch),
        }
    }

    /// A pair's padded distance, unless it is proven larger than `limit`.
    fn distance(
        &self,
        index: usize,
        limit: f64,
        frames: &[Frame<f64>],
        memories: &mut Option<Memories>,
        scratch: &mut Scratch,
    ) -> Option<PairDistance> {
        let pair = self.pair(index, frames);
        let limit = limit + pair.info.padding;
        let found = match memories.as_mut().and_then(|m| m.of_pair(self.identity, index)) {
            Some(memory) => pair.separation_remembering(limit, memory, scratch),
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
        let (a, b) = (self.rider(info.bodies.0), self.rider(info.bodies.1));
        let (pose_ra, pose_rb) = (MatrixPose::from(&frame(a.body)), MatrixPose::from(&frame(b.body)));
        Pair { info, bodies: (&a.solid, &b.solid), pose_ra, pose_ab: pose_ra.relative(&pose_rb) }
    }

    fn rider(&self, index: usize) -> &Rider {
        self.riders[index].as_ref().expect("pairs name only bodies with geometry")
    }

    /// Memory of all hierarchies and the triangles in them (bytes), and the number of triangles.
    #[must_use]
    pub fn hierarchy_size(&self) -> (usize, usize) {
        let solids = self.riders.iter().flatten().map(|rider| &rider.solid);
        solids.fold((0, 0), |(bytes, triangles), s| (bytes + s.bytes(), triangles + s.triangle_count()))
    }
}

/// Capsules of the bodies that occur in pairs, and the pairs of them.
fn capsule_pairs(riders: &[Option<Rider>], infos: &[PairInfo]) -> CapsulePairs {
    let mut numbers = vec![usize::MAX; riders.len()];
    let mut capsules = Vec::new();
    for (i, rider) in riders.iter().enumerate() {
        if let Some(rider) = rider {
            numbers[i] = capsules.len();
            capsules.push((rider.body, rider.capsule));
        }
    }
    let pairs: Vec<_> = infos.iter().map(|p| (numbers[p.bodies.0], numbers[p.bodies.1])).collect();
    CapsulePairs::new(&capsules, &pairs)
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
