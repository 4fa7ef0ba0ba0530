//! `clearance check`: reads states, reports collisions and distances.

use std::time::Instant;

use clap::Args;
use clearance::checker::{CollisionChecker, CollisionReport, ConstantContacts, Question, Workspace};
use clearance::robot::Configuration;
use clearance::scene::BodyId;
use rayon::prelude::*;

use super::check_contacts::{ContactArgs, ContactResult};
use super::check_gradient::{self, GradientResult};
use super::check_output::{CheckOutput, StateResult, text};
use super::exit_status::ExitStatus;
use super::failure::Failure;
use super::model_args::{ModelArgs, WorldArgs};
use super::progress::Progress;
use super::run_args::{Format, RunArgs, Stats, internal, print_line};
use super::state_args::StateArgs;
use super::timing::{self, Timing};

/// Number of states that are compared at once, before it is decided whether more are needed.
const STATES_AT_ONCE: usize = 64;

#[derive(Args)]
pub struct CheckArgs {
    #[command(flatten)]
    model: ModelArgs,

    #[command(flatten)]
    world: WorldArgs,

    #[command(flatten)]
    input: StateArgs,

    /// Query on each state [default: free, or pairs with --contacts]
    #[arg(long, value_enum)]
    query: Option<Query>,

    #[command(flatten)]
    contacts: ContactArgs,

    /// With --query distance and pair-distances: largest distance in metres that is reported [default: no limit]
    #[arg(
        long,
        value_name = "M",
        default_value_t = f64::INFINITY,
        hide_default_value = true,
        allow_negative_numbers = true
    )]
    limit: f64,

    /// With --query pair-distances: also signed distances, normals and witness points of the pairs, and derivatives with respect to each
    /// joint
    #[arg(long)]
    gradient: bool,

    #[command(flatten)]
    run: RunArgs,
}

#[derive(clap::ValueEnum, Clone, Copy, PartialEq, Eq)]
pub enum Query {
    /// Whether the state is free; stops at the first collision
    Free,
    /// All colliding pairs
    Pairs,
    /// The smallest distance of the robot from itself, and that from the world, with their pairs and witness points
    Distance,
    /// The distance of every pair, and the same
    PairDistances,
}

pub fn run(args: &CheckArgs) -> Result<ExitStatus, Failure> {
    if args.limit.is_nan() || args.limit < 0.0 {
        return Err(Failure::Input("--limit must be zero or more metres".to_owned()));
    }
    if args.limit < f64::INFINITY && matches!(args.query(), Query::Free | Query::Pairs) {
        let why = "--limit needs distances: give --query distance or pair-distances";
        return Err(Failure::Input(why.to_owned()));
    }
    if args.contacts.contacts.is_some() && args.query() != Query::Pairs {
        let why = "--contacts needs all colliding pairs: leave --query out, or give --query pairs";
        return Err(Failure::Input(why.to_owned()));
    }
    if args.gradient && args.query() != Query::PairDistances {
        return Err(Failure::Input("--gradient needs --query pair-distances".to_owned()));
    }
    let start = Instant::now();
    let checker = args.run.pairs.checker(&args.model, &args.world)?;
    let load_seconds = start.elapsed().as_secs_f64();
    let robot = checker.robot();
    let states = args.input.read(robot)?;
    if checker.pairs().is_empty() {
        log::warn!("there is no pair to check: every state counts as free");
    }
    if let Some(note) = robot.limits_note("state", states.iter().map(|q| [q])) {
        log::warn!("{note}");
    }
    let question = args.question();
    let reports = check_all(&checker, &states, question, &args.run)?;
    if let Some(remark) = constant_contacts(&checker, &states, &reports, args)? {
        log::warn!("{remark}. {ADVICE}");
    } else if let Some(remark) = frequent_contact(&checker, &states, &reports) {
        log::warn!("{remark}. {ADVICE}");
    }
    let details = Details {
        contacts: args.contacts.of_states(&checker, &states, &reports, &args.run)?,
        gradients: args.gradients(&checker, &states)?,
    };
    let timing = time_passes(&checker, &states, args);
    let output = CheckOutput {
        robot: robot.name().to_owned(),
        joints: robot.position_names().to_vec(),
        pairs_checked: checker.pairs().len(),
        load_seconds,
        stats: Stats::total(reports.iter().map(|report| report.work)),
        results: results(&reports, details, args.query(), &checker),
        timing,
    };
    match args.run.format {
        Format::Json => print_line(&serde_json::to_string(&output).map_err(internal)?)?,
        Format::Text => print_line(&text(&output, &checker))?,
    }
    let all_free = reports.iter().all(CollisionReport::is_free);
    Ok(ExitStatus::of_answer(all_free))
}

/// Contacts and derivatives by state, where they were requested.
struct Details {
    contacts: Option<Vec<Vec<ContactResult>>>,
    gradients: Option<Vec<GradientResult>>,
}

fn results(
    reports: &[CollisionReport],
    details: Details,
    query: Query,
    checker: &CollisionChecker,
) -> Vec<StateResult> {
    let mut results: Vec<StateResult> =
        reports.iter().map(|report| StateResult::new(query, report, checker)).collect();
    for (result, contacts) in results.iter_mut().zip(details.contacts.into_iter().flatten()) {
        result.contacts = Some(contacts);
    }
    for (result, gradient) in results.iter_mut().zip(details.gradients.into_iter().flatten()) {
        result.gradient = Some(gradient);
    }
    results
}

impl CheckArgs {
    fn query(&self) -> Query {
        let default = if self.contacts.contacts.is_some() { Query::Pairs } else { Query::Free };
        self.query.unwrap_or(default)
    }

    fn question(&self) -> Question {
        let limit = self.limit;
        match self.query() {
            Query::Free => Question::Free,
            Query::Pairs => Question::Pairs,
            Query::Distance => Question::SelfAndWorldDistance { limit },
            Query::PairDistances => Question::PairDistances { limit },
        }
    }

    /// The derivatives of each state, if they are requested.
    fn gradients(
        &self,
        checker: &CollisionChecker,
        states: &[Configuration],
    ) -> Result<Option<Vec<GradientResult>>, Failure> {
        if !self.gradient {
            return Ok(None);
        }
        let found = check_gradient::clearances(checker, states, self.limit, &self.run)?;
        Ok(Some(found.iter().map(|clearance| GradientResult::new(clearance, checker)).collect()))
    }

    /// The question of the timed passes: for distances, only the least distance of all pairs.
    fn timed_question(&self) -> Question {
        match self.question() {
            Question::SelfAndWorldDistance { limit } => Question::Distance { limit },
            question => question,
        }
    }
}

/// One report per state, in the order of the states, independent of the number of threads.
fn check_all(
    checker: &CollisionChecker,
    states: &[Configuration],
    question: Question,
    run: &RunArgs,
) -> Result<Vec<CollisionReport>, Failure> {
    let progress = Progress::new(states.len());
    let pool = run.pool(states.len())?;
    Ok(pool.install(|| {
        (states.par_iter())
            .map_init(
                || checker.workspace(),
                |workspace, q| {
                    let report = checker.check(q, question, workspace);
                    progress.piece_done();
                    report
                },
            )
            .collect()
    }))
}

/// Advice for pairs that always touch.
const ADVICE: &str = "`clearance acm` decides which pairs can collide and writes an SRDF; --ignore A,B leaves a pair out for a trial";

/// Random states at which pairs of a few colliding states are tried.
const TRIALS: usize = 50;

/// Remark about a link pair that collides in the few given states, and in many random states, too.
fn frequent_contact(
    checker: &CollisionChecker,
    states: &[Configuration],
    reports: &[CollisionReport],
) -> Option<String> {
    if states.len() >= ConstantContacts::FEWEST_STATES || reports.iter().any(CollisionReport::is_free) {
        return None;
    }
    let (robot, mut workspace) = (checker.robot(), checker.workspace());
    let mut of_links = |q: &Configuration| -> Vec<(BodyId, BodyId)> {
        let pairs = checker.check(q, Question::Pairs, &mut workspace).colliding_pairs;
        pairs.into_iter().filter(|(a, b)| [a, b].iter().all(|id| matches!(id, BodyId::Link(_)))).collect()
    };
    let mut touching = of_links(states.first()?);
    let mut random = fastrand::Rng::with_seed(1);
    for _ in 0..TRIALS {
        if touching.is_empty() {
            return None;
        }
        let here = of_links(&robot.random_configuration(&mut random));
        touching.retain(|pair| here.contains(pair));
    }
    let (a, b) = *touching.first()?;
    let [a, b] = [a, b].map(|body| checker.body_name(body));
    let more = match touching.len() {
        1 => String::new(),
        pairs => format!(" (and {} more pairs)", pairs - 1),
    };
    Some(format!("links '{a}' and '{b}'{more} touch in {TRIALS} of {TRIALS} random states, too"))
}

/// Remark about link pairs that are in contact in all states, if every state collides and there are enough states.
fn constant_contacts(
    checker: &CollisionChecker,
    states: &[Configuration],
    reports: &[CollisionReport],
    args: &CheckArgs,
) -> Result<Option<String>, Failure> {
    if states.len() < ConstantContacts::FEWEST_STATES || reports.iter().any(CollisionReport::is_free) {
        return Ok(None);
    }
    let mut contacts = ConstantContacts::default();
    let pool = args.run.pool(states.len())?;
    for (states, reports) in states.chunks(STATES_AT_ONCE).zip(reports.chunks(STATES_AT_ONCE)) {
        // other queries do not report all pairs
        let pairs = |workspace: &mut Workspace, q: &Configuration, report: &CollisionReport| {
            if args.query() == Query::Pairs {
                return report.colliding_pairs.clone();
            }
            checker.check(q, Question::Pairs, workspace).colliding_pairs
        };
        let all: Vec<Vec<(BodyId, BodyId)>> = pool.install(|| {
            let each = states.par_iter().zip(reports);
            each.map_init(|| checker.workspace(), |workspace, (q, report)| pairs(workspace, q, report))
                .collect()
        });
        states.iter().zip(&all).for_each(|(q, pairs)| contacts.add(q, pairs));
        if !contacts.is_open() {
            return Ok(None);
        }
    }
    Ok(contacts.remark(&format!("all {} states", states.len()), checker))
}

fn time_passes(checker: &CollisionChecker, states: &[Configuration], args: &CheckArgs) -> Option<Timing> {
    let (question, mut workspace) = (args.timed_question(), checker.workspace());
    timing::measure(args.run.repeat, states.len(), || {
        for q in states {
            if args.gradient {
                std::hint::black_box(checker.clearance(q, args.limit, &mut workspace));
            } else if question == Question::Free {
                std::hint::black_box(checker.is_free(q, &mut workspace));
            } else {
                std::hint::black_box(checker.check(q, question, &mut workspace));
            }
        }
    })
}
