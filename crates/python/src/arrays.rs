//! Conversion of Python arguments to arrays of numbers and rows of joint positions, and of results to NumPy arrays.

use std::collections::HashSet;

use numpy::{
    PyArray1, PyArrayDyn, PyArrayMethods, PyReadonlyArrayDyn, PyUntypedArray, PyUntypedArrayMethods,
};
use pyo3::exceptions::{PyMemoryError, PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyFloat, PyList, PyTuple};

/// Numbers of an argument: C-contiguous float64, of any shape.
pub struct Numbers<'py> {
    array: PyReadonlyArrayDyn<'py, f64>,
}

impl<'py> Numbers<'py> {
    /// Reads an argument; `what` is its name in errors. An array that is not float64 and C-contiguous is converted.
    pub fn new(value: &Bound<'py, PyAny>, what: &str) -> PyResult<Self> {
        // no subclass: one may not be what its memory is
        if value.cast_exact::<PyUntypedArray>().is_ok()
            && let Ok(array) = value.cast::<PyArrayDyn<f64>>()
            && array.is_c_contiguous()
            && array.is_aligned()
        {
            return Ok(Self { array: array.readonly() });
        }
        let numpy = value.py().import("numpy")?;
        let masked = numpy.getattr("ma")?.getattr("MaskedArray")?;
        if is_masked(value, &masked, &mut HashSet::new())? {
            return Err(PyTypeError::new_err(format!(
                "{what} is or contains a masked array, whose masked entries have no value: give their values with {what}.filled(...), or \
                 leave out their rows with numpy.ma.compress_rows({what})"
            )));
        }
        let ragged = |error: PyErr| {
            // an interrupt, or a lack of memory, is none of the array
            if !error.is_instance_of::<PyTypeError>(value.py())
                && !error.is_instance_of::<PyValueError>(value.py())
            {
                return error;
            }
            PyTypeError::new_err(format!(
                "{what} must be an array of real numbers, but it is none of one shape: {error}"
            ))
        };
        let array = numpy.call_method1("asarray", (value,)).map_err(ragged)?;
        let kind: String = array.getattr("dtype")?.getattr("kind")?.extract()?;
        let is_empty = array.getattr("size")?.extract::<usize>()? == 0;
        if !matches!(kind.as_str(), "f" | "i" | "u") && !is_empty {
            let dtype = array.getattr("dtype")?.str()?.to_string();
            let name = value.get_type().name()?.to_string();
            return Err(PyTypeError::new_err(format!(
                "{what} must be an array of real numbers (float64), but it is of type {name} with dtype {dtype}"
            )));
        }
        let array = numpy.call_method1("require", (array, "float64", ["C_CONTIGUOUS", "ALIGNED"]))?;
        Ok(Self { array: array.cast::<PyArrayDyn<f64>>()?.readonly() })
    }

    /// All numbers, the last index fastest.
    pub fn values(&self) -> &[f64] {
        self.array.as_slice().unwrap_or_default()
    }

    /// Lengths of the dimensions.
    pub fn shape(&self) -> &[usize] {
        self.array.shape()
    }

    /// The numbers as `N`; `form` says in words what is expected.
    pub fn fixed<const N: usize>(&self, what: &str, form: &str) -> PyResult<[f64; N]> {
        let given = (self.shape().len() == 1).then(|| self.values().try_into().ok()).flatten();
        given.ok_or_else(|| wrong_shape(what, self.shape(), form))
    }

    /// The numbers as rows of three.
    pub fn rows_of_three(&self, what: &str) -> PyResult<Vec<[f64; 3]>> {
        match self.shape() {
            [_, 3] => Ok(self.values().chunks_exact(3).map(|row| [row[0], row[1], row[2]]).collect()),
            shape => Err(wrong_shape(what, shape, "must be (N, 3)")),
        }
    }
}

/// True for a masked array, and for lists that contain one. `seen` has the lists that were looked at: a list may contain itself.
fn is_masked(
    value: &Bound<'_, PyAny>,
    masked: &Bound<'_, PyAny>,
    seen: &mut HashSet<usize>,
) -> PyResult<bool> {
    if value.is_instance(masked)? {
        return Ok(true);
    }
    let items: Vec<Bound<'_, PyAny>> = match (value.cast::<PyList>(), value.cast::<PyTuple>()) {
        (Ok(list), _) => list.iter().collect(),
        (_, Ok(tuple)) => tuple.iter().collect(),
        _ => return Ok(false),
    };
    if !seen.insert(value.as_ptr() as usize) {
        return Ok(false);
    }
    for item in items {
        if !item.is_exact_instance_of::<PyFloat>() && is_masked(&item, masked, seen)? {
            return Ok(true);
        }
    }
    Ok(false)
}

/// Rows of joint positions: an argument of shape (..., n) with n positions each.
pub struct Rows<'py> {
    numbers: Numbers<'py>,
    columns: usize,
}

impl<'py> Rows<'py> {
    /// Reads an argument whose last dimension has one position for each of `names`.
    pub fn new(value: &Bound<'py, PyAny>, what: &str, names: &[String]) -> PyResult<Self> {
        let numbers = Numbers::new(value, what)?;
        if numbers.shape().last() == Some(&names.len()) {
            return Ok(Self { numbers, columns: names.len() });
        }
        let form = format!("must be (..., {}): one position for each of {}", names.len(), names.join(", "));
        Err(wrong_shape(what, numbers.shape(), &form))
    }

    /// Shape without the last dimension; empty for a single state.
    pub fn leading(&self) -> &[usize] {
        let shape = self.numbers.shape();
        &shape[..shape.len() - 1]
    }

    /// True for a single state, of shape (n,).
    pub fn is_single(&self) -> bool {
        self.leading().is_empty()
    }

    /// Number of rows.
    pub fn count(&self) -> usize {
        self.leading().iter().product()
    }

    /// All rows, one after the other.
    pub fn table(&self) -> Table<'_> {
        Table { values: self.numbers.values(), columns: self.columns }
    }

    /// Name of a row in errors, such as ` in row [3, 0]`; nothing for a single state.
    pub fn place(&self, row: usize) -> String {
        let (mut rest, mut index) = (row, Vec::new());
        for length in self.leading().iter().rev() {
            index.push(rest % length);
            rest /= length;
        }
        index.reverse();
        if index.is_empty() { String::new() } else { format!(" in row {index:?}") }
    }
}

/// Rows of equal length, which threads can share.
#[derive(Clone, Copy)]
pub struct Table<'a> {
    values: &'a [f64],
    columns: usize,
}

impl<'a> Table<'a> {
    /// A row.
    pub fn row(&self, index: usize) -> &'a [f64] {
        &self.values[index * self.columns..(index + 1) * self.columns]
    }
}

/// Two arguments of shapes (..., n), broadcast to one shape by the rules of NumPy; nothing is copied.
pub struct Pairing {
    /// The shape without the last dimension.
    pub shape: Vec<usize>,
    /// For each argument and dimension: by how much the row changes with the index.
    steps: [Vec<usize>; 2],
}

impl Pairing {
    /// Of two arguments with these names.
    pub fn new([a, b]: [&Rows<'_>; 2], [name_a, name_b]: [&str; 2]) -> PyResult<Self> {
        let length = |shape: &[usize], dimension: usize, depth: usize| {
            (dimension + shape.len()).checked_sub(depth).map_or(1, |own| shape[own])
        };
        let depth = a.leading().len().max(b.leading().len());
        let mut shape = Vec::with_capacity(depth);
        for dimension in 0..depth {
            match [a, b].map(|rows| length(rows.leading(), dimension, depth)) {
                [one, other] if one == other || other == 1 => shape.push(one),
                [1, other] => shape.push(other),
                _ => {
                    let text = format!(
                        "{name_a} of shape {} and {name_b} of shape {} can not be broadcast to one shape",
                        shape_text(a.numbers.shape()),
                        shape_text(b.numbers.shape())
                    );
                    return Err(PyValueError::new_err(text));
                }
            }
        }
        if shape.iter().try_fold(1_usize, |count, length| count.checked_mul(*length)).is_none() {
            return Err(PyMemoryError::new_err(format!("{name_a} and {name_b} have too many pairs of rows")));
        }
        let steps = [a, b].map(|rows| {
            let (mut steps, mut step) = (vec![0; depth], 1);
            for dimension in (0..depth).rev() {
                let own = length(rows.leading(), dimension, depth);
                steps[dimension] = if own == 1 { 0 } else { step };
                step *= own;
            }
            steps
        });
        Ok(Self { shape, steps })
    }

    /// Number of pairs of rows.
    pub fn count(&self) -> usize {
        self.shape.iter().product()
    }

    /// Row of the first (0) or second (1) argument in a pair.
    pub fn row(&self, argument: usize, pair: usize) -> usize {
        let (mut rest, mut row) = (pair, 0);
        for (length, step) in self.shape.iter().zip(&self.steps[argument]).rev() {
            row += rest % length * step;
            rest /= length;
        }
        row
    }
}

/// The error about a wrong shape: `form` says what it must be.
pub fn wrong_shape(what: &str, shape: &[usize], form: &str) -> PyErr {
    PyValueError::new_err(format!("{what} has shape {}, but it {form}", shape_text(shape)))
}

/// A shape as Python shows it.
fn shape_text(shape: &[usize]) -> String {
    match shape {
        [length] => format!("({length},)"),
        _ => format!("({})", shape.iter().map(ToString::to_string).collect::<Vec<_>>().join(", ")),
    }
}

/// An array of this shape with these values, which are as many.
pub fn array<'py, T: numpy::Element>(
    py: Python<'py>,
    values: Vec<T>,
    shape: &[usize],
) -> PyResult<Bound<'py, PyArrayDyn<T>>> {
    PyArray1::from_vec(py, values).reshape(shape.to_vec())
}
