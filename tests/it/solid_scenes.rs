//! Solid meshes in random scenes: every question, streams, batches and motions have the results of brute force.
//!
//! Brute force takes surfaces from the reference engine, points of clouds one by one, and adds the solid angles of all faces to find out
//! whether something is inside.

use std::fmt::Write;
use std::path::Path;
use std::sync::Arc;

use clearance::checker::{
    CollisionChecker, CollisionReport, MotionOptions, MotionVerdict, Question, Workspace,
};
use clearance::geometry::math::{Point, Pose, Vector};
use clearance::geometry::{Primitive, Shape, TriangleMesh};
use clearance::motion::MotionSegment;
use clearance::proximity::Effort;
use clearance::robot::{Configuration, LinkPoses, RobotModel};
use clearance::scene::{AttachedObject, BodyId, MeshModel, Obstacle, Settings, World};

use crate::random::Random;
use crate::reference::{self, ReferenceBody};

/// Joints of the robot: it has a link more.
const JOINTS: usize = 5;

/// Up to this distance (m), pairs are compared.
const NEAR: f64 = 0.2;

/// Difference (m) of distances that rounding explains.
const ROUNDING: f64 = 1e-9;

/// A body without hierarchies.
struct Slow {
    id: BodyId,
    elements: Option<ReferenceBody>,
    /// Triangles of meshes, those of each mesh in a list, and whether the mesh is closed.
    meshes: Vec<(Vec<[Point; 3]>, bool)>,
    /// Points of all connected parts, more than are needed.
    samples: Vec<Point>,
    /// Balls: centres, and their radius (m).
    cloud: (Vec<Point>, f64),
}

impl Slow {
    fn new(id: BodyId, shapes: &[(Pose, &Shape)]) -> Self {
        let is_element = |shape: &Shape| matches!(shape, Shape::Mesh(_) | Shape::Primitive(_));
        let elements: Vec<_> = shapes.iter().filter(|(_, shape)| is_element(shape)).collect();
        let mut slow = Self {
            id,
            elements: (!elements.is_empty())
                .then(|| ReferenceBody::new(elements.iter().map(|(pose, shape)| (pose, *shape)))),
            meshes: Vec::new(),
            samples: Vec::new(),
            cloud: (Vec::new(), 0.0),
        };
        for (pose, shape) in shapes {
            match shape {
                Shape::Primitive(_) => slow.samples.push(Point::from(pose.translation.vector)),
                Shape::Mesh(mesh) => {
                    let faces = (0..mesh.triangles().len()).map(|i| mesh.triangle(i).corners());
                    let faces: Vec<_> = faces.map(|corners| corners.map(|p| pose * p)).collect();
                    slow.samples.extend(faces.iter().map(|corners| corners[0]));
                    slow.meshes.push((faces, !mesh.solid().remarks().is_open()));
                }
                Shape::Points(cloud) => {
                    let centres = cloud.points().iter().map(|p| pose * Point::from(p.map(f64::from)));
                    slow.cloud = (centres.collect(), cloud.radius());
                }
                _ => unreachable!("not in these scenes"),
            }
        }
        slow.samples.extend(&slow.cloud.0);
        slow
    }

    /// True if a closed mesh winds around a point.
    fn encloses(&self, p: &Point) -> bool {
        let winding = |faces: &[[Point; 3]]| {
            let angle = |[a, b, c]: &[Point; 3]| {
                let [a, b, c] = [a - p, b - p, c - p].map(|v| v.normalize());
                2.0 * a.dot(&b.cross(&c)).atan2(1.0 + a.dot(&b) + b.dot(&c) + c.dot(&a))
            };
            faces.iter().map(angle).sum::<f64>() / (4.0 * std::f64::consts::PI)
        };
        self.meshes.iter().any(|(faces, is_closed)| *is_closed && winding(faces).abs() > 0.5)
    }

    /// Distance of the balls of a cloud from triangles.
    fn distance_of_cloud(&self, (centres, radius): &(Vec<Point>, f64), pose: &Pose) -> f64 {
        let faces: Vec<_> = self.meshes.iter().flat_map(|(faces, _)| faces).collect();
        let mut least = f64::INFINITY;
        for centre in centres {
            let p = pose * centre;
            for [a, b, c] in &faces {
                let triangle = clearance::geometry::Triangle { a: *a, b: *b, c: *c };
                least = least.min((nalgebra::distance(&triangle.nearest_point(&p), &p) - radius).max(0.0));
            }
        }
        least
    }

    /// Distance (m) as solids, and whether something is inside although the surfaces are apart.
    fn distance(&self, other: &Self, pose_ab: &Pose) -> (f64, bool) {
        let mut least = f64::INFINITY;
        if let (Some(a), Some(b)) = (&self.elements, &other.elements) {
            least = reference::distance(a, b, pose_ab, f64::INFINITY).map_or(least, |found| found.distance);
        }
        let pose_ba = pose_ab.inverse();
        least = least.min(self.distance_of_cloud(&other.cloud, pose_ab));
        least = least.min(other.distance_of_cloud(&self.cloud, &pose_ba));
        if least == 0.0 {
            return (0.0, false);
        }
        let is_inside = other.samples.iter().any(|p| self.encloses(&(pose_ab * p)))
            || self.samples.iter().any(|p| other.encloses(&(pose_ba * p)));
        (if is_inside { 0.0 } else { least }, is_inside)
    }
}

/// A closed surface over a grid of angles.
fn grid(around: u32, across: u32, at: impl Fn(f64, f64) -> [f64; 3]) -> Vec<[[f64; 3]; 3]> {
    let angle = |i: u32, count: u32| f64::from(i) / f64::from(count) * std::f64::consts::TAU;
    let corner = |i: u32, j: u32| at(angle(i, around), angle(j, across));
    let cells = (0..around).flat_map(|i| (0..across).map(move |j| (i, j)));
    let faces = cells.flat_map(|(i, j)| {
        let (k, l) = ((i + 1) % around, (j + 1) % across);
        let [a, b, c, d] = [corner(i, j), corner(k, j), corner(k, l), corner(i, l)];
        [[a, b, c], [a, c, d]]
    });
    faces.collect()
}

fn ring(radius: f64, thickness: f64) -> Vec<[[f64; 3]; 3]> {
    grid(16, 8, |u, v| {
        let out = radius + thickness * v.cos();
        [out * u.cos(), out * u.sin(), thickness * v.sin()]
    })
}

fn cuboid(half: [f64; 3], centre: [f64; 3]) -> Vec<[[f64; 3]; 3]> {
    let corner = |i: usize| [0, 1, 2].map(|k| centre[k] + if i >> k & 1 == 0 { -half[k] } else { half[k] });
    let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let faces = quads.iter().flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]]);
    faces.map(|face: [usize; 3]| face.map(corner)).collect()
}

/// Faces of one of several kinds of mesh, about `size` (m) large.
fn mesh(random: &mut Random, size: f64) -> Vec<[[f64; 3]; 3]> {
    let half = [0, 1, 2].map(|_| random.within(0.4, 1.0) * size);
    match random.below(7) {
        0 => ring(0.7 * size, random.within(0.1, 0.3) * size),
        1 => cuboid(half, [0.0; 3]),
        // a hollow box
        2 => {
            let cavity = cuboid(half.map(|h| 0.8 * h), [0.0; 3]);
            [cuboid(half, [0.0; 3]), cavity.into_iter().map(|[a, b, c]| [a, c, b]).collect()].concat()
        }
        // an open box
        3 => cuboid(half, [0.0; 3])[2..].to_vec(),
        // several parts, one within another
        4 => [
            cuboid(half.map(|h| 0.3 * h), [0.6 * size, 0.0, 0.0]),
            cuboid(half.map(|h| 0.3 * h), [-0.6 * size, 0.0, 0.0]),
            cuboid(half.map(|h| 0.1 * h), [-0.6 * size, 0.0, 0.0]),
        ]
        .concat(),
        _ => {
            let blob = random.blob(5, size);
            (0..blob.triangles().len()).map(|i| blob.triangle(i).corners().map(|p| p.coords.into())).collect()
        }
    }
}

fn write_stl(path: &Path, facets: &[[[f64; 3]; 3]]) {
    let mut text = "solid s\n".to_owned();
    for facet in facets {
        text += "facet normal 0 0 0\nouter loop\n";
        for [x, y, z] in facet {
            writeln!(text, "vertex {x} {y} {z}").unwrap();
        }
        text += "endloop\nendfacet\n";
    }
    std::fs::write(path, text + "endsolid s\n").unwrap();
}

fn shape_of(facets: &[[[f64; 3]; 3]]) -> Shape {
    let vertices = facets.iter().flatten().map(|p| Point::from(*p)).collect();
    let faces = (0..u32::try_from(facets.len()).unwrap()).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]);
    Shape::Mesh(Arc::new(TriangleMesh::new(vertices, faces.collect()).unwrap()))
}

/// A chain of links of meshes and primitives, of any size, so that they often are inside each other.
fn robot(random: &mut Random) -> Arc<RobotModel> {
    let folder = tempfile::tempdir().unwrap();
    let mut urdf = "<robot name='r'><link name='root'/>".to_owned();
    for i in 0..=JOINTS {
        let mut shapes = String::new();
        for k in 0..1 + random.below(2) {
            let name = format!("{i}_{k}.stl");
            let size = [0.04, 0.12, 0.35][random.below(3) as usize];
            write_stl(&folder.path().join(&name), &mesh(random, size));
            let geometry = if random.below(5) == 0 {
                format!("<sphere radius='{}'/>", 0.3 * size)
            } else {
                format!("<mesh filename='{name}'/>")
            };
            let [x, y, z] = random.vector(0.05).into();
            let _ = write!(
                shapes,
                "<collision><origin xyz='{x} {y} {z}' rpy='{y} {z} {x}'/><geometry>{geometry}</geometry></collision>"
            );
        }
        let _ = write!(urdf, "<link name='l{i}'>{shapes}</link>");
    }
    for i in 0..=JOINTS {
        let parent = if i == 0 { "root".to_owned() } else { format!("l{}", i - 1) };
        let kind = if i == 0 { "fixed" } else { ["prismatic", "revolute"][i % 2] };
        let axis = ["1 0 0", "0 1 0", "0 0 1"][random.below(3) as usize];
        let [x, y, z] = random.vector(0.3).into();
        let _ = write!(
            urdf,
            "<joint name='j{i}' type='{kind}'><parent link='{parent}'/><child link='l{i}'/><axis xyz='{axis}'/>
             <origin xyz='{x} {y} {z}'/><limit lower='-0.7' upper='0.7' effort='1' velocity='1'/></joint>"
        );
    }
    let path = folder.path().join("r.urdf");
    std::fs::write(&path, urdf + "</robot>").unwrap();
    Arc::new(RobotModel::load(&path, None, &[]).unwrap())
}

fn world(random: &mut Random) -> World {
    let mut world = World::default();
    for i in 0..2 + random.below(5) {
        let shape = match random.below(6) {
            0 => random.points(30, 0.4, 0.01),
            1 => Shape::Primitive(random.primitive()),
            // a room, and other large meshes
            2 => shape_of(&mesh(random, 1.2)),
            3 => shape_of(&ring(0.8, 0.35)),
            _ => shape_of(&mesh(random, 0.2)),
        };
        world.add(Obstacle::of_shape(format!("o{i}"), random.pose(0.5), shape)).unwrap();
    }
    if random.below(2) == 0 {
        let held = Obstacle::of_shape("held", random.pose(0.2), shape_of(&mesh(random, 0.1)));
        world.attach(AttachedObject::grasped(&held, "l5", &Pose::identity(), vec![])).unwrap();
    }
    world
}

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
            Question::Distance { limit } => assert_nearest(&report, least, limit),
            Question::PairDistances { limit } => assert_distances(&report, near, limit),
            Question::Survey { influence_distance, limit } => {
                assert_distances(&report, near, influence_distance);
                assert_nearest(&report, least, limit);
            }
        }
    }
}

fn assert_nearest(report: &CollisionReport, least: f64, limit: f64) {
    match report.nearest {
        Some(nearest) => assert!((nearest.distance - least).abs() < ROUNDING, "{report:?} {least}"),
        None => assert!(least > limit.min(NEAR) - ROUNDING, "{report:?} {least}"),
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

const QUESTIONS: usize = 6;

fn questions(near: &[NearPair], random: &mut Random) -> [Question; QUESTIONS] {
    let mut limit = || limit_between(near, random);
    [
        Question::Free,
        Question::Pairs,
        Question::Distance { limit: limit() },
        Question::Distance { limit: f64::INFINITY },
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
    for round in 0..60 {
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
    assert!(seen.inside > 100 && seen.only_inside > 40 && seen.free > 40, "{seen:?}");
}

/// The memory of a stream stays right while bodies come inside others, leave them, or jump there.
#[test]
fn streams_are_as_by_brute_force() {
    let mut random = Random::new(2028);
    let mut seen = Seen::default();
    for round in 0..24 {
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
    assert!(seen.inside > 200 && seen.only_inside > 80 && seen.free > 80, "{seen:?}");
}

/// What is proven free is free in many states of it, and where a contact is named there is one.
#[test]
fn motions_are_free_where_brute_force_finds_nothing() {
    let mut random = Random::new(2029);
    let (mut free, mut contacts, mut inside) = (0, 0, 0);
    for _ in 0..40 {
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
    assert!(free > 30 && contacts > 100 && inside > 20, "{free} {contacts} {inside}");
}
