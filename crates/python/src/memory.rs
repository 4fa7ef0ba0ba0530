//! Allocation of lists of results: missing memory raises `MemoryError` instead of ending the process.

use pyo3::exceptions::PyMemoryError;
use pyo3::prelude::*;

fn reserved<T>(count: usize) -> PyResult<Vec<T>> {
    let mut values = Vec::new();
    values.try_reserve_exact(count).map_err(|_| {
        let size = size_of::<T>();
        PyMemoryError::new_err(format!(
            "no memory for {count} results of {size} bytes each: use smaller batches"
        ))
    })?;
    Ok(values)
}

/// So many copies of a value.
pub fn filled<T: Clone>(value: T, count: usize) -> PyResult<Vec<T>> {
    let mut values = reserved(count)?;
    values.resize(count, value);
    Ok(values)
}

/// The values of an iterator, which are `count`.
pub fn collected<T>(values: impl IntoIterator<Item = T>, count: usize) -> PyResult<Vec<T>> {
    let mut all = reserved(count)?;
    all.extend(values);
    Ok(all)
}
