//! `clearance acm`: decides which pairs of links can collide, writes SRDF entries and certificates, audits an SRDF.

use std::collections::HashSet;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use clap::Args;
use clearance::collision_matrix::{
    AllowedPairs, DecidedPair, MatrixBuilder, MatrixDocument, MatrixOptions, SrdfEntry, add_disabled_pairs,
    audit,
};
use clearance::robot::quoted;
use clearance::robot::{LinkId, RobotModel};
use clearance::scene::{Scene, Settings, World};
use clearance_files::input_files::{self, DESCRIPTION_LIMIT, STATES_LIMIT};

use super::acm_output::{AcmOutput, AuditOutput};
use super::certificate_file;
use super::exit_status::ExitStatus;
use super::failure::Failure;
use super::matrix_verification;
use super::model_args::{ModelArgs, RobotArgs, link_pair, warn_of_meshes};
use super::output_files;
use super::progress::Progress;
use super::run_args::{Format, internal, positive, print_line, warn_of_padding};

/// Time between two writes of the file of --resume.
const SAVE_EVERY: Duration = Duration::from_secs(20);

/// Decide for every pair of links whether they can collide within the joint limits.
///
/// never: proven that the links do not collide in any state. always: proven that they collide in every state. sometimes: one colliding and
/// one free state, both confirmed by the checker. undecided: --deadline or --max-boxes was reached.
///
/// Exit codes: 0 every pair is decided; 1 a pair is undecided; 2 bad input. With --audit: 0 no entry is refuted; 1 an entry is refuted.
#[derive(Args)]
pub struct AcmArgs {
    #[command(flatten)]
    model: ModelArgs,

    /// Check the pairs that this SRDF disables: refute each "Never" that can collide, with a state
    #[arg(
        long,
        value_name = "SRDF",
        conflicts_with_all = ["srdf", "write_srdf", "certificate", "allow", "allow_adjacent"]
    )]
    audit: Option<PathBuf>,

    /// Add the pairs that never collide to this SRDF; all else in it stays. Without the file, --srdf is the original, or a new one is made
    #[arg(long, value_name = "SRDF")]
    write_srdf: Option<PathBuf>,

    /// Also write this pair, with the reason "User"; may be given more than once
    #[arg(long, value_name = "A,B", requires = "write_srdf")]
    allow: Vec<String>,

    /// Also write all links that are joined by a joint and touch in most states, with the reason "Adjacent"
    #[arg(long, requires = "write_srdf")]
    allow_adjacent: bool,

    /// Write the proofs to this file, for `clearance verify`
    #[arg(long, value_name = "FILE")]
    certificate: Option<PathBuf>,

    /// Read decided pairs from this file if it exists, and keep all decisions in it
    #[arg(long, value_name = "FILE")]
    resume: Option<PathBuf>,

    /// Time limit in seconds; the remaining pairs are undecided
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    deadline: Option<f64>,

    /// Largest number of boxes of joint positions for one pair
    #[arg(long, value_name = "N", default_value_t = MatrixOptions::MOST_BOXES)]
    max_boxes: u64,

    /// Number of threads [default: one for each processor]; without --deadline the result does not depend on it
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    threads: Option<u16>,

    /// List every pair, not only those that need attention
    #[arg(long)]
    list: bool,

    /// Output format
    #[arg(long, value_enum, default_value_t = Format::Text)]
    format: Format,
}

pub fn run(args: &AcmArgs) -> Result<ExitStatus, Failure> {
    args.deadline.map(|s| positive("--deadline", s)).transpose()?;
    let outputs = [&args.write_srdf, &args.certificate, &args.resume];
    output_files::check(&[], &outputs.map(Option::as_deref))?;
    args.certificate.as_deref().map(certificate_file::check).transpose()?;
    let robot = Arc::new(args.robot_args().load()?);
    let settings = args.model.settings();
    warn_of_padding(&settings, &Scene::default());
    warn_of_meshes(&robot, &World::default(), &settings);
    args.warn_of_srdf();
    let allowed = args.allowed(&robot)?;
    let known = args.known(&robot, &settings)?;
    let original = args.original_srdf(&robot)?;
    if let Some(original) = &original {
        args.reject_enabled(original)?;
    }
    let start = Instant::now();
    let (pairs, kept) = args.decide(&robot, &settings, &known)?;
    let seconds = start.elapsed().as_secs_f64();
    if args.audit.is_some() {
        let status = args.report_audit(&robot, &pairs, seconds)?;
        return kept.map(|()| status);
    }
    let document = MatrixDocument::new(&robot, &settings, pairs);
    if let Some(file) = &args.certificate {
        write_limited(file, &(document.certificate_json(&robot, &settings) + "\n"))?;
    }
    let written = args.write_srdf(&robot, original.as_ref(), &document.pairs, &allowed)?;
    let output = AcmOutput { document: &document, robot: &robot, seconds, written, lists_all: args.list };
    print_line(&match args.format {
        Format::Json => output.json(),
        Format::Text => output.text(),
    })?;
    kept?;
    let all_decided = document.pairs.iter().all(|pair| pair.decision.is_final());
    Ok(ExitStatus::of_answer(all_decided))
}

impl AcmArgs {
    /// The robot, with the SRDF that is audited.
    fn robot_args(&self) -> RobotArgs {
        let mut robot = self.model.robot.clone();
        robot.srdf = self.audit.clone().or(robot.srdf);
        robot
    }

    /// Warns if nothing is read from the file of --srdf.
    fn warn_of_srdf(&self) {
        let Some(srdf) = &self.model.robot.srdf else { return };
        match &self.write_srdf {
            None => log::warn!(
                "--srdf has no effect: all pairs are decided; give it as --audit to check its entries, or give --write-srdf, too"
            ),
            Some(file) if file != srdf && file.exists() => log::warn!(
                "--srdf has no effect: entries are added to {}, which exists, and not to a copy of {}",
                file.display(),
                srdf.display()
            ),
            Some(_) => {}
        }
    }

    /// Rejects a pair of --allow that the SRDF enables: no entry is added for it.
    fn reject_enabled(&self, original: &OriginalSrdf) -> Result<(), Failure> {
        let enabled = original.model.srdf().map_or(&[][..], |srdf| &srdf.enabled_pairs);
        for pair in &self.allow {
            let [a, b] = link_pair(&original.model, "--allow", pair)?;
            if enabled.contains(&(a, b)) || enabled.contains(&(b, a)) {
                return Err(Failure::Input(format!(
                    "--allow {pair}: {} enables this pair: remove its <enable_collisions>, or leave the pair out of --allow",
                    original.path.display()
                )));
            }
        }
        Ok(())
    }

    /// Pairs that are written although they can collide.
    fn allowed(&self, robot: &RobotModel) -> Result<AllowedPairs, Failure> {
        let mut allowed = AllowedPairs { adjacent: self.allow_adjacent, ..AllowedPairs::default() };
        for pair in &self.allow {
            let links = link_pair(robot, "--allow", pair)?;
            allowed.allow(robot, links).map_err(|why| Failure::Input(format!("--allow {pair}: {why}")))?;
        }
        Ok(allowed)
    }

    /// Decisions of an earlier run.
    fn known(&self, robot: &RobotModel, settings: &Settings) -> Result<Vec<DecidedPair>, Failure> {
        let Some(file) = self.resume.as_deref().filter(|file| file.exists()) else { return Ok(Vec::new()) };
        let text = input_files::read_text(file, STATES_LIMIT).map_err(Failure::input)?;
        let document = MatrixDocument::from_json(&text, robot, settings)
            .map_err(|why| Failure::Input(format!("{}: {why}", file.display())))?;
        // its decisions may be written to an SRDF
        matrix_verification::verify(robot, settings, &document.certificate(robot, settings))?.map_err(
            |why| {
                Failure::Input(format!(
                    "{}: a decision is not proven: {why}; remove the file",
                    file.display()
                ))
            },
        )?;
        Ok(document.pairs)
    }

    /// Decides all pairs, or those that the audited SRDF disables. Also returns whether the file of --resume holds these decisions, and all
    /// that it held before.
    fn decide(
        &self,
        robot: &Arc<RobotModel>,
        settings: &Settings,
        known: &[DecidedPair],
    ) -> Result<(Vec<DecidedPair>, Result<(), Failure>), Failure> {
        // a time that no clock reaches is no deadline
        let deadline =
            self.deadline.and_then(|s| Instant::now().checked_add(Duration::try_from_secs_f64(s).ok()?));
        let builder = MatrixBuilder::new(robot, settings).map_err(Failure::input)?;
        let disabled: HashSet<[LinkId; 2]> = match (&self.audit, robot.srdf()) {
            (Some(_), Some(srdf)) => {
                srdf.unchecked_pairs(robot.link_ids()).into_iter().map(|(a, b, _)| [a, b]).collect()
            }
            _ => HashSet::new(),
        };
        let wanted = |a: LinkId, b: LinkId| {
            self.audit.is_none() || disabled.contains(&[a, b]) || disabled.contains(&[b, a])
        };
        let options = MatrixOptions { most_boxes: self.max_boxes, deadline, ..MatrixOptions::default() };
        let count = if self.audit.is_some() { disabled.len() } else { builder.pair_count() };
        let progress = Progress::new(count);
        let saved = Mutex::new((Instant::now(), Vec::new()));
        let on_decided = |pair: &DecidedPair| {
            progress.piece_done();
            let Some(file) = &self.resume else { return };
            let Ok(mut saved) = saved.lock() else { return };
            saved.1.push(pair.clone());
            if saved.0.elapsed() > SAVE_EVERY {
                saved.0 = Instant::now();
                if let Err(failure) = save(file, robot, settings, with_known(&saved.1, known)) {
                    log::warn!("{failure}");
                }
            }
        };
        let threads = self.threads.map_or(0, usize::from);
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().map_err(internal)?;
        let pairs = pool.install(|| builder.decide_some(wanted, known, &options, &on_decided));
        let file = self.resume.as_deref();
        let kept = file.map_or(Ok(()), |file| save(file, robot, settings, with_known(&pairs, known)));
        Ok((pairs, kept))
    }

    fn report_audit(
        &self,
        robot: &RobotModel,
        pairs: &[DecidedPair],
        seconds: f64,
    ) -> Result<ExitStatus, Failure> {
        let audited = audit(robot, pairs);
        let output = AuditOutput { robot, audited: &audited, seconds, lists_all: self.list };
        print_line(&match self.format {
            Format::Json => output.json(),
            Format::Text => output.text(),
        })?;
        Ok(ExitStatus::of_answer(!output.is_refuted()))
    }

    /// The SRDF that entries are added to, read before anything is decided.
    fn original_srdf(&self, robot: &RobotModel) -> Result<Option<OriginalSrdf>, Failure> {
        let Some(file) = &self.write_srdf else { return Ok(None) };
        let original = if file.exists() { Some(file.as_path()) } else { self.model.robot.srdf.as_deref() };
        let Some(path) = original else { return Ok(None) };
        let text = input_files::read_text(path, DESCRIPTION_LIMIT).map_err(Failure::input)?;
        add_disabled_pairs(Some(&text), robot.name(), &[])
            .map_err(|why| Failure::Input(format!("{}: {why}", path.display())))?;
        // the entries of the original count, not those of --srdf
        let model = self.load_with_srdf(path)?;
        let of = model.srdf().map_or("", |srdf| &srdf.robot_name);
        if of != robot.name() {
            let [of, own] = [of, robot.name()].map(quoted);
            log::warn!("{}: it is the SRDF of robot {of}, and entries of {own} are added", path.display());
        }
        Ok(Some(OriginalSrdf { path: path.to_owned(), text, model }))
    }

    /// Writes the SRDF; returns the new entries.
    fn write_srdf(
        &self,
        robot: &RobotModel,
        original: Option<&OriginalSrdf>,
        pairs: &[DecidedPair],
        allowed: &AllowedPairs,
    ) -> Result<Vec<SrdfEntry>, Failure> {
        let Some(file) = &self.write_srdf else { return Ok(Vec::new()) };
        let entries = allowed.new_entries(pairs, original.map(|original| &original.model));
        let new = add_disabled_pairs(original.map(|original| &*original.text), robot.name(), &entries)
            .map_err(|why| Failure::Input(format!("{}: {why}", file.display())))?;
        input_files::replace(file, new.as_bytes()).map_err(Failure::input)?;
        Ok(entries)
    }

    fn load_with_srdf(&self, srdf: &Path) -> Result<RobotModel, Failure> {
        let robot = RobotArgs { srdf: Some(srdf.to_owned()), ..self.model.robot.clone() };
        robot.load_quietly(&robot.mesh_files())
    }
}

/// An SRDF that entries are added to.
struct OriginalSrdf {
    path: PathBuf,
    text: String,
    /// The robot with this SRDF.
    model: RobotModel,
}

/// These decisions, and the known ones about other pairs.
fn with_known(pairs: &[DecidedPair], known: &[DecidedPair]) -> Vec<DecidedPair> {
    let names: HashSet<[&str; 2]> = pairs.iter().map(|pair| [&*pair.link1, &*pair.link2]).collect();
    let is_new = |known: &&DecidedPair| {
        let (a, b) = (&*known.link1, &*known.link2);
        !names.contains(&[a, b]) && !names.contains(&[b, a])
    };
    pairs.iter().chain(known.iter().filter(is_new)).cloned().collect()
}

/// Writes the decisions so far.
fn save(
    file: &Path,
    robot: &RobotModel,
    settings: &Settings,
    pairs: Vec<DecidedPair>,
) -> Result<(), Failure> {
    write_limited(file, &(MatrixDocument::new(robot, settings, pairs).to_json() + "\n"))
}

/// Writes a text, if it is not longer than what is read.
fn write_limited(file: &Path, text: &str) -> Result<(), Failure> {
    if text.len() as u64 > STATES_LIMIT {
        let size = text.len() >> 20;
        let message = format!(
            "{}: {size} MiB of proofs are more than is read: give a smaller --max-boxes",
            file.display()
        );
        return Err(Failure::Input(message));
    }
    input_files::replace(file, text.as_bytes()).map_err(Failure::input)
}
