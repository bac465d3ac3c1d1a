//! The structure term and its gradient C_GW, a linear map of the plan.
//!
//! With A = S_A + K_A split into its symmetric and antisymmetric parts, the gradient of
//! 1/2 sum (A_ii' - B_jj')^2 T_ij T_i'j' is
//! `1/2 (A^2 + A'^2) T1 + 1/2 (B^2 + B'^2) T'1 - 2 S_A T S_B + 2 K_A T K_B` (squares entrywise), which for symmetric
//! structures is the usual A^2 u + B^2 v - 2 A T B.

use super::problem::{Loss, Problem};
use super::wide::{add_product, dot};

/// Structure matrices prepared for many products.
#[derive(Debug)]
pub struct Structure {
    n: usize,
    m: usize,
    kind: Kind,
}

#[derive(Debug)]
enum Kind {
    Square {
        source: Vec<f64>,
        target: Vec<f64>,
        source_squared: Vec<f64>,
        target_squared: Vec<f64>,
        // Antisymmetric parts; present when both structures have one.
        skew: Option<(Vec<f64>, Vec<f64>)>,
        scratch: Vec<f64>,
    },
    Absolute {
        source: Vec<f64>,
        target: Vec<f64>,
        symmetric: bool,
    },
}

fn transpose_mix(a: &[f64], n: usize, mix: impl Fn(f64, f64) -> f64) -> Vec<f64> {
    (0..n * n).map(|k| mix(a[k], a[(k % n) * n + k / n])).collect()
}

impl Structure {
    /// Prepare a problem's structures.
    #[must_use]
    pub fn new(problem: &Problem, loss: Loss) -> Self {
        let (n, m) = (problem.n, problem.m);
        let (a, b) = (&problem.source, &problem.target);
        let skew_a = transpose_mix(a, n, |x, y| 0.5 * (x - y));
        let skew_b = transpose_mix(b, m, |x, y| 0.5 * (x - y));
        let is_skew = |k: &[f64]| k.iter().any(|x| *x != 0.0);
        let kind = match loss {
            Loss::Absolute => Kind::Absolute {
                source: a.clone(),
                target: b.clone(),
                symmetric: !is_skew(&skew_a) && !is_skew(&skew_b),
            },
            Loss::Square => Kind::Square {
                source: transpose_mix(a, n, |x, y| 0.5 * (x + y)),
                target: transpose_mix(b, m, |x, y| 0.5 * (x + y)),
                source_squared: transpose_mix(a, n, |x, y| 0.5 * (x * x + y * y)),
                target_squared: transpose_mix(b, m, |x, y| 0.5 * (x * x + y * y)),
                skew: (is_skew(&skew_a) && is_skew(&skew_b)).then_some((skew_a, skew_b)),
                scratch: vec![0.0; n * m],
            },
        };
        Self { n, m, kind }
    }

    /// Write C_GW(T) (n x m), the gradient of 1/2 sum loss T T, given T's marginals u and v.
    pub fn gradient(&mut self, t: &[f64], u: &[f64], v: &[f64], out: &mut [f64]) {
        let (n, m) = (self.n, self.m);
        match &mut self.kind {
            Kind::Square { source, target, source_squared, target_squared, skew, scratch } => {
                for i in 0..n {
                    let row = dot(&source_squared[i * n..(i + 1) * n], u);
                    out[i * m..(i + 1) * m].fill(row);
                }
                for j in 0..m {
                    let col = dot(&target_squared[j * m..(j + 1) * m], v);
                    for i in 0..n {
                        out[i * m + j] += col;
                    }
                }
                add_sandwich(-2.0, source, t, target, scratch, out, n, m);
                if let Some((a, b)) = skew {
                    add_sandwich(2.0, a, t, b, scratch, out, n, m);
                }
            }
            Kind::Absolute { source, target, symmetric } => {
                out.fill(0.0);
                absolute(source, target, t, out, n, m, false);
                if !*symmetric {
                    absolute(source, target, t, out, n, m, true);
                    for x in out.iter_mut() {
                        *x *= 0.5;
                    }
                }
            }
        }
    }
}

/// out += scale * A T B.
#[allow(clippy::too_many_arguments)]
fn add_sandwich(scale: f64, a: &[f64], t: &[f64], b: &[f64], scratch: &mut [f64], out: &mut [f64], n: usize, m: usize) {
    scratch.fill(0.0);
    add_product(1.0, a, t, scratch, n, m);
    add_product(scale, scratch, b, out, m, m);
}

/// out_ij += sum |A_ii' - B_jj'| T_i'j', of the transposed structures if asked.
fn absolute(a: &[f64], b: &[f64], t: &[f64], out: &mut [f64], n: usize, m: usize, transposed: bool) {
    let at = |x: &[f64], k: usize, i: usize, j: usize| if transposed { x[j * k + i] } else { x[i * k + j] };
    for i in 0..n {
        for j in 0..m {
            let mut sum = 0.0;
            for k in 0..n {
                let length = at(a, n, i, k);
                for l in 0..m {
                    sum += (length - at(b, m, j, l)).abs() * t[k * m + l];
                }
            }
            out[i * m + j] += sum;
        }
    }
}
