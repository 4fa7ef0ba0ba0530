//! A straight motion in joint space: proven free, with a certificate that is verified by other code.

use std::error::Error;
use std::path::Path;
use std::sync::Arc;

use clearance::{
    CollisionChecker, MotionOptions, MotionSegment, MotionVerdict, RobotModel, Settings, Verifier, World,
};

pub fn main() -> Result<(), Box<dyn Error>> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("urdf/demo_arm");
    let srdf = folder.join("demo_arm.srdf");
    let robot = Arc::new(RobotModel::load(&folder.join("demo_arm.urdf"), Some(&srdf), &[])?);
    let world = World::default();
    let checker = CollisionChecker::new(Arc::clone(&robot), &world, Settings::default())?;
    let mut workspace = checker.workspace();

    let from = robot.configuration_from_names([("joint4", -1.5)])?;
    let to = robot.configuration_from_names([("joint4", -2.0)])?;
    let motion = MotionSegment::straight(&robot, &from, &to);
    let (report, certificate) = checker.certify_motion(&motion, &MotionOptions::default(), &mut workspace);
    match report.verdict {
        MotionVerdict::Free => println!("free for every t in [0, 1]"),
        MotionVerdict::Contact { t: [before, at], pair: (a, b), .. } => {
            println!(
                "free until t = {before}, at t = {at} {} hits {}",
                checker.body_name(a),
                checker.body_name(b)
            );
        }
        MotionVerdict::Undecided { reason, .. } => println!("undecided: {reason}"),
    }

    let certificate = certificate.ok_or("only free motions have a certificate")?;
    let verified = Verifier::new(&robot, &world, checker.settings(), None)?.verify(&certificate)?;
    println!("verified: {} pairs of bodies stay apart, by {} proofs", verified.pairs, verified.proofs);
    Ok(())
}
