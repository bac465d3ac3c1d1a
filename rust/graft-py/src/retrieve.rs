//! Border of retrieval.

use graft_core::retrieve::{Library, Ranking, Target, Wanted, rank};
use graft_core::transport::feature::{FeatureCost, Features, Variant};
use numpy::{IntoPyArray, PyArray1, PyReadonlyArray1, PyReadonlyArray2};
use pyo3::prelude::*;

use crate::convert::{finite, slice, to_py};
use crate::transport::{choice, options_of};

type Words<'py> = PyReadonlyArray1<'py, i64>;
type Numbers<'py> = PyReadonlyArray1<'py, f64>;
type Table<'py> = PyReadonlyArray2<'py, f64>;
type Hot<'py> = PyReadonlyArray1<'py, f32>;

/// Indices, costs, and how many graphs were solved.
type Best<'py> = (Bound<'py, PyArray1<i64>>, Bound<'py, PyArray1<f64>>, usize);

/// Return the k graphs of a packed library that cost least to match with a target.
#[pyfunction]
#[pyo3(signature = (offsets, parts, extents, relations, descriptors, structures, masses, hot_extents, hot_features,
    hot_masses, target_extents, target_relations, target_descriptors, target_structure, target_prior, *, alpha, tau_s,
    tau_t, eps, loss, entropy, em_rate, tol, max_outer, lambda_obb, lambda_global, lambda_relation, variant, part_weight,
    doubt_weight, rival_weight, k, bar, among, prune))]
#[allow(clippy::too_many_arguments)]
pub fn rank_graphs<'py>(
    py: Python<'py>,
    offsets: Words<'py>,
    parts: Words<'py>,
    extents: Table<'py>,
    relations: Table<'py>,
    descriptors: Option<Table<'py>>,
    structures: Numbers<'py>,
    masses: Numbers<'py>,
    hot_extents: Hot<'py>,
    hot_features: Hot<'py>,
    hot_masses: Hot<'py>,
    target_extents: Table<'py>,
    target_relations: Table<'py>,
    target_descriptors: Option<Table<'py>>,
    target_structure: Table<'py>,
    target_prior: Numbers<'py>,
    alpha: f64,
    tau_s: f64,
    tau_t: f64,
    eps: f64,
    loss: &str,
    entropy: &str,
    em_rate: Option<f64>,
    tol: f64,
    max_outer: usize,
    lambda_obb: f64,
    lambda_global: f64,
    lambda_relation: f64,
    variant: &str,
    part_weight: f64,
    doubt_weight: f64,
    rival_weight: f64,
    k: usize,
    bar: f64,
    among: Option<Words<'py>>,
    prune: bool,
) -> PyResult<Best<'py>> {
    let variant = choice("variant", variant, &[("graft", Variant::Graft), ("paper", Variant::Paper)])?;
    let ranking = Ranking {
        options: options_of((alpha, tau_s, tau_t, eps), loss, entropy, em_rate, (tol, max_outer))?,
        feature: FeatureCost { lambda_obb, lambda_global, lambda_relation, variant },
        part_weight,
        doubt_weight,
        rival_weight,
    };
    let library = Library {
        offsets: slice("offsets", &offsets)?,
        parts: slice("parts", &parts)?,
        extents: slice("extents", &extents)?,
        relations: slice("relations", &relations)?,
        descriptors: descriptors.as_ref().map(|d| slice("descriptors", d)).transpose()?,
        structures: slice("structures", &structures)?,
        masses: slice("masses", &masses)?,
        hot_extents: slice("hot extents", &hot_extents)?,
        hot_features: slice("hot features", &hot_features)?,
        hot_masses: slice("hot masses", &hot_masses)?,
    };
    let target = Target {
        features: Features {
            extents: finite("target half extents", &target_extents)?,
            relations: finite("target relations", &target_relations)?,
            descriptors: target_descriptors.as_ref().map(|d| finite("target descriptors", d)).transpose()?,
        },
        structure: finite("target structure", &target_structure)?,
        prior: finite("target prior", &target_prior)?,
    };
    let among = among.as_ref().map(|a| slice("among", a)).transpose()?;
    let wanted = Wanted { k, bar, among, prune };
    let ranked = py.detach(|| rank(&library, &target, &ranking, &wanted)).map_err(|error| to_py(&error))?;
    let (indices, costs): (Vec<i64>, Vec<f64>) =
        ranked.best.iter().map(|(index, cost)| (i64::try_from(*index).unwrap_or(i64::MAX), *cost)).unzip();
    Ok((indices.into_pyarray(py), costs.into_pyarray(py), ranked.solved))
}
