//! Border of the segmentation.

use graft_core::Error;
use graft_core::segment::{self, Levels, Segmentation};
use numpy::ndarray::Array2;
use numpy::{IntoPyArray, PyArray2, PyReadonlyArray2};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use crate::convert::{finite, slice, to_py};

/// Labels (levels, elements) coarse to fine, the level chosen, log-odds (kept, dropped), and counts: open edges,
/// crowded edges, turned faces, components, components joined, faces of the coarser copy.
type Found<'py> = (Bound<'py, PyArray2<i64>>, usize, (f64, f64), (usize, usize, usize, usize, usize, usize));

/// Segment a mesh into `parts` parts, as many as people would make when None; all levels when `hierarchy`.
#[pyfunction]
#[pyo3(signature = (vertices, faces, *, parts, hierarchy, seed))]
pub fn segment_mesh<'py>(
    py: Python<'py>,
    vertices: PyReadonlyArray2<'py, f64>,
    faces: PyReadonlyArray2<'py, i64>,
    parts: Option<usize>,
    hierarchy: bool,
    seed: u64,
) -> PyResult<Found<'py>> {
    let (vertices, faces) = (finite("vertices", &vertices)?, slice("faces", &faces)?);
    let found = py.detach(|| segment::segment_mesh(vertices, faces, levels(parts, hierarchy), seed));
    crossed(py, found)
}

/// Segment a cloud with normals and (p, k) neighbours; otherwise like `segment_mesh`.
#[pyfunction]
#[pyo3(signature = (points, normals, neighbours, *, parts, hierarchy, seed))]
// One argument for each array and option that crosses.
#[allow(clippy::too_many_arguments)]
pub fn segment_cloud<'py>(
    py: Python<'py>,
    points: PyReadonlyArray2<'py, f64>,
    normals: PyReadonlyArray2<'py, f64>,
    neighbours: PyReadonlyArray2<'py, i64>,
    parts: Option<usize>,
    hierarchy: bool,
    seed: u64,
) -> PyResult<Found<'py>> {
    let (points, normals) = (finite("points", &points)?, finite("normals", &normals)?);
    let neighbours = slice("neighbours", &neighbours)?;
    let found = py.detach(|| segment::segment_cloud(points, normals, neighbours, levels(parts, hierarchy), seed));
    crossed(py, found)
}

fn levels(parts: Option<usize>, hierarchy: bool) -> Levels {
    match parts {
        Some(count) => Levels::Count(count),
        None if hierarchy => Levels::All,
        None => Levels::Chosen,
    }
}

fn crossed(py: Python<'_>, found: Result<Segmentation, Error>) -> PyResult<Found<'_>> {
    let found = found.map_err(|error| to_py(&error))?;
    let shape = (found.levels.len(), found.levels.first().map_or(0, Vec::len));
    let flat = found.levels.into_iter().flatten().map(i64::from).collect();
    let labels = Array2::from_shape_vec(shape, flat).map_err(|error| PyValueError::new_err(error.to_string()))?;
    let r = found.repairs;
    Ok((
        labels.into_pyarray(py),
        found.chosen,
        found.certainty.into(),
        (r.open_edges, r.crowded_edges, r.flipped, r.components, r.joined, r.coarse),
    ))
}
