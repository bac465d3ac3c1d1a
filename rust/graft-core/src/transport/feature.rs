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
    /// Variant.
    pub variant: Variant,
}

/// One side's parts: half extents (k x 3) in diagonals, descriptors (k x dim) or none.
#[derive(Debug, Clone, Copy)]
pub struct Features<'a> {
    /// Half extents, row-major.
    pub extents: &'a [f64],
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
    /// M_ij = lambda_obb tanh(|e_i - e_j| / 2) + lambda_global (1 - cos(f_i, f_j)), row-major.
    ///
    /// The descriptor's term is dropped, weights untouched, unless both sides have descriptors. The cosine with a
    /// descriptor of zero is 0.
    ///
    /// # Errors
    /// A negative weight, or descriptors whose length is no multiple of the parts.
    pub fn matrix(&self, source: Features, target: Features) -> Result<Vec<f64>, Error> {
        for (name, weight) in [("lambda_obb", self.lambda_obb), ("lambda_global", self.lambda_global)] {
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
        let (Some(s), Some(t)) = (source.descriptors, target.descriptors) else {
            return Ok(out);
        };
        let dim = t.len().checked_div(m).unwrap_or(0);
        if dim == 0 || s.len() != n * dim {
            return Err(Error::shape("source descriptors", format!("{n} x {dim} numbers"), s.len()));
        }
        let (s, t) = (unit_rows(s, dim), unit_rows(t, dim));
        for (row, a) in out.chunks_exact_mut(m).zip(s.chunks_exact(dim)) {
            for (value, b) in row.iter_mut().zip(t.chunks_exact(dim)) {
                let cos = a.iter().zip(b).map(|(x, y)| x * y).sum::<f64>().clamp(-1.0, 1.0);
                *value += self.lambda_global
                    * match self.variant {
                        Variant::Graft => 1.0 - cos,
                        Variant::Paper => 1.0 + cos,
                    };
            }
        }
        Ok(out)
    }
}
