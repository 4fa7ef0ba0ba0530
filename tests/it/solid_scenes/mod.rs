//! Tests of solid meshes in random scenes: queries, streams, batches and motions against brute force.
//!
//! Brute force takes surfaces from the reference engine, points of clouds one by one, and adds the solid angles of all faces to find out
//! whether something is inside.

mod random_scene;
mod slow_body;

use std::sync::Arc;

use clearance::checker::{
    CollisionChecker, CollisionReport, MotionOptions, MotionVerdict, PairDistance, PairKind, Question,
    Workspace,
};
use clearance::geometry::math::Pose;
use clearance::motion::MotionSegment;
use clearance::proximity::Effort;
use clearance::robot::{Configuration, LinkPoses};
use clearance::scene::{BodyId, MeshModel, Settings};

use crate::random::Random;
use random_scene::{JOINTS, robot, world};
use slow_body::Slow;

/// Up to this distance (m), pairs are compared.
const NEAR: f64 = 0.2;

/// Difference (m) of distances that rounding explains.
const ROUNDING: f64 = 1e-9;

/// A scene, for both.
struct Scene {
    checker: CollisionChecker,
    parts: Vec<Slow>,
    obstacles: Vec<(Pose, Slow)>,
}

/// A pair that touches or is near, its distance (m), and whether one body is inside the other.
type NearPair = (BodyId, BodyId, f64, bool);

impl Scene {
    fn new(random: &mut Random, padding: f64) -> Self {
        let (robot, world) = (robot(random), world(random));
        let settings = Settings { mesh_model: MeshModel::Solid, padding, ..Settings::default() };
        let checker = CollisionChecker::new(Arc::clone(&robot), &world, settings).unwrap();
        let slow_part = |id| match id {
            BodyId::Link(link) => {
                let shapes = robot.link(link).collisions.iter().map(|c| (c.pose_ls, &c.shape));
                Slow::new(id, &shapes.collect::<Vec<_>>())
            }
            BodyId::Attached(object) => {
                let object = world.attached_object(object);
                let shapes = object.shapes.iter().map(|s| (object.pose_lo * s.pose_os, &s.shape));
                Slow::new(id, &shapes.collect::<Vec<_>>())
            }
            BodyId::Obstacle(_) => unreachable!("no part of the robot"),
        };
        let parts = checker.pairs().parts().map(slow_part).collect();
        let obstacles = world.ids().map(|id| {
            let obstacle = world.obstacle(id);
            let shapes: Vec<_> = obstacle.shapes.iter().map(|s| (s.pose_os, &s.shape)).collect();
            (obstacle.pose_ro, Slow::new(BodyId::Obstacle(id), &shapes))
        });
        let obstacles = obstacles.collect();
        Self { checker, parts, obstacles }
    }

    fn state(&self, random: &mut Random) -> Configuration {
        let positions: Vec<f64> = (0..JOINTS).map(|_| random.within(-0.7, 0.7)).collect();
        self.checker.robot().configuration(&positions).unwrap()
    }

    /// All pairs within a distance (m), by brute force.
    fn near_pairs(&self, q: &Configuration, limit: f64) -> Vec<NearPair> {
        let robot = self.checker.robot();
        let mut poses = LinkPoses::new(robot);
        robot.forward_kinematics(q, &mut poses);
        let pose_of = |body: BodyId| match body {
            BodyId::Link(id) => *poses.pose(id),
            BodyId::Attached(id) => {
                *poses.pose(robot.link_by_name(&self.checker.world().attached_object(id).link).unwrap())
            }
            BodyId::Obstacle(_) => unreachable!("no part of the robot"),
        };
        let padding = self.checker.settings().padding;
        let mut near = Vec::new();
        let mut add = |a: &Slow, b: &Slow, pose_ab: &Pose, padding: f64| {
            let (distance, is_inside) = a.distance(b, pose_ab);
            if distance - padding <= limit {
                near.push((a.id, b.id, (distance - padding).max(0.0), is_inside));
            }
        };
        let part = |id: BodyId| self.parts.iter().find(|slow| slow.id == id).unwrap();
        for (a, b) in self.checker.pairs().self_pairs() {
            add(part(*a), part(*b), &(pose_of(*a).inverse() * pose_of(*b)), 0.0);
        }
        for (a, obstacle) in self.checker.pairs().world_pairs() {
            let (pose_ro, b) =
                self.obstacles.iter().find(|(_, slow)| slow.id == BodyId::Obstacle(obstacle)).unwrap();
            add(part(a), b, &(pose_of(a).inverse() * pose_ro), padding);
        }
        near
    }

    /// Compares the answers to one question with the near pairs.
    fn compare(&self, q: &Configuration, near: &[NearPair], question: Question, workspace: &mut Workspace) {
        let report = self.checker.check(q, question, workspace);
        let touching: Vec<_> =
            near.iter().filter(|pair| pair.2 == 0.0).map(|pair| (pair.0, pair.1)).collect();
        assert_eq!(report.is_free(), touching.is_empty(), "{question:?} {near:?} {report:?}");
        let least = near.iter().map(|pair| pair.2).fold(f64::INFINITY, f64::min);
        match question {
            Question::Free => {}
            Question::Pairs => assert_eq!(report.colliding_pairs, touching, "{near:?}"),
            Question::Distance { limit } => assert_nearest(report.nearest.as_ref(), least, limit),
            Question::SelfAndWorldDistance { limit } => {
                assert_nearest(report.nearest.as_ref(), least, limit);
                assert_each_kind(&report, near, limit);
            }
            Question::PairDistances { limit } => assert_distances(&report, near, limit),
            Question::Survey { influence_distance, limit } => {
                assert_distances(&report, near, influence_distance);
                assert_nearest(report.nearest.as_ref(), least, limit);
                assert_each_kind(&report, near, limit);
            }
        }
    }
}

/// `least` is infinite if nothing is within [`NEAR`].
fn assert_nearest(nearest: Option<&PairDistance>, least: f64, limit: f64) {
    match nearest {
        Some(nearest) if least == f64::INFINITY => assert!(nearest.distance > NEAR - ROUNDING, "{nearest:?}"),
        Some(nearest) => assert!((nearest.distance - least).abs() < ROUNDING, "{nearest:?} {least}"),
        None => assert!(least > limit.min(NEAR) - ROUNDING, "{least}"),
    }
}

/// The nearest self pair and the nearest world pair.
fn assert_each_kind(report: &CollisionReport, near: &[NearPair], limit: f64) {
    for kind in PairKind::ALL {
        let of_kind = near.iter().filter(|pair| PairKind::of_second(pair.1) == kind);
        let least = of_kind.map(|pair| pair.2).fold(f64::INFINITY, f64::min);
        assert_nearest(report.nearest_of(kind), least, limit);
    }
}

fn assert_distances(report: &CollisionReport, near: &[NearPair], limit: f64) {
    let expected = near.iter().filter(|pair| pair.2 <= limit);
    let expected: Vec<_> = expected.map(|(a, b, distance, _)| (*a, *b, *distance)).collect();
    assert_eq!(report.pair_distances.len(), expected.len(), "{report:?} {near:?}");
    for (found, (a, b, distance)) in report.pair_distances.iter().zip(&expected) {
        assert_eq!((found.a, found.b), (*a, *b), "{near:?}");
        assert!((found.distance - distance).abs() < ROUNDING, "{found:?} {distance}");
    }
}

/// Distances next to a limit depend on rounding: limits between the distances that occur.
fn limit_between(near: &[NearPair], random: &mut Random) -> f64 {
    let limit = random.within(0.0, NEAR);
    let is_clear = |limit: f64| near.iter().all(|pair| (pair.2 - limit).abs() > 1e-7);
    if is_clear(limit) { limit } else { limit + 1e-6 }
}

const QUESTIONS: usize = 8;

fn questions(near: &[NearPair], random: &mut Random) -> [Question; QUESTIONS] {
    let mut limit = || limit_between(near, random);
    [
        Question::Free,
        Question::Pairs,
        Question::Distance { limit: limit() },
        Question::Distance { limit: f64::INFINITY },
        Question::SelfAndWorldDistance { limit: limit() },
        Question::SelfAndWorldDistance { limit: f64::INFINITY },
        Question::PairDistances { limit: limit() },
        Question::Survey { influence_distance: limit(), limit: f64::INFINITY },
    ]
}

/// How often a pair had one body inside the other, how often nothing touched, and in how many states.
#[derive(Debug, Default)]
struct Seen {
    inside: usize,
    only_inside: usize,
    free: usize,
    states: usize,
}

impl Seen {
    fn note(&mut self, near: &[NearPair]) {
        self.states += 1;
        self.inside += usize::from(near.iter().any(|pair| pair.3));
        self.free += usize::from(near.iter().all(|pair| pair.2 > 0.0));
        let touching = || near.iter().filter(|pair| pair.2 == 0.0);
        self.only_inside += usize::from(touching().count() > 0 && touching().all(|pair| pair.3));
    }
}

#[test]
fn every_question_and_batches_are_as_by_brute_force() {
    let mut random = Random::new(2027);
    let mut seen = Seen::default();
    for round in 0..48 {
        let scene = Scene::new(&mut random, [0.0, 0.0, 0.01][round % 3]);
        let mut workspace = scene.checker.workspace();
        let states: Vec<Configuration> = (0..11).map(|_| scene.state(&mut random)).collect();
        let all_near: Vec<Vec<NearPair>> = states.iter().map(|q| scene.near_pairs(q, NEAR)).collect();
        for (q, near) in states.iter().zip(&all_near) {
            for question in questions(near, &mut random) {
                scene.compare(q, near, question, &mut workspace);
            }
            assert_eq!(scene.checker.is_free(q, &mut workspace), near.iter().all(|pair| pair.2 > 0.0));
            seen.note(near);
        }
        let free: Vec<bool> = all_near.iter().map(|near| near.iter().all(|pair| pair.2 > 0.0)).collect();
        assert_eq!(scene.checker.are_free(&states), free, "round {round}");
    }
    assert!(seen.inside > 100 && seen.only_inside > 10 && seen.free > 40, "{seen:?}");
}

/// The memory of a stream stays right while bodies come inside others, leave them, or jump there.
#[test]
fn streams_are_as_by_brute_force() {
    let mut random = Random::new(2028);
    let mut seen = Seen::default();
    for round in 0..12 {
        let scene = Scene::new(&mut random, [0.0, 0.0, 0.01][round % 3]);
        let mut streams: [Workspace; QUESTIONS] =
            std::array::from_fn(|_| scene.checker.streaming_workspace());
        let mut tolerant = scene.checker.streaming_workspace();
        let mut last = scene.state(&mut random);
        let step = [0.001, 0.01, 0.05][round % 3];
        for i in 0..40 {
            last = if i % 13 == 12 {
                scene.state(&mut random)
            } else {
                let moved =
                    last.positions().iter().map(|q| (q + random.within(-step, step)).clamp(-0.7, 0.7));
                scene.checker.robot().configuration(&moved.collect::<Vec<_>>()).unwrap()
            };
            let near = scene.near_pairs(&last, NEAR);
            for (question, stream) in questions(&near, &mut random).into_iter().zip(&mut streams) {
                scene.compare(&last, &near, question, stream);
                scene.checker.prepare(stream);
            }
            let effort = Effort { relative_tolerance: 0.2, ..Effort::default() };
            let question = Question::Distance { limit: f64::INFINITY };
            let report = scene.checker.check_with(&last, question, &effort, &mut tolerant);
            assert_eq!(report.is_free(), near.iter().all(|pair| pair.2 > 0.0), "{near:?} {report:?}");
            seen.note(&near);
        }
    }
    assert!(seen.inside > 80 && seen.only_inside > 30 && seen.free > 40, "{seen:?}");
}

/// What is proven free is free in many states of it, and where a contact is named there is one.
#[test]
fn motions_are_free_where_brute_force_finds_nothing() {
    let mut random = Random::new(2029);
    let (mut free, mut contacts, mut inside) = (0, 0, 0);
    for _ in 0..20 {
        let scene = Scene::new(&mut random, 0.0);
        let mut workspace = scene.checker.workspace();
        for _ in 0..12 {
            let from = scene.state(&mut random);
            let moved: Vec<f64> = from.positions().iter().map(|q| q + random.within(-0.2, 0.2)).collect();
            let to = scene.checker.robot().configuration(&moved).unwrap();
            let segment = MotionSegment::straight(scene.checker.robot(), &from, &to);
            let verdict =
                scene.checker.check_motion_with(&segment, &MotionOptions::default(), &mut workspace).verdict;
            let at = |t: f64| scene.near_pairs(&segment.at(t), 0.0);
            let is_free = |t: f64| at(t).iter().all(|pair| pair.2 > 0.0);
            match verdict {
                MotionVerdict::Free => {
                    assert!((0..=20).all(|i| is_free(f64::from(i) / 20.0)));
                    free += 1;
                }
                MotionVerdict::Contact { t: [before, at_contact], pair, .. } => {
                    let touching = at(at_contact);
                    let found = touching.iter().find(|near| (near.0, near.1) == pair);
                    assert!(found.is_some_and(|near| near.2 < ROUNDING), "{pair:?} {touching:?}");
                    inside += usize::from(found.is_some_and(|near| near.3));
                    assert!((0..8).all(|i| is_free(before * f64::from(i) / 8.0)) || before == 0.0);
                    contacts += 1;
                }
                MotionVerdict::Undecided { .. } => {}
            }
        }
    }
    assert!(free > 30 && contacts > 40 && inside > 10, "{free} {contacts} {inside}");
}
