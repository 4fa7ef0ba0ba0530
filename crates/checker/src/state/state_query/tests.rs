//! Self and world apart: a checker of both kinds of pairs reports, bit for bit, what two checkers report that check one
//! kind each.

use std::sync::Arc;

use clearance_geometry::testing::Random;
use clearance_proximity::Work;
use clearance_robot::{Configuration, RobotModel};
use clearance_scene::{BodyId, Settings, World};

use crate::random_scenes::{GRID, coordinate, robot, settings, world};
use crate::{CollisionChecker, CollisionReport, PairDistance, PairKind, Question, Workspace};

fn state(robot: &RobotModel, random: &mut Random) -> Vec<f64> {
    robot.position_names().iter().map(|_| coordinate(random, 1.0)).collect()
}

/// A state near another one, or anywhere.
fn next_state(before: &[f64], robot: &RobotModel, random: &mut Random) -> Vec<f64> {
    match random.below(12) {
        0 => state(robot, random),
        1 => before.to_vec(),
        2 => before.iter().map(|q| (q / GRID).round() * GRID).collect(),
        _ => before.iter().map(|q| q + random.within(0.004)).collect(),
    }
}

/// A checker with its workspaces: for single states, and for a stream.
struct Checked {
    checker: CollisionChecker,
    single: Workspace,
    stream: Workspace,
}

impl Checked {
    fn new(robot: &Arc<RobotModel>, world: &World, settings: Settings) -> Self {
        let checker = CollisionChecker::new(Arc::clone(robot), world, settings).unwrap();
        let (single, stream) = (checker.workspace(), checker.streaming_workspace());
        Self { checker, single, stream }
    }

    /// The report, which is the same for a single state and in a stream.
    fn check(&mut self, q: &Configuration, question: Question) -> CollisionReport {
        let without_work = |report| CollisionReport { work: Work::default(), ..report };
        let single = without_work(self.checker.check(q, question, &mut self.single));
        let streamed = without_work(self.checker.check(q, question, &mut self.stream));
        assert_eq!(single, streamed, "{question:?}");
        single
    }
}

/// Bodies and bits of a distance.
fn bits(pair: &PairDistance) -> (BodyId, BodyId, [u64; 8]) {
    let [p, q] = pair.witness_points;
    let numbers = [pair.distance, pair.lower, p.x, p.y, p.z, q.x, q.y, q.z];
    (pair.a, pair.b, numbers.map(f64::to_bits))
}

/// Compares the results about one kind of pairs with those of a checker that checks no others.
fn are_apart(both: &CollisionReport, alone: &CollisionReport, kind: PairKind) {
    let is_of_kind = |pair: &&PairDistance| pair.kind() == kind;
    assert_eq!(both.nearest_of(kind).map(bits), alone.nearest.as_ref().map(bits));
    assert_eq!(both.has_collision(kind), alone.has_collision(kind));
    let of_kind = both.pair_distances.iter().filter(is_of_kind).map(bits);
    assert!(of_kind.eq(alone.pair_distances.iter().map(bits)));
    let touching = both.colliding_pairs.iter().filter(|pair| PairKind::of_second(pair.1) == kind);
    assert!(touching.eq(&alone.colliding_pairs));
    let other = PairKind::ALL.into_iter().find(|other| *other != kind).unwrap();
    assert!(alone.nearest_of(other).is_none() && !alone.has_collision(other));
}

/// Counts of each kind of result.
#[derive(Debug, Default)]
struct Counts {
    nothing: [u32; 2],
    touching: [u32; 2],
    apart: [u32; 2],
}

impl Counts {
    fn note(&mut self, report: &CollisionReport) {
        for (i, kind) in PairKind::ALL.into_iter().enumerate() {
            match report.nearest_of(kind) {
                None => self.nothing[i] += 1,
                Some(nearest) if nearest.distance == 0.0 => self.touching[i] += 1,
                Some(_) => self.apart[i] += 1,
            }
        }
    }
}

#[test]
fn self_and_world_are_apart_bit_for_bit() {
    let (mut random, mut counts) = (Random::new(91), Counts::default());
    for _ in 0..250 {
        let (robot, world, settings) =
            (Arc::new(robot(&mut random)), world(&mut random), settings(&mut random));
        let checked = |check_self, check_world| {
            Checked::new(&robot, &world, Settings { check_self, check_world, ..settings.clone() })
        };
        let (mut both, mut alone) = (checked(true, true), [checked(true, false), checked(false, true)]);
        let mut positions = state(&robot, &mut random);
        for _ in 0..40 {
            positions = next_state(&positions, &robot, &mut random);
            let q = robot.configuration(&positions).unwrap();
            let limit = [f64::INFINITY, 0.3, GRID, 0.0, -1.0][random.below(5)];
            let influence_distance = [0.0, 0.02, 0.1][random.below(3)];
            let question = match random.below(3) {
                0 => Question::SelfAndWorldDistance { limit },
                1 => Question::PairDistances { limit },
                _ => Question::Survey { influence_distance, limit },
            };
            let report = both.check(&q, question);
            counts.note(&report);
            for (kind, alone) in PairKind::ALL.into_iter().zip(&mut alone) {
                let report_alone = alone.check(&q, question);
                assert_eq!(report_alone.nearest_of(kind), report_alone.nearest.as_ref());
                are_apart(&report, &report_alone, kind);
                if matches!(question, Question::SelfAndWorldDistance { .. }) {
                    are_apart(&report, &alone.check(&q, Question::Distance { limit }), kind);
                }
            }
            if !matches!(question, Question::PairDistances { .. }) {
                let least = both.check(&q, Question::Distance { limit });
                assert_eq!(report.is_free(), least.is_free());
                let reaches_farther =
                    matches!(question, Question::Survey { .. }) && influence_distance > limit;
                let of_touching =
                    |n: &PairDistance| matches!(question, Question::Survey { .. }) && n.distance == 0.0;
                // which of several touching pairs is reported depends on the search
                if !reaches_farther && !report.nearest.as_ref().is_some_and(of_touching) {
                    assert_eq!(report.nearest.as_ref().map(bits), least.nearest.as_ref().map(bits));
                }
            }
        }
    }
    let Counts { nothing, touching, apart } = counts;
    assert!([nothing, touching, apart].iter().flatten().all(|count| *count > 500), "{counts:?}");
}
