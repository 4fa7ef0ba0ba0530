//! Benchmark queries of one robot among obstacles: world files, scattered primitives, worlds of increasing size, and
//! the latency of a new point cloud.

use std::collections::BTreeMap;
use std::fmt::Write;
use std::hint::black_box;
use std::path::Path;

use clearance::geometry::{PointCloud, Shape};
use clearance::scene::Obstacle;
use clearance::{CollisionChecker, Configuration, World};
use cpu_time::ProcessTime;

use crate::Outcome;
use crate::answer::Answer;
use crate::neutral::Neutral;
use crate::random::Random;
use crate::scatter;
use crate::surroundings::Surroundings;
use crate::world_file;

/// Numbers of obstacles as a world grows.
const GROWTH: [usize; 4] = [10, 100, 1000, 10_000];

/// How much farther (m) than the robot reaches nothing stands that would differ between worlds: the size of an obstacle.
const MARGIN: f64 = 0.25;

/// States that tell how often scattered obstacles are touched, and how far the robot reaches.
const SAMPLE: usize = 100;

/// Messages whose time is taken.
const MESSAGES: usize = 9;

/// Worlds around one robot, by name: `world`, `cubes` where it is of points, and `growth-N`.
#[derive(Default)]
pub struct Among(BTreeMap<String, Surroundings>);

impl Among {
    /// Takes the world of a file, and writes it for the others; `key=value` words.
    pub fn read(&mut self, checker: &CollisionChecker, file: &str, out: &str) -> Outcome<String> {
        self.take(checker, &world_file::read(Path::new(file))?, out)
    }

    /// Takes `count` primitives scattered around the robot.
    pub fn scatter(
        &mut self,
        checker: &CollisionChecker,
        states: &[Configuration],
        [count, seed, out]: [&str; 3],
    ) -> Outcome<String> {
        let mut random = Random::new(seed.parse()?);
        let sample = &states[..states.len().min(SAMPLE)];
        self.take(checker, &scatter::around(checker, sample, count.parse()?, &mut random)?, out)
    }

    fn take(&mut self, checker: &CollisionChecker, world: &World, out: &str) -> Outcome<String> {
        let mut neutral = Neutral::create(Path::new(out), "world")?;
        neutral.world(world)?;
        neutral.finish()?;
        self.0.insert("world".to_owned(), Surroundings::new(checker, world)?);
        self.0.remove("cubes");
        let mut words = format!("objects={}", world.len());
        if let Some(cloud) = world_file::cloud(world) {
            let _ = write!(words, "\tpoints={}", cloud.1.points().len());
            self.0.insert("cubes".to_owned(), Surroundings::new(checker, &world_file::cubes(cloud)?)?);
        }
        Ok(words)
    }

    /// Takes worlds of ever more obstacles of the same density; `key=value` words.
    pub fn grow(
        &mut self,
        checker: &CollisionChecker,
        states: &[Configuration],
        seed: &str,
    ) -> Outcome<String> {
        let mut random = Random::new(seed.parse()?);
        let reach = scatter::reach(checker, states) + MARGIN;
        let sample = &states[..states.len().min(SAMPLE)];
        let worlds = scatter::growing(checker, sample, reach, &GROWTH, &mut random)?;
        for (count, world) in GROWTH.iter().zip(&worlds) {
            self.0.insert(format!("growth-{count}"), Surroundings::new(checker, world)?);
        }
        Ok(format!("reach={reach:.3}"))
    }

    /// Asks a question written `free-NAME`, `free-NAME-batch` or `distance-NAME` about every state; false where there is no
    /// such call.
    pub fn ask(&mut self, question: &str, states: &[Configuration], hear: impl FnMut(Answer)) -> bool {
        let Some((kind, place)) = question.split_once('-') else { return false };
        let (name, kind) = match place.strip_suffix("-batch") {
            Some(name) if kind == "free" => (name, "free-batch"),
            _ => (place, kind),
        };
        self.0.get_mut(name).is_some_and(|among| among.ask(kind, states, hear))
    }

    /// Milliseconds of CPU time from decoded points to the answer about a first state: in place of no cloud, then each time
    /// in place of the last one. `None` where there is no cloud.
    pub fn cloud_latency(&self, states: &[Configuration]) -> Outcome<Option<String>> {
        let Some(among) = self.0.get("world") else { return Ok(None) };
        let Some((pose, cloud)) = world_file::cloud(among.checker().world()) else { return Ok(None) };
        let mut checker = Surroundings::new(among.checker(), &World::default())?.checker().clone();
        let mut workspace = checker.workspace();
        let mut spent = Vec::new();
        for q in states.iter().cycle().take(MESSAGES) {
            let points = cloud.points().to_vec();
            let start = ProcessTime::now();
            let shape = Shape::Points(PointCloud::new(points, cloud.radius())?.into());
            let mut world = World::default();
            world.add(Obstacle::of_shape("cloud", pose, shape))?;
            checker.set_world(&world)?;
            black_box(checker.is_free(q, &mut workspace));
            spent.push(start.elapsed().as_secs_f64() * 1e3);
        }
        Ok(Some(spent.iter().map(|ms| format!("{ms:.3}")).collect::<Vec<_>>().join("\t")))
    }
}
