//! `--mesh solid` against `--mesh surface`: states, streams and motions where nothing is inside anything.
//!
//! `cargo bench --bench solid_meshes -- FOLDER`, pinned to one core by `taskset -c 1`. FOLDER has a `robots.json` with name, URDF, SRDF and
//! package root of each robot; without it only the bundled arm runs. Both answer the same states in turn; CPU time of the thread, best
//! of the rounds.

#[path = "../tests/it/random.rs"]
#[allow(dead_code)] // the tests use the rest
mod random;

use std::f64::consts::TAU;
use std::hint::black_box;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use clearance::checker::MotionOptions;
use clearance::geometry::math::{Point, Pose};
use clearance::geometry::{Shape, TriangleMesh};
use clearance::motion::MotionSegment;
use clearance::scene::{MeshModel, Obstacle};
use clearance::{CollisionChecker, Configuration, Question, RobotModel, Settings, World};
use cpu_time::ThreadTime;

use random::Random;

const ROUNDS: usize = 11;
const STATES: usize = 100;
const MOTIONS: usize = 20;

/// A robot, and the size (m) of the surroundings that it is put in.
struct Robot {
    name: String,
    model: Arc<RobotModel>,
    reach: f64,
}

/// The robots of a folder that are compared, or the bundled arm.
fn robots(folder: Option<&Path>) -> Vec<Robot> {
    let Some(folder) = folder else {
        let files = Path::new(env!("CARGO_MANIFEST_DIR")).join("urdf/demo_arm/demo_arm");
        let model = RobotModel::load(&files.with_extension("urdf"), Some(&files.with_extension("srdf")), &[]);
        let model = Arc::new(model.expect("a bundled robot loads"));
        return vec![Robot { name: "demo_arm".into(), model, reach: 1.0 }];
    };
    let text = std::fs::read_to_string(folder.join("robots.json")).expect("FOLDER has a robots.json");
    let list: serde_json::Value = serde_json::from_str(&text).expect("robots.json is JSON");
    let path = |robot: &serde_json::Value, key: &str| folder.join(robot[key].as_str().expect("a path"));
    (list.as_array().expect("a list").iter())
        .filter_map(|robot| {
            let name = robot["name"].as_str()?.to_owned();
            let reach = match name.as_str() {
                "panda" | "ur5e" => 1.0,
                "pr2" => 1.6,
                _ => return None,
            };
            let packages = [path(robot, "package_root")];
            let model = RobotModel::load(&path(robot, "urdf"), Some(&path(robot, "srdf")), &packages);
            Some(Robot { name, model: Arc::new(model.expect("the robot loads")), reach })
        })
        .collect()
}

/// A round trench with a wall: a closed mesh whose bounding box contains the robot, and whose inside does not.
fn trench(reach: f64, around: u32, across: u32) -> TriangleMesh {
    let profile: [[f64; 2]; 6] = [[0.4, -0.3], [1.4, -0.3], [1.4, 1.2], [1.3, 1.2], [1.3, -0.2], [0.4, -0.2]];
    let lengths: Vec<f64> = (0..6)
        .map(|i| {
            let ([a, b], [c, d]) = (profile[i], profile[(i + 1) % 6]);
            (c - a).hypot(d - b)
        })
        .collect();
    let total: f64 = lengths.iter().sum();
    let at_length = |mut s: f64| {
        for (i, length) in lengths.iter().enumerate() {
            if s <= *length || i == 5 {
                let ([a, b], [c, d]) = (profile[i], profile[(i + 1) % 6]);
                return [a + (c - a) * s / length, b + (d - b) * s / length];
            }
            s -= length;
        }
        unreachable!("the last side ends the loop")
    };
    let vertices = (0..around).flat_map(|i| (0..across).map(move |j| (i, j))).map(|(i, j)| {
        let [r, z] = at_length(f64::from(j) / f64::from(across) * total);
        let angle = f64::from(i) / f64::from(around) * TAU;
        let ripple = 1.0 + 0.004 * (17.0 * angle).sin() * (23.0 * z).cos();
        Point::new(reach * r * ripple * angle.cos(), reach * r * ripple * angle.sin(), reach * z)
    });
    let number = |i: u32, j: u32| (i % around) * across + j % across;
    let quads = (0..around).flat_map(|i| (0..across).map(move |j| (i, j)));
    let faces = quads.flat_map(|(i, j)| {
        let [a, b, c, d] = [number(i, j), number(i + 1, j), number(i + 1, j + 1), number(i, j + 1)];
        [[a, b, c], [a, c, d]]
    });
    TriangleMesh::new(vertices.collect(), faces.collect()).expect("a valid mesh")
}

/// Small closed rings around the robot.
fn rings(reach: f64, count: usize, random: &mut Random) -> Vec<Obstacle> {
    let ring = Arc::new(trench(0.1 * reach, 60, 40));
    (0..count)
        .map(|i| {
            let mut pose = random.pose(0.0);
            #[allow(clippy::cast_precision_loss)] // few rings
            let angle = TAU * (i as f64 / count as f64);
            pose.translation =
                [reach * angle.cos(), reach * angle.sin(), reach * random.within(-0.6, 0.6)].into();
            Obstacle::of_shape(format!("ring{i}"), pose, Shape::Mesh(Arc::clone(&ring)))
        })
        .collect()
}

fn worlds(robot: &Robot) -> Vec<(&'static str, World, bool)> {
    let (mut large, mut scattered) = (World::default(), World::default());
    let mesh = Shape::Mesh(Arc::new(trench(robot.reach, 400, 128)));
    large.add(Obstacle::of_shape("trench", Pose::identity(), mesh)).expect("a new name");
    for ring in rings(robot.reach, 20, &mut Random::new(3)) {
        scattered.add(ring).expect("a new name");
    }
    vec![("itself", World::default(), true), ("trench", large, false), ("rings", scattered, false)]
}

fn random_states(robot: &RobotModel, count: usize, random: &mut Random) -> Vec<Configuration> {
    let state = |_| {
        let positions: Vec<f64> = (robot.joint_ids())
            .filter(|j| robot.first_position(*j).is_some())
            .map(|j| robot.joint(j).limits.map_or([-3.0, 3.0], |l| [l.lower, l.upper]))
            .map(|[low, high]| random.within(low, high))
            .collect();
        robot.configuration(&positions).expect("within limits")
    };
    (0..count).map(state).collect()
}

/// States a thousandth of a second apart, through some of the given ones.
fn succession(robot: &RobotModel, through: &[Configuration]) -> Vec<Configuration> {
    let mut states = Vec::new();
    for ends in through.windows(2).take(STATES / 50) {
        for i in 0..200 {
            let share = f64::from(i) / 2000.0;
            let mixed = ends[0].positions().iter().zip(ends[1].positions()).map(|(p, q)| p + (q - p) * share);
            states.push(robot.configuration(&mixed.collect::<Vec<_>>()).expect("within limits"));
        }
    }
    states
}

/// Best CPU times of two passes in turn: surface, solid (µs per item).
#[allow(clippy::cast_precision_loss)] // few items
fn race(count: usize, passes: [&mut dyn FnMut(); 2]) -> [f64; 2] {
    let mut best = [f64::INFINITY; 2];
    let [surface, solid] = passes;
    for _ in 0..ROUNDS {
        for (pass, best) in [&mut *surface as &mut dyn FnMut(), &mut *solid].into_iter().zip(&mut best) {
            let start = ThreadTime::now();
            pass();
            *best = best.min(start.elapsed().as_secs_f64() * 1e6 / count as f64);
        }
    }
    best
}

fn tell(row: &str, [surface, solid]: [f64; 2]) {
    println!("| {row} | {surface:.3} | {solid:.3} | {:.3} |", solid / surface);
}

fn compare(robot: &Robot, world_name: &str, world: &World, check_self: bool) {
    let checker = |mesh_model| {
        let settings = Settings { mesh_model, check_self, ..Settings::default() };
        CollisionChecker::new(Arc::clone(&robot.model), world, settings).expect("settings are sound")
    };
    let both = [checker(MeshModel::Surface), checker(MeshModel::Solid)];
    let random = &mut Random::new(7);
    let all = random_states(&robot.model, 20_000, random);
    let mut workspaces = both.each_ref().map(CollisionChecker::workspace);
    let mut free = |checker: usize, q| both[checker].is_free(q, &mut workspaces[checker]);
    let mut apart: Vec<Configuration> = all.iter().filter(|q| free(1, q)).take(STATES).cloned().collect();
    if apart.len() < STATES {
        println!("{} {world_name}: only {} free states", robot.name, apart.len());
        apart = all[..STATES].to_vec();
    }
    let title = format!("{} | {world_name}", robot.name);
    let any = &all[..STATES];
    {
        let [mut a, mut b] = both.each_ref().map(CollisionChecker::workspace);
        let mut surface = || any.iter().for_each(|q| _ = black_box(both[0].is_free(q, &mut a)));
        let mut solid = || any.iter().for_each(|q| _ = black_box(both[1].is_free(q, &mut b)));
        let times = race(STATES, [&mut surface, &mut solid]);
        tell(&format!("{title} | boolean, any state"), times);
    }
    for (name, question) in [
        ("boolean", Question::Free),
        ("pairs", Question::Pairs),
        ("distance", Question::Distance { limit: f64::INFINITY }),
        ("distance within 0.1 m", Question::Distance { limit: 0.1 }),
    ] {
        let [mut a, mut b] = both.each_ref().map(CollisionChecker::workspace);
        for q in &apart {
            let (x, y) = (both[0].check(q, question, &mut a), both[1].check(q, question, &mut b));
            assert_eq!(x.nearest, y.nearest);
        }
        let times = race(
            STATES,
            [
                &mut || apart.iter().for_each(|q| _ = black_box(both[0].check(q, question, &mut a))),
                &mut || apart.iter().for_each(|q| _ = black_box(both[1].check(q, question, &mut b))),
            ],
        );
        tell(&format!("{title} | {name}, free states"), times);
    }
    {
        let [mut a, mut b] = both.each_ref().map(CollisionChecker::workspace);
        let (mut x, mut y) = ([false; STATES], [false; STATES]);
        let mut surface = || both[0].are_free_with(&apart, &mut a, black_box(&mut x));
        let mut solid = || both[1].are_free_with(&apart, &mut b, black_box(&mut y));
        let times = race(STATES, [&mut surface, &mut solid]);
        tell(&format!("{title} | batch"), times);
    }
    let near = succession(&robot.model, &apart);
    for (name, question) in [
        ("stream, boolean", Question::Free),
        ("stream, distance within 0.1 m", Question::Distance { limit: 0.1 }),
    ] {
        let pass = |checker: &CollisionChecker| {
            let mut stream = checker.streaming_workspace();
            for q in &near {
                black_box(checker.check(q, question, &mut stream));
                checker.prepare(&mut stream);
            }
        };
        let times = race(near.len(), [&mut || pass(&both[0]), &mut || pass(&both[1])]);
        tell(&format!("{title} | {name}"), times);
    }
    let segments: Vec<MotionSegment> = (apart.iter().zip(&apart[1..]))
        .map(|(from, to)| {
            let mixed = from.positions().iter().zip(to.positions()).map(|(p, q)| p + 0.1 * (q - p));
            let to = robot.model.configuration(&mixed.collect::<Vec<_>>()).expect("within limits");
            MotionSegment::straight(&robot.model, from, &to)
        })
        .filter(|segment| {
            both[1].check_motions(std::slice::from_ref(segment), &MotionOptions::default())[0].is_free()
        })
        .take(MOTIONS)
        .collect();
    let pass = |checker: &CollisionChecker, workspace: &mut clearance::Workspace| {
        for segment in &segments {
            black_box(checker.check_motion_with(segment, &MotionOptions::default(), workspace));
        }
    };
    let [mut a, mut b] = both.each_ref().map(CollisionChecker::workspace);
    let times = race(segments.len(), [&mut || pass(&both[0], &mut a), &mut || pass(&both[1], &mut b)]);
    tell(&format!("{title} | motion, free"), times);
}

fn main() {
    let folder = std::env::args().skip(1).find(|argument| !argument.starts_with("--")).map(PathBuf::from);
    println!("| robot | world | question | surface (µs) | solid (µs) | ratio |");
    println!("|---|---|---|---|---|---|");
    for robot in robots(folder.as_deref()) {
        for (name, world, check_self) in worlds(&robot) {
            compare(&robot, name, &world, check_self);
        }
    }
}
