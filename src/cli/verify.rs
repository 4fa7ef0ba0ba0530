//! `clearance verify`: is a certificate a proof?

use std::path::PathBuf;
use std::process::ExitCode;

use clap::Args;
use clearance::input_files::{self, STATES_LIMIT};
use clearance::motion::{Certificate, SegmentText};
use clearance::verifier::{self, Verified};
use serde_json::json;

use super::failure::Failure;
use super::model::{ModelArgs, WorldArgs, warn_of_meshes};
use super::run_args::{Format, PairArgs, print_line};

#[derive(Args)]
pub struct VerifyArgs {
    #[command(flatten)]
    model: ModelArgs,

    #[command(flatten)]
    world: WorldArgs,

    /// What `clearance motion --certificate` wrote
    #[arg(value_name = "CERTIFICATE.json")]
    certificate: PathBuf,

    #[command(flatten)]
    pairs: PairArgs,

    /// Obstacles may move as the certificate says
    #[arg(long)]
    moving_obstacles: bool,

    /// How the answer is written
    #[arg(long, value_enum, default_value_t = Format::Text)]
    format: Format,
}

/// Exit code 0: it is a proof; 1: it is none, and why.
pub fn run(args: &VerifyArgs) -> Result<ExitCode, Failure> {
    let robot = args.model.load()?;
    let loaded = args.world.load(&robot, &args.model.mesh_files())?;
    let mut settings = args.model.settings();
    (settings.check_self, settings.check_world) = (!args.pairs.no_self, !args.pairs.no_world);
    loaded.add_to(&mut settings);
    warn_of_meshes(&robot, &loaded.world, &settings);
    let file = args.certificate.display();
    let text = input_files::read_text(&args.certificate, STATES_LIMIT).map_err(Failure::input)?;
    let certificate: Certificate = serde_json::from_str(&text)
        .map_err(|e| Failure::Input(format!("{file}: this is no certificate: {e}")))?;
    let movers = certificate.segments.iter().flat_map(|s| &s.motion.obstacles);
    if let Some(mover) = movers.into_iter().find(|_| !args.moving_obstacles) {
        let name = &mover.name;
        return Err(Failure::Input(format!(
            "{file}: the proof supposes that obstacle '{name}' moves; say --moving-obstacles if it does"
        )));
    }
    let verified = verifier::verify(&robot, &loaded.world, &settings, loaded.allowed.as_ref(), &certificate);
    if verified.as_ref().is_ok_and(|v| v.pairs == 0) {
        log::warn!("there is no pair to check: every motion counts as free");
    }
    match (args.format, &verified) {
        (Format::Text, Ok(Verified { segments, pairs, proofs, .. })) => print_line(&format!(
            "proven free: {proofs} proofs for {pairs} pairs in {segments} segment(s) hold\n{}",
            ends(&certificate)
        ))?,
        (Format::Text, Err(refusal)) => print_line(&format!("NOT PROVEN: {refusal}"))?,
        (Format::Json, Ok(v)) => print_line(
            &json!({"verified": true, "segments": v.segments, "pairs": v.pairs, "proofs": v.proofs})
                .to_string(),
        )?,
        (Format::Json, Err(refusal)) => {
            print_line(&json!({"verified": false, "reason": refusal.to_string()}).to_string())?;
        }
    }
    Ok(ExitCode::from(u8::from(verified.is_err())))
}

/// Which motion it is about.
fn ends(certificate: &Certificate) -> String {
    let end = |text: Option<&SegmentText>, last: bool| -> String {
        let Some(text) = text else { return String::new() };
        let polynomials = text
            .polynomials
            .as_ref()
            .map(|all| all.iter().map(|p| if last { p.iter().sum() } else { p[0] }).collect::<Vec<f64>>());
        let straight = if last { text.to.clone() } else { text.from.clone() };
        let positions = straight.or(polynomials).unwrap_or_default();
        let named = certificate.joints.iter().zip(&positions).map(|(joint, q)| format!("{joint}={q}"));
        named.collect::<Vec<_>>().join(" ")
    };
    let segments = &certificate.segments;
    let from = end(segments.first().map(|s| &s.motion), false);
    let to = end(segments.last().map(|s| &s.motion), true);
    format!("from {from}\nto   {to}")
}
