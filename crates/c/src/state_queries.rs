//! C interface of state queries: free or not, least distance, contacts, and distance derivatives.

use clearance::checker::{Clearance, Contact, LocalContact, PairContacts, PairKind, WitnessCount};
use clearance::robot::Configuration;
use clearance::scene::BodyId;
use clearance::{CollisionReport, PairDistance, Question};

use crate::arguments::Arguments;
use crate::checker::clearance_checker;
use crate::rows;
use crate::status::{Failure, Outcome, clearance_status};
use crate::structs::{clearance_pair, clearance_state, clearance_states, xyz};
use crate::thread_pools::batch_pool;
use crate::workspace::{Memory, clearance_workspace, query, query_state};

/// Arrays of results, as C reads them.
#[derive(Debug, Default)]
pub struct StateResults {
    pairs: Vec<clearance_pair>,
    distances: Vec<clearance_pair_distance>,
    contacts: Vec<clearance_contact>,
    clearances: Vec<clearance_pair_clearance>,
    gradients: Vec<f64>,
}

/// Whether a state is free of collision: true is proven, every pair is apart, by more than the padding.
///
/// Rejected: positions that are not finite.
#[unsafe(no_mangle)]
pub extern "C" fn clearance_checker_is_free(
    checker: *const clearance_checker,
    workspace: *mut clearance_workspace,
    state: clearance_state,
    is_free: *mut bool,
) -> clearance_status {
    query_state(checker, workspace, state, |arguments, checker, memory| {
        let free = checker.checker.is_free(&memory.q, &mut memory.workspace);
        arguments.write(is_free, free, "is_free")
    })
}

/// Writes for each of many states 1 if it is free, as `clearance_checker_is_free` does, and otherwise 0: `states.count` results.
///
/// `threads` is the number of threads; 0 for all cores, 1 for the calling thread with this workspace. Results do not depend on it.
/// Rejected: positions that are not finite; the text names the row.
#[unsafe(no_mangle)]
pub extern "C" fn clearance_checker_are_free(
    checker: *const clearance_checker,
    workspace: *mut clearance_workspace,
    states: clearance_states,
    threads: usize,
    are_free: *mut u8,
) -> clearance_status {
    query(checker, workspace, |arguments, checker, memory| {
        arguments.check_room(are_free, states.count, "are_free")?;
        let states = read_states(arguments, checker, states)?;
        let mut free = vec![false; states.len()];
        if threads == 1 {
            checker.checker.are_free_with(&states, &mut memory.workspace, &mut free);
        } else {
            free = batch_pool(threads)?.install(|| checker.checker.are_free(&states));
        }
        let free: Vec<u8> = free.into_iter().map(u8::from).collect();
        arguments.write_array(are_free, free.len(), &free, "are_free")
    })
}

fn read_states(
    arguments: Arguments<'_>,
    checker: &clearance_checker,
    states: clearance_states,
) -> Outcome<Vec<Configuration>> {
    let clearance_states { positions, count, n } = states;
    read_rows(arguments, checker, (positions, count, n), "states")
}

/// Reads `count` rows of `n` positions.
pub fn read_rows(
    arguments: Arguments<'_>,
    checker: &clearance_checker,
    (positions, count, n): (*const f64, usize, usize),
    name: &str,
) -> Outcome<Vec<Configuration>> {
    let all = arguments.array(positions, count.saturating_mul(n), name)?;
    let row = |i: usize| rows::read(&checker.space, &all[i * n..(i + 1) * n], &|| format!("{name}: row {i}"));
    (0..count).map(row).collect()
}

/// Distance of two bodies, padding subtracted.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct clearance_pair_distance {
    /// Names of the bodies, valid as long as the checker; null if no pair is within the largest distance.
    pub pair: clearance_pair,
    /// Distance (m): 0 for bodies that touch, infinity if there is no pair.
    pub distance: f64,
    /// Nearest points of the two bodies (m, root frame), without padding; NaN if there is no pair.
    pub points: [[f64; 3]; 2],
}

impl clearance_pair_distance {
    fn new(checker: &clearance_checker, found: Option<&PairDistance>) -> Self {
        let none = Self { pair: clearance_pair::NONE, distance: f64::INFINITY, points: [[f64::NAN; 3]; 2] };
        found.map_or(none, |found| Self {
            pair: checker.pair((found.a, found.b)),
            distance: found.distance,
            points: found.witness_points.each_ref().map(xyz),
        })
    }
}

/// Least distances in one state.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct clearance_distances {
    /// Of two bodies of the robot.
    pub self_pair: clearance_pair_distance,
    /// Of a body of the robot and an obstacle.
    pub world_pair: clearance_pair_distance,
}

/// Searches for the least distances within the robot, and between robot and world, up to `max_distance` (m).
///
/// Rejected: positions that are not finite, and a negative `max_distance`.
#[unsafe(no_mangle)]
pub extern "C" fn clearance_checker_distance(
    checker: *const clearance_checker,
    workspace: *mut clearance_workspace,
    state: clearance_state,
    max_distance: f64,
    distances: *mut clearance_distances,
) -> clearance_status {
    query_state(checker, workspace, state, |arguments, checker, memory| {
        check_length("max_distance", max_distance)?;
        let question = Question::SelfAndWorldDistance { limit: max_distance };
        let report = checker.checker.check(&memory.q, question, &mut memory.workspace);
        let [self_pair, world_pair] =
            PairKind::ALL.map(|kind| clearance_pair_distance::new(checker, report.nearest_of(kind)));
        arguments.write(distances, clearance_distances { self_pair, world_pair }, "distances")
    })
}

/// Rejects lengths below zero and NaN.
pub fn check_length(what: &str, value: f64) -> Outcome {
    if value >= 0.0 {
        Ok(())
    } else {
        Err(Failure::rejected(format!("{what} is {value}, but must be zero or more metres")))
    }
}

/// Extent of a report.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct clearance_report_options {
    /// Distances of pairs up to this (m) are reported. Default 0.1.
    pub max_distance: f64,
    /// Number of contacts of each colliding pair; 0 for none. Default 1.
    pub max_contacts: usize,
}

impl Default for clearance_report_options {
    fn default() -> Self {
        Self { max_distance: 0.1, max_contacts: 1 }
    }
}

/// The default extent of a report.
#[unsafe(no_mangle)]
pub extern "C" fn clearance_report_options_default() -> clearance_report_options {
    clearance_report_options::default()
}

/// A contact of two bodies, paddings included.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct clearance_contact {
    /// Names of the bodies, valid as long as the checker.
    pub pair: clearance_pair,
    /// Point of the contact (m, root frame).
    pub point: [f64; 3],
    /// Unit vector (root frame) along which the second body separates; NaN if it is not known.
    pub normal: [f64; 3],
    /// Length (m) of a translation along the normal after which the bodies are apart: the depth, or an upper bound on it; NaN if it is
    /// not known.
    pub depth: f64,
    /// Lower bound (m) on the depth.
    pub depth_lower: f64,
    /// True for the deepest contact of its pair, whose depth is that of the pair.
    pub is_deepest: bool,
}

impl clearance_contact {
    fn deepest(pair: clearance_pair, found: &Contact) -> Self {
        Self {
            pair,
            point: xyz(&found.point),
            normal: found.normal.map_or([f64::NAN; 3], Into::into),
            depth: found.depth.unwrap_or(f64::NAN),
            depth_lower: found.depth_lower,
            is_deepest: true,
        }
    }

    fn other(pair: clearance_pair, found: &LocalContact) -> Self {
        let (point, normal) = (xyz(&found.point), found.normal.into());
        Self {
            pair,
            point,
            normal,
            depth: found.depth.unwrap_or(f64::NAN),
            depth_lower: 0.0,
            is_deepest: false,
        }
    }
}

/// Report on one state. Arrays are valid until the next query with the workspace.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct clearance_report {
    /// True only if every pair is proven apart.
    pub is_free: bool,
    /// True if two bodies of the robot collide.
    pub self_collision: bool,
    /// True if a body of the robot collides with an obstacle.
    pub world_collision: bool,
    /// All colliding pairs.
    pub colliding_pairs: *const clearance_pair,
    /// Number of colliding pairs.
    pub colliding_pair_count: usize,
    /// Contacts of the colliding pairs, pair by pair, the deepest of each first.
    pub contacts: *const clearance_contact,
    /// Number of contacts.
    pub contact_count: usize,
    /// Distances of all pairs within the largest distance.
    pub distances: *const clearance_pair_distance,
    /// Number of distances.
    pub distance_count: usize,
}

/// Full report on a state: all colliding pairs, their contacts, and the distances of near pairs. Null `options` are the defaults.
///
/// Rejected: positions that are not finite, and a negative `max_distance`.
#[unsafe(no_mangle)]
pub extern "C" fn clearance_checker_check(
    checker: *const clearance_checker,
    workspace: *mut clearance_workspace,
    state: clearance_state,
    options: *const clearance_report_options,
    report: *mut clearance_report,
) -> clearance_status {
    query_state(checker, workspace, state, |arguments, checker, memory| {
        let options = arguments.object_or_none(options, "options")?.copied().unwrap_or_default();
        check_length("max_distance", options.max_distance)?;
        let question = Question::PairDistances { limit: options.max_distance };
        let found = checker.checker.check(&memory.q, question, &mut memory.workspace);
        let contacts = contacts(checker, memory, &found, options.max_contacts);
        let distances = found.pair_distances.iter();
        let results = &mut memory.results;
        results.pairs = found.colliding_pairs.iter().map(|&pair| checker.pair(pair)).collect();
        results.contacts = contacts;
        results.distances = distances.map(|pair| clearance_pair_distance::new(checker, Some(pair))).collect();
        arguments.write(report, results.report(&found), "report")
    })
}

fn contacts(
    checker: &clearance_checker,
    memory: &mut Memory,
    report: &CollisionReport,
    most: usize,
) -> Vec<clearance_contact> {
    let pairs = if most == 0 { &[][..] } else { &report.colliding_pairs };
    pairs.iter().flat_map(|&pair| contacts_of_pair(checker, memory, pair, most)).collect()
}

fn contacts_of_pair(
    checker: &clearance_checker,
    memory: &mut Memory,
    pair: (BodyId, BodyId),
    most: usize,
) -> Vec<clearance_contact> {
    let (names, Memory { q, workspace, .. }) = (checker.pair(pair), memory);
    let found = if most == 1 {
        let deepest = checker.checker.contact(q, pair, workspace);
        deepest.map(|deepest| PairContacts { deepest, others: vec![] })
    } else {
        checker.checker.contacts(q, pair, most, workspace)
    };
    let all = found.iter().flat_map(|PairContacts { deepest, others }| {
        let others = others.iter().map(|other| clearance_contact::other(names, other));
        std::iter::once(clearance_contact::deepest(names, deepest)).chain(others)
    });
    all.collect()
}

impl StateResults {
    fn report(&self, found: &CollisionReport) -> clearance_report {
        clearance_report {
            is_free: found.is_free(),
            self_collision: found.self_collision,
            world_collision: found.world_collision,
            colliding_pairs: self.pairs.as_ptr(),
            colliding_pair_count: self.pairs.len(),
            contacts: self.contacts.as_ptr(),
            contact_count: self.contacts.len(),
            distances: self.distances.as_ptr(),
            distance_count: self.distances.len(),
        }
    }
}

/// Signed distance of two bodies.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct clearance_pair_clearance {
    /// Names of the bodies, valid as long as the checker.
    pub pair: clearance_pair,
    /// Signed distance (m, padding subtracted): minus the penetration depth of bodies that overlap.
    pub distance: f64,
    /// Lower bound (m) on the signed distance; minus infinity if no translation is known that separates the bodies.
    pub lower: f64,
    /// Upper bound (m) on the signed distance.
    pub upper: f64,
    /// Nearest points of the two bodies (m, root frame), without padding.
    pub points: [[f64; 3]; 2],
    /// Unit vector (root frame) along which the second body moves away from the first; NaN if it is not known.
    pub normal: [f64; 3],
    /// True if the nearest points are unique, so that the signed distance has a derivative.
    pub is_unique: bool,
}

/// Signed distances of near pairs. Arrays are valid until the next query with the workspace.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct clearance_clearance {
    /// All pairs within the influence distance.
    pub pairs: *const clearance_pair_clearance,
    /// Number of pairs.
    pub pair_count: usize,
    /// pair_count x n derivatives of the signed distances with respect to the positions of the state (m/rad, m/m), row by row; zeros for a
    /// pair without normal.
    pub gradients: *const f64,
    /// Number of positions of a state.
    pub n: usize,
}

/// Signed distances of all pairs up to `influence_distance` (m), with nearest points, normals and derivatives.
///
/// Rejected: positions that are not finite, and an `influence_distance` that is no number. If it is negative, only pairs that overlap at
/// least as deep are reported.
#[unsafe(no_mangle)]
pub extern "C" fn clearance_checker_clearance(
    checker: *const clearance_checker,
    workspace: *mut clearance_workspace,
    state: clearance_state,
    influence_distance: f64,
    clearance: *mut clearance_clearance,
) -> clearance_status {
    query_state(checker, workspace, state, |arguments, checker, memory| {
        if influence_distance.is_nan() {
            return Err(Failure::rejected("influence_distance is NaN, but must be a number of metres"));
        }
        let found = checker.checker.clearance(&memory.q, influence_distance, &mut memory.workspace);
        let results = &mut memory.results;
        results.set_clearances(checker, &found);
        let written = clearance_clearance {
            pairs: results.clearances.as_ptr(),
            pair_count: results.clearances.len(),
            gradients: results.gradients.as_ptr(),
            n: checker.space.names().len(),
        };
        arguments.write(clearance, written, "clearance")
    })
}

impl StateResults {
    fn set_clearances(&mut self, checker: &clearance_checker, found: &Clearance) {
        let pairs = found.pairs.iter().map(|pair| clearance_pair_clearance {
            pair: checker.pair((pair.a, pair.b)),
            distance: pair.distance,
            lower: pair.lower,
            upper: pair.upper,
            points: pair.witness_points.each_ref().map(xyz),
            normal: pair.normal.map_or([f64::NAN; 3], Into::into),
            is_unique: pair.witnesses == WitnessCount::One,
        });
        self.clearances = pairs.collect();
        let rows = (0..found.pairs.len()).flat_map(|row| checker.space.select(found.row(row)));
        self.gradients = rows.collect();
    }
}
