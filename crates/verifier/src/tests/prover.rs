//! Test helper: a slow and simple prover, which halves intervals until the bound is less than the distance.
use clearance_motion::{Certificate, MotionSegment, Proof, SegmentProof};
use clearance_motion::{model_fingerprint, world_fingerprint};
use clearance_scene::Settings;

use crate::Verifier;
use crate::proof_interval::ProofInterval;
use crate::segment_kinematics::SegmentKinematics;
use crate::segment_verifier::SegmentVerifier;

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
        let kinematics =
            SegmentKinematics::new(verifier.model.robot, verifier.model.world, segment, motion.clone())
                .unwrap();
        let mut segment_verifier = SegmentVerifier::new(&verifier.model, segment, 0.0, &kinematics);
        let mut list = Vec::new();
        for pair in 0..verifier.model.required.pairs.len() {
            halves(&mut segment_verifier, verifier, pair, [0.0, 1.0], &mut list)?;
        }
        proofs.push(SegmentProof { motion: motion.text(), proofs: list });
    }
    let names = verifier.model.required.pairs.iter().map(|pair| pair.names.clone()).collect();
    let model = model_fingerprint(verifier.model.robot, settings, None);
    Ok(Certificate::new(
        verifier.model.robot,
        [model, world_fingerprint(verifier.model.world)],
        names,
        proofs,
    ))
}

fn halves(
    segment_verifier: &mut SegmentVerifier,
    verifier: &Verifier,
    pair: usize,
    [from, to]: [f64; 2],
    proofs: &mut Vec<Proof>,
) -> Result<(), usize> {
    let interval = ProofInterval::new(from, to);
    segment_verifier.go_to(interval);
    segment_verifier.place(pair);
    let bound = segment_verifier.bound(pair, interval, true);
    let lower = distance(segment_verifier, pair);
    if lower > bound * (1.0 + 2e-9) + 2e-9 + verifier.model.required.pairs[pair].padding {
        proofs.push(Proof(pair, from, to, lower, bound));
        return Ok(());
    }
    if to - from < SHORTEST {
        return Err(pair);
    }
    halves(segment_verifier, verifier, pair, [from, interval.middle], proofs)?;
    halves(segment_verifier, verifier, pair, [interval.middle, to], proofs)
}

/// The largest distance that is proven, by halving.
fn distance(segment_verifier: &mut SegmentVerifier, pair: usize) -> f64 {
    let (mut low, mut high) = (0.0, 10.0);
    while high - low > 1e-12 {
        let middle = 0.5 * (low + high);
        if segment_verifier.is_apart(pair, middle) { low = middle } else { high = middle }
    }
    low
}
