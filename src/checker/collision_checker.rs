//! Questions about states of a robot in a world.

use std::sync::Arc;

use super::pair::Pair;
use super::report::{Body, CollisionReport, Question};
use super::settings::{MeshModel, Settings};
use super::{AllowedCollisionMatrix, PairList, Workspace};
use crate::constants::CONTACT_DISTANCE;
use crate::math::Pose;
use crate::query::{CollisionBody, Work};
use crate::robot::{Configuration, LinkPoses, RobotModel};
use crate::world::World;

/// A robot in a world, ready for questions from any number of threads: `Send + Sync`, no lock.
#[derive(Clone, Debug)]
pub struct CollisionChecker {
    robot: Arc<RobotModel>,
    world: World,
    settings: Settings,
    pairs: PairList,
    /// By link; `None` without geometry.
    link_bodies: Vec<Option<CollisionBody>>,
    /// By obstacle; in the root frame.
    obstacle_bodies: Vec<Option<CollisionBody>>,
    link_padding: Vec<f64>,
}

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
        let link_padding = link_padding(&robot, &settings)?;
        let pairs =
            PairList::new(&robot, world, matrix).restricted(settings.check_self, settings.check_world);
        let mesh_model = settings.mesh_model;
        let link_bodies = (robot.links().iter())
            .map(|l| body(l.collisions.iter().map(|c| (&c.pose_ls, &c.shape)), mesh_model))
            .collect();
        let obstacle_bodies = (world.obstacles().iter())
            .map(|o| body(o.shapes.iter().map(|s| (&s.pose_rs, &s.shape)), mesh_model))
            .collect();
        Ok(Self { world: world.clone(), link_bodies, obstacle_bodies, robot, settings, pairs, link_padding })
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
        Workspace { poses: LinkPoses::new(&self.robot), queue: Vec::with_capacity(self.pairs.len()) }
    }

    /// Where the links were in the last check made with this workspace (root frame).
    #[must_use]
    pub fn link_poses<'w>(&self, workspace: &'w Workspace) -> &'w LinkPoses {
        &workspace.poses
    }

    /// Whether every pair is proven apart; stops at the first that is not.
    #[must_use]
    pub fn is_free(&self, q: &Configuration, workspace: &mut Workspace) -> bool {
        self.robot.forward_kinematics(q, &mut workspace.poses);
        let mut work = Work::default();
        !(0..self.pairs.len()).any(|i| self.pair(i, &workspace.poses).touches(&mut work))
    }

    /// Answers `question` about the state `q`.
    #[must_use]
    pub fn check(&self, q: &Configuration, question: Question, workspace: &mut Workspace) -> CollisionReport {
        self.robot.forward_kinematics(q, &mut workspace.poses);
        let mut report = CollisionReport::default();
        match question {
            Question::Free => self.first_hits(workspace, &mut report),
            Question::Pairs => self.all_hits(workspace, &mut report),
            Question::Distance { limit } => {
                self.first_hits(workspace, &mut report);
                self.least_distance(limit, workspace, &mut report);
            }
            Question::PairDistances { limit } => self.distances(limit, workspace, &mut report),
            Question::Survey { influence_distance, limit } => {
                self.distances(influence_distance, workspace, &mut report);
                if report.nearest.is_none() && limit > influence_distance {
                    self.least_distance(limit, workspace, &mut report);
                }
            }
        }
        report
    }

    /// The first colliding pair of links, and the first of a link and an obstacle.
    fn first_hits(&self, workspace: &Workspace, report: &mut CollisionReport) {
        let self_count = self.pairs.self_pairs().len();
        for scope in [0..self_count, self_count..self.pairs.len()] {
            for i in scope {
                let pair = self.pair(i, &workspace.poses);
                if pair.touches(&mut report.work) {
                    report.add_hit(pair.ids);
                    break;
                }
            }
        }
    }

    fn all_hits(&self, workspace: &Workspace, report: &mut CollisionReport) {
        for i in 0..self.pairs.len() {
            let pair = self.pair(i, &workspace.poses);
            if pair.touches(&mut report.work) {
                report.add_hit(pair.ids);
            }
        }
    }

    /// The least distance of all pairs; pairs that may be nearer are asked first, and each only up to the least so far.
    fn least_distance(&self, limit: f64, workspace: &mut Workspace, report: &mut CollisionReport) {
        let Workspace { poses, queue } = workspace;
        queue.clear();
        for i in 0..self.pairs.len() {
            let lower = self.pair(i, poses).lower_bound(&mut report.work);
            queue.push((lower, i));
        }
        queue.sort_unstable_by(|x, y| x.0.total_cmp(&y.0).then(x.1.cmp(&y.1)));
        let mut bound = limit.max(CONTACT_DISTANCE);
        for &(lower, i) in queue.iter() {
            if lower > bound || report.nearest.is_some_and(|n| n.distance == 0.0) {
                break;
            }
            let pair = self.pair(i, poses);
            if let Some(found) = pair.distance(bound, &mut report.work)
                && report.nearest.is_none_or(|n| found.distance < n.distance)
            {
                bound = found.distance;
                report.nearest = Some(found);
            }
        }
        // where two methods could differ, the one that saw contact is believed
        if let Some(touching) = report.nearest.filter(|n| n.distance == 0.0)
            && !report.hits_like(touching.b)
        {
            report.add_hit((touching.a, touching.b));
        }
    }

    /// Every pair's distance up to `limit`.
    fn distances(&self, limit: f64, workspace: &Workspace, report: &mut CollisionReport) {
        for i in 0..self.pairs.len() {
            let pair = self.pair(i, &workspace.poses);
            if pair.lower_bound(&mut report.work) > limit.max(CONTACT_DISTANCE) {
                continue;
            }
            let Some(found) = pair.distance(limit, &mut report.work) else {
                continue;
            };
            if found.distance == 0.0 {
                report.add_hit(pair.ids);
            }
            if report.nearest.is_none_or(|n| found.distance < n.distance) {
                report.nearest = Some(found);
            }
            report.pair_distances.push(found);
        }
    }

    /// Pair number `index`: pairs of links first, then of links and obstacles.
    fn pair(&self, index: usize, poses: &LinkPoses) -> Pair<'_> {
        let self_pairs = self.pairs.self_pairs();
        let has_body = "pairs name only bodies with geometry";
        if let Some(&(a, b)) = self_pairs.get(index) {
            let padding = if self.settings.pad_self {
                self.link_padding[a.index()] + self.link_padding[b.index()]
            } else {
                0.0
            };
            let body = |l: crate::robot::LinkId| self.link_bodies[l.index()].as_ref().expect(has_body);
            return Pair {
                ids: (Body::Link(a), Body::Link(b)),
                bodies: (body(a), body(b)),
                poses: (*poses.pose(a), *poses.pose(b)),
                padding,
            };
        }
        let (link, obstacle) = self.pairs.world_pairs()[index - self_pairs.len()];
        Pair {
            ids: (Body::Link(link), Body::Obstacle(obstacle)),
            bodies: (
                self.link_bodies[link.index()].as_ref().expect(has_body),
                (self.obstacle_bodies[obstacle.0 as usize].as_ref()).expect(has_body),
            ),
            poses: (*poses.pose(link), Pose::identity()),
            padding: self.link_padding[link.index()],
        }
    }
}

impl CollisionReport {
    /// Whether a collision with the same kind of body as `other` is known.
    fn hits_like(&self, other: Body) -> bool {
        match other {
            Body::Link(_) => self.self_collision,
            Body::Obstacle(_) => self.world_collision,
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

fn body<'a>(
    shapes: impl Iterator<Item = (&'a Pose, &'a crate::geometry::Shape)> + Clone,
    mesh_model: MeshModel,
) -> Option<CollisionBody> {
    match mesh_model {
        MeshModel::Surface => CollisionBody::new(shapes),
        MeshModel::Solid => CollisionBody::with_solid_meshes(shapes),
    }
}

fn link_padding(robot: &RobotModel, settings: &Settings) -> Result<Vec<f64>, SettingsError> {
    let usable = |of: &str, value: f64| {
        if value.is_finite() && value >= 0.0 {
            Ok(value)
        } else {
            Err(SettingsError::BadPadding { of: of.to_owned(), value })
        }
    };
    let default = usable("", settings.padding)?;
    let mut padding = vec![default; robot.links().len()];
    for (name, &value) in &settings.link_padding {
        let link = (robot.link_by_name(name)).ok_or_else(|| SettingsError::UnknownLink(name.clone()))?;
        padding[link.index()] = usable(&format!(" of link '{name}'"), value)?;
    }
    Ok(padding)
}
