//! Border of the part descriptors.

use crate::convert;
use graft_core::descriptor::{self, Family, Options, Parts};
use numpy::ndarray::Array2;
use numpy::{IntoPyArray, PyArray2, PyReadonlyArray1, PyReadonlyArray2, PyUntypedArrayMethods};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

/// Describe packed parts: (n, dim) rows of length 1, or the features before standardisation when `raw`.
#[pyfunction]
#[pyo3(signature = (vertices, faces, vertex_offsets, face_offsets, *, families, samples, seed, raw = false))]
// pyo3 hands arguments over by value; one argument per array is the border.
#[allow(clippy::too_many_arguments)]
pub fn describe_parts<'py>(
    py: Python<'py>,
    vertices: PyReadonlyArray2<'py, f64>,
    faces: PyReadonlyArray2<'py, i64>,
    vertex_offsets: PyReadonlyArray1<'py, i64>,
    face_offsets: PyReadonlyArray1<'py, i64>,
    families: Vec<String>,
    samples: usize,
    seed: u64,
    raw: bool,
) -> PyResult<Bound<'py, PyArray2<f64>>> {
    three("vertices", vertices.shape())?;
    three("faces", faces.shape())?;
    let options = Options { families: named(&families)?, samples, seed };
    let parts = Parts {
        vertices: convert::finite("vertices", &vertices)?.as_chunks().0,
        faces: convert::slice("faces", &faces)?.as_chunks().0,
        vertex_offsets: convert::slice("vertex_offsets", &vertex_offsets)?,
        face_offsets: convert::slice("face_offsets", &face_offsets)?,
    };
    let count = parts.vertex_offsets.len().saturating_sub(1);
    let rows = py
        .detach(|| if raw { descriptor::raw_features(parts, &options) } else { descriptor::describe(parts, &options) })
        .map_err(|error| convert::to_py(&error))?;
    let width = rows.len() / count.max(1);
    let table = Array2::from_shape_vec((count, width), rows).map_err(|e| PyValueError::new_err(e.to_string()))?;
    Ok(table.into_pyarray(py))
}

/// Width of the rows of `describe_parts`.
#[pyfunction]
pub fn descriptor_dim(families: Vec<String>) -> PyResult<usize> {
    Ok(Options { families: named(&families)?, samples: descriptor::MIN_SAMPLES, seed: 0 }.dim())
}

fn named(families: &[String]) -> PyResult<Vec<Family>> {
    families.iter().map(|name| Family::named(name).map_err(|error| convert::to_py(&error))).collect()
}

fn three(name: &str, shape: &[usize]) -> PyResult<()> {
    if shape[1] == 3 {
        return Ok(());
    }
    Err(PyValueError::new_err(format!("{name}: expected shape (n, 3), got ({}, {})", shape[0], shape[1])))
}
