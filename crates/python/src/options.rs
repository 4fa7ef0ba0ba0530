//! Conversion of option values from Python; every error names the option and the value.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::time::{Duration, Instant};

use pyo3::exceptions::{PyOverflowError, PyTypeError};
use pyo3::prelude::*;
use pyo3::types::PyMapping;

use crate::error::error;

/// Largest number of threads.
const MOST_THREADS: u64 = 1024;

/// Characters of a value that an error shows.
const SHOWN: usize = 60;

/// Conversion functions of arguments: each has the name of the option that it converts.
macro_rules! options {
    ($($name:ident: $type:ty = $convert:expr;)*) => {
        $(
            pub fn $name(value: &Bound<'_, PyAny>) -> PyResult<$type> {
                $convert(stringify!($name), value)
            }
        )*
    };
}

options! {
    absolute_tolerance: f64 = length;
    allow: Vec<(String, String)> = pairs_of_names;
    any_contact: bool = flag;
    budget: u64 = count;
    clearance: f64 = length;
    counts: Option<BTreeMap<String, usize>> =
        |name, value| Ok(optional(name, value, counts_by_link)?.map(BTreeMap::from_iter));
    edge: f64 = number;
    influence_distance: f64 = real;
    event_distance: f64 = |_, value| length("distance", value);
    excess: Option<f64> = |name, value| optional(name, value, tolerance_of);
    fixed: BTreeMap<String, f64> =
        |name, value| Ok(optional(name, value, numbers_by_name)?.into_iter().flatten().collect());
    inner: bool = flag;
    length_of_shape: f64 = |_, value| number("length", value);
    links: Option<Vec<String>> = |name, value| optional(name, value, names);
    locked: Vec<String> = names;
    margin: f64 = length;
    margin_if_any: Option<f64> = |_, value| optional("margin", value, length);
    max_boxes: Option<u64> = |name, value| optional(name, value, count);
    max_checks: u64 = count;
    max_contacts: usize = size_of;
    max_distance: f64 = length_or_infinity;
    max_edges: u64 = count;
    num_threads: Option<usize> = threads;
    offset: f64 = number;
    package_paths: Vec<PathBuf> = |name, value| extract(name, value, "a list of paths");
    point_radius: Option<f64> = |name, value| optional(name, value, number);
    port: u16 = |name, value| whole(name, value, u64::from(u16::MAX));
    positions: BTreeMap<String, f64> = |name, value| Ok(numbers_by_name(name, value)?.into_iter().collect());
    radius: f64 = number;
    range: f64 = number;
    relative_tolerance: f64 = length;
    search_distance: f64 = |_, value| length("max_distance", value);
    seed: u64 = count;
    shape_count: usize = |_, value| at_least("count", value, 1);
    shortcuts: u32 = |name, value| whole(name, value, u64::from(u32::MAX));
    sphere_count: Option<usize> = |_, value| optional("count", value, |name, value| at_least(name, value, 1));
    size: Option<usize> = |name, value| optional(name, value, size_of);
    timeout: Option<Instant> = |name, value| Ok(optional(name, value, deadline)?.flatten());
    tolerance: f64 = tolerance_of;
    total: Option<usize> = |name, value| optional(name, value, |name, value| at_least(name, value, 1));
    tolerance_if_any: Option<f64> = |_, value| optional("tolerance", value, tolerance_of);
    touch_links: Vec<String> = names;
    triangle_count: Option<usize> = |_, value| optional("count", value, |name, value| at_least(name, value, 4));
}

/// The error about a value; `form` says what it must be.
fn bad(name: &str, value: &Bound<'_, PyAny>, form: &str) -> String {
    let given = value.repr().map_or_else(|_| "something else".to_owned(), |text| text.to_string());
    let short: String = given.chars().take(SHOWN).collect();
    let rest = if short.len() < given.len() { "..." } else { "" };
    format!("{name} is {short}{rest}, but must be {form}")
}

/// The error about a value that was not extracted. Numbers out of range are errors about values, all others errors about types.
fn unfit(name: &str, value: &Bound<'_, PyAny>, form: &str, why: &PyErr) -> PyErr {
    let text = bad(name, value, form);
    if why.is_instance_of::<PyOverflowError>(value.py()) { error(text) } else { PyTypeError::new_err(text) }
}

/// Extracts a value.
fn extract<T>(name: &str, value: &Bound<'_, PyAny>, form: &str) -> PyResult<T>
where
    T: for<'a, 'py> FromPyObject<'a, 'py, Error = PyErr>,
{
    value.extract().map_err(|why: PyErr| unfit(name, value, form, &why))
}

fn optional<T>(
    name: &str,
    value: &Bound<'_, PyAny>,
    convert: impl Fn(&str, &Bound<'_, PyAny>) -> PyResult<T>,
) -> PyResult<Option<T>> {
    if value.is_none() { Ok(None) } else { convert(name, value).map(Some) }
}

fn number(name: &str, value: &Bound<'_, PyAny>) -> PyResult<f64> {
    extract(name, value, "a number (float64)")
}

fn checked(
    name: &str,
    value: &Bound<'_, PyAny>,
    form: &str,
    is_valid: impl Fn(f64) -> bool,
) -> PyResult<f64> {
    let given = extract(name, value, form)?;
    if is_valid(given) { Ok(given) } else { Err(error(format!("{name} is {given}, but must be {form}"))) }
}

fn real(name: &str, value: &Bound<'_, PyAny>) -> PyResult<f64> {
    checked(name, value, "a number of metres", |given| !given.is_nan())
}

fn length(name: &str, value: &Bound<'_, PyAny>) -> PyResult<f64> {
    checked(name, value, "a finite number, zero or more", |given| given >= 0.0 && given.is_finite())
}

fn length_or_infinity(name: &str, value: &Bound<'_, PyAny>) -> PyResult<f64> {
    checked(name, value, "zero or more metres", |given| given >= 0.0)
}

fn tolerance_of(name: &str, value: &Bound<'_, PyAny>) -> PyResult<f64> {
    checked(name, value, "a finite number of metres above zero", |given| given > 0.0 && given.is_finite())
}

/// Time after so many seconds; none if they are infinite, or more than clocks can count.
fn deadline(name: &str, value: &Bound<'_, PyAny>) -> PyResult<Option<Instant>> {
    let seconds = checked(name, value, "zero or more seconds", |given| given >= 0.0)?;
    Ok(Duration::try_from_secs_f64(seconds).ok().and_then(|span| Instant::now().checked_add(span)))
}

fn names(name: &str, value: &Bound<'_, PyAny>) -> PyResult<Vec<String>> {
    extract(name, value, "a list of names")
}

/// Pairs of names, each a tuple or a list.
pub fn pairs_of_names(name: &str, value: &Bound<'_, PyAny>) -> PyResult<Vec<(String, String)>> {
    let form = "a list of pairs of names";
    let pairs: Vec<Vec<String>> = extract(name, value, form)?;
    let pair_of = |pair: Vec<String>| match <[String; 2]>::try_from(pair) {
        Ok([a, b]) => Ok((a, b)),
        Err(_) => Err(PyTypeError::new_err(bad(name, value, form))),
    };
    pairs.into_iter().map(pair_of).collect()
}

/// Numbers by name, of any mapping.
pub fn numbers_by_name(name: &str, value: &Bound<'_, PyAny>) -> PyResult<Vec<(String, f64)>> {
    by_name(name, value, "a dict from names to numbers")
}

fn counts_by_link(name: &str, value: &Bound<'_, PyAny>) -> PyResult<Vec<(String, usize)>> {
    by_name(name, value, "a dict from names of links to whole numbers")
}

fn by_name<T>(name: &str, value: &Bound<'_, PyAny>, form: &str) -> PyResult<Vec<(String, T)>>
where
    T: for<'a, 'py> FromPyObject<'a, 'py>,
{
    let Ok(mapping) = value.cast::<PyMapping>() else {
        return Err(PyTypeError::new_err(bad(name, value, form)));
    };
    let items: PyResult<Vec<(String, T)>> = mapping.items()?.extract();
    items.map_err(|why| unfit(name, value, form, &why))
}

fn flag(name: &str, value: &Bound<'_, PyAny>) -> PyResult<bool> {
    extract(name, value, "True or False")
}

fn whole<T: TryFrom<u64>>(name: &str, value: &Bound<'_, PyAny>, most: u64) -> PyResult<T> {
    let form = match most {
        u64::MAX => "a whole number, zero or more".to_owned(),
        most => format!("a whole number from 0 to {most}"),
    };
    let given: u64 = extract(name, value, &form)?;
    T::try_from(given).map_err(|_| error(bad(name, value, &form)))
}

fn count(name: &str, value: &Bound<'_, PyAny>) -> PyResult<u64> {
    whole(name, value, u64::MAX)
}

fn size_of(name: &str, value: &Bound<'_, PyAny>) -> PyResult<usize> {
    whole(name, value, usize::MAX as u64)
}

/// A whole number that is not below `least`.
fn at_least(name: &str, value: &Bound<'_, PyAny>, least: usize) -> PyResult<usize> {
    let form = format!("a whole number, {least} or more");
    let given: u64 = extract(name, value, &form)?;
    let given = usize::try_from(given).ok().filter(|given| *given >= least);
    given.ok_or_else(|| error(bad(name, value, &form)))
}

fn threads(name: &str, value: &Bound<'_, PyAny>) -> PyResult<Option<usize>> {
    let form = format!("None or a whole number from 1 to {MOST_THREADS}");
    let given: Option<u64> = optional(name, value, |name, value| extract(name, value, &form))?;
    match given {
        Some(given) if !(1..=MOST_THREADS).contains(&given) => Err(error(bad(name, value, &form))),
        _ => Ok(given.and_then(|given| usize::try_from(given).ok())),
    }
}
