//! `clearance bench`: measures the time of checks, and compares broad phase structures or kinds of bounding volumes.

mod hash_grid;
mod k_d_tree;
mod loose_octree;
mod scatter;
mod structures;
mod sweep_and_prune;
mod volume_costs;

use std::hint::black_box;

use clap::Args;
use clearance::checker::{CollisionChecker, Question};
use clearance::proximity::bvh::AxisBox;
use clearance::robot::Configuration;
use clearance::scene::World;
use serde::Serialize;

use super::exit_status::ExitStatus;
use super::failure::Failure;
use super::model_args::{self, ModelArgs, WorldArgs};
use super::run_args::{Format, internal, print_line, warn_of_pad_self};
use super::timing;
use hash_grid::HashGrid;
use k_d_tree::KdTree;
use loose_octree::LooseOctree;
use structures::{BroadPhase, Tree, overlap};
use sweep_and_prune::SweepAndPrune;
use volume_costs::{Comparison, Subject, VolumeCosts};

/// Joint space distance (rad or m) of successive states: an arm at 2 rad/s, a state every millisecond.
const STEP: f64 = 0.002;

/// Numbers of boxes around the robot unless others are given.
const OBSTACLES: [u32; 4] = [10, 100, 1000, 10_000];

/// Number of passes; the fastest one counts.
const PASSES: u32 = 5;

#[derive(Args)]
pub struct BenchArgs {
    #[command(flatten)]
    model: ModelArgs,

    #[command(flatten)]
    world: WorldArgs,

    /// Without a world: number of boxes around the robot; several numbers are measured one after the other [default: 10,100,1000,10000]
    #[arg(long, value_name = "N,...", value_delimiter = ',', value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    obstacles: Vec<u32>,

    /// Compare the kinds of bounding volumes instead: numbers of tests and their times, with the world if there is one
    #[arg(long, conflicts_with_all = ["volumes", "obstacles"])]
    compare_volumes: bool,

    /// Number of random states of the robot
    #[arg(long, value_name = "N", default_value_t = 500, value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    states: u32,

    /// Seed of the random numbers
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,

    /// Output format
    #[arg(long, value_enum, default_value_t = Format::Text)]
    format: Format,
}

/// Output in JSON format. Times are thread CPU time, the best of several passes.
#[derive(Serialize)]
struct BenchOutput {
    robot: String,
    states: usize,
    worlds: Vec<WorldResult>,
}

/// Output of `--compare-volumes` in JSON format.
#[derive(Serialize)]
struct VolumesOutput {
    robot: String,
    states: usize,
    /// Time of kinematics and capsules (µs per state).
    level_0_us: f64,
    costs: Vec<VolumeCosts>,
}

#[derive(Serialize)]
struct WorldResult {
    obstacles: usize,
    /// Number of bounding boxes: one per obstacle, or one per piece of a large obstacle.
    boxes: usize,
    /// Fraction of the states that are free.
    free: f64,
    /// Time of the boolean query (µs per state).
    boolean_us: f64,
    /// Time of the minimum distance query with a limit of 1 m (µs per state).
    distance_us: f64,
    /// Pairs of a robot part and an obstacle whose boxes overlap (per state).
    overlaps: f64,
    broad_phases: Vec<BroadPhaseResult>,
}

#[derive(Serialize)]
struct BroadPhaseResult {
    name: &'static str,
    /// Time to build the structure from all boxes (µs).
    build_us: f64,
    /// Time to find the boxes that overlap the boxes of all parts, in random states (µs per state).
    query_us: f64,
    /// The same for successive states of a motion.
    successive_us: f64,
    /// Time to move an obstacle by a small distance (µs).
    move_us: f64,
    /// Time to remove an obstacle and insert it again (µs).
    replace_us: f64,
}

pub fn run(args: &BenchArgs) -> Result<ExitStatus, Failure> {
    let robot = args.model.robot.load()?;
    let scene = args.world.load(&robot, &args.model.robot.mesh_files())?;
    if !args.obstacles.is_empty() && !scene.world.is_empty() {
        let why = "--obstacles has no effect in a world: give --obstacles, or --world and --cloud";
        return Err(Failure::Input(why.to_owned()));
    }
    let settings = args.model.settings();
    warn_of_pad_self(&settings, &scene);
    let mut without_world = scene.clone();
    without_world.world = World::default();
    let alone = model_args::checker(robot, &without_world, settings)?;
    let mut random = fastrand::Rng::with_seed(args.seed);
    let states: Vec<_> = (0..args.states).map(|_| alone.robot().random_configuration(&mut random)).collect();
    if args.compare_volumes {
        let subject = Subject { checker: &alone, world: &scene.world, matrix: scene.matrix.as_ref() };
        return compare_volumes(&subject, &states, args.format);
    }
    let worlds = if scene.world.is_empty() {
        let region = region(&alone, &states);
        let counts = if args.obstacles.is_empty() { &OBSTACLES[..] } else { &args.obstacles };
        let worlds = counts.iter().map(|&count| scatter::boxes(count, &region, &mut random));
        worlds.collect::<Result<_, _>>()?
    } else {
        vec![scene.world]
    };
    let mut results = Vec::new();
    for world in &worlds {
        let checker = alone
            .with_world(world, alone.settings().clone(), scene.matrix.as_ref())
            .map_err(Failure::input)?;
        results.push(measure_world(&checker, &states)?);
    }
    let output =
        BenchOutput { robot: alone.robot().name().to_owned(), states: states.len(), worlds: results };
    match args.format {
        Format::Json => print_line(&serde_json::to_string(&output).map_err(internal)?)?,
        Format::Text => print_text(&output)?,
    }
    Ok(ExitStatus::SUCCESS)
}

fn compare_volumes(
    subject: &Subject,
    states: &[Configuration],
    format: Format,
) -> Result<ExitStatus, Failure> {
    let robot = subject.checker.robot().name();
    let comparison = volume_costs::compare(subject, states)?;
    match format {
        Format::Text => volume_costs::print_text(robot, states.len(), &comparison)?,
        Format::Json => {
            let Comparison { level_0_us, costs } = comparison;
            let output = VolumesOutput { robot: robot.to_owned(), states: states.len(), level_0_us, costs };
            print_line(&serde_json::to_string(&output).map_err(internal)?)?;
        }
    }
    Ok(ExitStatus::SUCCESS)
}

/// Bounding box of the robot over several states.
fn region(checker: &CollisionChecker, states: &[Configuration]) -> AxisBox {
    let mut workspace = checker.workspace();
    scatter::around(
        states.iter().flat_map(|q| checker.part_boxes(q, &mut workspace)).collect::<Vec<_>>().iter(),
    )
}

#[allow(clippy::cast_precision_loss)] // counts fit 52 bits
fn measure_world(checker: &CollisionChecker, states: &[Configuration]) -> Result<WorldResult, Failure> {
    let mut workspace = checker.workspace();
    let free = states.iter().filter(|q| checker.is_free(q, &mut workspace)).count();
    let boolean_us = best(states.len(), || {
        for q in states {
            black_box(checker.is_free(q, &mut workspace));
        }
    });
    let distance_us = best(states.len(), || {
        for q in states {
            black_box(checker.check(q, Question::Distance { limit: 1.0 }, &mut workspace));
        }
    });
    let parts: Vec<Vec<AxisBox>> = states.iter().map(|q| checker.part_boxes(q, &mut workspace)).collect();
    let successive: Vec<Vec<AxisBox>> =
        motion(checker, states).iter().map(|q| checker.part_boxes(q, &mut workspace)).collect();
    let items = checker.world_boxes();
    let random = Queries { truth: brute_force(&items, &parts), parts };
    let successive = Queries { truth: brute_force(&items, &successive), parts: successive };
    let overlaps: usize = random.truth.iter().map(Vec::len).sum();
    let queries = [&random, &successive];
    Ok(WorldResult {
        obstacles: checker.world().len(),
        boxes: items.len(),
        free: free as f64 / states.len() as f64,
        boolean_us,
        distance_us,
        overlaps: overlaps as f64 / states.len() as f64,
        broad_phases: vec![
            race::<Tree>(&items, queries)?,
            race::<SweepAndPrune>(&items, queries)?,
            race::<HashGrid>(&items, queries)?,
            race::<LooseOctree>(&items, queries)?,
            race::<KdTree>(&items, queries)?,
        ],
    })
}

/// Boxes of all robot parts in several states.
struct Queries {
    parts: Vec<Vec<AxisBox>>,
    /// The items that overlap them in each state.
    truth: Vec<Vec<u32>>,
}

/// As many states as there are, each [`STEP`] from the one before, on the way from one of them to the next.
#[allow(clippy::cast_possible_truncation, clippy::cast_precision_loss, clippy::cast_sign_loss)] // few steps
fn motion(checker: &CollisionChecker, states: &[Configuration]) -> Vec<Configuration> {
    let robot = checker.robot();
    let along = states.iter().zip(states.iter().cycle().skip(1)).flat_map(|(from, to)| {
        let steps = (robot.joint_space_distance(from, to) / STEP).ceil().clamp(1.0, 1e6) as usize;
        (0..steps).map(move |i| robot.interpolate(from, to, i as f64 / steps as f64))
    });
    along.take(states.len()).collect()
}

/// For each state: the overlapping items, from a comparison of all boxes with all boxes.
fn brute_force(items: &[(u32, AxisBox)], parts: &[Vec<AxisBox>]) -> Vec<Vec<u32>> {
    let of_part = |part: &AxisBox| {
        let near = items.iter().filter(|(_, bounds)| overlap(bounds, part));
        near.map(|(item, _)| *item).collect::<Vec<_>>()
    };
    parts.iter().map(|parts| sorted(parts.iter().flat_map(of_part).collect())).collect()
}

fn sorted(mut items: Vec<u32>) -> Vec<u32> {
    items.sort_unstable();
    items
}

/// Measures one structure. Checks that its results are correct, before and after all items have moved forth and back.
fn race<B: BroadPhase>(
    items: &[(u32, AxisBox)],
    [random, successive]: [&Queries; 2],
) -> Result<BroadPhaseResult, Failure> {
    let build_us = best(1, || drop(black_box(B::build(items))));
    let mut structure = B::build(items);
    random.agree(&mut structure)?;
    let query_us = random.time(&mut structure);
    let successive_us = successive.time(&mut structure);
    let move_us = best(2 * items.len(), || {
        for by in [0.01, 0.0] {
            for (item, bounds) in items {
                structure.set(*item, &shifted(bounds, by));
            }
        }
    });
    let replace_us = best(items.len(), || {
        for (item, bounds) in items {
            structure.remove(*item);
            structure.set(*item, bounds);
        }
    });
    random.agree(&mut structure)?;
    successive.agree(&mut structure)?;
    Ok(BroadPhaseResult { name: B::NAME, build_us, query_us, successive_us, move_us, replace_us })
}

impl Queries {
    /// Microseconds a state.
    fn time<B: BroadPhase>(&self, structure: &mut B) -> f64 {
        let mut found = Vec::new();
        best(self.parts.len(), || {
            for parts in &self.parts {
                for (query, part) in (0..).zip(parts) {
                    found.clear();
                    structure.overlapping(query, part, &mut found);
                    black_box(&found);
                }
            }
        })
    }

    fn agree<B: BroadPhase>(&self, structure: &mut B) -> Result<(), Failure> {
        for (parts, truth) in self.parts.iter().zip(&self.truth) {
            let mut found = Vec::new();
            for (query, part) in (0..).zip(parts) {
                structure.overlapping(query, part, &mut found);
            }
            if sorted(found) != *truth {
                return Err(Failure::Internal(format!("{} does not find the boxes that overlap", B::NAME)));
            }
        }
        Ok(())
    }
}

/// The box, moved by `by` (m) along the first axis.
fn shifted(bounds: &AxisBox, by: f32) -> AxisBox {
    let mut moved = *bounds;
    if by != 0.0 {
        (moved.lo[0], moved.hi[0]) = (bounds.lo[0] + by, bounds.hi[0] + by);
    }
    moved
}

fn best(pieces: usize, pass: impl FnMut()) -> f64 {
    timing::measure(PASSES, pieces, pass).map_or(0.0, |timing| timing.us_min)
}

fn print_text(output: &BenchOutput) -> Result<(), Failure> {
    print_line(&format!(
        "{}: {} random states; µs of CPU time, best of {PASSES}",
        output.robot, output.states
    ))?;
    for world in &output.worlds {
        let WorldResult { obstacles, boxes, free, boolean_us, distance_us, overlaps, broad_phases } = world;
        print_line(&format!(
            "\n{obstacles} obstacles in {boxes} boxes, {:.0} % of the states free: boolean {boolean_us:.2}, distance {distance_us:.2} a state",
            100.0 * free
        ))?;
        print_line(&format!(
            "  {:<16} {:>12} {:>12} {:>12} {:>12} {:>12}   ({overlaps:.1} overlaps a state)",
            "broad phase", "random state", "next state", "move", "replace", "build"
        ))?;
        for BroadPhaseResult { name, build_us, query_us, successive_us, move_us, replace_us } in broad_phases
        {
            print_line(&format!(
                "  {name:<16} {query_us:>12.3} {successive_us:>12.3} {move_us:>12.3} {replace_us:>12.3} {build_us:>12.1}"
            ))?;
        }
    }
    Ok(())
}
