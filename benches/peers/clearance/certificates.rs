//! What it costs to verify a certificate, as a multiple of making it.

use std::time::Duration;

use clearance::CollisionChecker;
use clearance::motion::Certificate;
use cpu_time::ProcessTime;

use crate::Outcome;
use crate::edges::Edge;

/// CPU time (s) of all edges together, and the size of what is verified.
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

/// Of free edges; `None` while the library has no certificates to ask for.
pub fn costs(_checker: &CollisionChecker, _edges: &[Edge]) -> Outcome<Option<CertificateCosts>> {
    // Missing until certificates can be asked for and verified: two calls for `measure`, in place of this `None`.
    //   make:   `MotionSegment::straight`, then what gives a `Certificate` of a free segment (tolerance 5e-4).
    //   verify: `Verifier::new(checker.robot(), &World::default(), &Settings::default(), matrix)`, once, before time
    //           is taken; then `.verify(&certificate)`, an error where it does not accept. `matrix` is the one that
    //           `checker_of` in `whole_robot.rs` gave the checker: `WholeRobot` must keep it.
    Ok(None)
}

/// `make` gives the certificate of a free edge, `verify` fails where it is not accepted.
#[allow(dead_code)] // until `costs` has its two calls
fn measure(
    edges: &[Edge],
    mut make: impl FnMut(&Edge) -> Outcome<Certificate>,
    mut verify: impl FnMut(&Certificate) -> Outcome<()>,
) -> Outcome<CertificateCosts> {
    for edge in edges.iter().take(1) {
        verify(&make(edge)?)?; // caches warm up
    }
    let start = ProcessTime::now();
    let certificates = edges.iter().map(&mut make).collect::<Outcome<Vec<_>>>()?;
    let making = start.elapsed();
    let start = ProcessTime::now();
    certificates.iter().try_for_each(&mut verify)?;
    let verifying = start.elapsed();
    let intervals = certificates.iter().flat_map(|c| &c.segments).map(|s| s.proofs.len()).sum();
    Ok(CertificateCosts { edges: edges.len(), intervals, making, verifying })
}
