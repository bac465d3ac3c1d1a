//! Boxes, hulls and surface samples of parts.

use graft_core::Error;
use graft_core::geometry::{self, OrientedBox, PartShape, Vec3, points_of};
use numpy::ndarray::{Array1, Array2, Array3};
use numpy::{IntoPyArray, PyArray1, PyArray2, PyArray3, PyReadonlyArray1, PyReadonlyArray2, PyReadonlyArray3};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use crate::convert::{finite, slice, to_py};

/// Centres (n, 3), axes (n, 3, 3) in columns and half extents (n, 3).
pub type BoxArrays<'py> = (Bound<'py, PyArray2<f64>>, Bound<'py, PyArray3<f64>>, Bound<'py, PyArray2<f64>>);

/// Check (n, 3) points.
fn points(name: &'static str, array: &PyReadonlyArray2<'_, f64>) -> PyResult<Vec<Vec3>> {
    let flat = finite(name, array)?;
    let shape = array.as_array().dim();
    if shape.1 != 3 {
        return Err(to_py(&Error::shape(name, "shape (n, 3)", format!("{shape:?}"))));
    }
    Ok(points_of(flat))
}

/// Check a table of boxes.
pub fn boxes(
    centers: &PyReadonlyArray2<'_, f64>,
    axes: &PyReadonlyArray3<'_, f64>,
    half_extents: &PyReadonlyArray2<'_, f64>,
) -> PyResult<Vec<OrientedBox>> {
    let middle = points("centers", centers)?;
    let half = points("half_extents", half_extents)?;
    let turned = finite("axes", axes)?;
    let shape = axes.as_array().dim();
    if shape != (middle.len(), 3, 3) {
        let expected = format!("shape ({}, 3, 3)", middle.len());
        return Err(to_py(&Error::shape("axes", expected, format!("{shape:?}"))));
    }
    if half.len() != middle.len() {
        let expected = format!("shape ({}, 3)", middle.len());
        return Err(to_py(&Error::shape("half_extents", expected, format!("({}, 3)", half.len()))));
    }
    let column = |m: &[f64], k: usize| Vec3::new(m[k], m[3 + k], m[6 + k]);
    Ok(middle
        .into_iter()
        .zip(half)
        .zip(turned.chunks_exact(9))
        .map(|((center, h), m)| OrientedBox { center, axes: [0, 1, 2].map(|k| column(m, k)), half_extents: h.into() })
        .collect())
}

fn box_arrays<'py>(py: Python<'py>, found: &[OrientedBox]) -> BoxArrays<'py> {
    let n = found.len();
    (
        Array2::from_shape_fn((n, 3), |(i, k)| found[i].center[k]).into_pyarray(py),
        Array3::from_shape_fn((n, 3, 3), |(i, r, c)| found[i].axes[c][r]).into_pyarray(py),
        Array2::from_shape_fn((n, 3), |(i, k)| found[i].half_extents[k]).into_pyarray(py),
    )
}

/// Cut concatenated arrays into parts.
fn shapes(
    vertices: Vec<Vec3>,
    normals: Vec<Vec3>,
    vertex_counts: &[i64],
    faces: &[i64],
    face_counts: &[i64],
) -> PyResult<Vec<PartShape>> {
    let total = |counts: &[i64]| counts.iter().try_fold(0i64, |sum, &c| if c < 0 { None } else { sum.checked_add(c) });
    let agrees = |counts: &[i64], length: usize| total(counts) == i64::try_from(length).ok();
    if vertex_counts.contains(&0) || !agrees(vertex_counts, vertices.len()) {
        let expected = format!("positive counts adding up to {} vertices", vertices.len());
        return Err(to_py(&Error::value("vertex_counts", expected, format!("{vertex_counts:?}"))));
    }
    if face_counts.len() != vertex_counts.len() || !agrees(face_counts, faces.len() / 3) {
        let expected = format!("{} counts adding up to {} faces", vertex_counts.len(), faces.len() / 3);
        return Err(to_py(&Error::value("face_counts", expected, format!("{face_counts:?}"))));
    }
    if normals.len() != vertices.len() {
        let expected = format!("shape ({}, 3)", vertices.len());
        return Err(to_py(&Error::shape("normals", expected, format!("({}, 3)", normals.len()))));
    }
    let (mut at, mut face_at) = (0, 0);
    let mut parts = Vec::with_capacity(vertex_counts.len());
    for (&v, &f) in vertex_counts.iter().zip(face_counts) {
        let (v, f) = (v as usize, f as usize);
        let rows = &faces[3 * face_at..3 * (face_at + f)];
        if let Some(bad) = rows.iter().find(|&&i| i < 0 || i >= v as i64) {
            return Err(to_py(&Error::value("faces", format!("vertex indices in [0, {v})"), bad)));
        }
        parts.push(PartShape {
            vertices: vertices[at..at + v].to_vec(),
            faces: rows.chunks_exact(3).map(|r| [r[0] as usize, r[1] as usize, r[2] as usize]).collect(),
            normals: normals[at..at + v].to_vec(),
        });
        (at, face_at) = (at + v, face_at + f);
    }
    Ok(parts)
}

/// Measure the parts of an object.
///
/// Takes the parts' vertices and normals (zero rows where unknown) one after the other, how many each part has, their
/// faces (indices within the part) likewise. Returns the diagonal of the object's minimal box, the boxes, areas, volumes,
/// hull volumes, flag bits (1 degenerate, 2 flat, 4 symmetric), sampled points and normals.
#[pyfunction]
#[pyo3(signature = (vertices, normals, vertex_counts, faces, face_counts, samples, seed))]
#[allow(clippy::type_complexity, clippy::too_many_arguments)]
pub fn part_geometry<'py>(
    py: Python<'py>,
    vertices: PyReadonlyArray2<'py, f64>,
    normals: PyReadonlyArray2<'py, f64>,
    vertex_counts: PyReadonlyArray1<'py, i64>,
    faces: PyReadonlyArray2<'py, i64>,
    face_counts: PyReadonlyArray1<'py, i64>,
    samples: usize,
    seed: u64,
) -> PyResult<(
    f64,
    BoxArrays<'py>,
    Bound<'py, PyArray1<f64>>,
    Bound<'py, PyArray1<f64>>,
    Bound<'py, PyArray1<f64>>,
    Bound<'py, PyArray1<u8>>,
    Bound<'py, PyArray3<f64>>,
    Bound<'py, PyArray3<f64>>,
)> {
    if faces.as_array().dim().1 != 3 {
        let got = format!("{:?}", faces.as_array().dim());
        return Err(to_py(&Error::shape("faces", "shape (f, 3)", got)));
    }
    let parts = shapes(
        points("vertices", &vertices)?,
        points("normals", &normals)?,
        slice("vertex_counts", &vertex_counts)?,
        slice("faces", &faces)?,
        slice("face_counts", &face_counts)?,
    )?;
    let (found, diagonal) = py.detach(|| geometry::object_geometry(&parts, samples, seed));
    let n = found.len();
    let bounds: Vec<OrientedBox> = found.iter().map(|p| p.frame.bounds).collect();
    let scalars =
        |value: fn(&geometry::PartGeometry) -> f64| found.iter().map(value).collect::<Array1<f64>>().into_pyarray(py);
    let flags: Array1<u8> = found
        .iter()
        .map(|p| u8::from(p.degenerate) | u8::from(p.frame.flat) << 1 | u8::from(p.frame.symmetric) << 2)
        .collect();
    let places = Array3::from_shape_fn((n, samples, 3), |(i, k, c)| found[i].samples.points[k][c]);
    let directions = Array3::from_shape_fn((n, samples, 3), |(i, k, c)| found[i].samples.normals[k][c]);
    Ok((
        diagonal,
        box_arrays(py, &bounds),
        scalars(|p| p.area),
        scalars(|p| p.volume),
        scalars(|p| p.hull_volume),
        flags.into_pyarray(py),
        places.into_pyarray(py),
        directions.into_pyarray(py),
    ))
}

/// The minimal box of a point set: centre (3,), axes (3, 3) in columns, longest first, half extents (3,).
#[pyfunction]
#[allow(clippy::type_complexity)]
pub fn oriented_box<'py>(
    py: Python<'py>,
    points: PyReadonlyArray2<'py, f64>,
) -> PyResult<(Bound<'py, PyArray1<f64>>, Bound<'py, PyArray2<f64>>, Bound<'py, PyArray1<f64>>)> {
    let cloud = self::points("points", &points)?;
    if cloud.is_empty() {
        return Err(PyValueError::new_err("points: expected at least one, got none"));
    }
    let found = py.detach(|| {
        let centroid = cloud.iter().sum::<Vec3>() / cloud.len() as f64;
        geometry::frame::stated_frame(geometry::minimal_box(&cloud), &centroid, &Vec3::zeros(), 0.0, |_, _| 0.0).bounds
    });
    Ok((
        Array1::from_iter(found.center.iter().copied()).into_pyarray(py),
        Array2::from_shape_fn((3, 3), |(r, c)| found.axes[c][r]).into_pyarray(py),
        Array1::from_iter(found.half_extents).into_pyarray(py),
    ))
}

/// The convex hull of a point set: vertices (v, 3) and outward faces (f, 3); no faces when it is flat.
#[pyfunction]
#[allow(clippy::type_complexity)]
pub fn convex_hull<'py>(
    py: Python<'py>,
    points: PyReadonlyArray2<'py, f64>,
) -> PyResult<(Bound<'py, PyArray2<f64>>, Bound<'py, PyArray2<i64>>)> {
    let cloud = self::points("points", &points)?;
    let hull = py.detach(|| geometry::convex_hull(&cloud));
    Ok((
        Array2::from_shape_fn((hull.vertices.len(), 3), |(i, k)| hull.vertices[i][k]).into_pyarray(py),
        Array2::from_shape_fn((hull.faces.len(), 3), |(i, k)| i64::from(hull.faces[i][k])).into_pyarray(py),
    ))
}

/// Half the sum of the mean nearest distances between `cloud` (a, 3) and each of `candidates` (k, b, 3), both ways: (k,).
#[pyfunction]
pub fn chamfer_distances<'py>(
    py: Python<'py>,
    cloud: PyReadonlyArray2<'py, f64>,
    candidates: PyReadonlyArray3<'py, f64>,
) -> PyResult<Bound<'py, PyArray1<f64>>> {
    let from = finite("cloud", &cloud)?;
    let to = finite("candidates", &candidates)?;
    let (rows, width) = cloud.as_array().dim();
    if rows == 0 || width != 3 {
        return Err(to_py(&Error::shape("cloud", "shape (a, 3), a > 0", format!("({rows}, {width})"))));
    }
    let (k, b, width) = candidates.as_array().dim();
    if b == 0 || width != 3 {
        return Err(to_py(&Error::shape("candidates", "shape (k, b, 3), b > 0", format!("({k}, {b}, {width})"))));
    }
    Ok(py.detach(|| geometry::chamfer(from, to, b)).into_pyarray(py))
}
