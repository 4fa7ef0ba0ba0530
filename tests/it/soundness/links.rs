//! Tests of links of real robots: at random relative poses, and in random states of robots in worlds.

use clearance::checker::{CollisionChecker, CollisionReport, PairDistance, Question};
use clearance::geometry::constants::CONTACT_DISTANCE;
use clearance::geometry::math::Pose;
use clearance::geometry::{Primitive, Shape};
use clearance::proximity::{Scratch, distance};
use clearance::robot::{LinkPoses, RobotModel};
use clearance::scene::{BodyId, Settings};
use clearance::scene::{Obstacle, World};
use rayon::prelude::*;
use std::path::Path;
use std::sync::Arc;

use super::laws::{Case, Scrutiny, judge};
use super::ledger::{Accuracy, Family, Ledger, survey};
use super::random_pairs::OF_CYLINDERS;
use super::solid_oracle::solid_distance;
use super::subject::Subject;
use super::triangles::OF_TRIANGLES;
use super::{is_long, share};
use crate::random::Random;
use crate::tally::{json, shared_folder};

/// Meshes are found in closed form, some of the robots' primitives by iteration: each pair is held to its own.
fn accuracy_of(a: &Subject, b: &Subject) -> Accuracy {
    if a.is_mesh() && b.is_mesh() { OF_TRIANGLES } else { OF_CYLINDERS }
}

/// A robot, and each of its links that has geometry as a subject.
struct Robot {
    model: Arc<RobotModel>,
    links: Vec<Option<Subject>>,
}

impl Robot {
    fn load(urdf: &Path, srdf: &Path, roots: &[std::path::PathBuf]) -> Self {
        let model = RobotModel::load(urdf, srdf.is_file().then_some(srdf), roots)
            .unwrap_or_else(|e| panic!("{}: {e}", urdf.display()));
        let links = (model.links().par_iter())
            .map(|link| {
                let shapes: Vec<_> = link.collisions.iter().map(|c| (c.pose_ls, c.shape.clone())).collect();
                (!shapes.is_empty()).then(|| Subject::new(shapes))
            })
            .collect();
        Self { model: Arc::new(model), links }
    }

    fn some_link(&self, random: &mut Random) -> &Subject {
        let solid: Vec<&Subject> = self.links.iter().flatten().collect();
        solid[random.below(u32::try_from(solid.len()).expect("few")) as usize]
    }
}

/// The shared robots: a few in the fast share, all of them in the long mode; else those that are bundled.
fn robots() -> Vec<Robot> {
    let mut found = vec![];
    if let Some(folder) = shared_folder("robots") {
        for entry in json(&folder.join("robots.json")).as_array().into_iter().flatten() {
            let path = |key: &str| folder.join(entry[key].as_str().unwrap_or_default());
            if is_long() || ["panda", "ur5e"].iter().any(|n| entry["name"] == *n) {
                found.push(Robot::load(&path("urdf"), &path("srdf"), &[path("package_root")]));
            }
        }
    }
    if let Some(folder) = shared_folder("truth") {
        let names = if is_long() { &["ur5", "panda"][..] } else { &["ur5"] };
        found.extend(names.iter().map(|name| {
            let of = |file: &str| folder.join(name).join(file);
            Robot::load(&of("robot.urdf"), &of("robot.srdf"), &[])
        }));
    }
    if found.is_empty() {
        let bundled = Path::new(env!("CARGO_MANIFEST_DIR")).join("urdf");
        found.extend(["demo_arm", "dual_arm"].map(|name| {
            let of = |ending: &str| bundled.join(name).join(format!("{name}.{ending}"));
            Robot::load(&of("urdf"), &of("srdf"), &[])
        }));
    }
    found
}

/// Anywhere from deep in each other to well apart; then moved along the line of nearest points until they are a small
/// gap or overlap from touching.
#[test]
fn links_at_random_poses() {
    let family = Family { name: "links at random poses", accuracy: OF_CYLINDERS };
    let robots = robots();
    let count = share(120, 320_000);
    let ledger = survey(count, 700, |random, ledger| {
        let robot = &robots[random.below(u32::try_from(robots.len()).expect("few")) as usize];
        let (a, b) = (robot.some_link(random), robot.some_link(random));
        let ((centre_a, ball_a), (centre_b, ball_b)) = (a.solid.ball(), b.solid.ball());
        let rotation = random.rotation();
        let apart = random.vector(1.0).normalize() * (random.within(0.1, 1.2) * (ball_a + ball_b));
        let pose_ab = Pose::from_parts((centre_a + apart - rotation * centre_b).into(), rotation);
        let mut case = Case { a, b, pose_ab };
        judge(&case, accuracy_of(a, b), Scrutiny::mostly_answers(random), random, ledger);
        let told = distance(&a.body, &b.body, &pose_ab, f64::INFINITY, &mut Scratch::default());
        let Some([p, q]) = told.map(|t| t.witness_points) else { return };
        let Some(out) = (q - p).try_normalize(1e-6) else { return };
        let gap = 10f64.powf(random.within(-12.0, -2.0)) * if random.below(2) == 0 { -1.0 } else { 1.0 };
        case.pose_ab.translation.vector -= (q - p) - out * gap;
        judge(&case, accuracy_of(a, b), Scrutiny::mostly_answers(random), random, ledger);
    });
    ledger.finish(&family, count);
}

/// A world of each kind of obstacle within a robot's reach, and the obstacles as subjects.
fn world(random: &mut Random) -> (World, Vec<Subject>) {
    let primitives = [
        Primitive::cuboid([0.3, 0.2, 0.5]),
        Primitive::sphere(0.15),
        Primitive::cylinder(0.1, 0.6),
        Primitive::capsule(0.05, 0.4),
    ];
    let mut shapes: Vec<Shape> =
        primitives.into_iter().map(|p| Shape::Primitive(p.expect("positive"))).collect();
    shapes.push(Shape::Mesh(random.blob(10, 0.2).into()));
    let mut world = World::default();
    let mut subjects = vec![];
    for (i, shape) in shapes.into_iter().enumerate() {
        let pose_rs = random.pose(0.8);
        let obstacle = Obstacle::of_shape(format!("obstacle {i}"), pose_rs, shape.clone());
        world.add(obstacle).expect("names differ");
        subjects.push(Subject::new(vec![(pose_rs, shape)]));
    }
    (world, subjects)
}

/// A robot in a world, and the oracle's copies of both.
struct Scene<'r> {
    robot: &'r Robot,
    obstacles: Vec<Subject>,
    checker: CollisionChecker,
}

impl Scene<'_> {
    fn subject(&self, body: BodyId) -> &Subject {
        match body {
            BodyId::Link(id) => self.robot.links[id.index()].as_ref().expect("pairs have geometry"),
            BodyId::Obstacle(id) => &self.obstacles[id.0 as usize],
            BodyId::Attached(_) => unreachable!("nothing is attached"),
        }
    }

    /// Asks every question about one random state, and the oracle about every pair.
    fn judge_state(&self, random: &mut Random, ledger: &mut Ledger) {
        let robot = &self.robot.model;
        let positions = positions_within_limits(robot, random);
        let q = robot.configuration(&positions).expect("as many positions as the robot has");
        let mut workspace = self.checker.workspace();
        let mut ask = |question| self.checker.check(&q, question, &mut workspace);
        let limit = f64::INFINITY;
        let [free, pairs, least, all] = [
            Question::Free,
            Question::Pairs,
            Question::Distance { limit },
            Question::PairDistances { limit },
        ]
        .map(&mut ask);
        let mut wrong = same_story(&free, &pairs, &least, &all);
        if self.checker.is_free(&q, &mut workspace) != all.is_free() {
            wrong.push("is_free says otherwise".to_owned());
        }
        if all.pair_distances.len() != self.checker.pairs().len() {
            wrong.push(format!("{} distances", all.pair_distances.len()));
        }
        let mut poses = LinkPoses::new(robot);
        robot.forward_kinematics(&q, &mut poses);
        let pose = |body| match body {
            BodyId::Link(id) => *poses.pose(id),
            BodyId::Attached(_) | BodyId::Obstacle(_) => Pose::identity(),
        };
        for told in &all.pair_distances {
            let pose_ab = pose(told.a).inv_mul(&pose(told.b));
            let collides = pairs.colliding_pairs.contains(&(told.a, told.b));
            wrong.extend(self.pair_disagreement(told, &pose_ab, collides, ledger));
        }
        ledger.note(&format!("{} at {positions:?}", robot.name()), &wrong);
    }

    fn pair_disagreement(
        &self,
        told: &PairDistance,
        pose_ab: &Pose,
        collides: bool,
        ledger: &mut Ledger,
    ) -> Option<String> {
        let (a, b) = (self.subject(told.a), self.subject(told.b));
        let accuracy = accuracy_of(a, b);
        let (a, b) = (&a.solid, &b.solid);
        let reach = a.reach + b.reach + pose_ab.translation.vector.amax();
        let band = accuracy.band(reach);
        let below = told.distance.max(CONTACT_DISTANCE) + 2.0 * band.below;
        let truth =
            solid_distance(a, b, pose_ab, below).or_else(|| solid_distance(a, b, pose_ab, f64::INFINITY));
        let truth = truth.unwrap_or(f64::INFINITY);
        let touching = truth <= CONTACT_DISTANCE;
        ledger.poses += 1;
        ledger.element_pairs += a.part_count() * b.part_count();
        ledger.touching += usize::from(touching);
        let names = || [told.a, told.b].map(|body| self.checker.body_name(body).to_owned());
        if band.undecided(truth) {
            ledger.undecided += 1;
            return None;
        }
        ledger.missed_collisions += usize::from(touching && !collides);
        ledger.error(told.distance, truth, reach, accuracy);
        (collides != touching || !band.allows(told.distance, truth))
            .then(|| format!("{:?}: truth {truth:e}, told {:e}, collides {collides}", names(), told.distance))
    }
}

fn positions_within_limits(robot: &RobotModel, random: &mut Random) -> Vec<f64> {
    (robot.joint_ids())
        .filter_map(|j| robot.first_position(j).map(|_| robot.joint(j)))
        .flat_map(|joint| vec![joint; joint.kind.degrees_of_freedom()])
        .map(|joint| joint.limits.map_or((-3.0, 3.0), |l| (l.lower, l.upper)))
        .map(|(lower, upper)| random.within(lower, upper))
        .collect()
}

/// Answers to different questions about one state do not contradict each other.
fn same_story(
    free: &CollisionReport,
    pairs: &CollisionReport,
    least: &CollisionReport,
    all: &CollisionReport,
) -> Vec<String> {
    let mut wrong = vec![];
    for (name, report) in [("free", free), ("distance", least), ("pair distances", all)] {
        if (report.self_collision, report.world_collision) != (pairs.self_collision, pairs.world_collision) {
            wrong.push(format!("'{name}' and 'pairs' differ"));
        }
    }
    let mut colliding = [&all.colliding_pairs, &pairs.colliding_pairs].map(Clone::clone);
    for list in &mut colliding {
        list.sort_unstable();
    }
    if colliding[0] != colliding[1] {
        wrong.push("the colliding pairs differ".to_owned());
    }
    let nearest = all.pair_distances.iter().map(|p| p.distance).fold(f64::INFINITY, f64::min);
    let told = least.nearest.map_or(f64::INFINITY, |n| n.distance);
    if (told - nearest).abs() > 1e-12 {
        wrong.push(format!("least distance {told:e}, but of the pairs {nearest:e}"));
    }
    wrong
}

#[test]
fn robots_in_random_states() {
    let family = Family { name: "robots in random states", accuracy: OF_CYLINDERS };
    let robots = robots();
    let poses = share(600, 600_000) / robots.len();
    let mut random = Random::new(701);
    let scenes: Vec<Scene> = (robots.iter())
        .map(|robot| {
            let (world, obstacles) = world(&mut random);
            let checker = CollisionChecker::new(robot.model.clone(), &world, Settings::default());
            Scene { robot, obstacles, checker: checker.expect("default settings") }
        })
        .collect();
    let ledger = (scenes.iter().enumerate())
        .map(|(i, scene)| {
            let states = poses.div_ceil(scene.checker.pairs().len());
            survey(states, 702 + i as u64, |random, ledger| scene.judge_state(random, ledger))
        })
        .fold(Ledger::default(), Ledger::merged);
    ledger.finish(&family, poses * robots.len());
}
