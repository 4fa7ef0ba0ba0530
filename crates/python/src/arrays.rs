//! Conversion of NumPy arrays and whatever NumPy makes arrays of.

use numpy::{PyArray1, PyArrayDyn, PyArrayMethods, PyReadonlyArrayDyn, PyUntypedArrayMethods};
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;

/// Numbers of an argument: C-contiguous float64, of any shape.
pub struct Numbers<'py> {
    array: PyReadonlyArrayDyn<'py, f64>,
}

impl<'py> Numbers<'py> {
    /// Reads an argument; `what` is its name in errors. An array that is not float64 and C-contiguous is converted.
    pub fn new(value: &Bound<'py, PyAny>, what: &str) -> PyResult<Self> {
        if let Ok(array) = value.cast::<PyArrayDyn<f64>>()
            && array.is_c_contiguous()
            && array.is_aligned()
        {
            return Ok(Self { array: array.readonly() });
        }
        let numpy = value.py().import("numpy")?;
        let ragged = |error: PyErr| {
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

/// Broadcasts two arguments of shapes (..., n) to one shape.
pub fn broadcast<'py>(
    [a, b]: [&Bound<'py, PyAny>; 2],
    [name_a, name_b]: [&str; 2],
) -> PyResult<[Bound<'py, PyAny>; 2]> {
    let numpy = a.py().import("numpy")?;
    let shape = |x: &Bound<'py, PyAny>| numpy.call_method1("shape", (x,));
    let (shape_a, shape_b) = (shape(a)?, shape(b)?);
    if shape_a.eq(&shape_b)? {
        return Ok([a.clone(), b.clone()]);
    }
    let both = numpy.call_method1("broadcast_arrays", (a, b)).map_err(|_| {
        PyValueError::new_err(format!(
            "{name_a} of shape {shape_a} and {name_b} of shape {shape_b} can not be broadcast to one shape"
        ))
    })?;
    Ok([both.get_item(0)?, both.get_item(1)?])
}

/// The error about a wrong shape: `form` says what it must be.
pub fn wrong_shape(what: &str, shape: &[usize], form: &str) -> PyErr {
    let shape = match shape {
        [length] => format!("({length},)"),
        _ => format!("({})", shape.iter().map(ToString::to_string).collect::<Vec<_>>().join(", ")),
    };
    PyValueError::new_err(format!("{what} has shape {shape}, but it {form}"))
}

/// An array of this shape with these values, which are as many.
pub fn array<'py, T: numpy::Element>(
    py: Python<'py>,
    values: Vec<T>,
    shape: &[usize],
) -> PyResult<Bound<'py, PyArrayDyn<T>>> {
    PyArray1::from_vec(py, values).reshape(shape.to_vec())
}
