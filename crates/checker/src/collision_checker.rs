//! Collision checker: collision and distance queries on states of a robot in a world.

use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, OnceLock};

use clearance_geometry::ScaleError;
use clearance_geometry::math::Extremes;
use clearance_geometry::simd::LANES;
use clearance_motion::CertificateParts;
use clearance_proximity::Scratch;
use clearance_robot::{Chain, DisplacementRates, PathsToRoot, PlacedFrame, RobotModel};
use clearance_scene::AllowedCollisionMatrix;
use clearance_scene::World;

use super::Workspace;
use super::bodies::{
    RobotBody, capsule_pairs, chain, joints_between, pair_infos, robot_bodies, travel_rates,
};
use super::capsules::{CapsulePairs, PlacedSegment, up};
use super::fixed_nearest::FixedNearest;
use super::motion::{MotionScratch, Ways};
use super::nearby::NearbyScratch;
use super::nearest_first::NearestFirst;
use super::obstacles::Obstacles;
use super::pair::PairInfo;
use super::pair_priority::PairPriority;
use super::reachable::Reachable;
use super::stream::Stream;
use super::within_reach::{PartOrder, WithinReach};
use clearance_scene::BodyId;
use clearance_scene::PairList;
use clearance_scene::Settings;

/// Collision checker of a robot in a world; can be queried from any number of threads: `Send + Sync`, no lock.
///
/// Pairs have numbers: first the self pairs in the order of their list, then for each robot part one number per place of an obstacle.
#[derive(Clone, Debug)]
pub struct CollisionChecker {
    robot: Arc<RobotModel>,
    world: World,
    settings: Settings,
    pub(super) matrix: Option<AllowedCollisionMatrix>,
    pairs: PairList,
    pub(super) chain: Chain,
    /// The parts of the robot that have geometry.
    pub(super) robot_bodies: Vec<RobotBody>,
    /// In the order of the self pairs.
    pub(super) infos: Vec<PairInfo>,
    /// A capsule around each part, and the self pairs of these capsules.
    pub(super) capsules: CapsulePairs,
    /// By part: the radius (m) of its capsule with its padding, rounded up.
    pub(super) padded_radii: Vec<f32>,
    /// The largest padding (m) of any self pair.
    pub(super) largest_padding: f64,
    pub(super) paths_to_root: PathsToRoot,
    /// By self pair: the number of joints on either side of the lowest common ancestor of its bodies.
    pub(super) joints_between: Vec<[u32; 2]>,
    pub(super) ways: Ways,
    /// Bounds on how far bodies move when joints move.
    pub(super) rates: DisplacementRates,
    pub(super) reachable: Reachable,
    pub(super) obstacles: Obstacles,
    /// Parts that are to be tested against obstacles; computed at the first query.
    pub(super) within_reach: OnceLock<WithinReach>,
    /// Nearest obstacle to the parts that no joint moves; computed at the first query.
    pub(super) fixed_nearest: OnceLock<FixedNearest>,
    /// Fingerprints of the model and the world; computed at the first use.
    pub(super) fingerprints: OnceLock<[String; 2]>,
    pub(super) parts: OnceLock<CertificateParts>,
    /// Unique among all robots built in this process.
    pub(super) identity: u64,
    /// Unique among all robots in their worlds.
    pub(super) revision: u64,
}

static BUILT: AtomicU64 = AtomicU64::new(0);

fn next_identity() -> u64 {
    BUILT.fetch_add(1, Ordering::Relaxed)
}

/// A setting that is invalid for this robot.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SettingsError {
    #[error("padding or scale is given for link '{0}', which the robot has not")]
    UnknownLink(String),
    #[error("padding{of} is {value:?}, but must be a finite number of metres, zero or more")]
    BadPadding { of: String, value: f64 },
    #[error("the scale of '{of}' is {value:?}, but must be more than zero and at most 1000")]
    BadScale { of: String, value: f64 },
    #[error("'{of}' can not be scaled: {why}")]
    CannotScale { of: String, why: ScaleError },
    #[error("object '{object}' is attached to link '{link}', which the robot has not")]
    NoCarrier { object: String, link: String },
}

impl CollisionChecker {
    /// Builds the hierarchies of every link and obstacle, and selects the pairs by SRDF or adjacency.
    pub fn new(robot: Arc<RobotModel>, world: &World, settings: Settings) -> Result<Self, SettingsError> {
        Self::with_matrix(robot, world, settings, None)
    }

    /// As [`Self::new`]; a scene's allowed collision matrix, if given, selects the pairs instead of the SRDF.
    pub fn with_matrix(
        robot: Arc<RobotModel>,
        world: &World,
        settings: Settings,
        matrix: Option<&AllowedCollisionMatrix>,
    ) -> Result<Self, SettingsError> {
        Self::build(robot, world, settings, matrix, (&[], &Obstacles::default()))
    }

    /// The same robot in another world, or with other settings or another matrix. Hierarchies that do not change are shared.
    pub fn with_world(
        &self,
        world: &World,
        settings: Settings,
        matrix: Option<&AllowedCollisionMatrix>,
    ) -> Result<Self, SettingsError> {
        let known = (self.robot_bodies.as_slice(), &self.obstacles);
        Self::build(Arc::clone(&self.robot), world, settings, matrix, known)
    }

    /// Changes the world in place: only obstacles that differ are updated, unless attached objects differ. If this is not possible,
    /// returns an error and changes nothing.
    pub fn set_world(&mut self, world: &World) -> Result<(), SettingsError> {
        let same = |(a, b): (&Arc<_>, &Arc<_>)| Arc::ptr_eq(a, b);
        let (held, holds) = (self.world.attached(), world.attached());
        if held.len() != holds.len() || !held.iter().zip(holds).all(same) {
            *self = self.with_world(world, self.settings.clone(), self.matrix.as_ref())?;
            return Ok(());
        }
        // all fallible steps come before the first change
        for change in self.obstacles.outdated(world, &self.settings)? {
            self.pairs.set_obstacle(change.0, world.place(change.0).map(|obstacle| obstacle.name.as_str()));
            self.obstacles.set(change, &self.reachable);
        }
        self.world = world.clone();
        self.within_reach = OnceLock::new();
        self.fixed_nearest = OnceLock::new();
        self.fingerprints = OnceLock::new();
        self.parts = OnceLock::new();
        self.revision = next_identity();
        Ok(())
    }

    fn build(
        robot: Arc<RobotModel>,
        world: &World,
        settings: Settings,
        matrix: Option<&AllowedCollisionMatrix>,
        (known_riders, known_obstacles): (&[RobotBody], &Obstacles),
    ) -> Result<Self, SettingsError> {
        let pairs =
            PairList::new(&robot, world, matrix).restricted(settings.check_self, settings.check_world);
        let chain = chain(&robot, world);
        let robot_bodies = robot_bodies(&robot, world, (&chain, &pairs), &settings, known_riders)?;
        let infos = pair_infos(&pairs, &robot_bodies, &settings);
        let capsules = capsule_pairs(&robot_bodies, &infos);
        let padded_radii = robot_bodies
            .iter()
            .map(|robot_body| up(robot_body.capsule.radius + robot_body.padding))
            .collect();
        let largest_padding = infos.iter().map(|p| p.padding).fold(0.0, f64::greater);
        let reachable = Reachable::new(&robot, &chain, &robot_bodies);
        let obstacles = Obstacles::new(world, &settings, known_obstacles, &reachable)?;
        let rates = travel_rates(&robot, &chain, &robot_bodies);
        let paths_to_root = chain.paths_to_root();
        let joints_between = joints_between(&paths_to_root, &robot_bodies, &infos);
        let ways = Ways::new(&paths_to_root, &robot_bodies);
        Ok(Self {
            robot,
            world: world.clone(),
            settings,
            matrix: matrix.cloned(),
            pairs,
            chain,
            robot_bodies,
            infos,
            capsules,
            padded_radii,
            largest_padding,
            paths_to_root,
            joints_between,
            ways,
            rates,
            reachable,
            obstacles,
            within_reach: OnceLock::new(),
            fixed_nearest: OnceLock::new(),
            fingerprints: OnceLock::new(),
            parts: OnceLock::new(),
            identity: next_identity(),
            revision: next_identity(),
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

    /// Upper bound (m) on the change of any distance while joints move between two configurations; infinite where there is no bound.
    #[must_use]
    pub fn travel(&self, from: &[f64], to: &[f64]) -> f64 {
        self.rates.between(from, to)
    }

    /// The name of a link or an object.
    #[must_use]
    pub fn body_name(&self, body: BodyId) -> &str {
        match body {
            BodyId::Link(id) => &self.robot.link(id).name,
            BodyId::Attached(id) => &self.world.attached_object(id).name,
            BodyId::Obstacle(id) => &self.world.obstacle(id).name,
        }
    }

    /// Scratch memory for one thread.
    #[must_use]
    pub fn workspace(&self) -> Workspace {
        self.workspace_with(Scratch::default())
    }

    /// As [`Self::workspace`], but uses only the baseline instructions of this architecture. Results are the same, bit by bit.
    #[must_use]
    pub fn portable_workspace(&self) -> Workspace {
        self.workspace_with(Scratch::portable())
    }

    /// As [`Self::workspace`], for states that follow each other closely: results of one state are reused for the next, and only pairs
    /// for which they do not suffice are searched again. Reports are the same, except for their work counts. Distances within a tolerance
    /// ([`Self::check_with`]) are bounds that depend on earlier queries, for a fraction of the work.
    #[must_use]
    pub fn streaming_workspace(&self) -> Workspace {
        let stream = Stream::new(self.revision, self.infos.len(), self.robot_bodies.len());
        Workspace { stream: Some(stream), ..self.workspace() }
    }

    pub(super) fn workspace_with(&self, scratch: Scratch) -> Workspace {
        let groups = self.capsules.group_count();
        Workspace {
            checker: self.identity,
            frames: vec![PlacedFrame::IDENTITY; self.chain.body_count()],
            segments: vec![PlacedSegment::default(); self.capsules.capsule_count()],
            near: vec![0; groups],
            bounds: vec![[0.0; LANES]; groups],
            queue: Vec::with_capacity(self.pairs.len().min(1 << 12)),
            nearest_first: NearestFirst::default(),
            asked: Vec::new(),
            in_doubt: Vec::new(),
            part_order: PartOrder::default(),
            likely: PairPriority::new(),
            nearby: NearbyScratch::default(),
            scratch,
            motion: MotionScratch::default(),
            stream: None,
        }
    }

    /// The parts on some bodies of the chain.
    pub(super) fn parts_on(&self, bodies: impl Fn(usize) -> bool) -> impl DoubleEndedIterator<Item = usize> {
        (0..self.robot_bodies.len()).filter(move |part| bodies(self.robot_bodies[*part].body))
    }

    /// Memory of all hierarchies and the triangles in them (bytes), and the number of triangles.
    #[must_use]
    pub fn hierarchy_size(&self) -> (usize, usize) {
        let of_parts = self.robot_bodies.iter().map(|robot_body| &robot_body.solid);
        let solids = of_parts.chain(self.obstacles.iter().map(|obstacle| &obstacle.solid));
        solids.fold((0, 0), |(bytes, triangles), s| (bytes + s.bytes(), triangles + s.triangle_count()))
    }
}
