//! Grasps: collisions of grippers.

use graft_core::geometry::{OrientedBox, Vec3, points_of};
use graft_core::grasp::{HalfSpace, Hand};
use graft_core::{Error, grasp};
use numpy::ndarray::Array1;
use numpy::{IntoPyArray, PyArray1, PyReadonlyArray1, PyReadonlyArray2, PyReadonlyArray3};
use pyo3::prelude::*;

use crate::convert::{finite, slice, to_py};

/// Read boxes, palm first, of which the last `fingers` belong to the finger.
fn hand_of(
    centers: &PyReadonlyArray2<'_, f64>,
    half_extents: &PyReadonlyArray2<'_, f64>,
    rotations: &PyReadonlyArray3<'_, f64>,
    fingers: usize,
) -> PyResult<Hand> {
    let shape = |name, expected: &str, got: &[usize]| to_py(&Error::shape(name, expected, format!("{got:?}")));
    let count = centers.as_array().nrows();
    for (name, array) in [("centers", centers), ("half_extents", half_extents)] {
        if array.as_array().shape() != [count, 3] {
            return Err(shape(name, &format!("({count}, 3)"), array.as_array().shape()));
        }
    }
    if rotations.as_array().shape() != [count, 3, 3] {
        return Err(shape("rotations", &format!("({count}, 3, 3)"), rotations.as_array().shape()));
    }
    if fingers > count {
        return Err(to_py(&Error::value("fingers", format!("at most {count} boxes"), fingers)));
    }
    let centers = points_of(finite("centers", centers)?);
    let half_extents = points_of(finite("half_extents", half_extents)?);
    let rotations = finite("rotations", rotations)?;
    let mut palm: Vec<OrientedBox> = (0..count)
        .map(|i| {
            let r = &rotations[9 * i..9 * i + 9];
            OrientedBox {
                center: centers[i],
                axes: [0, 1, 2].map(|k| Vec3::new(r[k], r[3 + k], r[6 + k])),
                half_extents: half_extents[i].into(),
            }
        })
        .collect();
    let finger = palm.split_off(count - fingers);
    Ok(Hand { palm, finger })
}

/// Say which poses of a gripper touch an object or go below a plane.
#[pyfunction]
#[pyo3(signature = (*, vertices, faces, points, radii, centers, half_extents, rotations, fingers, poses, openings,
                    margin, plane, solid))]
// One argument for each array that crosses.
#[allow(clippy::too_many_arguments)]
pub fn gripper_collisions<'py>(
    py: Python<'py>,
    vertices: PyReadonlyArray2<'py, f64>,
    faces: PyReadonlyArray2<'py, i64>,
    points: PyReadonlyArray2<'py, f64>,
    radii: PyReadonlyArray1<'py, f64>,
    centers: PyReadonlyArray2<'py, f64>,
    half_extents: PyReadonlyArray2<'py, f64>,
    rotations: PyReadonlyArray3<'py, f64>,
    fingers: usize,
    poses: PyReadonlyArray3<'py, f64>,
    openings: PyReadonlyArray1<'py, f64>,
    margin: f64,
    plane: Option<[f64; 4]>,
    solid: bool,
) -> PyResult<Bound<'py, PyArray1<bool>>> {
    let hand = hand_of(&centers, &half_extents, &rotations, fingers)?;
    let (vertices, faces) = (finite("vertices", &vertices)?, slice("faces", &faces)?);
    let (points, radii) = (finite("points", &points)?, finite("radii", &radii)?);
    let (poses, openings) = (finite("poses", &poses)?, finite("openings", &openings)?);
    let support = plane.map(|p| HalfSpace { normal: Vec3::new(p[0], p[1], p[2]), offset: p[3] });
    let hits = py
        .detach(|| {
            let surface = grasp::Surface { vertices, faces, points, radii };
            let collider = surface.collider()?;
            let collider = if solid { collider.solid() } else { collider };
            grasp::collisions(&collider, &hand, poses, openings, margin, support.as_ref())
        })
        .map_err(|error| to_py(&error))?;
    Ok(Array1::from_vec(hits).into_pyarray(py))
}
