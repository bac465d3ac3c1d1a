//! Motions: a hand or an arm as arrays in, paths out.

use std::time::Duration;

use graft_core::Error;
use graft_core::geometry::{OrientedBox, Vec3, points_of};
use graft_core::grasp::{HalfSpace, Surface};
use graft_core::motion::{self, Chain, Contacts, Link, LinkBox, Motion, Obstacles, Options, Outcome, Plan, Pose};
use numpy::ndarray::{Array1, Array2, Array3, Array4};
use numpy::{
    IntoPyArray, PyArray1, PyArray2, PyArray3, PyArray4, PyReadonlyArray1, PyReadonlyArray2, PyReadonlyArray3,
};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use crate::convert::{finite, slice, to_py};

/// Per problem: how it ended (0 found, 1 start blocked, 2 goal blocked, 3 out of iterations, 4 out of time), waypoints,
/// iterations, nodes, checks.
pub type Rows<'py> = Bound<'py, PyArray2<i64>>;

fn shape<T: numpy::Element, D: numpy::ndarray::Dimension>(
    name: &str,
    array: &numpy::PyReadonlyArray<'_, T, D>,
    want: &[Option<usize>],
) -> PyResult<()> {
    let got = array.as_array().shape().to_vec();
    if got.iter().zip(want).all(|(g, w)| w.is_none_or(|w| w == *g)) {
        return Ok(());
    }
    let want: Vec<String> = want.iter().map(|w| w.map_or("n".to_owned(), |w| w.to_string())).collect();
    Err(PyValueError::new_err(format!("{name}: expected shape ({}), got {got:?}", want.join(", "))))
}

fn poses(name: &str, array: &PyReadonlyArray3<'_, f64>) -> PyResult<Vec<Pose>> {
    shape(name, array, &[None, Some(4), Some(4)])?;
    let (rows, _) = finite(name, array)?.as_chunks::<16>();
    Ok(rows.iter().map(Pose::from_rows).collect())
}

fn boxes(
    centers: &PyReadonlyArray2<'_, f64>,
    rotations: &PyReadonlyArray3<'_, f64>,
    half_extents: &PyReadonlyArray2<'_, f64>,
) -> PyResult<Vec<OrientedBox>> {
    shape("box_centers", centers, &[None, Some(3)])?;
    let n = centers.as_array().nrows();
    shape("box_rotations", rotations, &[Some(n), Some(3), Some(3)])?;
    shape("box_half_extents", half_extents, &[Some(n), Some(3)])?;
    let centers = points_of(finite("box_centers", centers)?);
    let (rotations, _) = finite("box_rotations", rotations)?.as_chunks::<9>();
    let (half_extents, _) = finite("box_half_extents", half_extents)?.as_chunks::<3>();
    let make = |((center, r), half): ((Vec3, &[f64; 9]), &[f64; 3])| OrientedBox {
        center,
        axes: std::array::from_fn(|k| Vec3::new(r[k], r[3 + k], r[6 + k])),
        half_extents: *half,
    };
    Ok(centers.into_iter().zip(rotations).zip(half_extents).map(make).collect())
}

/// What stands in the way, as it crosses the border.
#[derive(FromPyObject)]
pub struct World<'py> {
    #[pyo3(item(0))]
    vertices: PyReadonlyArray2<'py, f64>,
    #[pyo3(item(1))]
    faces: PyReadonlyArray2<'py, i64>,
    #[pyo3(item(2))]
    points: PyReadonlyArray2<'py, f64>,
    #[pyo3(item(3))]
    radii: PyReadonlyArray1<'py, f64>,
    #[pyo3(item(4))]
    support: Option<[f64; 4]>,
}

impl World<'_> {
    fn surface(&self) -> PyResult<Surface<'_>> {
        shape("vertices", &self.vertices, &[None, Some(3)])?;
        shape("faces", &self.faces, &[None, Some(3)])?;
        shape("points", &self.points, &[None, Some(3)])?;
        Ok(Surface {
            vertices: finite("vertices", &self.vertices)?,
            faces: slice("faces", &self.faces)?,
            points: finite("points", &self.points)?,
            radii: finite("radii", &self.radii)?,
        })
    }

    fn plane(&self) -> Option<HalfSpace> {
        self.support.map(|[x, y, z, offset]| HalfSpace { normal: Vec3::new(x, y, z), offset })
    }
}

fn obstacles(surface: &Surface<'_>, support: Option<HalfSpace>) -> Result<Obstacles, Error> {
    Ok(Obstacles { object: surface.collider()?, support })
}

/// An arm as it crosses the border.
#[derive(FromPyObject)]
pub struct Links<'py> {
    #[pyo3(item(0))]
    parents: PyReadonlyArray1<'py, i64>,
    #[pyo3(item(1))]
    rests: PyReadonlyArray3<'py, f64>,
    #[pyo3(item(2))]
    kinds: PyReadonlyArray1<'py, i64>,
    #[pyo3(item(3))]
    axes: PyReadonlyArray2<'py, f64>,
    #[pyo3(item(4))]
    anchors: PyReadonlyArray2<'py, f64>,
    #[pyo3(item(5))]
    limits: PyReadonlyArray2<'py, f64>,
    #[pyo3(item(6))]
    carriers: PyReadonlyArray1<'py, i64>,
    #[pyo3(item(7))]
    box_centers: PyReadonlyArray2<'py, f64>,
    #[pyo3(item(8))]
    box_rotations: PyReadonlyArray3<'py, f64>,
    #[pyo3(item(9))]
    box_half_extents: PyReadonlyArray2<'py, f64>,
}

impl Links<'_> {
    fn chain(&self) -> PyResult<Chain> {
        let rests = poses("link_rests", &self.rests)?;
        let n = rests.len();
        shape("link_parents", &self.parents, &[Some(n)])?;
        shape("link_kinds", &self.kinds, &[Some(n)])?;
        shape("link_axes", &self.axes, &[Some(n), Some(3)])?;
        shape("link_anchors", &self.anchors, &[Some(n), Some(3)])?;
        shape("limits", &self.limits, &[None, Some(2)])?;
        let (parents, kinds) = (slice("link_parents", &self.parents)?, slice("link_kinds", &self.kinds)?);
        let axes = points_of(finite("link_axes", &self.axes)?);
        let anchors = points_of(finite("link_anchors", &self.anchors)?);
        let links = (0..n).map(|i| {
            let motion = match kinds[i] {
                0 => Motion::Fixed,
                1 => Motion::Hinge { axis: axes[i], anchor: anchors[i] },
                2 => Motion::Slide { axis: axes[i] },
                other => return Err(to_py(&Error::value("link_kinds", "0, 1 or 2", other))),
            };
            Ok(Link { parent: usize::try_from(parents[i]).ok(), rest: rests[i], motion })
        });
        let links = links.collect::<PyResult<Vec<Link>>>()?;
        let shapes = boxes(&self.box_centers, &self.box_rotations, &self.box_half_extents)?;
        shape("box_links", &self.carriers, &[Some(shapes.len())])?;
        let on = indices("box_links", slice("box_links", &self.carriers)?)?;
        let on_links = on.into_iter().zip(shapes).map(|(link, shape)| LinkBox { link, shape }).collect();
        let (limits, _) = finite("limits", &self.limits)?.as_chunks::<2>();
        Chain::new(links, on_links, limits.iter().map(|l| (l[0], l[1])).collect()).map_err(|error| to_py(&error))
    }
}

fn indices(name: &str, values: &[i64]) -> PyResult<Vec<usize>> {
    let index =
        |&i: &i64| usize::try_from(i).map_err(|_| PyValueError::new_err(format!("{name}: expected indices, got {i}")));
    values.iter().map(index).collect()
}

fn contacts(movers: &PyReadonlyArray1<'_, i64>, pairs: &PyReadonlyArray2<'_, i64>) -> PyResult<Contacts> {
    shape("pairs", pairs, &[None, Some(2)])?;
    let movers = indices("movers", slice("movers", movers)?)?;
    let (pairs, _) = slice("pairs", pairs)?.as_chunks::<2>();
    let pairs = pairs.iter().map(|p| indices("pairs", p).map(|p| (p[0], p[1])));
    Ok(Contacts { movers, pairs: pairs.collect::<PyResult<_>>()? })
}

fn values(name: &str, array: &PyReadonlyArray2<'_, f64>) -> PyResult<Vec<Vec<f64>>> {
    finite(name, array)?;
    Ok(array.as_array().rows().into_iter().map(|row| row.to_vec()).collect())
}

/// How to plan, as it crosses the border.
#[derive(FromPyObject)]
pub struct Settings {
    #[pyo3(item(0))]
    clearance: f64,
    #[pyo3(item(1))]
    step: f64,
    #[pyo3(item(2))]
    goal_bias: f64,
    #[pyo3(item(3))]
    max_iterations: usize,
    #[pyo3(item(4))]
    time_limit: Option<f64>,
    #[pyo3(item(5))]
    shortcuts: usize,
    #[pyo3(item(6))]
    seed: u64,
}

impl Settings {
    fn options(&self) -> PyResult<Options> {
        let limit = |seconds: f64| {
            Duration::try_from_secs_f64(seconds)
                .map_err(|_| to_py(&Error::value("time_limit", "seconds, at least 0", seconds)))
        };
        Ok(Options {
            clearance: self.clearance,
            step: self.step,
            goal_bias: self.goal_bias,
            max_iterations: self.max_iterations,
            time_limit: self.time_limit.map(limit).transpose()?,
            shortcuts: self.shortcuts,
            seed: self.seed,
        })
    }
}

fn rows<'py, State>(py: Python<'py>, plans: &[Plan<State>]) -> Rows<'py> {
    let numbers = plans.iter().map(|plan| {
        let ended = match plan.outcome {
            Outcome::Found => 0,
            Outcome::StartBlocked => 1,
            Outcome::GoalBlocked => 2,
            Outcome::OutOfIterations => 3,
            Outcome::OutOfTime => 4,
        };
        [ended, plan.path.len() as i64, plan.iterations as i64, plan.nodes as i64, plan.checks as i64]
    });
    Array2::from(numbers.collect::<Vec<_>>()).into_pyarray(py)
}

fn unshaped(error: numpy::ndarray::ShapeError) -> PyErr {
    PyValueError::new_err(error.to_string())
}

/// Plan for a hand made of boxes: all waypoints (m, 4, 4), and a row for each problem.
#[pyfunction]
#[pyo3(signature = (*, world, box_centers, box_rotations, box_half_extents, bounds, starts, goals, settings))]
#[allow(clippy::too_many_arguments)]
pub fn plan_hands<'py>(
    py: Python<'py>,
    world: World<'py>,
    box_centers: PyReadonlyArray2<'py, f64>,
    box_rotations: PyReadonlyArray3<'py, f64>,
    box_half_extents: PyReadonlyArray2<'py, f64>,
    bounds: PyReadonlyArray3<'py, f64>,
    starts: PyReadonlyArray3<'py, f64>,
    goals: PyReadonlyArray3<'py, f64>,
    settings: Settings,
) -> PyResult<(Bound<'py, PyArray3<f64>>, Rows<'py>)> {
    shape("bounds", &bounds, &[None, Some(2), Some(3)])?;
    let corners: Vec<[Vec3; 2]> =
        points_of(finite("bounds", &bounds)?).chunks_exact(2).map(|pair| [pair[0], pair[1]]).collect();
    let hand = boxes(&box_centers, &box_rotations, &box_half_extents)?;
    let (starts, goals) = (poses("starts", &starts)?, poses("goals", &goals)?);
    let options = settings.options()?;
    let (surface, plane) = (world.surface()?, world.plane());
    let plans = py
        .detach(|| motion::plan_hands(&obstacles(&surface, plane)?, &hand, &corners, &starts, &goals, &options))
        .map_err(|error| to_py(&error))?;
    let path: Vec<f64> = plans.iter().flat_map(|plan| &plan.path).flat_map(Pose::to_rows).collect();
    let path = Array3::from_shape_vec((path.len() / 16, 4, 4), path).map_err(unshaped)?;
    Ok((path.into_pyarray(py), rows(py, &plans)))
}

/// Plan for an arm: all waypoints (m, j), and a row for each problem.
#[pyfunction]
#[pyo3(signature = (*, world, links, movers, pairs, starts, goals, settings))]
#[allow(clippy::too_many_arguments)]
pub fn plan_arms<'py>(
    py: Python<'py>,
    world: World<'py>,
    links: Links<'py>,
    movers: PyReadonlyArray1<'py, i64>,
    pairs: PyReadonlyArray2<'py, i64>,
    starts: PyReadonlyArray2<'py, f64>,
    goals: PyReadonlyArray2<'py, f64>,
    settings: Settings,
) -> PyResult<(Bound<'py, PyArray2<f64>>, Rows<'py>)> {
    let chain = links.chain()?;
    let contacts = contacts(&movers, &pairs)?;
    let (starts, goals) = (values("starts", &starts)?, values("goals", &goals)?);
    let options = settings.options()?;
    let (surface, plane) = (world.surface()?, world.plane());
    let plans = py
        .detach(|| motion::plan_arms(&obstacles(&surface, plane)?, &chain, &contacts, &starts, &goals, &options))
        .map_err(|error| to_py(&error))?;
    let path: Vec<f64> = plans.iter().flat_map(|plan| &plan.path).flatten().copied().collect();
    let joints = chain.limits().len();
    let count = plans.iter().map(|plan| plan.path.len()).sum();
    let path = Array2::from_shape_vec((count, joints), path).map_err(unshaped)?;
    Ok((path.into_pyarray(py), rows(py, &plans)))
}

/// Return which joint values (n, j) keep the slack: (n,).
#[pyfunction]
#[pyo3(signature = (*, world, links, movers, pairs, joints, slack))]
pub fn clear_arms<'py>(
    py: Python<'py>,
    world: World<'py>,
    links: Links<'py>,
    movers: PyReadonlyArray1<'py, i64>,
    pairs: PyReadonlyArray2<'py, i64>,
    joints: PyReadonlyArray2<'py, f64>,
    slack: f64,
) -> PyResult<Bound<'py, PyArray1<bool>>> {
    let chain = links.chain()?;
    let contacts = contacts(&movers, &pairs)?;
    let joints = values("joints", &joints)?;
    let (surface, plane) = (world.surface()?, world.plane());
    let clear = py
        .detach(|| motion::clear_arms(&obstacles(&surface, plane)?, &chain, &contacts, &joints, slack))
        .map_err(|error| to_py(&error))?;
    Ok(Array1::from_vec(clear).into_pyarray(py))
}

/// Return where the links are, (n, l, 4, 4), at joint values (n, j).
#[pyfunction]
pub fn arm_poses<'py>(
    py: Python<'py>,
    links: Links<'py>,
    joints: PyReadonlyArray2<'py, f64>,
) -> PyResult<Bound<'py, PyArray4<f64>>> {
    let chain = links.chain()?;
    shape("joints", &joints, &[None, Some(chain.limits().len())])?;
    let joints = values("joints", &joints)?;
    let placed: Vec<f64> = joints.iter().flat_map(|q| chain.poses(q)).flat_map(|pose| pose.to_rows()).collect();
    let count = links.parents.as_array().len();
    Ok(Array4::from_shape_vec((joints.len(), count, 4, 4), placed).map_err(unshaped)?.into_pyarray(py))
}
