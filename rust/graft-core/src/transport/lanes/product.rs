//! The gradient of the structure term in every lane: two matrix products.

// As in the kernel.
#![allow(clippy::inline_always)]

use super::block::State;
use super::kernel::apart;
use super::vector::Vector;

/// Rows of C_GW that are computed together, so that B and T are read from the cache once for all of them.
pub const ROWS: usize = 4;

/// C_GW = A^2 u + B^2 v - 2 A T B for symmetric structures.
#[inline(always)]
pub fn gradient<V: Vector>(a: &[V], b: &[V], state: &mut State<V>, work: &mut [V], n: usize, m: usize) {
    let zero = V::splat(0.0);
    let (half, col_part) = work.split_at_mut(ROWS * m);
    for j in 0..m {
        apart();
        let b_row = &b[j * m..(j + 1) * m];
        let mut sum = zero;
        for l in 0..m {
            apart();
            sum = sum + b_row[l] * b_row[l] * state.v[l];
        }
        col_part[j] = sum;
    }
    let mut i = 0;
    while i < n {
        let rows = if i + ROWS <= n { ROWS } else { 1 };
        let a_rows = &a[i * n..(i + rows) * n];
        let out = &mut state.gradient[i * m..(i + rows) * m];
        let half = &mut half[..rows * m];
        if rows == ROWS {
            product::<V, ROWS, 2>(a_rows, &state.plan, half, n, m);
            product::<V, ROWS, 2>(half, b, out, m, m);
        } else {
            product_row(a_rows, &state.plan, half, m);
            product_row(half, b, out, m);
        }
        for r in 0..rows {
            let a_row = &a_rows[r * n..(r + 1) * n];
            let mut row_part = zero;
            for k in 0..n {
                apart();
                row_part = row_part + a_row[k] * a_row[k] * state.u[k];
            }
            let out = &mut out[r * m..(r + 1) * m];
            for j in 0..m {
                apart();
                out[j] = row_part + col_part[j] - (out[j] + out[j]);
            }
        }
        i += rows;
    }
}

/// X Y, of X's R rows (of length k) and Y's m columns, C columns at a time.
#[inline(always)]
fn product<V: Vector, const R: usize, const C: usize>(x: &[V], y: &[V], out: &mut [V], k: usize, m: usize) {
    let mut j = 0;
    while j + C <= m {
        tile::<V, R, C>(x, y, out, k, m, j);
        j += C;
    }
    while j < m {
        tile::<V, R, 1>(x, y, out, k, m, j);
        j += 1;
    }
}

/// Columns j to j + C of the product, summed in registers.
#[inline(always)]
fn tile<V: Vector, const R: usize, const C: usize>(x: &[V], y: &[V], out: &mut [V], k: usize, m: usize, j: usize) {
    let mut sums = [[V::splat(0.0); C]; R];
    for l in 0..k {
        apart();
        let y = &y[l * m + j..l * m + j + C];
        for r in 0..R {
            let x = x[r * k + l];
            for c in 0..C {
                sums[r][c] = sums[r][c] + x * y[c];
            }
        }
    }
    for r in 0..R {
        for c in 0..C {
            out[r * m + j + c] = sums[r][c];
        }
    }
}

/// The product of one row; written out because LLVM shuffles an array of sums here.
#[inline(always)]
fn product_row<V: Vector>(x: &[V], y: &[V], out: &mut [V], m: usize) {
    let zero = V::splat(0.0);
    let mut j = 0;
    while j + 4 <= m {
        let (mut s0, mut s1, mut s2, mut s3) = (zero, zero, zero, zero);
        for l in 0..x.len() {
            apart();
            let (x, y) = (x[l], &y[l * m + j..l * m + j + 4]);
            s0 = s0 + x * y[0];
            s1 = s1 + x * y[1];
            s2 = s2 + x * y[2];
            s3 = s3 + x * y[3];
        }
        out[j] = s0;
        out[j + 1] = s1;
        out[j + 2] = s2;
        out[j + 3] = s3;
        j += 4;
    }
    while j < m {
        let mut sum = zero;
        for l in 0..x.len() {
            apart();
            sum = sum + x[l] * y[l * m + j];
        }
        out[j] = sum;
        j += 1;
    }
}
