//! Grasps: collisions of grippers, and the antipodal sampler.

use graft_core::geometry::{OrientedBox, Vec3, points_of};
use graft_core::grasp::{HalfSpace, Hand, NAMES, Nearness, Reason, Request, Settings, TERMS};
use graft_core::{Error, grasp};
use numpy::ndarray::{Array1, Array2, Array3};
use numpy::{IntoPyArray, PyArray1, PyArray2, PyArray3, PyReadonlyArray1, PyReadonlyArray2, PyReadonlyArray3};
use pyo3::exceptions::PyValueError;
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

fn half_space([x, y, z, offset]: [f64; 4]) -> HalfSpace {
    HalfSpace { normal: Vec3::new(x, y, z), offset }
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
    let support = plane.map(half_space);
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

/// Poses (n, 4, 4), widths, scores, contacts (n, 2, 3), distances, named terms (n,), rejections by name.
type Grasps<'py> = (
    Bound<'py, PyArray3<f64>>,
    Bound<'py, PyArray1<f64>>,
    Bound<'py, PyArray1<f64>>,
    Bound<'py, PyArray3<f64>>,
    Bound<'py, PyArray1<f64>>,
    (Vec<&'static str>, Bound<'py, PyArray2<f64>>),
    Vec<(&'static str, u64)>,
);

/// Find antipodal grasps that a parallel gripper can reach, best first.
#[pyfunction]
#[pyo3(signature = (*, vertices, faces, face_parts, centers, half_extents, rotations, fingers, stroke, contact,
                    approach, radius, part, plane, up, weights, depths, samples, rays, pairs, approaches, cone,
                    clearance, margin, travel, spacing, turn, count, seed))]
// One argument for each array that crosses, and for each parameter.
#[allow(clippy::too_many_arguments)]
pub fn antipodal_grasps<'py>(
    py: Python<'py>,
    vertices: PyReadonlyArray2<'py, f64>,
    faces: PyReadonlyArray2<'py, i64>,
    face_parts: PyReadonlyArray1<'py, i64>,
    centers: PyReadonlyArray2<'py, f64>,
    half_extents: PyReadonlyArray2<'py, f64>,
    rotations: PyReadonlyArray3<'py, f64>,
    fingers: usize,
    stroke: f64,
    contact: Option<[f64; 3]>,
    approach: Option<[f64; 3]>,
    radius: f64,
    part: Option<usize>,
    plane: Option<[f64; 4]>,
    up: Option<[f64; 3]>,
    weights: [f64; TERMS],
    depths: PyReadonlyArray1<'py, f64>,
    samples: usize,
    rays: usize,
    pairs: usize,
    approaches: usize,
    cone: f64,
    clearance: f64,
    margin: f64,
    travel: f64,
    spacing: f64,
    turn: f64,
    count: usize,
    seed: u64,
) -> PyResult<Grasps<'py>> {
    let request = Request {
        vertices: finite("vertices", &vertices)?,
        faces: slice("faces", &faces)?,
        face_parts: slice("face_parts", &face_parts)?,
        hand: hand_of(&centers, &half_extents, &rotations, fingers)?,
        stroke,
        contact: contact.map(Vec3::from),
        radius,
        approach: approach.map(Vec3::from),
        part,
        support: plane.map(half_space),
        up: up.map(Vec3::from),
        weights,
        settings: Settings {
            samples,
            rays,
            pairs,
            approaches,
            depths: finite("depths", &depths)?.to_vec(),
            cone,
            clearance,
            margin,
            travel,
            nearness: Nearness { distance: spacing, angle: turn },
            count,
            seed,
        },
    };
    let answer = py.detach(|| grasp::plan(&request)).map_err(|error| to_py(&error))?;
    let grasps = &answer.grasps;
    let n = grasps.len();
    let shaped = |error: numpy::ndarray::ShapeError| PyValueError::new_err(error.to_string());
    let poses = grasps.iter().flat_map(|g| g.facts.pose.matrix()).collect();
    let contacts = grasps.iter().flat_map(|g| g.facts.contacts).flat_map(|p| [p.x, p.y, p.z]).collect();
    let terms = grasps.iter().flat_map(|g| g.terms).collect();
    let column = |of: fn(&grasp::Proposal) -> f64| Array1::from_iter(grasps.iter().map(of)).into_pyarray(py);
    Ok((
        Array3::from_shape_vec((n, 4, 4), poses).map_err(shaped)?.into_pyarray(py),
        column(|g| g.facts.width),
        column(|g| g.score),
        Array3::from_shape_vec((n, 2, 3), contacts).map_err(shaped)?.into_pyarray(py),
        column(|g| g.distance),
        (NAMES.to_vec(), Array2::from_shape_vec((n, TERMS), terms).map_err(shaped)?.into_pyarray(py)),
        Reason::ALL.into_iter().map(|reason| (reason.name(), answer.rejected[reason as usize])).collect(),
    ))
}
