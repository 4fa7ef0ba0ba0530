//! `clearance verify`: checks whether a certificate is a proof, and for which motion.

use std::path::PathBuf;
use std::process::ExitCode;

use clap::Args;
use clearance::input_files::{self, STATES_LIMIT};
use clearance::motion::{Certificate, Trajectory};
use clearance::robot::RobotModel;
use clearance::scene::Settings;
use clearance::scene::World;
use clearance::verifier::{ExpectedMotion, Rejection, VerificationStatistics, Verifier};
use serde_json::json;

use super::certificate_summary::{Summary, on_one_line};
use super::failure::Failure;
use super::model::{ModelArgs, WorldArgs, warn_of_meshes};
use super::run_args::{Format, PairArgs, positive, print_line};
use super::way::WayArgs;

/// Check a certificate that a motion is free, with code that shares nothing with what wrote it.
///
/// A certificate proves one motion, with one tracking tolerance, among obstacles that stand or move in one way. Say which motion is
/// meant with the arguments that `clearance motion` was given (--from and --to, --edges or --trajectory, --tube, --moving): a
/// certificate of any other motion is rejected, and what differs is named. Without them, the motion that it is about is printed,
/// and has to be compared by the reader.
///
/// Exit code 0: it is a proof; 1: it is none, or one of another motion, robot or world; 2: bad input.
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

    #[command(flatten, next_help_heading = "The expected motion, as for `clearance motion`")]
    way: WayArgs,

    /// The tolerance (m) that it has to be made with
    #[arg(long, value_name = "M", allow_negative_numbers = true)]
    tolerance: Option<f64>,

    /// Obstacles may move as the certificate says, from where the world has them; which ones do is printed
    #[arg(long, conflicts_with = "moving")]
    moving_obstacles: bool,

    /// How the answer is written
    #[arg(long, value_enum, default_value_t = Format::Text)]
    format: Format,
}

/// Exit code 0: the certificate is a proof; 1: it is not, and the reason is printed.
pub fn run(args: &VerifyArgs) -> Result<ExitCode, Failure> {
    let robot = args.model.load()?;
    let scene = args.world.load(&robot, &args.model.mesh_files())?;
    let mut settings = args.model.settings();
    (settings.check_self, settings.check_world) = (!args.pairs.no_self, !args.pairs.no_world);
    let settings = settings.with_scene(&scene);
    warn_of_meshes(&robot, &scene.world, &settings);
    let expected = args.expected(&robot, &scene.world)?;
    let certificate = args.read()?;
    args.check_obstacles(&certificate)?;
    let verifier = Verifier::new(&robot, &scene.world, &settings, scene.matrix.as_ref());
    let verified = verifier.and_then(|verifier| verifier.verify_expected(&certificate, &expected));
    if verified.as_ref().is_ok_and(|v| v.pairs == 0) {
        log::warn!("there is no pair to check: every motion counts as free");
    }
    let told = Told { robot: &robot, settings: &settings, certificate: &certificate };
    print_line(&match args.format {
        Format::Text => told.text(&verified, &expected),
        Format::Json => told.json(&verified, &expected),
    })?;
    Ok(ExitCode::from(u8::from(verified.is_err())))
}

impl VerifyArgs {
    /// The expected motion, tube and tolerance.
    fn expected(&self, robot: &RobotModel, world: &World) -> Result<ExpectedMotion, Failure> {
        let tolerance = self.tolerance.map(|m| positive("--tolerance", m)).transpose()?;
        if self.way.moves_obstacles() && !self.way.is_given() {
            let needed =
                "--moving is about an expected motion: give --from and --to, --edges or --trajectory, too";
            return Err(Failure::Input(needed.to_owned()));
        }
        if self.way.directs_joints() && !self.way.is_given() {
            let needed = "--continuous is about an expected motion: give --from and --to, --edges or --trajectory, too";
            return Err(Failure::Input(needed.to_owned()));
        }
        let tube = self.way.tube(robot)?;
        let expected =
            ExpectedMotion { motion: None, any_obstacle_motion: self.moving_obstacles, tube, tolerance };
        if !self.way.is_given() {
            return Ok(expected);
        }
        let ways = self.way.with_obstacles(&self.way.ways(robot)?, world)?;
        match <[Trajectory; 1]>::try_from(ways) {
            Ok([motion]) => Ok(ExpectedMotion { motion: Some(motion), ..expected }),
            Err(ways) => {
                let count = ways.len();
                Err(Failure::Input(format!("--edges: a certificate is about one way, but {count} are given")))
            }
        }
    }

    fn read(&self) -> Result<Certificate, Failure> {
        let file = self.certificate.display();
        let text = input_files::read_text(&self.certificate, STATES_LIMIT).map_err(Failure::input)?;
        serde_json::from_str(&text).map_err(|e| {
            Failure::Input(format!("{file}: this is no certificate: {}", on_one_line(&e.to_string())))
        })
    }

    /// Rejects moving obstacles that the user has not declared.
    fn check_obstacles(&self, certificate: &Certificate) -> Result<(), Failure> {
        if self.moving_obstacles || self.way.is_given() {
            return Ok(());
        }
        let Some(mover) = certificate.segments.iter().flat_map(|s| &s.motion.obstacles).next() else {
            return Ok(());
        };
        let (file, name) = (self.certificate.display(), on_one_line(&mover.name));
        Err(Failure::Input(format!(
            "{file}: the proof supposes that obstacle '{name}' moves; say --moving-obstacles if it does, or how with --moving"
        )))
    }
}

/// The input that the output describes.
struct Told<'t> {
    robot: &'t RobotModel,
    settings: &'t Settings,
    certificate: &'t Certificate,
}

impl Told<'_> {
    fn text(
        &self,
        verified: &Result<VerificationStatistics, Rejection>,
        expected: &ExpectedMotion,
    ) -> String {
        let VerificationStatistics { segments, pairs, proofs, .. } = match verified {
            Ok(verified) => verified,
            Err(rejection) => return format!("NOT PROVEN: {rejection}"),
        };
        let summary = Summary::new(self.robot, self.settings, self.certificate);
        let about = match (&expected.motion, expected.any_obstacle_motion && summary.moves_obstacles()) {
            (None, _) => {
                "it was not told which motion is expected: compare the above, or give --from and --to, --edges or --trajectory"
            }
            (Some(_), true) => {
                "this is the expected motion of the robot; how obstacles are expected to move was not told (--moving)"
            }
            (Some(_), false) => "this is the expected motion",
        };
        format!(
            "proven free: {proofs} proofs for {pairs} pairs in {segments} segment(s) hold\n{}\n{about}",
            summary.text(*pairs)
        )
    }

    fn json(
        &self,
        verified: &Result<VerificationStatistics, Rejection>,
        expected: &ExpectedMotion,
    ) -> String {
        let told = expected.motion.is_some();
        match verified {
            Ok(v) => {
                let summary = Summary::new(self.robot, self.settings, self.certificate);
                let mut answer = json!({
                    "verified": true, "segments": v.segments, "pairs": v.pairs, "proofs": v.proofs,
                    "expected_motion_given": told,
                });
                if let (Some(answer), serde_json::Value::Object(summary)) =
                    (answer.as_object_mut(), summary.json())
                {
                    answer.extend(summary);
                }
                answer.to_string()
            }
            Err(rejection) => {
                json!({"verified": false, "reason": rejection.to_string(), "expected_motion_given": told})
                    .to_string()
            }
        }
    }
}
