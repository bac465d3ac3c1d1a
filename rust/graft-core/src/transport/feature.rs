//! The feature cost M of two part graphs, or of many source graphs end to end against one target.

use crate::Error;

/// How the descriptor's cosine enters.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Variant {
    /// tanh(|e - e'| / 2) and 1 - cos: both vanish for equal parts.
    Graft,
    /// The paper's literal sigmoid(|e - e'|) and cos, shifted by +1 to stay non-negative.
    Paper,
}

/// Weights and variant of the feature cost.
#[derive(Debug, Clone, Copy)]
pub struct FeatureCost {
    /// Weight of the boxes' term.
    pub lambda_obb: f64,
    /// Weight of the descriptors' term.
    pub lambda_global: f64,
    /// Weight of the relations' term.
    pub lambda_relation: f64,
    /// Variant.
    pub variant: Variant,
}

/// One side's parts: half extents (k x 3) in diagonals, relations (k x width), descriptors (k x dim) or none.
#[derive(Debug, Clone, Copy)]
pub struct Features<'a> {
    /// Half extents, row-major.
    pub extents: &'a [f64],
    /// Relations, row-major; rows of length at most 1.
    pub relations: &'a [f64],
    /// Descriptors, row-major.
    pub descriptors: Option<&'a [f64]>,
}

fn unit_rows(x: &[f64], dim: usize) -> Vec<f64> {
    let mut rows = x.to_vec();
    for row in rows.chunks_exact_mut(dim) {
        let top = row.iter().fold(0.0_f64, |top, v| top.max(v.abs()));
        if top > 0.0 {
            for v in row.iter_mut() {
                *v /= top;
            }
            let norm = row.iter().map(|v| v * v).sum::<f64>().sqrt();
            for v in row.iter_mut() {
                *v /= norm;
            }
        }
    }
    rows
}

impl FeatureCost {
    /// M_ij = lambda_obb tanh(|e_i - e_j| / 2) + lambda_global (1 - cos(f_i, f_j)) + lambda_relation (1 - r_i . r_j),
    /// row-major.
    ///
    /// The descriptor's term is dropped, weights untouched, unless both sides have descriptors. The cosine with a
    /// descriptor of zero is 0.
    ///
    /// # Errors
    /// A negative weight, or relations or descriptors whose length is no multiple of the parts.
    pub fn matrix(&self, source: Features, target: Features) -> Result<Vec<f64>, Error> {
        for (name, weight) in [
            ("lambda_obb", self.lambda_obb),
            ("lambda_global", self.lambda_global),
            ("lambda_relation", self.lambda_relation),
        ] {
            if !(weight >= 0.0 && weight.is_finite()) {
                return Err(Error::value(name, "a finite number >= 0", weight));
            }
        }
        let (n, m) = (source.extents.len() / 3, target.extents.len() / 3);
        let mut out = Vec::with_capacity(n * m);
        for a in source.extents.chunks_exact(3) {
            for b in target.extents.chunks_exact(3) {
                let apart = a.iter().zip(b).map(|(x, y)| (x - y) * (x - y)).sum::<f64>().sqrt();
                let boxes = match self.variant {
                    Variant::Graft => (apart / 2.0).tanh(),
                    Variant::Paper => 1.0 / (1.0 + (-apart).exp()),
                };
                out.push(self.lambda_obb * boxes);
            }
        }
        if self.lambda_relation > 0.0 {
            let width = width("source relations", source.relations, n, target.relations, m)?;
            add_products(&mut out, source.relations, target.relations, width, |dot| self.lambda_relation * (1.0 - dot));
        }
        if let (Some(s), Some(t)) = (source.descriptors, target.descriptors) {
            let dim = width("source descriptors", s, n, t, m)?;
            add_products(&mut out, &unit_rows(s, dim), &unit_rows(t, dim), dim, |cos| {
                self.lambda_global
                    * match self.variant {
                        Variant::Graft => 1.0 - cos,
                        Variant::Paper => 1.0 + cos,
                    }
            });
        }
        Ok(out)
    }
}

/// The common length of n source rows and m target rows.
fn width(name: &'static str, source: &[f64], n: usize, target: &[f64], m: usize) -> Result<usize, Error> {
    let dim = target.len().checked_div(m).unwrap_or(0);
    if dim == 0 || source.len() != n * dim {
        return Err(Error::shape(name, format!("{n} x {dim} numbers"), source.len()));
    }
    Ok(dim)
}

/// Add `term` of the dot product of every source row with every target row to the table.
fn add_products(table: &mut [f64], source: &[f64], target: &[f64], dim: usize, term: impl Fn(f64) -> f64) {
    let m = target.len() / dim;
    for (row, a) in table.chunks_exact_mut(m).zip(source.chunks_exact(dim)) {
        for (value, b) in row.iter_mut().zip(target.chunks_exact(dim)) {
            *value += term(a.iter().zip(b).map(|(x, y)| x * y).sum::<f64>().clamp(-1.0, 1.0));
        }
    }
}
