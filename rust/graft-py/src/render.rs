//! Pictures: arrays in, pixels out.

use graft_core::render::{self, Camera, Scene};
use numpy::ndarray::{Array1, Array3};
use numpy::{IntoPyArray, PyArray1, PyArray3, PyReadonlyArray1, PyReadonlyArray2};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use crate::convert::{finite, slice, to_py};

fn columns<T>(name: &str, array: &PyReadonlyArray2<'_, T>, want: usize) -> PyResult<()>
where
    T: numpy::Element,
{
    let shape = array.as_array().shape().to_vec();
    if shape[1] == want {
        return Ok(());
    }
    Err(PyValueError::new_err(format!("{name}: expected shape (n, {want}), got {shape:?}")))
}

/// Draw coloured triangles and spheres: (height, width, 4) sRGB with straight alpha.
#[pyfunction]
#[pyo3(signature = (*, vertices, faces, face_groups, centers, radii, center_groups, colors, camera, width, height))]
// One argument for each array that crosses.
#[allow(clippy::too_many_arguments)]
pub fn render_scene<'py>(
    py: Python<'py>,
    vertices: PyReadonlyArray2<'py, f64>,
    faces: PyReadonlyArray2<'py, i64>,
    face_groups: PyReadonlyArray1<'py, i64>,
    centers: PyReadonlyArray2<'py, f64>,
    radii: PyReadonlyArray1<'py, f64>,
    center_groups: PyReadonlyArray1<'py, i64>,
    colors: PyReadonlyArray2<'py, u8>,
    camera: PyReadonlyArray2<'py, f64>,
    width: usize,
    height: usize,
) -> PyResult<Bound<'py, PyArray3<u8>>> {
    columns("vertices", &vertices, 3)?;
    columns("faces", &faces, 3)?;
    columns("centers", &centers, 3)?;
    columns("colors", &colors, 3)?;
    let matrix = finite("camera", &camera)?
        .try_into()
        .map_err(|_| PyValueError::new_err("camera: expected shape (3, 4)".to_owned()))?;
    let scene = Scene {
        vertices: finite("vertices", &vertices)?,
        faces: slice("faces", &faces)?,
        face_groups: slice("face_groups", &face_groups)?,
        centers: finite("centers", &centers)?,
        radii: finite("radii", &radii)?,
        center_groups: slice("center_groups", &center_groups)?,
        colors: slice("colors", &colors)?,
    };
    let view = Camera { matrix, width, height };
    let pixels = py.detach(|| render::render(&scene, &view)).map_err(|error| to_py(&error))?;
    let picture =
        Array3::from_shape_vec((height, width, 4), pixels).map_err(|error| PyValueError::new_err(error.to_string()))?;
    Ok(picture.into_pyarray(py))
}

/// Return how far each ray goes until it hits the mesh, infinity where it does not.
#[pyfunction]
pub fn cast_rays<'py>(
    py: Python<'py>,
    vertices: PyReadonlyArray2<'py, f64>,
    faces: PyReadonlyArray2<'py, i64>,
    origins: PyReadonlyArray2<'py, f64>,
    directions: PyReadonlyArray2<'py, f64>,
) -> PyResult<Bound<'py, PyArray1<f64>>> {
    columns("vertices", &vertices, 3)?;
    columns("faces", &faces, 3)?;
    columns("origins", &origins, 3)?;
    columns("directions", &directions, 3)?;
    let (vertices, faces) = (finite("vertices", &vertices)?, slice("faces", &faces)?);
    let (origins, directions) = (finite("origins", &origins)?, finite("directions", &directions)?);
    let distances =
        py.detach(|| render::cast_rays(vertices, faces, origins, directions)).map_err(|error| to_py(&error))?;
    Ok(Array1::from_vec(distances).into_pyarray(py))
}
