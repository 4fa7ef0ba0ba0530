//! Benchmark of one robot: loads it, samples its states, and dispatches all queries on its states, edges and worlds.

use std::borrow::Borrow;
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::sync::Arc;

use clearance::checker::MotionOrder;
use clearance::geometry::Shape;
use clearance::robot::LinkId;
use clearance::scene::AllowedCollisionMatrix;
use clearance::{CollisionChecker, Configuration, Question, RobotModel, Settings, Workspace, World};
use cpu_time::ProcessTime;

use crate::among::Among;
use crate::answer::{Answer, link_pairs};
use crate::batch_and_stream::{batch, hierarchy_bytes, level_0_nanoseconds, stream};
use crate::edges::EdgeSets;
use crate::neutral::Neutral;
use crate::random::Random;
use crate::sample_states::{Space, from_file};
use crate::{Outcome, certificates, edges};

/// Share of random states from which on a pair of links counts as touching by design. MoveIt's setup assistant has
/// such a rule; without it the published PR2 is never free: its upper arms reach into its shoulders.
const BY_DESIGN: f64 = 0.5;

/// How far (m) the streamed question looks.
const NEAR: f64 = 0.1;

/// The hierarchies are built so often; the fastest counts.
const BUILDS: usize = 3;

pub struct WholeRobot {
    checker: CollisionChecker,
    /// What decides the checker's pairs in place of the SRDF.
    matrix: Option<AllowedCollisionMatrix>,
    workspace: Workspace,
    states: BTreeMap<&'static str, Vec<Configuration>>,
    edges: EdgeSets,
    among: Among,
    touching_by_design: usize,
}

impl WholeRobot {
    /// Reads a robot, draws what no file gives, and writes everything down for the others.
    ///
    /// `source`: URDF, SRDF, package root, file of random states, file of free states (`-` where there is none), seed,
    /// number of states to draw, steps of the walk, file to write.
    pub fn prepare(source: &[&str]) -> Outcome<Self> {
        let &[urdf, srdf, root, random_file, free_file, seed, count, steps, out] = source else {
            return Err("a robot needs nine words".into());
        };
        let given = |word: &'static str, text: &str| (text != "-").then(|| text.to_owned()).ok_or(word);
        let srdf = given("srdf", srdf).ok();
        let robot = Arc::new(RobotModel::load(
            Path::new(urdf),
            srdf.as_deref().map(Path::new),
            &[Path::new(root).to_owned()],
        )?);
        let mut random = Random::new(seed.parse()?);
        let space = Space::new(&robot);
        let (checker, matrix, touching_by_design) =
            checker_of(&robot, &space.uniform(&robot, &mut random, 200)?)?;
        let uniform = match given("states", random_file) {
            Ok(file) => from_file(&robot, Path::new(&file))?,
            Err(_) => space.uniform(&robot, &mut random, count.parse()?)?,
        };
        let free = match given("states", free_file) {
            Ok(file) => from_file(&robot, Path::new(&file))?,
            Err(_) => space.free(&checker, &mut random, count.parse()?)?,
        };
        let start = free.first().cloned().unwrap_or_else(|| robot.default_configuration());
        let walk = space.walk(&robot, &mut random, &start, steps.parse()?)?;
        let states = BTreeMap::from([("random", uniform), ("free", free), ("walk", walk)]);
        let mut neutral = Neutral::create(Path::new(out), robot.name())?;
        neutral.robot(&checker)?;
        neutral.limits(space.bounds())?;
        for (set, states) in &states {
            neutral.states(set, states)?;
        }
        neutral.finish()?;
        let (edges, among) = (EdgeSets::new(), Among::default());
        Ok(Self { workspace: checker.workspace(), checker, matrix, states, edges, among, touching_by_design })
    }

    /// `key=value` words for the report.
    pub fn summary(&self) -> String {
        let count = |set| self.states.get(set).map_or(0, Vec::len);
        format!(
            "pairs={}\ttouching_by_design={}\ttriangles={}\trandom={}\tfree={}\twalk={}",
            self.checker.pairs().len(),
            self.touching_by_design,
            self.triangles(),
            count("random"),
            count("free"),
            count("walk"),
        )
    }

    fn triangles(&self) -> usize {
        let shapes = self.checker.robot().links().iter().flat_map(|l| &l.collisions).map(|c| &c.shape);
        shapes.map(|s| if let Shape::Mesh(mesh) = s { mesh.triangles().len() } else { 0 }).sum()
    }

    /// `key=value` words: what building costs, and what the library tells of itself.
    pub fn figures(&self) -> Outcome<String> {
        let robot = self.checker.robot();
        let mut build_seconds = f64::INFINITY;
        for _ in 0..BUILDS {
            let start = ProcessTime::now();
            let built = CollisionChecker::new(robot.clone(), &World::default(), Settings::default())?;
            build_seconds = build_seconds.min(start.elapsed().as_secs_f64());
            drop(built);
        }
        let mut words = vec![format!("build_seconds={build_seconds:.4}")];
        let states = self.states.get("random").map_or(&[][..], |s| s);
        words.push(format!("level_0_ns={:.1}", level_0_nanoseconds(&self.checker, states)));
        words.push(format!("hierarchy_bytes={}", hierarchy_bytes(&self.checker)));
        Ok(words.join("\t"))
    }

    /// Takes the edges of a file in place of those it had.
    pub fn take_edges(&mut self, file: &Path) -> Outcome<()> {
        self.edges = edges::read(self.checker.robot(), file)?;
        Ok(())
    }

    /// What a line about worlds is answered with; `None` if it cannot be asked.
    pub fn surround(&mut self, words: &[&str]) -> Outcome<Option<String>> {
        let Self { checker, among, .. } = self;
        let states = first_few(&self.states, "random")?;
        match *words {
            ["world", file, out] => among.read(checker, file, out).map(Some),
            ["scatter", count, seed, out] => among.scatter(checker, states, [count, seed, out]).map(Some),
            ["growth", seed] => among.grow(checker, states, seed).map(Some),
            ["latency"] => among.cloud_latency(states),
            _ => Ok(None),
        }
    }

    /// `key=value` words: what making and verifying certificates of a set's edges costs; `None` if it cannot be asked.
    pub fn certificate_costs(&self, set: &str) -> Outcome<Option<String>> {
        let costs = certificates::costs(&self.checker, self.matrix.as_ref(), first_few(&self.edges, set)?)?;
        Ok(costs.map(|costs| costs.summary()))
    }

    /// Asks about every state or edge of `set`, which is a name or, for its first few, `name:count`.
    pub fn ask(&mut self, question: &str, set: &str, mut hear: impl FnMut(Answer)) -> Outcome<bool> {
        let Self { checker, workspace, states, edges, among, .. } = self;
        let order = match question {
            "edge-least" => {
                for edge in first_few(edges, set)? {
                    hear(Answer::Least(edges::least_distance(checker, edge, workspace)));
                }
                return Ok(true);
            }
            "edge" | "edge-least-proof" => Some(MotionOrder::Earliest),
            "edge-any" => Some(MotionOrder::Any),
            _ => None,
        };
        if let Some(order) = order {
            for edge in first_few(edges, set)? {
                hear(Answer::Edge(edges::verdict(checker, edge, order, workspace)));
            }
            return Ok(true);
        }
        let states = first_few(states, set)?;
        let mut least_distance = |limit: f64| {
            for q in states {
                let report = checker.check(q, Question::Distance { limit }, workspace);
                hear(Answer::Distance(report.nearest.map(|n| n.distance)));
            }
        };
        match question {
            "distance" => least_distance(f64::INFINITY),
            "near" => least_distance(NEAR),
            "free" => {
                for q in states {
                    hear(Answer::Free(checker.is_free(q, workspace)));
                }
            }
            "pairs" => {
                for q in states {
                    hear(Answer::Pairs(checker.check(q, Question::Pairs, workspace)));
                }
            }
            "free-batch" => batch(checker, states).into_iter().for_each(|free| hear(Answer::Free(free))),
            "near-stream" => stream(checker, states, NEAR).into_iter().for_each(hear),
            _ => return Ok(among.ask(question, states, hear)),
        }
        Ok(true)
    }
}

/// What `set` names: all of them or, written `name:count`, the first few.
fn first_few<'a, K, T>(sets: &'a BTreeMap<K, Vec<T>>, set: &str) -> Outcome<&'a [T]>
where
    K: Ord + Borrow<str>,
{
    let (name, count) = set.split_once(':').map_or((set, None), |(name, count)| (name, Some(count)));
    let all = sets.get(name).ok_or_else(|| format!("there is no set '{name}'"))?;
    let count = count.map_or(Ok(all.len()), str::parse)?;
    Ok(&all[..count.min(all.len())])
}

/// The checker without pairs that touch by design, the matrix that it takes, and how many pairs those are.
fn checker_of(
    robot: &Arc<RobotModel>,
    sample: &[Configuration],
) -> Outcome<(CollisionChecker, Option<AllowedCollisionMatrix>, usize)> {
    let given = CollisionChecker::new(robot.clone(), &World::default(), Settings::default())?;
    let mut workspace = given.workspace();
    let mut hits: BTreeMap<(LinkId, LinkId), usize> = BTreeMap::new();
    for q in sample {
        for pair in link_pairs(&given.check(q, Question::Pairs, &mut workspace)) {
            *hits.entry(pair).or_default() += 1;
        }
    }
    #[allow(clippy::cast_precision_loss)] // counts of states
    let by_design: BTreeSet<_> = hits
        .into_iter()
        .filter(|(_, n)| *n as f64 >= BY_DESIGN * sample.len() as f64)
        .map(|(pair, _)| pair)
        .collect();
    if by_design.is_empty() {
        return Ok((given, None, 0));
    }
    // a matrix replaces the SRDF: it must allow what the SRDF allowed, too
    let kept: BTreeSet<_> = given.pairs().link_pairs().filter(|pair| !by_design.contains(pair)).collect();
    let mut matrix = AllowedCollisionMatrix::default();
    for a in robot.link_ids() {
        for b in robot.link_ids().filter(|b| a < *b && !kept.contains(&(a, *b))) {
            matrix.set(&robot.link(a).name, &robot.link(b).name, true);
        }
    }
    let checker =
        CollisionChecker::with_matrix(robot.clone(), &World::default(), Settings::default(), Some(&matrix))?;
    Ok((checker, Some(matrix), by_design.len()))
}
