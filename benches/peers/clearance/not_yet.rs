//! What the library cannot do yet, and the ONLY PLACE to touch when it learns it: each function says what belongs in
//! it; `None` leaves a dash in the report.

use std::collections::BTreeMap;
use std::sync::Arc;

use clearance::geometry::TriangleMesh;
use clearance::math::Pose;
use clearance::{CollisionChecker, Configuration, Workspace};

use crate::answer::Answer;

/// TODO(batch): whether each state is free, on one thread: `CollisionChecker::check_states`.
pub fn batch(_checker: &CollisionChecker, _states: &[Configuration]) -> Option<Vec<bool>> {
    None
}

/// TODO(stream): the least distance within `limit` of successive states, each helped by the last: the stream interface.
/// The stream must begin cold in every call, so that a repeated pass gains nothing from the one before.
pub fn stream(
    _checker: &CollisionChecker,
    _workspace: &mut Workspace,
    _states: &[Configuration],
    _limit: f64,
) -> Option<Vec<Answer>> {
    None
}

/// TODO(level 0): CPU time (ns) a state of kinematics and the first, coarse filter alone.
pub fn level_0_nanoseconds(_checker: &CollisionChecker, _states: &[Configuration]) -> Option<f64> {
    None
}

/// TODO(memory): bytes of all hierarchies of the links, triangles included.
pub fn hierarchy_bytes(_checker: &CollisionChecker) -> Option<usize> {
    None
}

/// One line of the cost model `T = N_bv * C_bv + N_p * C_p`, in the mean of the poses.
pub struct Cost {
    pub volume: &'static str,
    pub question: &'static str,
    pub volume_tests: f64,
    pub volume_test_ns: f64,
    pub primitive_tests: f64,
    pub primitive_test_ns: f64,
}

/// TODO(cost model): of every volume type, for "free" and "distance", over all poses of two meshes (by gap).
pub fn cost_model(_meshes: &[Arc<TriangleMesh>; 2], _poses: &BTreeMap<&str, Vec<Pose>>) -> Option<Vec<Cost>> {
    None
}
