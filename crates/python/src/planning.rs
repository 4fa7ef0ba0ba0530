//! Paths of the planner.

use clearance::checker::{MotionOptions, Watch};
use clearance::planner::{self, NoPlan, Plan, PlanOptions};
use clearance::robot::JointGroup;
use pyo3::prelude::*;

use crate::arrays::array;
use crate::batches::run;
use crate::checker::CheckerCore;
use crate::error::error;
use crate::motion_queries::certificate_object;
use crate::recovery::deadline;
use crate::results::result;
use crate::state_queries::single;
use crate::workspaces::with_memory;

/// Limits of a search, as arguments.
pub struct PlanArguments {
    pub seed: u64,
    pub timeout: Option<f64>,
    pub max_edges: u64,
    pub range: f64,
    pub shortcuts: u32,
    pub certificate: bool,
}

/// Searches a path from `start` to `goal`.
pub fn plan<'py>(
    py: Python<'py>,
    core: &CheckerCore,
    [start, goal]: [&Bound<'py, PyAny>; 2],
    arguments: &PlanArguments,
) -> PyResult<Bound<'py, PyAny>> {
    let ends = [single(core, start, "start")?, single(core, goal, "goal")?];
    let group = JointGroup::of_joints(core.space.robot(), "joints of the checker", &core.space.joints());
    let watch = Watch::default();
    let options = PlanOptions {
        seed: arguments.seed,
        range: arguments.range,
        most_edges: arguments.max_edges,
        shortcuts: arguments.shortcuts,
        deadline: deadline(arguments.timeout)?,
        watch: Some(watch.clone()),
        ..PlanOptions::default()
    };
    let search = |_: &_| {
        with_memory(core, |memory| {
            let workspace = &mut memory.workspace;
            let plan = planner::plan(&core.checker, &group, &ends[0], &ends[1], &options, workspace)?;
            let proof = MotionOptions {
                tolerance: options.tolerance,
                watch: options.watch.clone(),
                ..MotionOptions::default()
            };
            let certificate = match &plan {
                Plan::Found(path) if arguments.certificate => {
                    path.certificate(&core.checker, &proof, workspace)
                }
                _ => None,
            };
            Ok((plan, certificate))
        })
    };
    let searched: Result<_, planner::PlanError> = run(py, None, || watch.stop(), search)?;
    let (plan, certificate) = searched.map_err(error)?;
    match plan {
        Plan::Found(path) => {
            let states: Vec<f64> =
                path.states.iter().flat_map(|q| core.space.select(q.positions())).collect();
            let shape = [path.states.len(), group.len()];
            result!(py, "Plan",
                found: true, path: array(py, states, &shape)?, length: path.length(), reason: "found",
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
