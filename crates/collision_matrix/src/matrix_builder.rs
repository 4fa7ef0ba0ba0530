//! Computes the decisions about all pairs of links.

use std::collections::HashMap;
use std::sync::{Arc, Mutex, PoisonError};

use clearance_checker::{CollisionChecker, Question, Workspace};
use clearance_geometry::math::Extremes;
use clearance_proximity::Scratch;
use clearance_robot::{LinkId, RobotModel};
use clearance_scene::{AllowedCollisionMatrix, BodyId, MeshModel, Settings, World};
use fastrand::Rng;
use rayon::prelude::*;

use crate::always_proof::{self, AlwaysSearch};
use crate::decision::{DecidedPair, Decision};
use crate::fixed_contact;
use crate::joint_path::{JointPath, Variable};
use crate::link_geometry::LinkGeometry;
use crate::never_proof::{self, NeverSearch, ProofLimits};
use crate::options::{MatrixFailure, MatrixOptions};
use crate::pair_problem::{PairProblem, PairWorkspace};
use crate::split_tree::MOST_VARIABLES;
use crate::witness_search::{self, Witnesses};

/// Budgets of the rounds, in boxes for each pair: pairs with short proofs are decided first.
const ROUNDS: [u64; 3] = [2_000, 60_000, u64::MAX];

/// Largest number of boxes for a proof of contact: each costs many distances.
const MOST_CONTACT_BOXES: u64 = 20_000;

/// Random states of the whole robot for a pair whose joints have no finite range.
const UNBOUNDED_SAMPLES: usize = 500;

/// Least gap (m) beyond contact of links that are fixed to each other: room for rounding in the verifier.
const FIXED_GAP: f64 = 1e-8;

/// Decides pairs of links of a robot. It is immutable and can be shared by threads.
#[derive(Debug)]
pub struct MatrixBuilder {
    robot: Arc<RobotModel>,
    links: Vec<LinkGeometry>,
    /// Checks all pairs that can move.
    checker: CollisionChecker,
    meshes_are_solid: bool,
}

/// A pair of links, by their places among the links with geometry.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Pair(usize, usize);

/// State of the search for one pair.
struct OpenPair {
    pair: Pair,
    /// Place in the result.
    index: usize,
    /// The decision of an earlier run.
    known: Option<DecidedPair>,
    witnesses: Option<Witnesses>,
    decided: Option<DecidedPair>,
}

impl MatrixBuilder {
    /// Builds the geometry of all links.
    pub fn new(robot: &Arc<RobotModel>, settings: &Settings) -> Result<Self, MatrixFailure> {
        let links = robot.link_ids().collect::<Vec<_>>().into_par_iter().map(|link| {
            LinkGeometry::new(robot, link, settings).map_err(|why| MatrixFailure::CannotScale {
                link: robot.link(link).name.clone(),
                why: why.to_string(),
            })
        });
        let links: Vec<Option<LinkGeometry>> = links.collect::<Result<_, _>>()?;
        let links: Vec<LinkGeometry> = links.into_iter().flatten().collect();
        if links.len() < 2 {
            return Err(MatrixFailure::NoPairs(robot.name().to_owned()));
        }
        let settings = Settings { check_self: true, check_world: false, ..settings.clone() };
        let meshes_are_solid = settings.mesh_model == MeshModel::Solid;
        let all = AllowedCollisionMatrix::default();
        let checker =
            CollisionChecker::with_matrix(Arc::clone(robot), &World::default(), settings, Some(&all))
                .map_err(|error| MatrixFailure::Settings(error.to_string()))?;
        Ok(Self { robot: Arc::clone(robot), links, checker, meshes_are_solid })
    }

    /// Largest number of pairs: those of links with collision geometry.
    #[must_use]
    pub fn pair_count(&self) -> usize {
        self.links.len() * (self.links.len() - 1) / 2
    }

    /// Decides all pairs that `known` does not decide. The proofs of `known` have to be verified before; all else in it is
    /// checked. `progress` is called for every decided pair, from any thread.
    ///
    /// Runs on the threads of the rayon pool it is called in.
    #[must_use]
    pub fn decide(
        &self,
        known: &[DecidedPair],
        options: &MatrixOptions,
        progress: &(impl Fn(&DecidedPair) + Sync),
    ) -> Vec<DecidedPair> {
        self.decide_some(|_, _| true, known, options, progress)
    }

    /// As [`Self::decide`], for the pairs of links that are `wanted`.
    #[must_use]
    pub fn decide_some(
        &self,
        wanted: impl Fn(LinkId, LinkId) -> bool,
        known: &[DecidedPair],
        options: &MatrixOptions,
        progress: &(impl Fn(&DecidedPair) + Sync),
    ) -> Vec<DecidedPair> {
        let count = self.links.len();
        let pairs = (0..count).flat_map(|i| (i + 1..count).map(move |j| Pair(i, j)));
        let pairs = pairs.filter(|Pair(i, j)| wanted(self.links[*i].link, self.links[*j].link));
        let mut results: Vec<Option<DecidedPair>> = Vec::new();
        let mut open: Vec<OpenPair> = Vec::new();
        let known: HashMap<(&str, &str), &DecidedPair> = (known.iter())
            .filter(|known| known.decision.is_final())
            .map(|known| ((known.link1.as_str(), known.link2.as_str()), known))
            .collect();
        for (index, pair) in pairs.enumerate() {
            let known = known.get(&(self.name(pair.0), self.name(pair.1))).map(|known| (*known).clone());
            open.push(OpenPair { pair, index, known, witnesses: None, decided: None });
            results.push(None);
        }
        // one for each thread: they are large, and pairs are many
        let workspaces = Mutex::new(Vec::new());
        for budget in ROUNDS {
            let limits = ProofLimits { boxes: budget.min(options.most_boxes), options };
            open.par_iter_mut().with_max_len(1).for_each(|open| {
                if options.is_over() && open.known.is_none() {
                    open.decided.get_or_insert_with(|| self.not_looked_at(open.pair));
                    return;
                }
                let free = || workspaces.lock().unwrap_or_else(PoisonError::into_inner);
                let taken = free().pop();
                let (mut workspace, mut scratch) =
                    taken.unwrap_or_else(|| (self.checker.workspace(), Scratch::default()));
                self.advance(open, limits, &mut workspace, &mut scratch);
                free().push((workspace, scratch));
                if let Some(pair) = open.decided.as_ref().filter(|pair| pair.decision.is_final()) {
                    progress(pair);
                }
            });
            open.retain_mut(|open| {
                let is_final = open.decided.as_ref().is_some_and(|pair| pair.decision.is_final());
                results[open.index].clone_from(&open.decided);
                !is_final
            });
        }
        results.into_iter().flatten().collect()
    }

    fn name(&self, place: usize) -> &str {
        self.robot.described_name(self.links[place].link)
    }

    /// Continues the search for a pair with a larger budget.
    fn advance(
        &self,
        open: &mut OpenPair,
        limits: ProofLimits,
        workspace: &mut Workspace,
        scratch: &mut Scratch,
    ) {
        let Pair(i, j) = open.pair;
        let links = [&self.links[i], &self.links[j]];
        let path = JointPath::new(&self.robot, links[0].link, links[1].link);
        let problem = PairProblem { links, path };
        let mut attempt = PairAttempt {
            builder: self,
            problem: &problem,
            checker_workspace: workspace,
            workspace: problem.workspace(std::mem::take(scratch)),
        };
        // what is known is not lost to the deadline
        let unlimited = MatrixOptions { deadline: None, watch: None, ..limits.options.clone() };
        let options = if open.known.is_some() { &unlimited } else { limits.options };
        let witnesses = open.witnesses.get_or_insert_with(|| {
            let mut random = Rng::with_seed(limits.options.seed ^ ((i as u64) << 32) ^ j as u64);
            attempt.witnesses(&mut random, options)
        });
        let known = open.known.take().filter(|known| attempt.confirms(&known.decision));
        let decision = match known {
            Some(known) => known.decision,
            None => attempt.decide(witnesses, limits),
        };
        *scratch = attempt.workspace.scratch;
        let contact_share = witnesses.contact_share;
        let variables = problem.path.variables().len();
        let mut decided = self.decided(open.pair, variables, contact_share, decision);
        decided.depth = self.contact_depth(&decided, &problem, witnesses, workspace);
        open.decided = Some(decided);
    }

    /// A pair that the deadline left out.
    fn not_looked_at(&self, pair: Pair) -> DecidedPair {
        let [a, b] = [pair.0, pair.1].map(|place| self.links[place].link);
        let decision = Decision::Undecided { least_distance: None, state: Vec::new() };
        self.decided(pair, JointPath::variable_count(&self.robot, a, b), 0.0, decision)
    }

    fn decided(
        &self,
        Pair(i, j): Pair,
        variables: usize,
        contact_share: f64,
        decision: Decision,
    ) -> DecidedPair {
        let [a, b] = [i, j].map(|place| self.links[place].link);
        DecidedPair {
            link1: self.name(i).to_owned(),
            link2: self.name(j).to_owned(),
            variables,
            is_adjacent: self.robot.same_rigid_body(a, b) || self.robot.adjacent_rigid_bodies(a, b),
            contact_share,
            depth: None,
            decision,
        }
    }

    /// Depth (m) of the contact in a colliding state, for links that are in contact in most states.
    fn contact_depth(
        &self,
        decided: &DecidedPair,
        problem: &PairProblem,
        witnesses: &Witnesses,
        workspace: &mut Workspace,
    ) -> Option<f64> {
        let [a, b] = problem.links.map(|link| link.link);
        if !decided.touches_mostly() || self.robot.same_rigid_body(a, b) || !problem.path.is_bounded() {
            return None;
        }
        let state = self.state(&problem.path, witnesses.colliding.as_ref()?);
        let q = self.robot.configuration(&state).ok()?;
        self.checker.contact(&q, (BodyId::Link(a), BodyId::Link(b)), workspace)?.depth
    }

    /// The state of the whole robot for values of a path's variables; other joints keep their defaults.
    fn state(&self, path: &JointPath, values: &[f64]) -> Vec<f64> {
        let mut positions = self.robot.default_configuration().positions().to_vec();
        for (variable, value) in path.variables().iter().zip(values) {
            positions[variable.position] = *value;
        }
        positions
    }

    /// True if the checker finds a pair in collision; `None` for links that it never checks, or an invalid state.
    fn checker_collides(&self, links: [LinkId; 2], state: &[f64], workspace: &mut Workspace) -> Option<bool> {
        if self.robot.same_rigid_body(links[0], links[1]) {
            return None;
        }
        let q = self.robot.configuration(state).ok()?;
        let report = self.checker.check(&q, Question::Pairs, workspace);
        let [a, b] = links.map(BodyId::Link);
        Some(report.colliding_pairs.iter().any(|pair| *pair == (a, b) || *pair == (b, a)))
    }
}

/// One attempt to decide a pair.
struct PairAttempt<'p, 'w> {
    builder: &'p MatrixBuilder,
    problem: &'p PairProblem<'p>,
    checker_workspace: &'w mut Workspace,
    workspace: PairWorkspace,
}

impl PairAttempt<'_, '_> {
    fn witnesses(&mut self, random: &mut Rng, options: &MatrixOptions) -> Witnesses {
        if self.problem.path.is_bounded() {
            return witness_search::search(self.problem, random, options, &mut self.workspace);
        }
        self.unbounded_witnesses(random, options)
    }

    /// States of the whole robot, as the path does not describe the pair's motion.
    fn unbounded_witnesses(&mut self, random: &mut Rng, options: &MatrixOptions) -> Witnesses {
        let robot = &self.builder.robot;
        let links = self.problem.links.map(|link| link.link);
        let (mut found, mut contacts) = (Witnesses::default(), 0.0);
        for _ in 0..UNBOUNDED_SAMPLES {
            if options.is_over() {
                return found;
            }
            let q = robot.sample(&clearance_robot::SamplingBox::default(), || random.f64());
            let state = q.positions().to_vec();
            match self.builder.checker_collides(links, &state, self.checker_workspace) {
                Some(true) => {
                    contacts += 1.0;
                    found.colliding.get_or_insert(state);
                }
                Some(false) => {
                    found.free.get_or_insert(state);
                }
                None => {}
            }
        }
        #[expect(clippy::cast_precision_loss, reason = "a small constant")]
        let samples = UNBOUNDED_SAMPLES as f64;
        found.contact_share = contacts / samples;
        found
    }

    /// Whether the states of an earlier decision are within the limits, and what it says about them is true. Proofs are
    /// not checked here.
    fn confirms(&mut self, known: &Decision) -> bool {
        let Decision::Sometimes { colliding, free } = known else { return true };
        let links = self.problem.links.map(|link| link.link);
        let mut is = |state: &[f64], expected: bool| {
            let is_within = |v: &Variable| {
                state.get(v.position).is_some_and(|value| (v.range[0]..=v.range[1]).contains(value))
            };
            self.problem.path.variables().iter().all(is_within)
                && self.builder.checker_collides(links, state, self.checker_workspace) == Some(expected)
        };
        is(colliding, true) && is(free, false)
    }

    fn decide(&mut self, witnesses: &mut Witnesses, limits: ProofLimits) -> Decision {
        if !self.problem.path.is_bounded() {
            return match (&witnesses.colliding, &witnesses.free) {
                (Some(colliding), Some(free)) => {
                    Decision::Sometimes { colliding: colliding.clone(), free: free.clone() }
                }
                (colliding, free) => self.undecided(colliding.as_ref().or(free.as_ref()), f64::INFINITY),
            };
        }
        if self.problem.path.variables().is_empty() {
            return self.decide_fixed(witnesses, limits);
        }
        if let Some(decision) = self.sometimes(witnesses) {
            return decision;
        }
        let decision = if witnesses.colliding.is_none() {
            self.decide_free(witnesses, limits)
        } else {
            self.decide_touching(witnesses, limits)
        };
        // a search may have found the missing state
        self.sometimes(witnesses).unwrap_or(decision)
    }

    /// Links that never move relative to each other.
    fn decide_fixed(&mut self, witnesses: &Witnesses, limits: ProofLimits) -> Decision {
        if witnesses.colliding.is_some() {
            return match fixed_contact::search(self.problem, &mut self.workspace) {
                Some(evidence) => Decision::Always { evidence: Box::new(evidence) },
                // one link may be inside a closed mesh of the other
                None => self.decide_touching(&mut witnesses.clone(), limits),
            };
        }
        match witnesses.least.as_ref().map(|least| least.0) {
            Some(least) if least > self.problem.threshold() + FIXED_GAP => {
                Decision::Never { proof: ".".to_owned(), least_distance: self.padded_distance(least) }
            }
            least => self.undecided(None, least.unwrap_or(f64::INFINITY)),
        }
    }

    /// The decision if both states are known and confirmed; a state that is not confirmed is forgotten.
    fn sometimes(&mut self, witnesses: &mut Witnesses) -> Option<Decision> {
        let links = self.problem.links.map(|link| link.link);
        let (colliding, free) = (witnesses.colliding.clone()?, witnesses.free.clone()?);
        let [colliding, free] =
            [colliding, free].map(|values| self.builder.state(&self.problem.path, &values));
        if self.builder.checker_collides(links, &colliding, self.checker_workspace) != Some(true) {
            witnesses.colliding = None;
            return None;
        }
        if self.builder.checker_collides(links, &free, self.checker_workspace) != Some(false) {
            witnesses.free = None;
            return None;
        }
        Some(Decision::Sometimes { colliding, free })
    }

    fn decide_free(&mut self, witnesses: &mut Witnesses, limits: ProofLimits) -> Decision {
        let least = |witnesses: &Witnesses| witnesses.least.as_ref().map_or(f64::INFINITY, |least| least.0);
        if self.problem.path.variables().len() <= MOST_VARIABLES {
            match never_proof::search(self.problem, limits, &mut self.workspace) {
                NeverSearch::Proven(tree) => {
                    let least_distance = self.padded_distance(least(witnesses));
                    return Decision::Never { proof: tree.text(), least_distance };
                }
                NeverSearch::Collision(values) => {
                    witnesses.colliding = Some(values.clone());
                    witnesses.least = Some((0.0, values));
                }
                NeverSearch::Exhausted { least: nearer, values } if nearer < least(witnesses) => {
                    witnesses.least = Some((nearer, values));
                }
                NeverSearch::Exhausted { .. } => {}
            }
        }
        let nearest = witnesses.least.as_ref();
        self.undecided(nearest.map(|(_, values)| values), least(witnesses))
    }

    fn decide_touching(&mut self, witnesses: &mut Witnesses, limits: ProofLimits) -> Decision {
        if self.problem.path.variables().len() > MOST_VARIABLES {
            return self.undecided(witnesses.colliding.as_ref(), 0.0);
        }
        let limits = ProofLimits { boxes: limits.boxes.min(MOST_CONTACT_BOXES), ..limits };
        let is_solid = self.builder.meshes_are_solid;
        match always_proof::search(self.problem, is_solid, limits, &mut self.workspace) {
            AlwaysSearch::Proven(evidence) => return Decision::Always { evidence: Box::new(evidence) },
            AlwaysSearch::Free(values) => witnesses.free = Some(values),
            AlwaysSearch::Exhausted => {}
        }
        self.undecided(witnesses.colliding.as_ref(), 0.0)
    }

    fn undecided(&self, values: Option<&Vec<f64>>, least_distance: f64) -> Decision {
        let bounded = self.problem.path.is_bounded();
        let state = values.map_or_else(Vec::new, |values| {
            if bounded { self.builder.state(&self.problem.path, values) } else { values.clone() }
        });
        Decision::Undecided { least_distance: self.padded_distance(least_distance), state }
    }

    /// A distance (m) with the paddings of the links subtracted, at least 0; `None` if it was not measured.
    fn padded_distance(&self, distance: f64) -> Option<f64> {
        Some((distance - self.problem.padding()).greater(0.0)).filter(|distance| distance.is_finite())
    }
}
