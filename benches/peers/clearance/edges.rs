//! Reader of edge files, and queries on one edge: motion check and least distance. An edge is a straight motion in
//! joint space.

use std::collections::BTreeMap;
use std::path::Path;

use clearance::checker::{MotionClearanceOptions, MotionOptions, MotionOrder, MotionVerdict};
use clearance::motion::MotionSegment;
use clearance::{CollisionChecker, Configuration, RobotModel, Workspace};

use crate::Outcome;

/// Distance (m) to contact below which a motion may be reported as undecided.
const TOLERANCE: f64 = 5e-4;

/// Start and end of an edge.
pub type Edge = [Configuration; 2];

pub type EdgeSets = BTreeMap<String, Vec<Edge>>;

/// Sets of edges: a line `edges SET COUNT`, then a line for each beginning and a line for each end.
pub fn read(robot: &RobotModel, file: &Path) -> Outcome<EdgeSets> {
    let text = std::fs::read_to_string(file)?;
    let mut lines = text.lines();
    let mut sets = EdgeSets::new();
    while let Some(head) = lines.next() {
        let &["edges", set, count] = &head.split('\t').collect::<Vec<_>>()[..] else {
            return Err(format!("{}: no edges in '{head}'", file.display()).into());
        };
        let mut state = || -> Outcome<Configuration> {
            let words = lines.next().ok_or("the file of edges ends too early")?.split('\t');
            Ok(robot.configuration(&words.map(str::parse).collect::<Result<Vec<f64>, _>>()?)?)
        };
        let edges = (0..count.parse()?).map(|_| Ok([state()?, state()?])).collect::<Outcome<Vec<Edge>>>()?;
        sets.insert(set.to_owned(), edges);
    }
    Ok(sets)
}

/// Checks one edge. Builds the segment too, because a planner has only the two configurations.
pub fn verdict(
    checker: &CollisionChecker,
    [from, to]: &Edge,
    order: MotionOrder,
    workspace: &mut Workspace,
) -> MotionVerdict {
    let segment = MotionSegment::straight(checker.robot(), from, to);
    let options = MotionOptions { tolerance: TOLERANCE, order, ..Default::default() };
    checker.check_motion_with(&segment, &options, workspace).verdict
}

/// Bounds (m) on the least distance along an edge, with the default tolerance.
pub fn least_distance(checker: &CollisionChecker, [from, to]: &Edge, workspace: &mut Workspace) -> [f64; 2] {
    let segment = MotionSegment::straight(checker.robot(), from, to);
    let found = checker.clearance_along(&segment, &MotionClearanceOptions::default(), workspace);
    [found.lower(), found.upper()]
}
