//! `clearance verify` for certificates of a collision matrix.

use std::path::Path;

use clearance::robot::RobotModel;
use clearance::scene::Settings;
use clearance::verifier::{MatrixCertificate, MatrixRejection, MatrixVerifier};
use clearance_files::input_files::{self, STATES_LIMIT};
use clearance_files::readable_text::on_one_line;
use rayon::prelude::*;
use serde::Deserialize;
use serde_json::json;

use super::exit_status::ExitStatus;
use super::failure::Failure;
use super::progress::Progress;
use super::run_args::{Format, print_line};

/// The only field that all certificates have in common.
#[derive(Deserialize)]
struct Head {
    format: String,
}

impl Head {
    /// Whether the file holds the decisions of a search that can be resumed.
    fn is_of_search(&self) -> bool {
        let version = self.format.strip_prefix("clearance collision matrix ");
        version.is_some_and(|version| !version.starts_with("certificate"))
    }
}

/// Reads a certificate of a collision matrix; `None` if the file is another certificate.
pub fn read(file: &Path) -> Result<Option<MatrixCertificate>, Failure> {
    let text = input_files::read_text(file, STATES_LIMIT).map_err(Failure::input)?;
    let head = serde_json::from_str::<Head>(&text).ok();
    if head.as_ref().is_some_and(Head::is_of_search) {
        let why = "this is the file of `clearance acm --resume`, and no certificate: write one with clearance acm --certificate";
        return Err(Failure::Input(format!("{}: {why}", file.display())));
    }
    let is_matrix = |head: &Head| head.format.starts_with("clearance collision matrix certificate");
    let Some(Head { format }) = head.filter(is_matrix) else { return Ok(None) };
    if format != MatrixCertificate::FORMAT {
        return Err(Failure::Input(format!(
            "{}: its format is '{}', not '{}': write it again with clearance acm --certificate",
            file.display(),
            on_one_line(&format),
            MatrixCertificate::FORMAT
        )));
    }
    let rejected = |e: serde_json::Error| {
        let why = e.to_string();
        Failure::Input(format!("{}: this is no certificate: {}", file.display(), on_one_line(&why)))
    };
    serde_json::from_str(&text).map(Some).map_err(rejected)
}

/// A certificate of a matrix proves no motion, and nothing of a world. Exit code 1.
pub fn reject_for_motion(format: Format) -> Result<ExitStatus, Failure> {
    let reason = "this is the certificate of a collision matrix: it proves nothing about a motion, a world, a tolerance or a margin; \
                  verify it with the robot alone";
    print_line(&match format {
        Format::Text => format!("NOT PROVEN: {reason}"),
        Format::Json => json!({"verified": false, "reason": reason}).to_string(),
    })?;
    Ok(ExitStatus::NEGATIVE)
}

/// Verifies every proof, on all processors. Exit code 0: all hold; 1: one does not, and the reason is printed.
pub fn run(
    robot: &RobotModel,
    settings: &Settings,
    certificate: &MatrixCertificate,
    format: Format,
) -> Result<ExitStatus, Failure> {
    let verified = verify(robot, settings, certificate)?;
    if certificate.pairs.is_empty() && certificate.always.is_empty() {
        log::warn!("the certificate claims nothing: it has no pair");
    }
    let is_proven = verified.is_ok();
    print_line(&match (format, verified) {
        (Format::Text, Ok(boxes)) => format!(
            "proven: {} pairs of links of '{}' never collide within the joint limits, {} always; {boxes} boxes hold",
            certificate.pairs.len(),
            robot.name(),
            certificate.always.len()
        ),
        (Format::Text, Err(rejection)) => format!("NOT PROVEN: {}", on_one_line(&rejection.to_string())),
        (Format::Json, Ok(boxes)) => {
            let never = certificate.pairs.iter().map(|pair| [&pair.link1, &pair.link2]).collect::<Vec<_>>();
            let always = certificate.always.iter().map(|pair| [&pair.link1, &pair.link2]).collect::<Vec<_>>();
            json!({"verified": true, "never": never, "always": always, "boxes": boxes}).to_string()
        }
        (Format::Json, Err(rejection)) => {
            json!({"verified": false, "reason": rejection.to_string()}).to_string()
        }
    })?;
    Ok(ExitStatus::of_answer(is_proven))
}

/// The number of proven boxes.
pub fn verify(
    robot: &RobotModel,
    settings: &Settings,
    certificate: &MatrixCertificate,
) -> Result<Result<u64, MatrixRejection>, Failure> {
    let verifier = MatrixVerifier::new(robot, settings).map_err(Failure::input)?;
    if let Err(rejection) = verifier.check_subject(certificate) {
        return Ok(Err(rejection));
    }
    let progress = Progress::new(certificate.pairs.len() + certificate.always.len());
    let counted = |verified| {
        progress.piece_done();
        verified
    };
    let never = certificate.pairs.par_iter().with_max_len(1).map(|proof| verifier.verify_pair(proof));
    let always = certificate.always.par_iter().with_max_len(1).map(|proof| verifier.verify_always(proof));
    let verified: Vec<Result<u64, MatrixRejection>> = never.chain(always).map(counted).collect();
    Ok(verified.into_iter().sum())
}
