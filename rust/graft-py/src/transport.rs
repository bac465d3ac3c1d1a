//! Border of the transport stage.

use graft_core::Error;
use graft_core::transport::batch::{Packed, Precision, Run};
use graft_core::transport::feature::{FeatureCost, Features, Variant};
use graft_core::transport::lanes::dispatch::{self, Instructions};
use graft_core::transport::starts::solve_from_starts;
use graft_core::transport::{Entropy, Input, Loss, Options, Solution};
use numpy::{IntoPyArray, PyArray1, PyArray2, PyArrayMethods, PyReadonlyArray1, PyReadonlyArray2};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use crate::convert::{finite, slice, to_py};

pub fn choice<T: Copy>(name: &str, got: &str, choices: &[(&str, T)]) -> PyResult<T> {
    choices.iter().find(|(word, _)| *word == got).map(|(_, value)| *value).ok_or_else(|| {
        let words: Vec<_> = choices.iter().map(|(word, _)| *word).collect();
        PyValueError::new_err(format!("{name}: expected one of {}, got {got}", words.join(", ")))
    })
}

type Flat<'py> = Bound<'py, PyArray1<f64>>;

pub fn options_of(
    (alpha, tau_s, tau_t, eps): (f64, f64, f64, f64),
    loss: &str,
    entropy: &str,
    em_rate: Option<f64>,
    (tol, max_outer): (f64, usize),
) -> PyResult<Options> {
    Ok(Options {
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
    })
}

fn run_of(threads: usize, precision: &str, history: bool, instructions: &str) -> PyResult<Run> {
    let sets = [
        ("best", dispatch::instructions()),
        ("avx512", Instructions::Avx512),
        ("avx2", Instructions::Avx2),
        ("baseline", Instructions::Baseline),
    ];
    Ok(Run {
        threads,
        precision: choice("precision", precision, &[("f64", Precision::F64), ("f32", Precision::F32)])?,
        history,
        instructions: choice("instructions", instructions, &sets)?,
    })
}

fn six(solution: &Solution) -> [f64; 6] {
    let t = &solution.terms;
    [t.structure, t.feature, t.marginal_source, t.marginal_target, t.entropy, t.prior]
}

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
        let mut all = Vec::with_capacity(solutions.iter().map(|s| of(s).len()).sum());
        for solution in solutions {
            all.extend_from_slice(of(solution));
        }
        all.into_pyarray(py)
    };
    let count = |of: fn(&Solution) -> usize| {
        let all: Vec<i64> = solutions.iter().map(|s| i64::try_from(of(s)).unwrap_or(i64::MAX)).collect();
        all.into_pyarray(py)
    };
    let terms: Vec<f64> = solutions.iter().flat_map(six).collect();
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
#[pyo3(signature = (sizes, features, source, target, source_mass, target_mass, prior, start, start_potential, *, alpha,
    tau_s, tau_t, eps, loss, entropy, em_rate, tol, max_outer, n_init, seed, precision, history, threads,
    instructions))]
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
    start_potential: Option<PyReadonlyArray1<'py, f64>>,
    alpha: f64,
    tau_s: f64,
    tau_t: f64,
    eps: f64,
    loss: &str,
    entropy: &str,
    em_rate: Option<f64>,
    tol: f64,
    max_outer: usize,
    n_init: usize,
    seed: u64,
    precision: &str,
    history: bool,
    threads: usize,
    instructions: &str,
) -> PyResult<Solved<'py>> {
    let options = options_of((alpha, tau_s, tau_t, eps), loss, entropy, em_rate, (tol, max_outer))?;
    let run = run_of(threads, precision, history, instructions)?;
    let words = slice("sizes", &sizes)?;
    let pairs: Vec<(usize, usize)> = words
        .chunks_exact(2)
        .map(|nm| Ok((usize::try_from(nm[0])?, usize::try_from(nm[1])?)))
        .collect::<Result<_, std::num::TryFromIntError>>()
        .map_err(|_| PyValueError::new_err("sizes: expected (k, 2) numbers >= 0"))?;
    let data = Packed {
        sizes: &pairs,
        features: slice("M", &features)?,
        source: slice("A", &source)?,
        target: slice("B", &target)?,
        source_mass: slice("mu", &source_mass)?,
        target_mass: slice("nu", &target_mass)?,
        prior: prior.as_ref().map(|x| slice("prior", x)).transpose()?,
        start: start.as_ref().map(|x| slice("start", x)).transpose()?,
        start_potential: start_potential.as_ref().map(|x| slice("start_g", x)).transpose()?,
    };
    let inputs = data.inputs().map_err(|error| to_py(&error))?;
    let solved = py.detach(|| solve_from_starts(&inputs, &options, &run, n_init, seed));
    let solutions = solved.map_err(|(pair, error)| match error {
        error if inputs.len() == 1 => to_py(&error),
        error => PyValueError::new_err(format!("{error} (pair {pair})")),
    })?;
    packed(py, &solutions)
}

/// Plan (n, m), target masses, f, g, terms, history, iterations, sweeps, converged.
type One<'py> = (Bound<'py, PyArray2<f64>>, Flat<'py>, Flat<'py>, Flat<'py>, [f64; 6], Flat<'py>, usize, usize, bool);

/// Solve one pair of matrices.
#[pyfunction]
#[pyo3(signature = (features, source, target, source_mass, target_mass, prior, start, start_potential, alpha, tau_s,
    tau_t, eps, loss, entropy, em_rate, tol, max_outer, n_init, seed, precision, history))]
#[allow(clippy::too_many_arguments)]
pub fn ufgw_pair<'py>(
    py: Python<'py>,
    features: PyReadonlyArray2<'py, f64>,
    source: PyReadonlyArray2<'py, f64>,
    target: PyReadonlyArray2<'py, f64>,
    source_mass: PyReadonlyArray1<'py, f64>,
    target_mass: PyReadonlyArray1<'py, f64>,
    prior: Option<PyReadonlyArray1<'py, f64>>,
    start: Option<PyReadonlyArray2<'py, f64>>,
    start_potential: Option<PyReadonlyArray1<'py, f64>>,
    alpha: f64,
    tau_s: f64,
    tau_t: f64,
    eps: f64,
    loss: &str,
    entropy: &str,
    em_rate: Option<f64>,
    tol: f64,
    max_outer: usize,
    n_init: usize,
    seed: u64,
    precision: &str,
    history: bool,
) -> PyResult<One<'py>> {
    let options = options_of((alpha, tau_s, tau_t, eps), loss, entropy, em_rate, (tol, max_outer))?;
    let run = run_of(1, precision, history, "best")?;
    let input = Input {
        features: slice("M", &features)?,
        source: slice("A", &source)?,
        target: slice("B", &target)?,
        source_mass: slice("mu", &source_mass)?,
        target_mass: slice("nu", &target_mass)?,
        prior: prior.as_ref().map(|x| slice("prior", x)).transpose()?,
        start: start.as_ref().map(|x| slice("start", x)).transpose()?,
        start_potential: start_potential.as_ref().map(|x| slice("start_g", x)).transpose()?,
    };
    let size = [input.source_mass.len(), input.target_mass.len()];
    let solved = py.detach(|| solve_from_starts(&[input], &options, &run, n_init, seed));
    let found = solved.map_err(|(_, error)| to_py(&error))?.into_iter().next();
    let found = found.ok_or_else(|| PyValueError::new_err("ufgw: expected one solution, got none"))?;
    let terms = six(&found);
    Ok((
        found.plan.into_pyarray(py).reshape(size)?,
        found.target_mass.into_pyarray(py),
        found.source_potential.into_pyarray(py),
        found.target_potential.into_pyarray(py),
        terms,
        found.history.into_pyarray(py),
        found.iterations,
        found.sweeps,
        found.converged,
    ))
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
