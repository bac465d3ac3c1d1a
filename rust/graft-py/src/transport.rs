//! Border of the transport stage.

use graft_core::Error;
use graft_core::transport::batch::{Packed, solve_batch};
use graft_core::transport::feature::{FeatureCost, Features, Variant};
use graft_core::transport::{Entropy, Loss, Options, Solution};
use numpy::{IntoPyArray, PyArray1, PyArray2, PyArrayMethods, PyReadonlyArray1, PyReadonlyArray2};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use crate::convert::{finite, slice, to_py};

fn choice<T: Copy>(name: &str, got: &str, choices: &[(&str, T)]) -> PyResult<T> {
    choices.iter().find(|(word, _)| *word == got).map(|(_, value)| *value).ok_or_else(|| {
        let words: Vec<_> = choices.iter().map(|(word, _)| *word).collect();
        PyValueError::new_err(format!("{name}: expected one of {}, got {got}", words.join(", ")))
    })
}

type Flat<'py> = Bound<'py, PyArray1<f64>>;

/// Plans, target masses, f, g, terms (k, 6), histories, their lengths, iterations, sweeps, converged.
type Solved<'py> = (
    Flat<'py>,
    Flat<'py>,
    Flat<'py>,
    Flat<'py>,
    Bound<'py, PyArray2<f64>>,
    Flat<'py>,
    Bound<'py, PyArray1<i64>>,
    Bound<'py, PyArray1<i64>>,
    Bound<'py, PyArray1<i64>>,
    Bound<'py, PyArray1<bool>>,
);

fn packed<'py>(py: Python<'py>, solutions: &[Solution]) -> PyResult<Solved<'py>> {
    let flat = |of: fn(&Solution) -> &[f64]| {
        let all: Vec<f64> = solutions.iter().flat_map(of).copied().collect();
        all.into_pyarray(py)
    };
    let count = |of: fn(&Solution) -> usize| {
        let all: Vec<i64> = solutions.iter().map(|s| i64::try_from(of(s)).unwrap_or(i64::MAX)).collect();
        all.into_pyarray(py)
    };
    let terms: Vec<f64> = solutions
        .iter()
        .flat_map(|s| {
            let t = &s.terms;
            [t.structure, t.feature, t.marginal_source, t.marginal_target, t.entropy, t.prior]
        })
        .collect();
    let converged: Vec<bool> = solutions.iter().map(|s| s.converged).collect();
    Ok((
        flat(|s| &s.plan),
        flat(|s| &s.target_mass),
        flat(|s| &s.source_potential),
        flat(|s| &s.target_potential),
        terms.into_pyarray(py).reshape([solutions.len(), 6])?,
        flat(|s| &s.history),
        count(|s| s.history.len()),
        count(|s| s.iterations),
        count(|s| s.sweeps),
        converged.into_pyarray(py),
    ))
}

/// Solve packed pairs of unbalanced fused Gromov-Wasserstein transport.
#[pyfunction]
#[pyo3(signature = (sizes, features, source, target, source_mass, target_mass, prior, start, *, alpha, tau_s, tau_t,
    eps, loss, entropy, em_rate, tol, max_outer, threads))]
#[allow(clippy::too_many_arguments)]
pub fn ufgw_batch<'py>(
    py: Python<'py>,
    sizes: PyReadonlyArray2<'py, i64>,
    features: PyReadonlyArray1<'py, f64>,
    source: PyReadonlyArray1<'py, f64>,
    target: PyReadonlyArray1<'py, f64>,
    source_mass: PyReadonlyArray1<'py, f64>,
    target_mass: PyReadonlyArray1<'py, f64>,
    prior: Option<PyReadonlyArray1<'py, f64>>,
    start: Option<PyReadonlyArray1<'py, f64>>,
    alpha: f64,
    tau_s: f64,
    tau_t: f64,
    eps: f64,
    loss: &str,
    entropy: &str,
    em_rate: Option<f64>,
    tol: f64,
    max_outer: usize,
    threads: usize,
) -> PyResult<Solved<'py>> {
    let options = Options {
        alpha,
        tau_s,
        tau_t,
        eps,
        loss: choice("loss", loss, &[("square", Loss::Square), ("absolute", Loss::Absolute)])?,
        entropy: choice(
            "entropy",
            entropy,
            &[("relative", Entropy::Relative), ("plain", Entropy::Plain), ("unit", Entropy::Unit)],
        )?,
        em_rate,
        tol,
        max_outer,
    };
    let words = slice("sizes", &sizes)?;
    let pairs: Vec<(usize, usize)> = words
        .chunks_exact(2)
        .map(|nm| Ok((usize::try_from(nm[0])?, usize::try_from(nm[1])?)))
        .collect::<Result<_, std::num::TryFromIntError>>()
        .map_err(|_| PyValueError::new_err("sizes: expected (k, 2) numbers >= 0"))?;
    let prior = prior.as_ref().map(|x| slice("prior", x)).transpose()?;
    let start = start.as_ref().map(|x| slice("start", x)).transpose()?;
    let data = Packed {
        sizes: &pairs,
        features: slice("M", &features)?,
        source: slice("A", &source)?,
        target: slice("B", &target)?,
        source_mass: slice("mu", &source_mass)?,
        target_mass: slice("nu", &target_mass)?,
        prior,
        start,
    };
    let inputs = data.inputs().map_err(|error| to_py(&error))?;
    let solved = py.detach(|| solve_batch(&inputs, &options, threads));
    let solutions = solved.map_err(|(pair, error)| match error {
        error if inputs.len() == 1 => to_py(&error),
        error => PyValueError::new_err(format!("{error} (pair {pair})")),
    })?;
    packed(py, &solutions)
}

/// Feature cost of n source parts (of any number of objects) and m target parts.
#[pyfunction]
#[pyo3(signature = (source_extents, source_relations, source_descriptors, target_extents, target_relations,
    target_descriptors, *, lambda_obb, lambda_global, lambda_relation, variant))]
#[allow(clippy::too_many_arguments)]
pub fn feature_costs<'py>(
    py: Python<'py>,
    source_extents: PyReadonlyArray2<'py, f64>,
    source_relations: PyReadonlyArray2<'py, f64>,
    source_descriptors: Option<PyReadonlyArray2<'py, f64>>,
    target_extents: PyReadonlyArray2<'py, f64>,
    target_relations: PyReadonlyArray2<'py, f64>,
    target_descriptors: Option<PyReadonlyArray2<'py, f64>>,
    lambda_obb: f64,
    lambda_global: f64,
    lambda_relation: f64,
    variant: &str,
) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let variant = choice("variant", variant, &[("graft", Variant::Graft), ("paper", Variant::Paper)])?;
    let source = Features {
        extents: boxes("source half extents", &source_extents)?,
        relations: finite("source relations", &source_relations)?,
        descriptors: source_descriptors.as_ref().map(|d| finite("source descriptors", d)).transpose()?,
    };
    let target = Features {
        extents: boxes("target half extents", &target_extents)?,
        relations: finite("target relations", &target_relations)?,
        descriptors: target_descriptors.as_ref().map(|d| finite("target descriptors", d)).transpose()?,
    };
    let cost = FeatureCost { lambda_obb, lambda_global, lambda_relation, variant };
    let matrix = py.detach(|| cost.matrix(source, target)).map_err(|error| to_py(&error))?;
    matrix.into_pyarray(py).reshape([source.extents.len() / 3, target.extents.len() / 3])
}

fn boxes<'a>(name: &'static str, array: &'a PyReadonlyArray2<'_, f64>) -> PyResult<&'a [f64]> {
    let data = finite(name, array)?;
    match array.as_array().shape() {
        [_, 3] => Ok(data),
        shape => Err(to_py(&Error::shape(name, "(n, 3)", format!("{shape:?}")))),
    }
}
