//! Times of making and verifying certificates of free edges.

use std::time::Duration;

use clearance::checker::MotionOptions;
use clearance::motion::{Certificate, MotionSegment};
use clearance::scene::AllowedCollisionMatrix;
use clearance::verifier::Verifier;
use clearance::{CollisionChecker, Settings, Workspace, World};
use cpu_time::ProcessTime;

use crate::Outcome;
use crate::edges::Edge;

/// CPU time of all edges together, and the size of what is verified.
pub struct CertificateCosts {
    edges: usize,
    intervals: usize,
    making: Duration,
    verifying: Duration,
}

impl CertificateCosts {
    /// `key=value` words.
    pub fn summary(&self) -> String {
        format!(
            "edges={}\tintervals={}\tmaking_s={}\tverifying_s={}",
            self.edges,
            self.intervals,
            self.making.as_secs_f64(),
            self.verifying.as_secs_f64(),
        )
    }
}

/// Of those edges that get a certificate; `None` if there are none. The checker has default settings and no world; its
/// pairs are those of `matrix`.
pub fn costs(
    checker: &CollisionChecker,
    matrix: Option<&AllowedCollisionMatrix>,
    edges: &[Edge],
) -> Outcome<Option<CertificateCosts>> {
    let (world, settings) = (World::default(), Settings::default());
    let verifier = Verifier::new(checker.robot(), &world, &settings, matrix)?;
    let mut workspace = checker.workspace();
    let mut make = |edge: &Edge| certificate(checker, edge, &mut workspace);
    // this warms caches, too
    let edges: Vec<&Edge> = edges.iter().filter(|edge| make(edge).is_some()).collect();
    if edges.is_empty() {
        return Ok(None);
    }
    let start = ProcessTime::now();
    let certificates: Vec<Certificate> = edges.iter().filter_map(|edge| make(edge)).collect();
    let making = start.elapsed();
    let start = ProcessTime::now();
    for certificate in &certificates {
        verifier.verify(certificate)?;
    }
    let verifying = start.elapsed();
    let intervals = certificates.iter().flat_map(|c| &c.segments).map(|s| s.proofs.len()).sum();
    Ok(Some(CertificateCosts { edges: edges.len(), intervals, making, verifying }))
}

/// The proof that an edge is free, if it is.
fn certificate(
    checker: &CollisionChecker,
    [from, to]: &Edge,
    workspace: &mut Workspace,
) -> Option<Certificate> {
    let segment = MotionSegment::straight(checker.robot(), from, to);
    checker.certify_motion(&segment, &MotionOptions::default(), workspace).1
}
