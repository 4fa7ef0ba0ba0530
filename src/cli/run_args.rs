//! Arguments that commands share: selection of pairs, threads and output format; helpers for values and output.

use clap::Args;
use clearance::checker::CollisionChecker;
use clearance::proximity::Work;
use clearance::scene::{Scene, Settings};
use serde::Serialize;

use super::failure::Failure;
use super::model_args::{self, ModelArgs, WorldArgs};

/// Which pairs are checked.
#[derive(Args, Clone, Copy, Debug)]
pub struct PairArgs {
    /// Leave out pairs of links
    #[arg(long)]
    pub no_self: bool,

    /// Leave out pairs of a link and an obstacle
    #[arg(long)]
    pub no_world: bool,
}

#[derive(Args, Clone, Copy, Debug)]
pub struct RunArgs {
    #[command(flatten)]
    pub pairs: PairArgs,

    /// Number of threads
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: u16,

    /// Output format
    #[arg(long, value_enum, default_value_t = Format::Text)]
    pub format: Format,

    /// Measure the time of this many passes over the inputs, on one thread
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = clap::value_parser!(u32).range(..=1_000_000))]
    pub repeat: u32,
}

#[derive(clap::ValueEnum, Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    Text,
    Json,
}

/// Counters of the work on all inputs.
#[derive(Serialize)]
pub struct Stats {
    volume_tests: u64,
    screened_pairs: u64,
    primitive_tests: u64,
}

impl PairArgs {
    /// Checker of a robot in its world, for the selected pairs.
    pub fn checker(self, model: &ModelArgs, world: &WorldArgs) -> Result<CollisionChecker, Failure> {
        let robot = model.robot.load()?;
        let loaded = world.load(&robot, &model.robot.mesh_files())?;
        let mut settings = model.settings();
        (settings.check_self, settings.check_world) = (!self.no_self, !self.no_world);
        warn_of_padding(&settings, &loaded);
        if self.no_self && !world.ignore.is_empty() {
            log::warn!("--ignore has no effect with --no-self");
        }
        model_args::checker(robot, &loaded, settings)
    }
}

/// Warns of paddings that change nothing.
pub fn warn_of_padding(settings: &Settings, scene: &Scene) {
    warn_of_pad_self(settings, scene);
    let without_world = match (settings.check_world, scene.world.is_empty()) {
        (false, _) => Some("--no-world is given"),
        (true, true) => Some("there is no world"),
        (true, false) => None,
    };
    let without_self = match (settings.check_self, settings.pad_self) {
        (false, _) => Some("--no-self is given"),
        (true, false) => Some("--pad-self is not given"),
        (true, true) => None,
    };
    if settings.padding > 0.0
        && let (Some(of_world), Some(of_self)) = (without_world, without_self)
    {
        log::warn!("--padding has no effect: {of_world}, and {of_self}");
    }
}

/// Warns if --pad-self changes nothing.
pub fn warn_of_pad_self(settings: &Settings, scene: &Scene) {
    if !settings.pad_self {
        return;
    }
    if !settings.check_self {
        log::warn!("--pad-self has no effect with --no-self");
    } else if settings.padding <= 0.0 && scene.link_padding.is_empty() {
        log::warn!("--pad-self has no effect without --padding");
    }
}

impl RunArgs {
    /// Thread pool of the requested size, but without more threads than inputs.
    pub fn pool(&self, inputs: usize) -> Result<rayon::ThreadPool, Failure> {
        let threads = usize::from(self.threads).min(inputs.max(1));
        rayon::ThreadPoolBuilder::new().num_threads(threads).build().map_err(internal)
    }
}

impl Stats {
    pub fn total(work: impl IntoIterator<Item = Work>) -> Self {
        let mut total = Work::default();
        for work in work {
            total += work;
        }
        let Work { volume_tests, screened_pairs, primitive_tests, .. } = total;
        Self { volume_tests, screened_pairs, primitive_tests }
    }
}

/// Checks that the value of an option is finite and positive.
pub fn positive(name: &str, value: f64) -> Result<f64, Failure> {
    let sound = value.is_finite() && value > 0.0;
    sound
        .then_some(value)
        .ok_or_else(|| Failure::Input(format!("{name} must be a finite number above zero, not {value}")))
}

/// Checks that the value of an option is a finite number of metres, zero or more.
pub fn not_negative(name: &str, value: f64) -> Result<f64, Failure> {
    let sound = value.is_finite() && value >= 0.0;
    sound.then_some(value).ok_or_else(|| {
        Failure::Input(format!("{name} is {value}, but must be a finite number of metres, zero or more"))
    })
}

/// Writes to stdout. A closed pipe is not an error.
pub fn print_line(line: &str) -> Result<(), Failure> {
    use std::io::Write;
    match writeln!(std::io::stdout().lock(), "{line}") {
        Err(e) if e.kind() != std::io::ErrorKind::BrokenPipe => Err(internal(e)),
        _ => Ok(()),
    }
}

pub fn internal(error: impl std::fmt::Display) -> Failure {
    Failure::Internal(error.to_string())
}
