//! `clearance replay`: runs a recording of the node again, without a network, and compares the results.

use std::path::{Path, PathBuf};

use clap::Args;
use clearance_ros::{Archive, Outcome, save_part};

use super::exit_status::ExitStatus;
use super::failure::Failure;
use super::recorded_arguments::prepare;
use super::run_args::{Format, internal, print_line};

/// Number of results before the different one to keep in a test; the smallest that reproduces the difference is used.
const KEPT: [u64; 4] = [1, 10, 100, u64::MAX];

/// Replays a recording and compares every result bit by bit, except computation times.
///
/// Exit codes: 0 all results are the same; 1 one differs, or there is nothing to compare; 2 the recording cannot be read.
#[derive(Args)]
pub struct ReplayArgs {
    /// MCAP file written by `clearance node --record FILE`
    #[arg(value_name = "FILE")]
    file: PathBuf,

    /// If a result differs, save the part of the recording that reproduces it to DIR, as a test like those in tests/replays
    #[arg(long, value_name = "DIR")]
    save_test: Option<PathBuf>,

    /// Output format
    #[arg(long, value_enum, default_value_t = Format::Text)]
    format: Format,
}

pub fn run(args: &ReplayArgs) -> Result<ExitStatus, Failure> {
    let outcome = replay(&args.file)?;
    let saved = match (&outcome.difference, &args.save_test) {
        (Some(_), Some(folder)) => Some(save_test(&args.file, folder, &outcome)?),
        _ => None,
    };
    match args.format {
        Format::Json => print_line(&serde_json::to_string(&outcome).map_err(internal)?)?,
        Format::Text => print_outcome(&args.file, &outcome)?,
    }
    match (saved, &args.save_test) {
        (Some(file), _) => eprintln!("saved: {}", file.display()),
        (None, Some(folder)) => {
            eprintln!("nothing is saved to {}: no result differs", folder.display());
        }
        (None, None) => {}
    }
    let is_same = outcome.difference.is_none() && outcome.lost.is_none() && outcome.same > 0;
    Ok(ExitStatus::of_answer(is_same))
}

/// Runs a recording again.
fn replay(file: &Path) -> Result<Outcome, Failure> {
    let archive = Archive::read(file).map_err(Failure::input)?;
    if archive.version != env!("CARGO_PKG_VERSION") {
        log::warn!("{}: version {} recorded it", file.display(), archive.version);
    }
    let prepared = prepare(archive).map_err(|why| Failure::Input(format!("{}: {why}", file.display())))?;
    clearance_ros::replay(file, prepared).map_err(Failure::input)
}

fn print_outcome(file: &Path, outcome: &Outcome) -> Result<(), Failure> {
    let (file, same) = (file.display(), outcome.same);
    if let Some(difference) = &outcome.difference {
        let (answer, seconds, nanoseconds) =
            (difference.answer, difference.time / 1_000_000_000, difference.time % 1_000_000_000);
        print_line(&format!(
            "answer {answer} at {seconds}.{nanoseconds:09} differs: {}\n  recorded: {}\n  replayed: {}",
            difference.field, difference.recorded, difference.replayed
        ))?;
    }
    if let Some(steps) = outcome.lost {
        print_line(&format!("the recorder lost {steps} steps here: what follows can not be run again"))?;
    }
    if outcome.cut_off {
        print_line("the file was not finished: what it holds was run")?;
    }
    if outcome.late > 0 {
        print_line(&format!(
            "{} answers lacked pairs at check_deadline: of these, is_free and speed_scale were compared",
            outcome.late
        ))?;
    }
    print_line(&format!("{file}: {same} answers are as recorded"))
}

/// Saves the part of a recording that reproduces the difference.
fn save_test(file: &Path, folder: &Path, outcome: &Outcome) -> Result<PathBuf, Failure> {
    let input_failure = |error: std::io::Error| Failure::Input(format!("{}: {error}", folder.display()));
    let Some(difference) = &outcome.difference else {
        return Err(Failure::Internal("there is no difference to save".to_owned()));
    };
    let to = folder.join("recording.mcap");
    if to.exists() {
        return Err(Failure::Input(format!("{}: is there already", to.display())));
    }
    std::fs::create_dir_all(folder).map_err(input_failure)?;
    for kept in KEPT {
        save_part(file, &to, difference.answer, kept).map_err(Failure::input)?;
        let shown = replay(&to)?.difference;
        let shows = |shown: &clearance_ros::Difference| {
            (&shown.field, &shown.recorded, &shown.replayed)
                == (&difference.field, &difference.recorded, &difference.replayed)
        };
        if shown.as_ref().is_some_and(shows) {
            return Ok(to);
        }
        std::fs::remove_file(&to).map_err(input_failure)?;
    }
    Err(Failure::Internal("no part of the recording shows the difference again".to_owned()))
}
