//! Path planning between two states: limits of the search, the path found, and its certificate.

use std::time::Instant;

use clearance::checker::{MotionOptions, Watch};
use clearance::planner::{self, NoPlan, Plan, PlanOptions};
use clearance::{Certificate, MotionVerdict, TrajectoryReport, UndecidedReason};
use pyo3::prelude::*;

use crate::arrays::array;
use crate::batches::run;
use crate::checker_core::CheckerCore;
use crate::error::error;
use crate::motion_queries::certificate_object;
use crate::result_builder::result;
use crate::state_queries::single;
use crate::workspaces::with_memory;

/// Limits of a search, as arguments.
pub struct PlanArguments {
    pub seed: u64,
    pub deadline: Option<Instant>,
    pub max_edges: u64,
    pub range: f64,
    pub shortcuts: u32,
    pub certificate: bool,
}

/// Reason of a path that was found, and its certificate. A path without the certificate that was asked for is an error, unless the time was
/// over.
fn certified(
    proven: Option<(TrajectoryReport, Option<Certificate>)>,
) -> PyResult<(&'static str, Option<Certificate>)> {
    let Some((report, certificate)) = proven else { return Ok(("found", None)) };
    match (report.verdict, certificate) {
        (_, Some(certificate)) => Ok(("found", Some(certificate))),
        (MotionVerdict::Undecided { reason: UndecidedReason::Deadline, .. }, None) => {
            Ok(("found_without_certificate", None))
        }
        (verdict, None) => Err(error(format!(
            "a path was found, but there is no certificate of it, since its edge {} is {verdict:?}: plan with certificate=False, and \
             prove the path with check_trajectory and a larger budget",
            report.segment
        ))),
    }
}

/// Searches a path from `start` to `goal`.
pub fn plan<'py>(
    py: Python<'py>,
    core: &CheckerCore,
    [start, goal]: [&Bound<'py, PyAny>; 2],
    arguments: &PlanArguments,
) -> PyResult<Bound<'py, PyAny>> {
    let ends = [single(core, start, "start")?, single(core, goal, "goal")?];
    let group = core.space.joint_group();
    let watch = Watch::default();
    let options = PlanOptions {
        seed: arguments.seed,
        range: arguments.range,
        most_edges: arguments.max_edges,
        shortcuts: arguments.shortcuts,
        deadline: arguments.deadline,
        watch: Some(watch.clone()),
        ..PlanOptions::default()
    };
    let search = |_: &_| {
        with_memory(core, |memory| {
            let workspace = &mut memory.workspace;
            let plan = planner::plan(&core.checker, &group, &ends[0], &ends[1], &options, workspace)?;
            let proof = MotionOptions {
                tolerance: options.tolerance,
                deadline: options.deadline,
                watch: options.watch.clone(),
                ..MotionOptions::default()
            };
            let proven = match &plan {
                Plan::Found(path) if arguments.certificate => {
                    let path = path.trajectory(&core.checker);
                    Some(core.checker.certify_trajectory(&path, &proof, workspace))
                }
                _ => None,
            };
            Ok((plan, proven))
        })
    };
    let searched: Result<_, planner::PlanError> = run(py, None, || watch.stop(), search)?;
    let (plan, proven) = searched.map_err(error)?;
    let (reason, certificate) = certified(proven)?;
    match plan {
        Plan::Found(path) => {
            let states: Vec<f64> =
                path.states.iter().flat_map(|q| core.space.select(q.positions())).collect();
            let shape = [path.states.len(), group.len()];
            result!(py, "Plan",
                found: true, path: array(py, states, &shape)?, length: path.length(), reason: reason,
                edges: path.edges, nodes: path.nodes, certificate: certificate_object(py, certificate)?)
        }
        Plan::NotFound(none) => {
            let edges = match none {
                NoPlan::MostEdges { edges } | NoPlan::Deadline { edges } | NoPlan::Canceled { edges } => {
                    edges
                }
                NoPlan::StartNotFree | NoPlan::GoalNotFree => 0,
            };
            result!(py, "Plan",
                found: false, path: None::<Vec<f64>>, length: None::<f64>, reason: none.reason(),
                edges: edges, nodes: None::<usize>, certificate: None::<Vec<u8>>)
        }
    }
}
