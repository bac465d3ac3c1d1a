//! Relations between parts.

use graft_core::{Error, graph};
use nalgebra::Vector3;
use numpy::ndarray::Array2;
use numpy::{IntoPyArray, PyArray1, PyArray2, PyReadonlyArray1, PyReadonlyArray2, PyReadonlyArray3};
use pyo3::prelude::*;

use crate::convert::{finite, slice, to_py};
use crate::geometry::boxes;

fn square<T: numpy::Element>(py: Python<'_>, n: usize, data: Vec<T>) -> PyResult<Bound<'_, PyArray2<T>>> {
    let table =
        Array2::from_shape_vec((n, n), data).map_err(|e| to_py(&Error::shape("table", format!("({n}, {n})"), e)))?;
    Ok(table.into_pyarray(py))
}

fn check_square(name: &'static str, (rows, columns): (usize, usize), n: usize) -> PyResult<()> {
    if (rows, columns) == (n, n) {
        return Ok(());
    }
    Err(to_py(&Error::shape(name, format!("shape ({n}, {n})"), format!("({rows}, {columns})"))))
}

/// Distances (n, n) between boxes.
#[pyfunction]
pub fn box_gaps<'py>(
    py: Python<'py>,
    centers: PyReadonlyArray2<'py, f64>,
    axes: PyReadonlyArray3<'py, f64>,
    half_extents: PyReadonlyArray2<'py, f64>,
) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let found = boxes(&centers, &axes, &half_extents)?;
    square(py, found.len(), py.detach(|| graph::gaps(&found)))
}

/// Edge lengths (n, n) in [0, 1) between all pairs, or along the adjacency when one is given.
#[pyfunction]
#[pyo3(signature = (centers, axes, half_extents, unit, adjacency=None))]
pub fn edge_lengths<'py>(
    py: Python<'py>,
    centers: PyReadonlyArray2<'py, f64>,
    axes: PyReadonlyArray3<'py, f64>,
    half_extents: PyReadonlyArray2<'py, f64>,
    unit: f64,
    adjacency: Option<PyReadonlyArray2<'py, bool>>,
) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let found = boxes(&centers, &axes, &half_extents)?;
    let n = found.len();
    if !(unit.is_finite() && unit > 0.0) {
        return Err(to_py(&Error::value("unit", "a positive number", unit)));
    }
    let lengths = match &adjacency {
        None => py.detach(|| graph::all_pairs(&found, unit)),
        Some(given) => {
            check_square("adjacency", given.as_array().dim(), n)?;
            let edges = slice("adjacency", given)?;
            py.detach(|| graph::shortest_paths(&found, edges, unit))
        }
    };
    square(py, n, lengths)
}

/// Adjacency (n, n): joints (j, 2) where there are any, else gaps of at most the threshold; always connected.
#[pyfunction]
pub fn part_adjacency<'py>(
    py: Python<'py>,
    gaps: PyReadonlyArray2<'py, f64>,
    joints: PyReadonlyArray2<'py, i64>,
    threshold: f64,
) -> PyResult<Bound<'py, PyArray2<bool>>> {
    let n = gaps.as_array().dim().0;
    check_square("gaps", gaps.as_array().dim(), n)?;
    if joints.as_array().dim().1 != 2 {
        let got = format!("{:?}", joints.as_array().dim());
        return Err(to_py(&Error::shape("joints", "shape (j, 2)", got)));
    }
    let flat = slice("joints", &joints)?;
    if let Some(bad) = flat.iter().find(|&&i| i < 0 || i >= n as i64) {
        return Err(to_py(&Error::value("joints", format!("part indices in [0, {n})"), bad)));
    }
    let pairs: Vec<(usize, usize)> = flat.chunks_exact(2).map(|p| (p[0] as usize, p[1] as usize)).collect();
    let distances = finite("gaps", &gaps)?;
    square(py, n, py.detach(|| graph::adjacency(n, distances, &pairs, threshold)))
}

/// Steps (n,) from one part to each, breadth first; n where there is no way.
#[pyfunction]
pub fn part_hops<'py>(
    py: Python<'py>,
    adjacency: PyReadonlyArray2<'py, bool>,
    part: usize,
) -> PyResult<Bound<'py, PyArray1<i64>>> {
    let n = adjacency.as_array().dim().0;
    check_square("adjacency", adjacency.as_array().dim(), n)?;
    if part >= n {
        return Err(to_py(&Error::value("part", format!("an index below {n}"), part)));
    }
    let steps = graph::hops(n, slice("adjacency", &adjacency)?, part);
    Ok(PyArray1::from_iter(py, steps.into_iter().map(|s| s as i64)))
}

/// How each part lies in its object: rows (n, 34) of length at most 1, or the raw features (n, 17), NaN where unknown.
#[pyfunction]
#[pyo3(signature = (centers, axes, half_extents, points, areas, diagonal, up=None, *, raw=false))]
#[allow(clippy::too_many_arguments)]
pub fn part_relations<'py>(
    py: Python<'py>,
    centers: PyReadonlyArray2<'py, f64>,
    axes: PyReadonlyArray3<'py, f64>,
    half_extents: PyReadonlyArray2<'py, f64>,
    points: PyReadonlyArray3<'py, f64>,
    areas: PyReadonlyArray1<'py, f64>,
    diagonal: f64,
    up: Option<[f64; 3]>,
    raw: bool,
) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let found = boxes(&centers, &axes, &half_extents)?;
    let n = found.len();
    let (count, samples, three) = points.as_array().dim();
    let areas = finite("areas", &areas)?;
    if (count, three) != (n, 3) || samples == 0 || areas.len() != n {
        let got = format!("({count}, {samples}, {three}) and ({},)", areas.len());
        return Err(to_py(&Error::shape("points and areas", format!("shapes ({n}, s, 3) and ({n},)"), got)));
    }
    if !(diagonal.is_finite() && diagonal > 0.0) {
        return Err(to_py(&Error::value("diagonal", "a positive number", diagonal)));
    }
    let (triples, _) = finite("points", &points)?.as_chunks::<3>();
    let parts: Vec<_> = found
        .iter()
        .zip(triples.chunks_exact(samples))
        .zip(areas)
        .map(|((bounds, points), &area)| graph::PartSurface { bounds, points, area })
        .collect();
    let up = up.map(Vector3::from);
    let (width, rows) = py.detach(|| {
        if raw {
            let rows = graph::raw_relations(&parts, diagonal, up);
            (graph::relations::FEATURES, rows.iter().flatten().map(|x| x.unwrap_or(f64::NAN)).collect())
        } else {
            (graph::relations::WIDTH, graph::relations(&parts, diagonal, up))
        }
    });
    let table = Array2::from_shape_vec((n, width), rows)
        .map_err(|e| to_py(&Error::shape("relations", format!("({n}, {width})"), e)))?;
    Ok(table.into_pyarray(py))
}
