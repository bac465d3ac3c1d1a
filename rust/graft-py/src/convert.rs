//! Checks names, shapes and finiteness, and maps errors: what every function of the border shares.

use graft_core::Error;
use numpy::ndarray::Dimension;
use numpy::{Element, PyReadonlyArray};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

/// Map a core error to `ValueError`.
pub fn to_py(error: &Error) -> PyErr {
    PyValueError::new_err(error.to_string())
}

/// Borrow a C-contiguous array's data, or say which argument is not.
pub fn slice<'a, T: Element, D: Dimension>(name: &str, array: &'a PyReadonlyArray<'_, T, D>) -> PyResult<&'a [T]> {
    array.as_slice().map_err(|_| PyValueError::new_err(format!("{name}: expected a C-contiguous array")))
}

/// Like [`slice`], and every number must be finite.
pub fn finite<'a, D: Dimension>(name: &str, array: &'a PyReadonlyArray<'_, f64, D>) -> PyResult<&'a [f64]> {
    let data = slice(name, array)?;
    match data.iter().position(|x| !x.is_finite()) {
        None => Ok(data),
        Some(at) => {
            Err(PyValueError::new_err(format!("{name}: expected finite numbers, got {} at flat index {at}", data[at])))
        }
    }
}
