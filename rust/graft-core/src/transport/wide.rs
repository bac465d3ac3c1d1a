//! The scalar solver's inner loops, vectors along the columns of one pair, for several instruction sets.
//!
//! Sums over columns run in [`WIDTH`] lanes that are added up in order at the end: one order whatever the instruction set.

// As in the lanes' kernel.
#![allow(clippy::inline_always)]

use super::lanes::dispatch::{self, Kernel, instructions};
use super::lanes::kernel::apart;
use super::lanes::vector::{F64x16, Vector};

const WIDTH: usize = F64x16::LANES;

/// Rows that are multiplied together.
const ROWS: usize = 4;

#[inline(always)]
fn load(x: &[f64], at: usize) -> F64x16 {
    let mut out = [0.0; WIDTH];
    out.copy_from_slice(&x[at..at + WIDTH]);
    F64x16(out)
}

/// The numbers from `at` on, zeros after the last.
#[inline(always)]
fn load_last(x: &[f64], at: usize) -> F64x16 {
    let mut out = [0.0; WIDTH];
    out[..x.len() - at].copy_from_slice(&x[at..]);
    F64x16(out)
}

#[inline(always)]
fn total(lanes: F64x16) -> f64 {
    let mut sum = 0.0;
    for k in 0..WIDTH {
        sum += lanes.0[k];
    }
    sum
}

/// sum of `term` over two slices of one length; `term` of zeros must be zero.
#[inline(always)]
fn reduce(a: &[f64], b: &[f64], term: impl Fn(F64x16, F64x16) -> F64x16) -> f64 {
    let whole = a.len() / WIDTH * WIDTH;
    let mut sums = F64x16::splat(0.0);
    let mut at = 0;
    while at < whole {
        apart();
        sums = sums + term(load(a, at), load(b, at));
        at += WIDTH;
    }
    if whole < a.len() {
        sums = sums + term(load_last(a, whole), load_last(b, whole));
    }
    total(sums)
}

macro_rules! kernel {
    ($name:ident<'a> { $($field:ident: $type:ty),* }, |$self:ident| $body:block) => {
        struct $name<'a> { $($field: $type),* }
        impl Kernel for $name<'_> {
            #[inline(always)]
            fn run($self) $body
        }
    };
}

kernel!(Dot<'a> { a: &'a [f64], b: &'a [f64], out: &'a mut f64 }, |self| {
    *self.out = reduce(self.a, self.b, |a, b| a * b);
});

kernel!(Distance<'a> { a: &'a [f64], b: &'a [f64], out: &'a mut f64 }, |self| {
    *self.out = reduce(self.a, self.b, |a, b| (a - b).abs());
});

kernel!(Exp<'a> { x: &'a mut [f64] }, |self| {
    let whole = self.x.len() / WIDTH * WIDTH;
    let mut at = 0;
    while at < whole {
        apart();
        let exp = load(self.x, at).exp();
        self.x[at..at + WIDTH].copy_from_slice(&exp.0);
        at += WIDTH;
    }
    let left = self.x.len() - whole;
    let exp = load_last(self.x, whole).exp();
    self.x[whole..].copy_from_slice(&exp.0[..left]);
});

kernel!(RowSums<'a> { matrix: &'a [f64], weights: &'a [f64], out: &'a mut [f64] }, |self| {
    let m = self.weights.len();
    for i in 0..self.out.len() {
        self.out[i] = reduce(&self.matrix[i * m..(i + 1) * m], self.weights, |a, b| a * b);
    }
});

kernel!(ColSums<'a> { matrix: &'a [f64], weights: &'a [f64], out: &'a mut [f64] }, |self| {
    let m = self.out.len();
    self.out.fill(0.0);
    for i in 0..self.weights.len() {
        let (row, weight) = (&self.matrix[i * m..(i + 1) * m], self.weights[i]);
        for j in 0..m {
            self.out[j] += weight * row[j];
        }
    }
});

kernel!(Product<'a> { scale: f64, x: &'a [f64], y: &'a [f64], out: &'a mut [f64], k: usize, m: usize }, |self| {
    let n = self.x.len() / self.k;
    let mut i = 0;
    while i < n {
        let rows = if i + ROWS <= n { ROWS } else { 1 };
        let x = &self.x[i * self.k..(i + rows) * self.k];
        let out = &mut self.out[i * self.m..(i + rows) * self.m];
        let mut j = 0;
        while j < self.m {
            // The last columns overlap the ones before: summed again, written once.
            let from = j.min(self.m - WIDTH);
            if rows == ROWS {
                tile::<ROWS>(self.scale, x, self.y, out, self.k, self.m, from, j - from);
            } else {
                tile::<1>(self.scale, x, self.y, out, self.k, self.m, from, j - from);
            }
            j = from + WIDTH;
        }
        i += rows;
    }
});

kernel!(Exponents<'a> {
    f: &'a [f64], g: &'a [f64], cost: &'a [f64], rate: f64, out: &'a mut [f64], tops: &'a mut [f64], row_top: &'a mut f64
}, |self| {
    let m = self.g.len();
    let whole = m / WIDTH * WIDTH;
    let rate = F64x16::splat(self.rate);
    for i in 0..self.f.len() {
        let (cost, out) = (&self.cost[i * m..(i + 1) * m], &mut self.out[i * m..(i + 1) * m]);
        let f = F64x16::splat(self.f[i]);
        let mut lanes = F64x16::splat(f64::NEG_INFINITY);
        let mut at = 0;
        while at < whole {
            apart();
            let x = (f + load(self.g, at) - load(cost, at)) * rate;
            out[at..at + WIDTH].copy_from_slice(&x.0);
            let tops = load(self.tops, at).max(x);
            self.tops[at..at + WIDTH].copy_from_slice(&tops.0);
            lanes = lanes.max(x);
            at += WIDTH;
        }
        let mut top = lanes.0.iter().fold(f64::NEG_INFINITY, |top, x| top.max(*x));
        for j in whole..m {
            let x = (self.f[i] + self.g[j] - cost[j]) * self.rate;
            out[j] = x;
            self.tops[j] = self.tops[j].max(x);
            top = top.max(x);
        }
        *self.row_top = self.row_top.max(top.abs());
    }
});

/// Add the product's columns `from + skip` to `from + WIDTH`.
#[allow(clippy::too_many_arguments)]
#[inline(always)]
fn tile<const R: usize>(
    scale: f64,
    x: &[f64],
    y: &[f64],
    out: &mut [f64],
    k: usize,
    m: usize,
    from: usize,
    skip: usize,
) {
    let mut sums = [F64x16::splat(0.0); R];
    for l in 0..k {
        apart();
        let y = load(y, l * m + from);
        for r in 0..R {
            sums[r] = sums[r] + F64x16::splat(x[r * k + l]) * y;
        }
    }
    for r in 0..R {
        for c in skip..WIDTH {
            out[r * m + from + c] += scale * sums[r].0[c];
        }
    }
}

/// sum a b.
#[must_use]
pub fn dot(a: &[f64], b: &[f64]) -> f64 {
    let mut out = 0.0;
    dispatch::run(Dot { a, b, out: &mut out }, instructions());
    out
}

/// sum |a - b|.
#[must_use]
pub fn distance(a: &[f64], b: &[f64]) -> f64 {
    let mut out = 0.0;
    dispatch::run(Distance { a, b, out: &mut out }, instructions());
    out
}

/// x <- e^x.
pub fn exp(x: &mut [f64]) {
    dispatch::run(Exp { x }, instructions());
}

/// out_ij = (f_i + g_j - cost_ij) rate; return the largest |largest entry| of any row or column.
#[must_use]
pub fn exponents(f: &[f64], g: &[f64], cost: &[f64], rate: f64, out: &mut [f64]) -> f64 {
    let (mut tops, mut row_top) = (vec![f64::NEG_INFINITY; g.len()], 0.0);
    dispatch::run(Exponents { f, g, cost, rate, out, tops: &mut tops, row_top: &mut row_top }, instructions());
    tops.iter().fold(row_top, |top, x| top.max(x.abs()))
}

/// out_i = sum_j matrix_ij weights_j.
pub fn row_sums(matrix: &[f64], weights: &[f64], out: &mut [f64]) {
    dispatch::run(RowSums { matrix, weights, out }, instructions());
}

/// out_j = sum_i weights_i matrix_ij.
pub fn col_sums(matrix: &[f64], weights: &[f64], out: &mut [f64]) {
    dispatch::run(ColSums { matrix, weights, out }, instructions());
}

/// out (n x m) += scale X (n x k) Y (k x m).
pub fn add_product(scale: f64, x: &[f64], y: &[f64], out: &mut [f64], k: usize, m: usize) {
    if m >= WIDTH {
        dispatch::run(Product { scale, x, y, out, k, m }, instructions());
        return;
    }
    for (x_row, out_row) in x.chunks_exact(k).zip(out.chunks_exact_mut(m)) {
        for (x, y_row) in x_row.iter().zip(y.chunks_exact(m)) {
            for (o, y) in out_row.iter_mut().zip(y_row) {
                *o += scale * x * y;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn numbers(len: usize, seed: u64) -> Vec<f64> {
        let mut x = seed;
        let mut next = || {
            x = x.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (x >> 40) as f64 / 16_777_216.0 - 0.5
        };
        (0..len).map(|_| next()).collect()
    }

    #[test]
    fn loops_are_their_definitions() {
        for (n, k, m) in [(1, 1, 1), (3, 5, 15), (4, 7, 16), (6, 9, 17), (9, 33, 50), (5, 2, 64)] {
            let (x, y) = (numbers(n * k, 1), numbers(k * m, 2));
            let mut out = numbers(n * m, 3);
            let before = out.clone();
            add_product(-2.0, &x, &y, &mut out, k, m);
            for i in 0..n {
                for j in 0..m {
                    let sum: f64 = (0..k).map(|l| x[i * k + l] * y[l * m + j]).sum();
                    assert!((out[i * m + j] - (before[i * m + j] - 2.0 * sum)).abs() < 1e-13);
                }
            }
            let (mut rows, mut cols) = (vec![0.0; k], vec![0.0; m]);
            row_sums(&y, &before[..m], &mut rows);
            col_sums(&y, &x[..k], &mut cols);
            for l in 0..k {
                assert!((rows[l] - (0..m).map(|j| y[l * m + j] * before[j]).sum::<f64>()).abs() < 1e-13);
            }
            for j in 0..m {
                assert!((cols[j] - (0..k).map(|l| y[l * m + j] * x[l]).sum::<f64>()).abs() < 1e-13);
            }
            let far: f64 = before.iter().zip(&out).map(|(a, b)| (a - b).abs()).sum();
            assert!((distance(&before, &out) - far).abs() < 1e-12 * (1.0 + far));
            let mut table = vec![0.0; n * m];
            let top = exponents(&x[..n], &y[..m], &before, 3.0, &mut table);
            let entry = |i: usize, j: usize| (x[i] + y[j] - before[i * m + j]) * 3.0;
            assert!((0..n * m).all(|k| (table[k] - entry(k / m, k % m)).abs() < 1e-14));
            let row = |i: usize| (0..m).map(|j| entry(i, j)).fold(f64::MIN, f64::max).abs();
            let col = |j: usize| (0..n).map(|i| entry(i, j)).fold(f64::MIN, f64::max).abs();
            let expected = (0..n).map(row).chain((0..m).map(col)).fold(0.0, f64::max);
            assert!((top - expected).abs() < 1e-14);
            let mut powers = before.clone();
            exp(&mut powers);
            assert!(powers.iter().zip(&before).all(|(p, x)| (p - x.exp()).abs() < 1e-15));
        }
    }
}
