//! `clearance verify`: checks whether a certificate is a proof, and for which motion.

use std::path::PathBuf;

use clap::Args;
use clearance::motion::{Certificate, Trajectory};
use clearance::robot::RobotModel;
use clearance::scene::Settings;
use clearance::scene::World;
use clearance::verifier::{ExpectedMotion, Rejection, VerificationStatistics, Verifier};
use clearance_files::input_files::{self, STATES_LIMIT};
use serde_json::json;

use super::certificate_summary::{Summary, on_one_line};
use super::exit_status::ExitStatus;
use super::failure::Failure;
use super::matrix_verification;
use super::model_args::{ModelArgs, WorldArgs, warn_of_meshes};
use super::motion_args::MotionInputArgs;
use super::run_args::{Format, PairArgs, not_negative, positive, print_line};

/// Verify a certificate that a motion is free, with code that is independent of the checker.
///
/// A certificate proves one motion with one tracking tolerance and one motion of the obstacles. Give the expected motion with the
/// arguments of `clearance motion` (--from and --to, --edges or --trajectory, --tube, --moving). A certificate of any other motion is
/// rejected, and the differences are printed. Without these arguments, the motion of the certificate is printed; compare it with
/// the motion that you expect.
///
/// Exit codes: 0 the proof is valid; 1 it is not, or it is for another motion, robot or world; 2 bad input.
#[derive(Args)]
pub struct VerifyArgs {
    #[command(flatten)]
    model: ModelArgs,

    #[command(flatten)]
    world: WorldArgs,

    /// Certificate written by `clearance motion --certificate` or `clearance acm --certificate`
    #[arg(value_name = "CERTIFICATE.json")]
    certificate: PathBuf,

    #[command(flatten)]
    pairs: PairArgs,

    #[command(flatten, next_help_heading = "The expected motion, as for `clearance motion`")]
    motion: MotionInputArgs,

    /// Expected tolerance (m) of the certificate
    #[arg(long, value_name = "M", allow_negative_numbers = true)]
    tolerance: Option<f64>,

    /// Margin (m) that the certificate has to prove, at least: no pair is ever nearer than this, besides its padding
    #[arg(long, value_name = "M", allow_negative_numbers = true)]
    margin: Option<f64>,

    /// Accept any motion of obstacles that starts at their poses in the world; the moving obstacles are printed
    #[arg(long, conflicts_with = "moving")]
    moving_obstacles: bool,

    /// Output format
    #[arg(long, value_enum, default_value_t = Format::Text)]
    format: Format,
}

/// Exit code 0: the certificate is a proof; 1: it is not, and the reason is printed.
pub fn run(args: &VerifyArgs) -> Result<ExitStatus, Failure> {
    let robot = args.model.robot.load()?;
    if let Some(certificate) = matrix_verification::read(&args.certificate)? {
        if args.is_about_motion() {
            return matrix_verification::reject_for_motion(args.format);
        }
        return matrix_verification::run(&robot, &args.model.settings(), &certificate, args.format);
    }
    let scene = args.world.load(&robot, &args.model.robot.mesh_files())?;
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
    let input = VerifiedInput { robot: &robot, settings: &settings, certificate: &certificate };
    print_line(&match args.format {
        Format::Text => input.text(&verified, &expected),
        Format::Json => input.json(&verified, &expected),
    })?;
    Ok(ExitStatus::of_answer(verified.is_ok()))
}

impl VerifyArgs {
    /// Whether an argument says something of a motion, or of the world that it is in.
    fn is_about_motion(&self) -> bool {
        let WorldArgs { world, cloud, point_radius, ignore, .. } = &self.world;
        let about_world =
            !world.is_empty() || !cloud.is_empty() || point_radius.is_some() || !ignore.is_empty();
        let about_pairs = self.pairs.no_self || self.pairs.no_world;
        let about_proof = self.tolerance.is_some() || self.margin.is_some() || self.moving_obstacles;
        about_world || about_pairs || about_proof || self.motion.is_any_given()
    }

    /// The expected motion, tube and tolerance.
    fn expected(&self, robot: &RobotModel, world: &World) -> Result<ExpectedMotion, Failure> {
        let tolerance = self.tolerance.map(|m| positive("--tolerance", m)).transpose()?;
        let margin = self.margin.map(|m| not_negative("--margin", m)).transpose()?;
        self.motion.check_effect(self.pairs)?;
        if self.motion.moves_obstacles() && !self.motion.is_given() {
            let needed =
                "--moving is about an expected motion: give --from and --to, --edges or --trajectory, too";
            return Err(Failure::Input(needed.to_owned()));
        }
        if self.motion.directs_joints() && !self.motion.is_given() {
            let needed = "--continuous is about an expected motion: give --from and --to, --edges or --trajectory, too";
            return Err(Failure::Input(needed.to_owned()));
        }
        let tube = self.motion.tube(robot)?;
        let expected = ExpectedMotion {
            motion: None,
            any_obstacle_motion: self.moving_obstacles,
            tube,
            tolerance,
            margin,
        };
        if !self.motion.is_given() {
            return Ok(expected);
        }
        let trajectories = self.motion.with_obstacles(&self.motion.trajectories(robot)?, world)?;
        match <[Trajectory; 1]>::try_from(trajectories) {
            Ok([motion]) => Ok(ExpectedMotion { motion: Some(motion), ..expected }),
            Err(trajectories) => {
                let count = trajectories.len();
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
        if self.moving_obstacles || self.motion.is_given() {
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
struct VerifiedInput<'t> {
    robot: &'t RobotModel,
    settings: &'t Settings,
    certificate: &'t Certificate,
}

impl VerifiedInput<'_> {
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
                "no expected motion was given: compare the above, or give --from and --to, --edges or --trajectory"
            }
            (Some(_), true) => {
                "this is the expected motion of the robot; how obstacles are expected to move was not given (--moving)"
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
        let is_motion_given = expected.motion.is_some();
        match verified {
            Ok(v) => {
                let summary = Summary::new(self.robot, self.settings, self.certificate);
                let mut output = json!({
                    "verified": true, "segments": v.segments, "pairs": v.pairs, "proofs": v.proofs,
                    "expected_motion_given": is_motion_given,
                });
                if let (Some(output), serde_json::Value::Object(summary)) =
                    (output.as_object_mut(), summary.json())
                {
                    output.extend(summary);
                }
                output.to_string()
            }
            Err(rejection) => {
                json!({"verified": false, "reason": rejection.to_string(), "expected_motion_given": is_motion_given})
                    .to_string()
            }
        }
    }
}
