//! Self and world apart: a checker of both kinds of pairs reports, bit for bit, what two checkers report that check one
//! kind each.

use std::sync::Arc;

use clearance_geometry::math::{Point, Pose, Rotation, Vector};
use clearance_geometry::testing::Random;
use clearance_geometry::{Plane, Primitive, Shape, TriangleMesh};
use clearance_proximity::Work;
use clearance_robot::{Configuration, MeshFiles, RobotModel};
use clearance_scene::{AttachedObject, BodyId, Obstacle, ObstacleShape, Settings, World};

use crate::{CollisionChecker, CollisionReport, PairDistance, PairKind, Question, Workspace};

/// Lengths are multiples of this (m), so that many bodies touch exactly.
const GRID: f64 = 0.05;

/// A multiple of [`GRID`], or any number.
fn coordinate(random: &mut Random, extent: f64) -> f64 {
    let any = random.within(extent);
    if random.below(3) == 0 { any } else { (any / GRID).round() * GRID }
}

fn pose(random: &mut Random, extent: f64) -> Pose {
    let place = Vector::from_fn(|_, _| coordinate(random, extent));
    let turn = if random.below(2) == 0 { Rotation::identity() } else { random.rotation() };
    Pose::from_parts(place.into(), turn)
}

fn shape(random: &mut Random) -> Shape {
    let size = |random: &mut Random| [0.05, 0.1, 0.15][random.below(3)];
    match random.below(9) {
        0 => Shape::Primitive(Primitive::Sphere { radius: size(random) }),
        1 => Shape::Primitive(Primitive::Cylinder { radius: size(random), half_length: size(random) }),
        2..4 => {
            let corners = (0..18).map(|_| Point::from(random.vector(0.2))).collect();
            let faces = (0..6).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
            Shape::Mesh(Arc::new(TriangleMesh::new(corners, faces).unwrap()))
        }
        4 if random.below(8) == 0 => Shape::Plane(Plane::from_coefficients([0.0, 0.1, 1.0, 0.7]).unwrap()),
        _ => Shape::Primitive(Primitive::Box { half_extents: [0; 3].map(|_| size(random)) }),
    }
}

/// A tree of links of boxes and balls.
fn robot(random: &mut Random) -> RobotModel {
    let links = 1 + random.below(7);
    let elements: String = (0..links).map(|i| link(i, random)).collect();
    let joints: String = (1..links).map(|i| joint(i, random)).collect();
    RobotModel::from_urdf(&format!("<robot name='r'>{elements}{joints}</robot>"), &MeshFiles::default())
        .unwrap()
}

fn link(index: usize, random: &mut Random) -> String {
    let geometry = match random.below(5) {
        0 => return format!("<link name='l{index}'/>"),
        1 => "<sphere radius='0.1'/>".to_owned(),
        _ => {
            let [x, y, z] = [0; 3].map(|_| [0.1, 0.2, 0.3][random.below(3)]);
            format!("<box size='{x} {y} {z}'/>")
        }
    };
    let [x, y, z] = [0; 3].map(|_| coordinate(random, 0.1));
    format!(
        "<link name='l{index}'><collision><origin xyz='{x} {y} {z}'/><geometry>{geometry}</geometry></collision></link>"
    )
}

/// The joint between a link and one of the links before it.
fn joint(index: usize, random: &mut Random) -> String {
    let parent = random.below(index);
    let kind = ["revolute", "continuous", "prismatic", "prismatic", "fixed"][random.below(5)];
    let [x, y, z] = [0; 3].map(|_| coordinate(random, 0.4));
    let axis = ["1 0 0", "0 1 0", "0 0 1"][random.below(3)];
    format!(
        "<joint name='j{index}' type='{kind}'><parent link='l{parent}'/><child link='l{index}'/><origin xyz='{x} {y} {z}'/>
         <axis xyz='{axis}'/><limit lower='-2' upper='2' effort='1' velocity='1'/></joint>"
    )
}

fn world(random: &mut Random) -> World {
    let mut world = World::default();
    for obstacle in 0..[0, 1, 3, 8][random.below(4)] {
        let of = |random: &mut Random| ObstacleShape { pose_os: pose(random, 0.1), shape: shape(random) };
        let shapes: Vec<_> = (0..=random.below(2)).map(|_| of(random)).collect();
        let placed = Obstacle { pose_ro: pose(random, 0.9), ..Obstacle::new(format!("o{obstacle}"), shapes) };
        world.add(placed).unwrap();
    }
    for attached in 0..[0, 0, 1, 2][random.below(4)] {
        let object = Obstacle::of_shape(format!("a{attached}"), pose(random, 0.3), shape(random));
        world.attach(AttachedObject::grasped(&object, "l0", &pose(random, 0.2), Vec::new())).unwrap();
    }
    world
}

fn settings(random: &mut Random) -> Settings {
    let padding = [0.0, 0.0, 1e-7, GRID, 0.03][random.below(5)];
    let mut settings = Settings { padding, pad_self: random.below(2) == 0, ..Settings::default() };
    if random.below(3) == 0 {
        settings.link_padding.insert("l0".to_owned(), GRID);
    }
    if random.below(3) == 0 {
        settings.object_padding.insert("o0".to_owned(), 0.02);
    }
    settings
}

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
