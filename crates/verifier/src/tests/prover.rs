//! A slow and simple prover: it halves intervals until the bound is less than the distance.
use clearance_motion::{Certificate, MotionSegment, Proof, SegmentProof};
use clearance_motion::{model_fingerprint, world_fingerprint};
use clearance_scene::Settings;

use crate::Verifier;
use crate::segment_kinematics::SegmentKinematics;
use crate::verifier::{Interval, Pass};

/// Shortest interval that is tried.
const SHORTEST: f64 = 1e-4;

/// A certificate, or the first pair that could not be proven apart.
pub fn prove(
    verifier: &Verifier,
    settings: &Settings,
    segments: &[MotionSegment],
) -> Result<Certificate, usize> {
    let mut proofs = Vec::new();
    for (segment, motion) in segments.iter().enumerate() {
        let course = SegmentKinematics::new(verifier.robot, verifier.world, segment, motion.clone()).unwrap();
        let mut pass = Pass::new(verifier, segment, &course);
        let mut list = Vec::new();
        for pair in 0..verifier.subject.pairs.len() {
            halves(&mut pass, verifier, pair, [0.0, 1.0], &mut list)?;
        }
        proofs.push(SegmentProof { motion: motion.text(), proofs: list });
    }
    let names = verifier.subject.pairs.iter().map(|pair| pair.names.clone()).collect();
    let model = model_fingerprint(verifier.robot, settings, None);
    Ok(Certificate::new(verifier.robot, [model, world_fingerprint(verifier.world)], names, proofs))
}

fn halves(
    pass: &mut Pass,
    verifier: &Verifier,
    pair: usize,
    [from, to]: [f64; 2],
    proofs: &mut Vec<Proof>,
) -> Result<(), usize> {
    let interval = Interval::new(from, to);
    pass.go_to(interval);
    pass.place(pair);
    let bound = pass.bound(pair, interval, true);
    let lower = distance(pass, pair);
    if lower > bound * (1.0 + 2e-9) + 2e-9 + verifier.subject.pairs[pair].padding {
        proofs.push(Proof(pair, from, to, lower, bound));
        return Ok(());
    }
    if to - from < SHORTEST {
        return Err(pair);
    }
    halves(pass, verifier, pair, [from, interval.middle], proofs)?;
    halves(pass, verifier, pair, [interval.middle, to], proofs)
}

/// The largest distance that is proven, by halving.
fn distance(pass: &mut Pass, pair: usize) -> f64 {
    let (mut low, mut high) = (0.0, 10.0);
    while high - low > 1e-12 {
        let middle = 0.5 * (low + high);
        if pass.apart(pair, middle) { low = middle } else { high = middle }
    }
    low
}
