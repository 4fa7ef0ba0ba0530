//! Tests of state queries: a checker of self and world pairs reports, bit for bit, the results of two checkers that
//! check one kind each.

use std::sync::Arc;

use clearance_geometry::math::{Extremes, Pose};
use clearance_geometry::testing::Random;
use clearance_geometry::{Primitive, Shape};
use clearance_proximity::{Effort, Work};
use clearance_robot::{Configuration, MeshFiles, RobotModel};
use clearance_scene::{BodyId, Obstacle, Settings, World};

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

/// Lower bound on the distances of all pairs of a kind that a survey implies; `None` without a pair of this kind.
fn bound_of_survey(report: &CollisionReport, kind: PairKind) -> Option<f64> {
    let of_kind =
        report.pair_distances.iter().chain(report.nearest_of(kind)).filter(|pair| pair.kind() == kind);
    of_kind.map(|pair| pair.lower).reduce(f64::lesser)
}

/// The survey of a state in a stream with tolerances, compared with the least distances of single states.
fn survey_holds(checked: &mut Checked, q: &Configuration, influence_distance: f64, effort: &Effort) -> usize {
    let question = Question::Survey { influence_distance, limit: f64::INFINITY };
    let survey = checked.checker.check_with(q, question, effort, &mut checked.stream);
    let exact = Question::SelfAndWorldDistance { limit: f64::INFINITY };
    let exact = checked.checker.check(q, exact, &mut checked.single);
    let mut compared = 0;
    for kind in PairKind::ALL {
        assert_eq!(survey.has_collision(kind), exact.has_collision(kind));
        let Some(truth) = exact.nearest_of(kind) else { continue };
        let bound = bound_of_survey(&survey, kind).unwrap();
        let found = survey.nearest_of(kind).unwrap().distance;
        let rounding = 1e-9 * (1.0 + truth.distance);
        assert!(bound <= truth.distance + rounding, "{bound} {truth:?} {influence_distance} {effort:?}");
        assert!(found >= truth.distance - rounding, "{found} {truth:?} {influence_distance} {effort:?}");
        compared += usize::from(truth.distance > 0.0);
    }
    compared
}

#[test]
fn a_survey_with_tolerances_bounds_the_least_distance_of_each_kind() {
    let (mut random, mut compared) = (Random::new(92), 0);
    for _ in 0..250 {
        let (robot, world, settings) =
            (Arc::new(robot(&mut random)), world(&mut random), settings(&mut random));
        let mut checked = Checked::new(&robot, &world, settings);
        let effort = Effort {
            absolute_tolerance: [0.0, 0.05, 0.2][random.below(3)],
            relative_tolerance: [0.0, 0.1, 0.5][random.below(3)],
            exact_cost: [0, 100, 1000][random.below(3)],
            ..Effort::default()
        };
        let mut positions = state(&robot, &mut random);
        for _ in 0..40 {
            positions = next_state(&positions, &robot, &mut random);
            let q = robot.configuration(&positions).unwrap();
            compared += survey_holds(&mut checked, &q, [0.0, 0.001, 0.1][random.below(3)], &effort);
        }
    }
    assert!(compared > 5_000, "{compared}");
}

/// The nearest pair has the roughest bounds, which are improved to decide its contact; the other is 0.5 mm apart.
#[test]
fn a_pair_that_turns_out_to_be_far_hides_no_near_one() {
    let urdf = "<robot name='r'><link name='base'>
        <collision><origin xyz='1 0 0.084'/><geometry><sphere radius='0.05'/></geometry></collision>
        <collision><origin xyz='1 0 -0.084'/><geometry><sphere radius='0.05'/></geometry></collision></link>
        <link name='tip'><collision><geometry><sphere radius='0.001'/></geometry></collision></link>
        <joint name='x' type='prismatic'><parent link='base'/><child link='tip'/><axis xyz='1 0 0'/>
        <limit lower='-1' upper='1' effort='1' velocity='1'/></joint></robot>";
    let robot = Arc::new(RobotModel::from_urdf(urdf, &MeshFiles::default()).unwrap());
    let mut world = World::default();
    for (name, x, radius) in [("between", 1.0, 0.01), ("wire", 0.0, 0.0005)] {
        let ball = Shape::Primitive(Primitive::sphere(radius).unwrap());
        world.add(Obstacle::of_shape(name, Pose::translation(x, 0.0, 0.0), ball)).unwrap();
    }
    let mut checked = Checked::new(&robot, &world, Settings::default());
    let q = robot.configuration(&[0.002]).unwrap();
    for tolerance in [0.05, 0.1] {
        let effort = Effort { absolute_tolerance: tolerance, ..Effort::default() };
        for influence_distance in [0.0, 0.0001, 0.1] {
            assert!(survey_holds(&mut checked, &q, influence_distance, &effort) > 0);
        }
    }
}
