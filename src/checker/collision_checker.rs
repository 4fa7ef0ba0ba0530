//! Questions about states of a robot in a world.

use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, OnceLock};

use super::bodies::{Rider, capsule_pairs, joints_between, link_padding, pair_infos, riders, travel_rates};
use super::capsules::{CapsulePairs, Segment};
use super::likely::LikelyPairs;
use super::motion::{MotionScratch, Ways, ways_of};
use super::pair::PairInfo;
use super::report::Body;
use super::settings::Settings;
use super::stream::Stream;
use super::{AllowedCollisionMatrix, PairList, Workspace};
use crate::query::Scratch;
use crate::robot::{Between, Chain, Frame, RobotModel, TravelRates};
use crate::simd::LANES;
use crate::world::World;

/// A robot in a world, ready for questions from any number of threads: `Send + Sync`, no lock.
#[derive(Clone, Debug)]
pub struct CollisionChecker {
    robot: Arc<RobotModel>,
    world: World,
    settings: Settings,
    pub(super) matrix: Option<AllowedCollisionMatrix>,
    pairs: PairList,
    pub(super) chain: Chain,
    /// By link, then by obstacle; `None` without geometry.
    pub(super) riders: Vec<Option<Rider>>,
    /// In the order of the pair list.
    pub(super) infos: Vec<PairInfo>,
    /// A capsule around each body, and the pairs of them in the order of the pair list.
    pub(super) capsules: CapsulePairs,
    /// The largest padding (m) of any pair.
    pub(super) largest_padding: f64,
    /// By pair: the joints between its bodies.
    pub(super) between: Vec<Between>,
    pub(super) ways: Ways,
    /// How far bodies may move when joints do.
    pub(super) rates: TravelRates,
    /// Of the model and the world, once somebody asked.
    pub(super) fingerprints: OnceLock<[String; 2]>,
    /// No two checkers built in one process have the same.
    pub(super) identity: u64,
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
        let rates = travel_rates(&robot, &chain, &riders);
        let between = joints_between(&chain, &riders, &infos);
        let ways = ways_of(&chain, &riders, &infos, &between);
        let identity = BUILT.fetch_add(1, Ordering::Relaxed);
        Ok(Self {
            robot,
            world,
            settings,
            matrix: matrix.cloned(),
            pairs,
            chain,
            riders,
            infos,
            capsules,
            largest_padding,
            between,
            ways,
            rates,
            fingerprints: OnceLock::new(),
            identity,
        })
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
        Workspace { stream: Some(Stream::new(self.identity, self.infos.len())), ..self.workspace() }
    }

    pub(super) fn workspace_with(&self, scratch: Scratch) -> Workspace {
        let groups = self.capsules.group_count();
        Workspace {
            checker: self.identity,
            frames: vec![Frame::IDENTITY; self.chain.body_count()],
            segments: vec![Segment { centre: [0.0; 3], half: [0.0; 3] }; self.capsules.capsule_count()],
            near: vec![0; groups],
            bounds: vec![[0.0; LANES]; groups],
            queue: Vec::with_capacity(self.pairs.len()),
            likely: LikelyPairs::new(),
            scratch,
            motion: MotionScratch::default(),
            stream: None,
        }
    }

    /// Memory of all hierarchies and the triangles in them (bytes), and the number of triangles.
    #[must_use]
    pub fn hierarchy_size(&self) -> (usize, usize) {
        let solids = self.riders.iter().flatten().map(|rider| &rider.solid);
        solids.fold((0, 0), |(bytes, triangles), s| (bytes + s.bytes(), triangles + s.triangle_count()))
    }
}
