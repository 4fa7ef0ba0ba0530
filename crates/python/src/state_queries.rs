//! Queries on states: free or not, distances, reports with contacts, and signed distances with derivatives.

use std::time::{Duration, Instant};

use clearance::checker::{Clearance, LocalContact, PairClearance, PairContacts, PairKind, WitnessCount};
use clearance::proximity::UnknownDepth;
use clearance::robot::Configuration;
use clearance::scene::BodyId;
use clearance::{CollisionChecker, CollisionReport, Contact, PairDistance, Question, Workspace};
use numpy::{PyArray1, PyArrayMethods, PyUntypedArray, PyUntypedArrayMethods};
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyList};

use crate::arrays::{Rows, array};
use crate::batches::evaluate;
use crate::checker_core::CheckerCore;
use crate::error::error;
use crate::memory::collected;
use crate::result_builder::{names, result, xyz};
use crate::workspaces::{QueryMemory, with_memory};

/// A single state releases the GIL if the last measured one took longer: for shorter ones, to get it back may cost more than to keep it.
const SHORT: Duration = Duration::from_micros(20);
/// While states are short, one in so many is measured.
const MEASURED: u64 = 16;

/// Whether states are free: a bool, or an array of them.
pub fn is_free<'py>(
    py: Python<'py>,
    core: &CheckerCore,
    q: &Bound<'py, PyAny>,
    threads: Option<usize>,
) -> PyResult<Bound<'py, PyAny>> {
    if q.cast_exact::<PyUntypedArray>().is_ok()
        && let Ok(single) = q.cast::<PyArray1<f64>>()
        && single.len() == core.space.names().len()
        // a copy of some numbers takes less time than the registration of a borrow
        && let Ok(row) = single.to_vec()
    {
        let free = is_single_free(py, core, &row)?;
        return Ok(PyBool::new(py, free).to_owned().into_any());
    }
    let rows = Rows::new(q, "q", core.space.names())?;
    if rows.is_single() {
        let free = is_single_free(py, core, rows.table().row(0))?;
        return Ok(PyBool::new(py, free).to_owned().into_any());
    }
    let check = |memory: &mut QueryMemory, count: usize, free: &mut [bool]| {
        let QueryMemory { workspace, block, .. } = memory;
        core.checker.are_free_with(&block[..count], workspace, free);
    };
    let free = evaluate(core, &rows, threads, false, check, py)?;
    Ok(array(py, free, rows.leading())?.into_any())
}

fn is_single_free(py: Python<'_>, core: &CheckerCore, row: &[f64]) -> PyResult<bool> {
    with_memory(core, |memory| {
        let QueryMemory { workspace, block, row: scratch, last_check, single_checks, .. } = memory;
        let q = &mut block[0];
        core.space.move_into(row, scratch, q).map_err(|why| error(format!("q: {why}")))?;
        let is_short = *last_check <= SHORT;
        let is_measured = single_checks.is_multiple_of(MEASURED);
        *single_checks += 1;
        if is_short && !is_measured {
            return Ok(core.checker.is_free(q, workspace));
        }
        let begin = Instant::now();
        let mut check = || core.checker.is_free(q, workspace);
        let free = if is_short { check() } else { py.detach(check) };
        *last_check = begin.elapsed();
        Ok(free)
    })
}

/// Evaluates each row by itself, and converts the results: one, or a list of shape (...).
fn each<'py, T: Send + Clone + Default>(
    py: Python<'py>,
    core: &CheckerCore,
    q: &Bound<'py, PyAny>,
    threads: Option<usize>,
    query: impl Fn(&Configuration, &mut Workspace) -> T + Sync,
    convert: impl Fn(&T) -> PyResult<Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyAny>> {
    let rows = Rows::new(q, "q", core.space.names())?;
    let results = evaluate_each(py, core, &rows, threads, query)?;
    let mut converted = collected([], results.len())?;
    for result in &results {
        converted.push(convert(result)?);
    }
    nested(py, converted, rows.leading())
}

/// Evaluates each row by itself.
fn evaluate_each<T: Send + Clone + Default>(
    py: Python<'_>,
    core: &CheckerCore,
    rows: &Rows<'_>,
    threads: Option<usize>,
    query: impl Fn(&Configuration, &mut Workspace) -> T + Sync,
) -> PyResult<Vec<T>> {
    let one_by_one = |memory: &mut QueryMemory, count: usize, results: &mut [T]| {
        let QueryMemory { workspace, block, .. } = memory;
        for (q, result) in block[..count].iter().zip(results) {
            *result = query(q, workspace);
        }
    };
    evaluate(core, rows, threads, T::default(), one_by_one, py)
}

/// Lists in lists, as deep as the shape is long.
pub fn nested<'py>(
    py: Python<'py>,
    values: Vec<Bound<'py, PyAny>>,
    shape: &[usize],
) -> PyResult<Bound<'py, PyAny>> {
    let Some((length, inner)) = shape.split_first() else {
        return values.into_iter().next().ok_or_else(|| error("there is no result"));
    };
    if inner.is_empty() {
        return Ok(PyList::new(py, values)?.into_any());
    }
    let size: usize = inner.iter().product();
    let list = PyList::empty(py);
    for i in 0..*length {
        list.append(nested(py, values[i * size..(i + 1) * size].to_vec(), inner)?)?;
    }
    Ok(list.into_any())
}

/// The least distance of one kind of pairs in one state.
#[derive(Clone, Default)]
struct Nearest {
    /// Infinite if nothing is within the limit.
    distance: Option<f64>,
    pair: Option<(BodyId, BodyId)>,
    points: Option<[[f64; 3]; 2]>,
    gradient: Vec<f64>,
}

impl Nearest {
    fn of_distance(found: &PairDistance) -> Self {
        let points = Some(found.witness_points.each_ref().map(xyz));
        Self { distance: Some(found.distance), pair: Some((found.a, found.b)), points, gradient: Vec::new() }
    }

    fn of_clearance(clearance: &Clearance, kind: PairKind, core: &CheckerCore) -> Self {
        let of_kind = clearance.pairs.iter().enumerate().filter(|(_, p)| PairKind::of_second(p.b) == kind);
        let nearest = of_kind.min_by(|(_, a), (_, b)| a.distance.total_cmp(&b.distance));
        nearest.map_or_else(Self::default, |(row, pair)| Self {
            distance: Some(pair.distance),
            pair: Some((pair.a, pair.b)),
            points: Some(pair.witness_points.each_ref().map(xyz)),
            gradient: core.space.select(clearance.row(row)),
        })
    }
}

/// Least distances of self pairs and world pairs.
pub fn distance<'py>(
    py: Python<'py>,
    core: &CheckerCore,
    q: &Bound<'py, PyAny>,
    (limit, gradients): (f64, bool),
    threads: Option<usize>,
) -> PyResult<Bound<'py, PyAny>> {
    let rows = Rows::new(q, "q", core.space.names())?;
    let found = evaluate_each(py, core, &rows, threads, |q, workspace| {
        if gradients {
            let clearance = core.checker.clearance(q, limit, workspace);
            return PairKind::ALL.map(|kind| Nearest::of_clearance(&clearance, kind, core));
        }
        let report = core.checker.check(q, Question::SelfAndWorldDistance { limit }, workspace);
        PairKind::ALL.map(|kind| report.nearest_of(kind).map_or_else(Nearest::default, Nearest::of_distance))
    })?;
    let side = |kind: usize| {
        let found = collected(found.iter().map(|both| &both[kind]), found.len())?;
        PyResult::Ok(Side { core, rows: &rows, found })
    };
    let [of_self, of_world] = [side(0)?, side(1)?];
    let [self_gradient, world_gradient] =
        if gradients { [Some(of_self.gradients(py)?), Some(of_world.gradients(py)?)] } else { [None, None] };
    result!(py, "Distances",
        self_distance: of_self.distances(py)?, self_pair: of_self.pairs(py)?, self_points: of_self.points(py)?,
        self_gradient: self_gradient,
        world_distance: of_world.distances(py)?, world_pair: of_world.pairs(py)?, world_points: of_world.points(py)?,
        world_gradient: world_gradient)
}

/// Results of all rows for one kind of pairs.
struct Side<'a, 'py> {
    core: &'a CheckerCore,
    rows: &'a Rows<'py>,
    found: Vec<&'a Nearest>,
}

impl<'py> Side<'_, 'py> {
    fn shape(&self, last: &[usize]) -> Vec<usize> {
        [self.rows.leading(), last].concat()
    }

    fn distances(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let distances = self.found.iter().map(|n| n.distance.unwrap_or(f64::INFINITY));
        let distances = collected(distances, self.found.len())?;
        match distances[..] {
            [distance] if self.rows.is_single() => Ok(distance.into_pyobject(py)?.into_any()),
            _ => Ok(array(py, distances, self.rows.leading())?.into_any()),
        }
    }

    fn pairs(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let names = |found: &&Nearest| found.pair.map(|(a, b)| names(&self.core.checker, a, b));
        if self.rows.is_single() {
            return Ok(self.found.first().and_then(names).into_pyobject(py)?.into_any());
        }
        let all = self.found.iter().map(|found| names(found).unwrap_or_default());
        let all = collected(all, self.found.len())?;
        let made = py.import("numpy")?.call_method1("array", (all, "U"))?;
        made.call_method1("reshape", (self.shape(&[2]),))
    }

    fn points(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let points = self.found.iter().flat_map(|n| n.points.unwrap_or([[f64::NAN; 3]; 2])).flatten();
        Ok(array(py, collected(points, 6 * self.found.len())?, &self.shape(&[2, 3]))?.into_any())
    }

    fn gradients(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let columns = self.core.space.names().len();
        let none = vec![0.0; columns];
        let rows = self.found.iter().flat_map(|n| if n.gradient.is_empty() { &none } else { &n.gradient });
        let rows = collected(rows.copied(), columns * self.found.len())?;
        Ok(array(py, rows, &self.shape(&[columns]))?.into_any())
    }
}

/// A report and the contacts of its colliding pairs.
#[derive(Clone, Default)]
struct FullReport {
    report: CollisionReport,
    contacts: Vec<((BodyId, BodyId), PairContacts)>,
}

/// Full reports on states.
pub fn check<'py>(
    py: Python<'py>,
    core: &CheckerCore,
    q: &Bound<'py, PyAny>,
    (limit, most_contacts): (f64, usize),
    threads: Option<usize>,
) -> PyResult<Bound<'py, PyAny>> {
    let query = |q: &Configuration, workspace: &mut Workspace| {
        let report = core.checker.check(q, Question::PairDistances { limit }, workspace);
        let contacts = report.colliding_pairs.iter().filter(|_| most_contacts > 0).filter_map(|&pair| {
            let found = match most_contacts {
                1 => core
                    .checker
                    .contact(q, pair, workspace)
                    .map(|deepest| PairContacts { deepest, others: vec![] }),
                most => core.checker.contacts(q, pair, most, workspace),
            };
            Some((pair, found?))
        });
        let contacts = contacts.collect();
        FullReport { report, contacts }
    };
    each(py, core, q, threads, query, |found| collision_report(py, &core.checker, found))
}

fn collision_report<'py>(
    py: Python<'py>,
    checker: &CollisionChecker,
    FullReport { report, contacts }: &FullReport,
) -> PyResult<Bound<'py, PyAny>> {
    let measured = |found: &Option<PairDistance>| {
        found.as_ref().map(|pair| pair_distance(py, checker, pair)).transpose()
    };
    let pairs: Vec<_> = report.colliding_pairs.iter().map(|&(a, b)| names(checker, a, b)).collect();
    let distances = report.pair_distances.iter().map(|pair| pair_distance(py, checker, pair));
    let distances = distances.collect::<PyResult<Vec<_>>>()?;
    let mut all_contacts = Vec::new();
    for ((a, b), PairContacts { deepest, others }) in contacts {
        let pair = names(checker, *a, *b);
        all_contacts.push(contact(py, pair.clone(), deepest)?);
        for other in others {
            all_contacts.push(local_contact(py, pair.clone(), other)?);
        }
    }
    result!(py, "CollisionReport",
        free: report.is_free(), self_collision: report.self_collision, world_collision: report.world_collision,
        pairs: pairs, contacts: all_contacts, nearest: measured(&report.nearest)?,
        nearest_self: measured(&report.nearest_self)?, nearest_world: measured(&report.nearest_world)?,
        distances: distances)
}

fn pair_distance<'py>(
    py: Python<'py>,
    checker: &CollisionChecker,
    found: &PairDistance,
) -> PyResult<Bound<'py, PyAny>> {
    let points = array(py, found.witness_points.iter().flat_map(xyz).collect(), &[2, 3])?;
    result!(py, "PairDistance", pair: names(checker, found.a, found.b), distance: found.distance, points: points)
}

fn contact<'py>(py: Python<'py>, pair: (String, String), found: &Contact) -> PyResult<Bound<'py, PyAny>> {
    let normal = found.normal.map(|n| PyArray1::from_slice(py, n.as_slice()));
    result!(py, "Contact",
        pair: pair, point: PyArray1::from_slice(py, &xyz(&found.point)), normal: normal, depth: found.depth,
        depth_lower: found.depth_lower, reason: found.unknown.map(UnknownDepth::code), is_deepest: true)
}

fn local_contact<'py>(
    py: Python<'py>,
    pair: (String, String),
    found: &LocalContact,
) -> PyResult<Bound<'py, PyAny>> {
    result!(py, "Contact",
        pair: pair, point: PyArray1::from_slice(py, &xyz(&found.point)),
        normal: PyArray1::from_slice(py, found.normal.as_slice()), depth: found.depth, depth_lower: 0.0,
        reason: None::<&str>, is_deepest: false)
}

/// Signed distances of near pairs, with derivatives.
pub fn clearance<'py>(
    py: Python<'py>,
    core: &CheckerCore,
    q: &Bound<'py, PyAny>,
    influence_distance: f64,
    threads: Option<usize>,
) -> PyResult<Bound<'py, PyAny>> {
    let query = |q: &Configuration, workspace: &mut Workspace| {
        core.checker.clearance(q, influence_distance, workspace)
    };
    each(py, core, q, threads, query, |found| clearance_report(py, core, found))
}

fn clearance_report<'py>(
    py: Python<'py>,
    core: &CheckerCore,
    found: &Clearance,
) -> PyResult<Bound<'py, PyAny>> {
    let (count, columns) = (found.pairs.len(), core.space.names().len());
    let values =
        |of: &dyn Fn(&PairClearance) -> f64| PyArray1::from_vec(py, found.pairs.iter().map(of).collect());
    let pairs: Vec<_> = found.pairs.iter().map(|pair| names(&core.checker, pair.a, pair.b)).collect();
    let points = found.pairs.iter().flat_map(|pair| pair.witness_points).flat_map(|p| xyz(&p)).collect();
    let normal = |pair: &PairClearance| pair.normal.map_or([f64::NAN; 3], Into::into);
    let gradients = (0..count).flat_map(|row| core.space.select(found.row(row))).collect();
    let unique = found.pairs.iter().map(|pair| pair.witnesses == WitnessCount::One).collect();
    result!(py, "Clearance",
        pairs: pairs, distances: values(&|pair| pair.distance), lower: values(&|pair| pair.lower),
        upper: values(&|pair| pair.upper), points: array(py, points, &[count, 2, 3])?,
        normals: array(py, found.pairs.iter().flat_map(normal).collect(), &[count, 3])?,
        gradients: array(py, gradients, &[count, columns])?, unique: PyArray1::from_vec(py, unique))
}

/// The configuration of the whole robot for an argument of shape (n,).
pub fn single(core: &CheckerCore, q: &Bound<'_, PyAny>, what: &str) -> PyResult<Configuration> {
    let rows = Rows::new(q, what, core.space.names())?;
    if !rows.is_single() {
        return Err(error(format!("{what} must be one state of shape ({},)", core.space.names().len())));
    }
    core.space.read(rows.table().row(0)).map_err(|why| error(format!("{what}: {why}")))
}
