//! Commands of the `clearance` program: argument parser, dispatch and exit codes.
//!
//! Exit codes: 0: everything in the query is free; 1: completed, and something is not free; 2: bad input; 3: internal error.
//! The node also has 4: ended as requested, but by force or with an incomplete recording; and 5: more memory than
//! `memory_limit`.

mod acm;
mod acm_output;
mod assignments;
mod bench;
mod certificate_file;
mod certificate_summary;
mod check;
mod check_contacts;
mod check_gradient;
mod check_output;
#[cfg(feature = "ros")]
mod demo;
#[cfg(feature = "ros")]
mod demo_table;
#[cfg(feature = "ros")]
mod doctor;
mod exit_status;
mod failure;
mod lint;
mod matrix_verification;
mod meshes;
mod model_args;
mod motion;
mod motion_args;
mod motion_clearance;
#[cfg(feature = "ros")]
mod node;
mod output_files;
mod plan;
mod progress;
#[cfg(feature = "ros")]
mod recorded_arguments;
mod recover;
#[cfg(feature = "ros")]
mod replay;
mod rounded_bounds;
mod run_args;
mod shapes;
mod spheres;
mod state_args;
mod state_files;
mod states;
mod summary;
mod timing;
mod verify;
mod view;
#[cfg(feature = "ros")]
mod view_args;

use std::ffi::OsString;

use clap::error::{ContextKind, ContextValue, ErrorKind};
use clap::{Parser, Subcommand};
use clearance_files::readable_text::on_one_line;
use log::LevelFilter;

use failure::Failure;

pub use exit_status::ExitStatus;

/// Does this robot hit itself or its surroundings, and how far is it from doing so?
///
/// Without a command: the ROS 2 node on the built-in demo robot, with a live table in the terminal.
#[derive(Parser)]
#[command(version, about, long_about, max_term_width = 100, subcommand_precedence_over_arg = true)]
struct Arguments {
    /// Least severe level of messages on stderr: off, error, warn, info, debug or trace [default: info for the node, error for the demo and
    /// for replay, else warn]
    #[arg(long, global = true, value_name = "LEVEL")]
    log_level: Option<LevelFilter>,

    #[cfg(feature = "ros")]
    #[command(flatten)]
    view: view_args::ViewArgs,

    #[command(subcommand)]
    command: Option<Command>,
}

#[derive(Subcommand)]
enum Command {
    /// Check states of a robot for collisions, or compute distances
    Check(check::CheckArgs),
    /// Check motions between configurations: proven free, contact, or undecided with the reason
    Motion(Box<motion::MotionArgs>),
    /// Find a free state near a state that collides, and a motion to it that is proven free after its first exit
    Recover(Box<recover::RecoverArgs>),
    /// Search a path between two states whose edges are proven free
    Plan(Box<plan::PlanArgs>),
    /// Decide for every pair of links whether they can collide within the joint limits: proofs for a collision matrix
    Acm(Box<acm::AcmArgs>),
    /// Cover the links of a robot with spheres that are proven to contain them
    Spheres(Box<spheres::SpheresArgs>),
    /// Verify a certificate that a motion is free, with code that is independent of the checker
    Verify(Box<verify::VerifyArgs>),
    /// Find defects of a robot's geometry, and compare its collision with its visual geometry
    Lint(lint::LintArgs),
    /// Show a robot and its world in a web browser, with a slider for each joint
    View(Box<view::ViewCommandArgs>),
    /// Measure the time of checks of a robot in a world, and compare broad-phase structures
    Bench(bench::BenchArgs),
    /// Run the ROS 2 node: subscribes to joint states, publishes collisions and distances
    #[cfg(feature = "ros")]
    Node(Box<node::NodeArgs>),
    /// Find faults of this machine and of the ROS topics when the node does not work
    #[cfg(feature = "ros")]
    Doctor(doctor::DoctorArgs),
    /// Replay a recording of the node without a network, and report the first result that differs
    #[cfg(feature = "ros")]
    Replay(replay::ReplayArgs),
}

/// Runs the program with its name and arguments. Every error is printed as one message on stderr.
pub fn run(command_line: &[OsString]) -> ExitStatus {
    let arguments = match Arguments::try_parse_from(command_line) {
        Ok(arguments) => arguments,
        Err(error) => return reject(&error, command_line),
    };
    match dispatch(arguments) {
        Ok(code) => code,
        Err(failure) => {
            eprintln!("clearance: {failure}");
            failure.exit_code()
        }
    }
}

/// Prints the error of the command line, on one line for frequent mistakes.
fn reject(error: &clap::Error, command_line: &[OsString]) -> ExitStatus {
    let stray = match (error.kind(), error.get(ContextKind::InvalidArg)) {
        (ErrorKind::UnknownArgument, Some(ContextValue::String(stray))) => Some(stray),
        _ => None,
    };
    let given: Vec<String> = command_line.iter().map(|a| a.to_string_lossy().into_owned()).collect();
    if let Some(hint) = stray.and_then(|stray| assignments::unquoted(&given, stray)) {
        eprintln!("clearance: {hint}");
        return ExitStatus::INVALID_INPUT;
    }
    // a closed pipe is not an error
    let _ = error.print();
    if error.use_stderr() { ExitStatus::INVALID_INPUT } else { ExitStatus::SUCCESS }
}

fn dispatch(arguments: Arguments) -> Result<ExitStatus, Failure> {
    #[cfg(feature = "ros")]
    if arguments.command.is_some() && arguments.view.is_given() {
        return Err(Failure::Input("--view stands after the command: clearance node --view".to_owned()));
    }
    match arguments.command {
        Some(Command::Check(args)) => {
            log_to_stderr(arguments.log_level.unwrap_or(LevelFilter::Warn));
            check::run(&args)
        }
        Some(Command::Motion(args)) => {
            log_to_stderr(arguments.log_level.unwrap_or(LevelFilter::Warn));
            motion::run(&args)
        }
        Some(Command::Recover(args)) => {
            log_to_stderr(arguments.log_level.unwrap_or(LevelFilter::Warn));
            recover::run(&args)
        }
        Some(Command::Plan(args)) => {
            log_to_stderr(arguments.log_level.unwrap_or(LevelFilter::Warn));
            plan::run(&args)
        }
        Some(Command::Acm(args)) => {
            log_to_stderr(arguments.log_level.unwrap_or(LevelFilter::Warn));
            acm::run(&args)
        }
        Some(Command::Spheres(args)) => {
            log_to_stderr(arguments.log_level.unwrap_or(LevelFilter::Warn));
            spheres::run(&args)
        }
        Some(Command::Verify(args)) => {
            log_to_stderr(arguments.log_level.unwrap_or(LevelFilter::Warn));
            verify::run(&args)
        }
        Some(Command::Lint(args)) => {
            log_to_stderr(arguments.log_level.unwrap_or(LevelFilter::Warn));
            lint::run(&args)
        }
        Some(Command::View(args)) => {
            log_to_stderr(arguments.log_level.unwrap_or(LevelFilter::Warn));
            view::run(&args)
        }
        Some(Command::Bench(args)) => {
            log_to_stderr(arguments.log_level.unwrap_or(LevelFilter::Warn));
            bench::run(&args)
        }
        #[cfg(feature = "ros")]
        Some(Command::Node(args)) => node::run(&args, arguments.log_level.unwrap_or(LevelFilter::Info)),
        #[cfg(feature = "ros")]
        Some(Command::Doctor(args)) => doctor::run(&args, arguments.log_level.unwrap_or(LevelFilter::Warn)),
        #[cfg(feature = "ros")]
        Some(Command::Replay(args)) => {
            log_to_stderr(arguments.log_level.unwrap_or(LevelFilter::Error));
            replay::run(&args)
        }
        #[cfg(feature = "ros")]
        None => demo::run(arguments.view, arguments.log_level.unwrap_or(LevelFilter::Error)),
        #[cfg(not(feature = "ros"))]
        None => Err(Failure::Input("this build has no ROS 2 node: name a command (see --help)".to_owned())),
    }
}

fn log_to_stderr(level: LevelFilter) {
    let logger =
        env_logger::Builder::new().filter_level(level).format_timestamp(None).format_target(false).build();
    let most = logger.filter();
    if log::set_boxed_logger(Box::new(Readable(logger))).is_ok() {
        log::set_max_level(most);
    }
}

/// Logger that escapes terminal control characters: names in the input may contain them.
struct Readable(env_logger::Logger);

impl log::Log for Readable {
    fn enabled(&self, metadata: &log::Metadata) -> bool {
        self.0.enabled(metadata)
    }

    fn log(&self, record: &log::Record) {
        if self.0.matches(record) {
            let text = record.args().to_string();
            let text = on_one_line(&text);
            let metadata = record.metadata().clone();
            self.0.log(&log::Record::builder().metadata(metadata).args(format_args!("{text}")).build());
        }
    }

    fn flush(&self) {
        self.0.flush();
    }
}
