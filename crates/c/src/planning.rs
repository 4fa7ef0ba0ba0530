//! C interface of the motion planner: options, search, and certificate of the path.

use std::ffi::{CStr, c_char, c_int};
use std::ptr;

use clearance::planner::{self, NoPlan, Path, Plan, PlanOptions};
use clearance::{Certificate, MotionOptions, MotionVerdict, TrajectoryReport, UndecidedReason, Workspace};

use crate::certificate::clearance_certificate;
use crate::checker::clearance_checker;
use crate::motion_options::deadline;
use crate::motion_queries::edge_ends;
use crate::status::{Failure, Outcome, clearance_status};
use crate::structs::clearance_edge;
use crate::workspace::{Memory, clearance_workspace, query};

/// Limits of a search for a path. Start with `clearance_plan_options_default`.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct clearance_plan_options {
    /// Seed of the random states. Default 1.
    pub seed: u64,
    /// Time (s) after which the search ends, and the proof of its path. Default infinity.
    pub timeout: f64,
    /// Number of edges after which the search ends. Default 200 000.
    pub max_edges: u64,
    /// Largest length of an edge of the search: the Euclidean norm of all changes (rad, m). Default 1.
    pub range: f64,
    /// Number of shortcuts that are tried. Default 64.
    pub shortcuts: u32,
    /// If not 0, a path gets a certificate. Default 0.
    pub certificate: c_int,
}

impl Default for clearance_plan_options {
    fn default() -> Self {
        let PlanOptions { seed, range, most_edges, shortcuts, .. } = PlanOptions::default();
        let (timeout, max_edges) = (f64::INFINITY, most_edges);
        Self { seed, timeout, max_edges, range, shortcuts, certificate: 0 }
    }
}

/// The default limits.
#[unsafe(no_mangle)]
pub extern "C" fn clearance_plan_options_default() -> clearance_plan_options {
    clearance_plan_options::default()
}

/// Result of a search for a path. The states are valid until the next query with the workspace.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct clearance_plan {
    /// True if there is a path. Nothing is proven if none is found.
    pub is_found: bool,
    /// `found`, `found_without_certificate`, `start_not_free`, `goal_not_free`, `most_edges` or `deadline`.
    pub reason: *const c_char,
    /// count x n positions (rad, m), from the start to the goal, row by row. The edges between them are proven free.
    pub states: *const f64,
    /// Number of states; 0 without a path.
    pub count: usize,
    /// Number of positions of a state.
    pub n: usize,
    /// Sum of the Euclidean norms of the changes along all edges (rad, m); 0 without a path.
    pub length: f64,
    /// Number of edges that were checked.
    pub edges: u64,
    /// The proof of all edges, if it was asked for and there is a path; otherwise null. It is also null if the time was over before the
    /// proof was complete: then the reason is `found_without_certificate`. The caller frees it with `clearance_certificate_free`.
    pub certificate: *mut clearance_certificate,
}

/// Searches for a path of straight edges from `ends.from` to `ends.to` whose edges are proven free. Null `options` are the defaults.
///
/// RRT-Connect with shortcuts. Only the joints of the checker's states move, within their limits, without passive joints of the SRDF.
/// Without a timeout, the same seed gives the same path. Rejected: a start or goal beyond joint limits, planar and floating joints, and a
/// path without the certificate that was asked for, unless the time was over.
#[unsafe(no_mangle)]
pub extern "C" fn clearance_checker_plan(
    checker: *const clearance_checker,
    workspace: *mut clearance_workspace,
    ends: clearance_edge,
    options: *const clearance_plan_options,
    plan: *mut clearance_plan,
) -> clearance_status {
    query(checker, workspace, |arguments, checker, memory| {
        let given = arguments.object_or_none(options, "options")?.copied().unwrap_or_default();
        let [start, goal] = edge_ends(arguments, &checker.space, ends)?;
        let group = checker.space.joint_group();
        let options = plan_options(&given)?;
        let workspace = &mut memory.workspace;
        let found = planner::plan(&checker.checker, &group, &start, &goal, &options, workspace);
        match found.map_err(Failure::rejected)? {
            Plan::NotFound(none) => arguments.write(plan, not_found(checker, &none), "plan"),
            Plan::Found(path) => {
                let is_proven = given.certificate != 0;
                let proof = is_proven.then(|| prove(checker, &path, &options, workspace));
                let (reason, certificate) = certified(proof)?;
                let found = clearance_plan { reason: reason.as_ptr(), ..found_path(checker, &path, memory) };
                arguments.write(plan, found, "plan")?;
                let Some(certificate) = certificate else { return Ok(()) };
                let plan = arguments.object_mut(plan, "plan")?;
                let certificate = clearance_certificate::new(certificate);
                arguments.write_handle(&raw mut plan.certificate, certificate, "certificate")
            }
        }
    })
}

/// Report on the trajectory of a path, and its certificate.
pub type Proof = (TrajectoryReport, Option<Certificate>);

fn prove(checker: &clearance_checker, path: &Path, limits: &PlanOptions, workspace: &mut Workspace) -> Proof {
    let options =
        MotionOptions { tolerance: limits.tolerance, deadline: limits.deadline, ..MotionOptions::default() };
    checker.checker.certify_trajectory(&path.trajectory(&checker.checker), &options, workspace)
}

/// Reason of a path that was found, and its certificate. A path without the certificate that was asked for is an error, unless the time
/// was over.
pub fn certified(proof: Option<Proof>) -> Outcome<(&'static CStr, Option<Certificate>)> {
    let Some((report, certificate)) = proof else { return Ok((c"found", None)) };
    match (report.verdict, certificate) {
        (_, Some(certificate)) => Ok((c"found", Some(certificate))),
        (MotionVerdict::Undecided { reason: UndecidedReason::Deadline, .. }, None) => {
            Ok((c"found_without_certificate", None))
        }
        (verdict, None) => Err(Failure::rejected(format!(
            "a path was found, but there is no certificate of it, since its edge {} is {verdict:?}: plan without certificate, and prove \
             the path with clearance_checker_check_trajectory and a larger budget",
            report.segment
        ))),
    }
}

fn plan_options(given: &clearance_plan_options) -> Outcome<PlanOptions> {
    Ok(PlanOptions {
        seed: given.seed,
        range: given.range,
        most_edges: given.max_edges,
        shortcuts: given.shortcuts,
        deadline: deadline(given.timeout)?,
        ..PlanOptions::default()
    })
}

fn found_path(checker: &clearance_checker, path: &Path, memory: &mut Memory) -> clearance_plan {
    let states = path.states.iter().flat_map(|q| checker.space.select(q.positions()));
    memory.states = states.collect();
    clearance_plan {
        is_found: true,
        reason: c"found".as_ptr(),
        states: memory.states.as_ptr(),
        count: path.states.len(),
        n: checker.space.names().len(),
        length: path.length(),
        edges: path.edges,
        certificate: ptr::null_mut(),
    }
}

fn not_found(checker: &clearance_checker, none: &NoPlan) -> clearance_plan {
    let (reason, edges): (&'static CStr, u64) = match *none {
        NoPlan::StartNotFree => (c"start_not_free", 0),
        NoPlan::GoalNotFree => (c"goal_not_free", 0),
        NoPlan::MostEdges { edges } => (c"most_edges", edges),
        NoPlan::Deadline { edges } => (c"deadline", edges),
        NoPlan::Canceled { edges } => (c"canceled", edges),
    };
    clearance_plan {
        is_found: false,
        reason: reason.as_ptr(),
        states: ptr::null(),
        count: 0,
        n: checker.space.names().len(),
        length: 0.0,
        edges,
        certificate: ptr::null_mut(),
    }
}
