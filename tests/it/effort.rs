//! Tests of tolerances and deadlines of checks: fewer exact distances, but correct bounds and contacts.

use clearance::checker::{
    CollisionChecker, CollisionReport, PairDistance, PairKind, Question, UndecidedPair, Workspace,
};
use clearance::geometry::math::{Point, Pose};
use clearance::geometry::{Shape, TriangleMesh};
use clearance::proximity::{Effort, Work};
use clearance::robot::{Configuration, MeshFiles, RobotModel};
use clearance::scene::{AttachedObject, BodyId, Obstacle, Settings, World};
use std::sync::Arc;
use std::time::{Duration, Instant};

use crate::random::Random;
use crate::streams::{checkers, random_state, walk};

const ALL: Question = Question::PairDistances { limit: f64::INFINITY };

fn exact(checker: &CollisionChecker, q: &Configuration) -> CollisionReport {
    checker.check(q, ALL, &mut checker.workspace())
}

fn distance_of(report: &CollisionReport, pair: &UndecidedPair) -> f64 {
    let same = report.pair_distances.iter().find(|p| (p.a, p.b) == (pair.a, pair.b));
    same.expect("all pairs are listed").distance
}

#[test]
fn tolerances_are_kept() {
    let mut random = Random::new(70);
    let (mut saved, mut full) = (0, 0);
    for checker in checkers() {
        let mut workspace = checker.workspace();
        for _ in 0..60 {
            let q = random_state(&checker, &mut random);
            let truth = exact(&checker, &q);
            let effort = Effort { relative_tolerance: 0.2, absolute_tolerance: 0.01, ..Effort::default() };
            let limit = f64::INFINITY;
            let nearest = checker.check(&q, Question::Distance { limit }, &mut workspace);
            full += nearest.work.screened_pairs;
            let told = checker.check_with(&q, Question::Distance { limit }, &effort, &mut workspace);
            saved += told.work.screened_pairs;
            let (told_nearest, least) = (told.nearest.unwrap(), nearest.nearest.unwrap().distance);
            assert!(told_nearest.lower <= least && least <= told_nearest.distance + 1e-12);
            // the share is of the distance without padding, which is 1 cm a body
            let allowed = (0.2 * (told_nearest.distance + 0.02)).max(0.01);
            assert!(told_nearest.distance - told_nearest.lower <= allowed + 1e-12);
            assert_eq!(told.is_free(), truth.is_free(), "tolerances are for distances, not for contact");
            let every = checker.check_with(&q, ALL, &effort, &mut workspace);
            assert_eq!(every.is_free(), truth.is_free());
            for (told, truth) in every.pair_distances.iter().zip(&truth.pair_distances) {
                assert_eq!((told.a, told.b), (truth.a, truth.b));
                assert!(told.lower <= truth.distance && truth.distance <= told.distance + 1e-12);
            }
        }
    }
    assert!(saved < full, "{saved} triangles screened instead of {full}");
}

const SMALL: Effort = Effort {
    relative_tolerance: 0.1,
    absolute_tolerance: 0.002,
    exact_within: 0.0,
    exact_cost: 0,
    deadline: None,
};
const LARGE: Effort = Effort {
    relative_tolerance: 0.6,
    absolute_tolerance: 0.1,
    exact_within: 0.04,
    exact_cost: 0,
    deadline: None,
};

const QUESTIONS: [Question; 10] = [
    Question::PairDistances { limit: 0.05 },
    ALL,
    Question::Survey { influence_distance: 0.05, limit: 1.0 },
    Question::Survey { influence_distance: 0.0, limit: f64::INFINITY },
    Question::PairDistances { limit: -1.0 },
    Question::PairDistances { limit: f64::NAN },
    Question::Distance { limit: f64::INFINITY },
    Question::SelfAndWorldDistance { limit: 1.0 },
    Question::Pairs,
    Question::Free,
];

/// Streams that are all asked the same question: within tolerances, prepared for the next state, and exactly.
struct Streams<'c> {
    checker: &'c CollisionChecker,
    question: Question,
    small: Workspace,
    large: Workspace,
    prepared: Workspace,
    exact: Workspace,
    /// Volume tests of the first, the third and the last.
    costs: [u64; 3],
}

impl<'c> Streams<'c> {
    fn new(checker: &'c CollisionChecker, question: Question) -> Self {
        let stream = || checker.streaming_workspace();
        let (small, large, prepared, exact) = (stream(), stream(), stream(), stream());
        Self { checker, question, small, large, prepared, exact, costs: [0; 3] }
    }

    /// Asks them, and compares what they tell with the truth; what is asked exactly in between stays exact.
    fn follow(&mut self, q: &Configuration, truth: &CollisionReport, in_between: bool) {
        let Self { checker, question, .. } = *self;
        let mut ask = |effort: &Effort, stream: &mut Workspace, cost: Option<usize>| {
            let told = checker.check_with(q, question, effort, stream);
            assert_eq!(told.is_free(), truth.is_free(), "{question:?}, {effort:?}");
            are_bounds(checker, (&told, truth), question, effort);
            if let Some(cost) = cost {
                self.costs[cost] += told.work.volume_tests;
            }
        };
        ask(&SMALL, &mut self.small, Some(0));
        ask(&LARGE, &mut self.large, None);
        ask(&SMALL, &mut self.prepared, Some(1));
        checker.prepare(&mut self.prepared);
        let exact = checker.check(q, question, &mut self.exact);
        self.costs[2] += exact.work.volume_tests;
        if in_between {
            let told = checker.check(q, question, &mut self.small);
            assert_eq!(CollisionReport { work: exact.work, ..told }, exact);
        }
    }
}

/// A stream within a tolerance tells bounds of the truth no farther apart than that, every pair within the limit, and contact
/// exactly.
#[test]
fn tolerant_streams_agree_within_tolerance_for_less_work() {
    let mut random = Random::new(74);
    let mut hits = 0;
    for checker in checkers() {
        let mut streams = QUESTIONS.map(|question| Streams::new(&checker, question));
        for (i, q) in walk(&checker, &mut random, 3, 25).iter().enumerate() {
            let truth = exact(&checker, q);
            hits += u32::from(!truth.is_free());
            for streams in &mut streams {
                streams.follow(q, &truth, i % 19 == 0);
            }
        }
        for (streams, [most, most_prepared]) in streams.iter().zip([[10, 10], [3, 3], [8, 8]]) {
            let [tolerant, prepared, exact] = streams.costs;
            eprintln!(
                "{:?}: {tolerant} volume tests, {prepared} if prepared, {exact} exactly",
                streams.question
            );
            assert!(10 * tolerant < most * exact && 10 * prepared < most_prepared * exact);
        }
    }
    assert!(hits > 5, "{hits} states collide");
}

/// Until a state has cost so much its distances are exact, and from then on within the tolerances; so is what streams tell.
#[test]
fn distances_are_exact_while_they_cost_little() {
    const NEVER: u64 = u64::MAX;
    let mut random = Random::new(76);
    let mut told_so = [[0; 2]; 5];
    let budgets = [1, 30, 300, 3000, NEVER];
    for checker in checkers() {
        for question in QUESTIONS {
            let mut streams = budgets.map(|_| [(); 2].map(|()| checker.streaming_workspace()));
            let mut alone = checker.workspace();
            for q in walk(&checker, &mut random, 2, 12) {
                let truth = exact(&checker, &q);
                for ((exact_cost, [stream, other]), told_so) in
                    budgets.iter().zip(&mut streams).zip(&mut told_so)
                {
                    let [large, small] =
                        [LARGE, SMALL].map(|effort| Effort { exact_cost: *exact_cost, ..effort });
                    for (workspace, effort) in [(&mut alone, large), (stream, large), (other, small)] {
                        let told = checker.check_with(&q, question, &effort, workspace);
                        assert_eq!(told.is_free(), truth.is_free(), "{question:?}, {effort:?}");
                        are_bounds(&checker, (&told, &truth), question, &effort);
                        assert!(*exact_cost < NEVER || told.is_exact());
                        told_so[usize::from(told.is_exact())] += 1;
                        if *exact_cost == NEVER {
                            let exact = checker.check(&q, question, &mut checker.workspace());
                            assert_eq!(CollisionReport { work: exact.work, ..told }, exact, "{question:?}");
                        }
                        checker.prepare(workspace);
                    }
                }
            }
        }
    }
    let [least, .., most] = told_so;
    assert!(least[0] > most[0] && most[0] == 0, "{told_so:?}: rough and exact reports by budget");
    assert!(told_so.is_sorted_by(|less, more| less[0] >= more[0]), "{told_so:?}");
}

/// What goes on as it did is searched before it is asked.
#[test]
fn what_is_prepared_needs_less() {
    let [plain, prepared] = plain_and_prepared(&SMALL).map(|work| work.volume_tests);
    assert!(2 * prepared < plain, "{prepared} and {plain} volume tests, prepared and plain");
}

/// What exact searches begin with is collected before it is asked, also where they may cost only so much.
#[test]
fn fronts_are_collected_between_states() {
    for effort in [Effort { exact_cost: 1000, ..SMALL }, Effort::default()] {
        let [plain, prepared] = plain_and_prepared(&effort).map(|work| work.cost());
        assert!(10 * prepared < 9 * plain, "{prepared} and {plain}, prepared and plain: {effort:?}");
    }
}

/// What two streams cost that go the same ways, of which one is prepared for what comes next.
fn plain_and_prepared(effort: &Effort) -> [Work; 2] {
    let mut random = Random::new(75);
    let [checker, _] = checkers();
    let (mut plain, mut prepared) = (checker.streaming_workspace(), checker.streaming_workspace());
    let mut costs = [Work::default(); 2];
    for _ in 0..4 {
        let [from, to] = [(); 2].map(|()| random_state(&checker, &mut random));
        for step in 0..100 {
            let share = f64::from(step) * 1e-3;
            let between = from.positions().iter().zip(to.positions()).map(|(a, b)| a + share * (b - a));
            let q = checker.robot().configuration(&between.collect::<Vec<_>>()).unwrap();
            for (cost, stream) in costs.iter_mut().zip([&mut plain, &mut prepared]) {
                *cost += checker.check_with(&q, ALL, effort, stream).work;
            }
            checker.prepare(&mut prepared);
        }
    }
    costs
}

/// That what was told within a tolerance is true of every pair.
fn are_bounds(
    checker: &CollisionChecker,
    (told, truth): (&CollisionReport, &CollisionReport),
    question: Question,
    effort: &Effort,
) {
    let padding = |bodies: [BodyId; 2]| {
        let of =
            |body: &BodyId| if matches!(body, BodyId::Link(_)) { checker.settings().padding } else { 0.0 };
        bodies.iter().map(of).sum::<f64>()
    };
    for pair in &told.pair_distances {
        let padding = padding([pair.a, pair.b]);
        let truth = truth.pair_distances.iter().find(|p| (p.a, p.b) == (pair.a, pair.b)).unwrap().distance;
        assert!(pair.lower <= truth && truth <= pair.distance + 1e-12, "{pair:?}, not {truth} m");
        assert!(pair.lower >= effort.lower(pair.distance + padding) - padding - 1e-9, "{pair:?}");
        assert!(truth > effort.exact_within || (pair.distance - pair.lower).abs() < 1e-12, "{pair:?}");
        let [p, q] = pair.witness_points;
        let apart = nalgebra::distance(&p, &q) - padding;
        assert!(pair.distance == 0.0 || (apart - pair.distance).abs() < 1e-9, "{pair:?}: {apart} m");
    }
    let (all_within, least_within) = match question {
        Question::PairDistances { limit } => (limit, limit),
        Question::Survey { influence_distance, limit } => (influence_distance, limit),
        Question::Distance { limit } | Question::SelfAndWorldDistance { limit } => (f64::NEG_INFINITY, limit),
        Question::Pairs | Question::Free => return,
    };
    for pair in truth.pair_distances.iter().filter(|pair| pair.distance <= all_within) {
        assert!(told.pair_distances.iter().any(|p| (p.a, p.b) == (pair.a, pair.b)), "{pair:?} is not told");
    }
    if !matches!(question, Question::Distance { .. }) {
        for kind in PairKind::ALL {
            is_bound_of_kind((told, truth), kind, least_within);
        }
    }
    let least = truth.nearest.unwrap().distance;
    let Some(nearest) = told.nearest else {
        assert!(least > least_within.max(0.0));
        return;
    };
    assert!(told.least_distance_lower() <= least && least <= nearest.distance + 1e-12);
    let mut certain = told.clone();
    certain.use_lower_bounds();
    let certain = certain.nearest.unwrap().distance;
    assert!(certain <= least && (certain > 0.0 || !truth.is_free()), "{certain} m, not {least} m");
}

/// That the least distance of one kind of pairs is true, whose lower bound holds for all pairs of that kind.
fn is_bound_of_kind((told, truth): (&CollisionReport, &CollisionReport), kind: PairKind, limit: f64) {
    let least = truth.nearest_of(kind).map_or(f64::INFINITY, |pair| pair.distance);
    let Some(nearest) = told.nearest_of(kind) else {
        assert!(least > limit.max(0.0), "{kind:?}: {least} m");
        return;
    };
    assert!(nearest.lower <= least && least <= nearest.distance + 1e-12, "{nearest:?}: {least} m");
    assert_eq!(nearest.kind(), kind);
    let mut certain = told.clone();
    certain.use_lower_bounds();
    let distance = |pair: Option<&PairDistance>| pair.map_or(f64::INFINITY, |pair| pair.distance);
    assert!(distance(certain.nearest_of(kind)) <= least);
    let of_both = PairKind::ALL.map(|kind| distance(certain.nearest_of(kind)));
    assert_eq!(distance(certain.nearest.as_ref()), of_both[0].min(of_both[1]));
}

/// However early a deadline comes, what is told is true, what is not known is told as open, and no proof is claimed.
#[test]
fn deadlines_leave_only_truth() {
    let mut random = Random::new(71);
    let (mut open, mut certain, mut unfinished) = (0, 0, 0);
    let questions = [
        Question::Free,
        Question::Pairs,
        Question::Distance { limit: f64::INFINITY },
        Question::SelfAndWorldDistance { limit: f64::INFINITY },
        ALL,
        Question::Survey { influence_distance: 0.1, limit: 1.0 },
    ];
    for checker in checkers() {
        let mut workspace = checker.streaming_workspace();
        for i in 0..60 {
            let q = random_state(&checker, &mut random);
            let truth = exact(&checker, &q);
            for question in questions {
                // past, and soon: how far one gets until then must not matter
                let deadline = Instant::now() + Duration::from_micros([0, 1, 3, 30, 300, 3000][i % 6]);
                let effort = Effort { deadline: Some(deadline), ..Effort::default() };
                let report = checker.check_with(&q, question, &effort, &mut workspace);
                open += report.undecided.len();
                assert!(!report.is_free() || truth.is_free(), "{question:?}");
                for pair in &report.undecided {
                    let distance = distance_of(&truth, pair);
                    assert!(pair.lower <= distance && distance <= pair.upper + 1e-12, "{pair:?}: {distance}");
                }
                for pair in &report.colliding_pairs {
                    assert!(truth.colliding_pairs.contains(pair), "{question:?}");
                }
                if matches!(question, Question::SelfAndWorldDistance { .. } | Question::Survey { .. }) {
                    let limit = if matches!(question, Question::Survey { .. }) { 1.0 } else { f64::INFINITY };
                    for kind in PairKind::ALL.into_iter().filter(|kind| report.is_nearest_certain(*kind)) {
                        is_bound_of_kind((&report, &truth), kind, limit);
                        certain += 1;
                    }
                }
                let is_free_but_unfinished = report.is_free() && report.unfinished.is_some();
                unfinished += u32::from(is_free_but_unfinished);
                let least = [&report.nearest, &report.nearest_self, &report.nearest_world];
                for pair in report.pair_distances.iter().chain(least.into_iter().flatten()) {
                    let open =
                        UndecidedPair { a: pair.a, b: pair.b, lower: pair.lower, upper: pair.distance };
                    let distance = distance_of(&truth, &open);
                    assert!(pair.lower <= distance && distance <= pair.distance + 1e-12);
                }
            }
        }
    }
    assert!(open > 0, "some deadlines came too early");
    eprintln!("{certain} least distances of a kind were certain, {unfinished} were left open in free states");
}

/// A deadline that does not come changes nothing.
#[test]
fn without_hurry_everything_is_decided() {
    let mut random = Random::new(72);
    let effort = Effort { deadline: Some(Instant::now() + Duration::from_secs(3600)), ..Effort::default() };
    for checker in checkers() {
        let mut workspace = checker.workspace();
        for _ in 0..20 {
            let q = random_state(&checker, &mut random);
            for question in [Question::Free, Question::Pairs, Question::Distance { limit: 0.5 }, ALL] {
                let report = checker.check_with(&q, question, &effort, &mut workspace);
                let truth = checker.check(&q, question, &mut checker.workspace());
                assert_eq!(report.undecided, []);
                assert_eq!(report.is_free(), truth.is_free());
                assert_eq!(report.nearest.map(|n| n.distance), truth.nearest.map(|n| n.distance));
            }
        }
    }
}

/// Paddings that differ: a pair whose tolerance leaves contact open must not be forgotten for a nearer one that is sure.
#[test]
fn a_large_tolerance_hides_no_contact() {
    let mut random = Random::new(73);
    let effort = Effort { relative_tolerance: 0.6, ..Effort::default() };
    let [padded, _] = checkers();
    let settings = Settings { padding: 0.05, pad_self: false, ..Settings::default() };
    let checker = CollisionChecker::new(padded.robot().clone(), padded.world(), settings).unwrap();
    let mut workspace = checker.workspace();
    let mut hits = 0;
    for _ in 0..400 {
        let q = random_state(&checker, &mut random);
        let truth = exact(&checker, &q);
        hits += u32::from(!truth.is_free());
        for question in [Question::Distance { limit: f64::INFINITY }, Question::PairDistances { limit: -1.0 }]
        {
            let told = checker.check_with(&q, question, &effort, &mut workspace);
            assert_eq!(told.is_free(), truth.is_free(), "{question:?}");
        }
        let told = checker.check(&q, Question::PairDistances { limit: f64::NAN }, &mut workspace);
        assert_eq!(told.is_free(), truth.is_free(), "no limit is too small for contact");
    }
    assert!(hits > 20, "some states collide");
}

/// Two wavy meshes, of which one slides over the other: their crests touch, part and nearly touch.
fn sliding_waves() -> CollisionChecker {
    const SIDE: u32 = 40;
    let place = |i: u32| f64::from(i) / f64::from(SIDE) - 0.5;
    let corners = (0..SIDE * SIDE).map(|i| {
        let (x, y) = (place(i % SIDE), place(i / SIDE));
        Point::new(x, y, 0.002 * (40.0 * x).sin() * (40.0 * y).cos())
    });
    let squares = (0..SIDE * (SIDE - 1)).filter(|i| i % SIDE < SIDE - 1);
    let halves = squares.flat_map(|i| [[i, i + 1, i + SIDE], [i + 1, i + SIDE + 1, i + SIDE]]);
    let waves = TriangleMesh::new(corners.collect(), halves.collect()).unwrap();
    let waves = Obstacle::of_shape("waves".to_owned(), Pose::identity(), Shape::Mesh(Arc::new(waves)));
    let urdf = "<robot name='slider'><link name='cart'/>
        <link name='base'><collision><origin xyz='0 0 -0.5'/><geometry><sphere radius='0.05'/></geometry></collision></link><link name='tool'/>
        <joint name='along' type='prismatic'><parent link='base'/><child link='cart'/><axis xyz='1 0 0'/>
          <limit lower='-1' upper='1' effort='1' velocity='1'/></joint>
        <joint name='up' type='prismatic'><parent link='cart'/><child link='tool'/><axis xyz='0 0 1'/>
          <limit lower='-1' upper='1' effort='1' velocity='1'/></joint></robot>";
    let robot = RobotModel::from_urdf(urdf, &MeshFiles::default()).unwrap();
    let mut world = World::default();
    world.attach(AttachedObject::grasped(&waves, "tool", &Pose::identity(), vec![])).unwrap();
    world.add(Obstacle { name: "floor".to_owned(), ..waves }).unwrap();
    CollisionChecker::new(Arc::new(robot), &world, Settings::default()).unwrap()
}

/// Where bodies touch, or nearly do, the elements that touched and the gap that was proven decide most further states.
#[test]
fn contact_that_persists_costs_little() {
    let checker = sliding_waves();
    let effort =
        Effort { exact_cost: 500, relative_tolerance: 0.1, absolute_tolerance: 0.001, ..Effort::default() };
    let mut stream = checker.streaming_workspace();
    let mut alone = checker.workspace();
    let (mut cost, mut cost_alone) = (Work::default(), Work::default());
    let mut touching = [0; 2];
    for i in 0..300 {
        let time = f64::from(i) * 2e-3;
        let q = checker.robot().configuration(&[0.02 * time, 4e-4 + 6e-4 * (9.0 * time).sin()]).unwrap();
        let report = checker.check_with(&q, ALL, &effort, &mut stream);
        let expected = checker.check_with(&q, ALL, &effort, &mut alone);
        let truth = exact(&checker, &q);
        assert_eq!(report.is_free(), truth.is_free(), "state {i}");
        are_bounds(&checker, (&report, &truth), ALL, &effort);
        for pair in &report.pair_distances {
            let apart = nalgebra::distance(&pair.witness_points[0], &pair.witness_points[1]);
            assert!(apart <= pair.distance + 1e-9, "state {i}: {pair:?}");
        }
        touching[usize::from(report.is_free())] += 1;
        cost += report.work;
        cost_alone += expected.work;
    }
    let [cost, alone] = [cost, cost_alone].map(|work| work.cost());
    eprintln!("touching and free: {touching:?}; cost {cost}, and {alone} without memory");
    assert!(touching.iter().all(|count| *count > 100), "{touching:?}");
    assert!(4 * cost < alone, "{cost}, and {alone} without memory");
}
