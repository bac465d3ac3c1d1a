//! One pair alone: the sums of [`super::kernel`] in the same order, vectors along the source's nodes.
//!
//! A row's sum over columns is a sum of vectors here when the arrays lie column by column; so that the sums over rows
//! are sums of vectors too, the kernel is kept in both orders. The bits are those of a lane.

// As in the kernel.
#![allow(clippy::inline_always)]

use super::aligned::Aligned;
use super::block::{Block, Rates, Report};
use super::dispatch::{self, Instructions, Kernel};
use super::judge::{Verdict, judge};
use super::kernel::{SWEEPS, apart, target_mass};
use super::lane::Lane;
use super::vector::Vector;
use crate::transport::problem::{Input, Options};
use crate::transport::ufgw::Solution;

/// Rows of a product that are summed together, and vectors of columns.
const ROWS: usize = 4;

/// Arrays for one pair at a time, kept for the next of the same padded size.
#[derive(Debug)]
pub struct Single<V: Vector> {
    block: Block<V::One>,
    // exp((f + g - C) / eps) row by row.
    by_row: Aligned<V::One>,
    // A node's number in every sum over nodes.
    terms: Aligned<V::One>,
    // Nodes before padding.
    n: usize,
    m: usize,
}

impl<V: Vector> Default for Single<V> {
    fn default() -> Self {
        Self::new(0, 0)
    }
}

impl<V: Vector> Single<V> {
    fn new(n: usize, m: usize) -> Self {
        let (wide, tall) = (n.next_multiple_of(V::LANES), m.next_multiple_of(V::LANES));
        let zero = V::One::splat(0.0);
        Self {
            block: Block::by_columns(wide, tall),
            by_row: Aligned::new(zero, wide * tall),
            terms: Aligned::new(zero, wide.max(tall)),
            n,
            m,
        }
    }

    /// Solve a checked pair; None if it is out of range.
    pub fn solve(&mut self, input: &Input, options: &Options, history: bool, with: Instructions) -> Option<Solution> {
        let (n, m) = (input.source_mass.len(), input.target_mass.len());
        if (n, m) != (self.n, self.m) {
            *self = Self::new(n, m);
        }
        let rates = Rates::new(options);
        let mut pair = Lane::load(&mut self.block, 0, 0, input, options, history);
        loop {
            dispatch::run(Iteration { single: self, rates: &rates }, with);
            match judge(&mut self.block, 0, &mut pair, options, history) {
                Verdict::Running => std::mem::swap(&mut self.block.at, &mut self.block.to),
                Verdict::Done(solution) => return Some(solution),
                Verdict::Rejected => return None,
            }
        }
    }
}

struct Iteration<'a, V: Vector> {
    single: &'a mut Single<V>,
    rates: &'a Rates,
}

impl<V: Vector> Kernel for Iteration<'_, V> {
    #[inline(always)]
    fn run(self) {
        absorb(self.single, self.rates);
        let shifts = sweep(self.single, self.rates);
        plan(self.single, self.rates, &shifts);
        gradient(self.single);
        curvature(self.single);
        target_mass(&mut self.single.block, self.rates);
    }
}

/// K = exp((f + g - C) / eps), by columns and by rows.
#[inline(always)]
fn absorb<V: Vector>(single: &mut Single<V>, rates: &Rates) {
    let block = &mut single.block;
    let (wide, tall) = (block.n, block.m);
    let (structure, momentum) = (V::splat(rates.structure), V::splat(rates.momentum));
    for j in 0..single.m {
        let column = j * wide..(j + 1) * wide;
        let kernel = &mut block.kernel[column.clone()];
        let (gradient, before) = (&block.at.gradient[column.clone()], &block.to.gradient[column.clone()]);
        let features = &block.features[column];
        let g = V::splat(block.g[j].get(0));
        let mut i = 0;
        while i < wide {
            apart();
            let slope = V::load(&gradient[i..]);
            let cost = structure * slope + momentum * (slope - V::load(&before[i..])) + V::load(&features[i..]);
            (V::load(&block.f[i..]) + g - cost).exp().store(&mut kernel[i..]);
            i += V::LANES;
        }
    }
    // By blocks, so that what is read and what is written stays in the cache.
    let (kernel, by_row) = (&block.kernel[..], &mut single.by_row[..]);
    let mut from = 0;
    while from < single.m {
        let to = (from + V::LANES).min(single.m);
        for i in 0..single.n {
            for j in from..to {
                by_row[i * tall + j] = kernel[j * wide + i];
            }
        }
        from = to;
    }
}

/// out = sum_k weights_k matrix_k over the first `count` rows of a matrix as wide as `out`.
///
/// Sums have names because LLVM shuffles an array of them here.
#[inline(always)]
fn weighted<V: Vector>(matrix: &[V::One], weights: &[V::One], out: &mut [V::One], count: usize) {
    let (width, zero) = (out.len(), V::splat(0.0));
    let mut at = 0;
    while at + 4 * V::LANES <= width {
        let (mut s0, mut s1, mut s2, mut s3) = (zero, zero, zero, zero);
        for k in 0..count {
            apart();
            let weight = V::splat(weights[k].get(0));
            let row = &matrix[k * width + at..k * width + at + 4 * V::LANES];
            s0 = s0 + V::load(row) * weight;
            s1 = s1 + V::load(&row[V::LANES..]) * weight;
            s2 = s2 + V::load(&row[2 * V::LANES..]) * weight;
            s3 = s3 + V::load(&row[3 * V::LANES..]) * weight;
        }
        s0.store(&mut out[at..]);
        s1.store(&mut out[at + V::LANES..]);
        s2.store(&mut out[at + 2 * V::LANES..]);
        s3.store(&mut out[at + 3 * V::LANES..]);
        at += 4 * V::LANES;
    }
    while at < width {
        let mut sum = zero;
        for k in 0..count {
            apart();
            sum = sum + V::load(&matrix[k * width + at..]) * V::splat(weights[k].get(0));
        }
        sum.store(&mut out[at..]);
        at += V::LANES;
    }
}

#[inline(always)]
fn total<O: Vector>(terms: &[O]) -> O {
    let mut sum = O::splat(0.0);
    for term in terms {
        sum = sum + *term;
    }
    sum
}

struct Shifts<O> {
    rows: O,
    cols: O,
    asked_rows: O,
}

#[inline(always)]
fn sweep<V: Vector>(single: &mut Single<V>, rates: &Rates) -> Shifts<V::One> {
    let (n, m) = (single.n, single.m);
    let (block, by_row, terms) = (&mut single.block, &single.by_row, &mut single.terms);
    let (wide, tall) = (block.n, block.m);
    let (follow_s, follow_t) = (V::splat(rates.follow_s), V::splat(rates.follow_t));
    let (slack_s, slack_t) = (V::splat(rates.slack_s), V::splat(rates.slack_t));
    let (one_slack_s, one_slack_t) = (V::One::splat(rates.slack_s), V::One::splat(rates.slack_t));
    let (one_follow_s, one_follow_t) = (V::One::splat(rates.follow_s), V::One::splat(rates.follow_t));
    let pull_s = V::splat(rates.pull_s);
    let zero = V::splat(0.0);
    let none = V::One::splat(0.0);

    block.log_rows[..wide].fill(none);
    for j in 0..m {
        block.cols[j] = block.at.nu[j];
        terms[j] = block.at.nu[j] * block.asked[j];
    }
    let mut log_asked_t = total(&terms[..m]).ln() + block.asked_log;
    let mut shifts = Shifts { rows: none, cols: none, asked_rows: none };
    for _ in 0..SWEEPS {
        // f given g.
        weighted::<V>(&block.kernel, &block.cols, &mut block.rows[..wide], m);
        let relax = V::splat(block.relax.get(0));
        let (row_shift, col_shift) = (V::splat(shifts.rows.get(0)), V::splat(shifts.cols.get(0)));
        let mut i = 0;
        while i < wide {
            apart();
            let (f, mu) = (V::load(&block.f[i..]), V::load(&block.mu[i..]));
            let best = zero - follow_s * (V::load(&block.rows[i..]).ln() + col_shift) - slack_s * f;
            let log = best + relax * (best - (V::load(&block.log_rows[i..]) + row_shift));
            log.store(&mut block.log_rows[i..]);
            (mu * log.exp()).store(&mut block.rows[i..]);
            let asked = (zero - pull_s * (f + log)).exp();
            asked.store(&mut block.asked_rows[i..]);
            (mu * asked).store(&mut terms[i..]);
            i += V::LANES;
        }
        block.relax = V::One::splat(rates.relax);
        let log_asked_s = total(&terms[..n]).ln();
        let shift = V::One::splat(rates.balance_s) * (log_asked_s - log_asked_t);
        let log_asked_s = log_asked_s - one_slack_s * shift;
        shifts.asked_rows = none - one_slack_s * shift;
        shifts.rows = one_follow_s * shift;

        // g given f.
        weighted::<V>(by_row, &block.rows, &mut block.asked[..tall], n);
        let row_shift = V::splat(shifts.rows.get(0));
        let mut j = 0;
        while j < tall {
            apart();
            let (sum, nu) = (V::load(&block.asked[j..]), V::load(&block.at.nu[j..]));
            let log = zero - follow_t * (sum.ln() + row_shift) - slack_t * V::load(&block.g[j..]);
            let scaling = log.exp();
            log.store(&mut block.log_cols[j..]);
            (nu * scaling).store(&mut block.cols[j..]);
            let asked = sum * scaling;
            asked.store(&mut block.asked[j..]);
            (nu * asked).store(&mut terms[j..]);
            j += V::LANES;
        }
        let log_mass = total(&terms[..m]).ln() + shifts.rows;
        let shift = V::One::splat(rates.balance_t) * (log_mass - log_asked_s);
        log_asked_t = log_mass - one_slack_t * shift;
        block.asked_log = shifts.rows - one_slack_t * shift;
        shifts.asked_rows = shifts.asked_rows + V::One::splat(rates.pull_s) * shift;
        shifts.cols = one_follow_t * shift;
        shifts.rows = shifts.rows - shift;
    }
    shifts
}

/// Sums over rows of what a plan's rows tell about a step.
struct Sums<O> {
    moved: O,
    momentum_gain: O,
    cost: O,
}

/// The new plan, and its row sums.
#[inline(always)]
fn entries<V: Vector>(single: &mut Single<V>, rates: &Rates, scale: V) -> Sums<V::One> {
    let block = &mut single.block;
    let wide = block.n;
    let (structure, momentum) = (V::splat(rates.structure), V::splat(rates.momentum));
    let (zero, none) = (V::splat(0.0), V::One::splat(0.0));
    let mut sums = Sums { moved: none, momentum_gain: none, cost: none };
    let len = single.m * wide;
    let (kernel, features) = (&block.kernel[..len], &block.features[..len]);
    let (from, gradient) = (&block.at.plan[..len], &block.at.gradient[..len]);
    let (to, before) = (&mut block.to.plan[..len], &block.to.gradient[..len]);
    let cols = &block.cols[..single.m];
    let mut i = 0;
    while i < wide {
        let row = V::load(&block.rows[i..]) * scale;
        let (mut sum, mut moved, mut gain, mut cost) = (zero, zero, zero, zero);
        let mut at = i;
        for col in cols {
            apart();
            let t = row * V::load(&kernel[at..]) * V::splat(col.get(0));
            let step = t - V::load(&from[at..]);
            let slope = V::load(&gradient[at..]);
            let ahead = momentum * (slope - V::load(&before[at..]));
            moved = moved + step.abs();
            gain = gain + ahead * step;
            cost = cost + t * (structure * slope + ahead + V::load(&features[at..]));
            sum = sum + t;
            t.store(&mut to[at..]);
            at += wide;
        }
        sum.store(&mut block.to.u[i..]);
        for k in 0..V::LANES.min(single.n - i) {
            sums.moved = sums.moved + V::One::splat(moved.get(k));
            sums.momentum_gain = sums.momentum_gain + V::One::splat(gain.get(k));
            sums.cost = sums.cost + V::One::splat(cost.get(k));
        }
        i += V::LANES;
    }
    sums
}

/// The new plan, its marginals, and how far it is from the old one and from what the prices ask for.
#[inline(always)]
fn plan<V: Vector>(single: &mut Single<V>, rates: &Rates, shifts: &Shifts<V::One>) {
    let none = V::One::splat(0.0);
    let tiny = V::One::splat(V::TINY);
    let scale = (shifts.rows + shifts.cols).exp();
    let asked_scale = shifts.asked_rows.exp();
    let Sums { moved, momentum_gain, cost } = entries(single, rates, V::splat(scale.get(0)));
    let block = &mut single.block;
    let (mut rows_moved, mut mass, mut potential) = (none, none, none);
    let (mut residual, mut residual_gain, mut log_scaling) = (none, none, none);
    for i in 0..single.n {
        let sum = block.to.u[i];
        mass = mass + sum;
        let asked = block.mu[i] * block.asked_rows[i] * asked_scale;
        let (excess, left) = (sum - asked, block.at.u[i] - sum);
        residual = residual + excess.abs();
        rows_moved = rows_moved + left.abs();
        residual_gain = residual_gain + excess * left / (left.positive(sum, asked) + tiny);
        let log = block.log_rows[i];
        log_scaling = log_scaling.max(block.mu[i].positive(log.abs(), none));
        block.f[i] = block.f[i] + log + shifts.rows;
        potential = potential + sum * block.f[i];
    }
    let mut cols_moved = none;
    for j in 0..single.m {
        let v = block.at.nu[j] * block.asked[j] * scale;
        cols_moved = cols_moved + (v - block.at.v[j]).abs();
        block.to.v[j] = v;
        let log = block.log_cols[j];
        log_scaling = log_scaling.max(block.at.nu[j].positive(log.abs(), none));
        block.g[j] = block.g[j] + log + shifts.cols;
        potential = potential + v * block.g[j];
    }
    block.report = Report {
        moved,
        rows_moved,
        cols_moved,
        mass,
        residual,
        residual_gain: V::One::splat(rates.tau_s) * residual_gain,
        momentum_gain,
        log_scaling,
        sum_t_log: potential - cost,
        ..block.report
    };
}

/// C_GW = A^2 u + B^2 v - 2 A T B, column by column.
#[inline(always)]
fn gradient<V: Vector>(single: &mut Single<V>) {
    let (n, m) = (single.n, single.m);
    let (block, terms) = (&mut single.block, &mut single.terms);
    let (wide, tall) = (block.n, block.m);
    product::<V>(&block.to.plan, wide, &block.source, &mut block.half, (m, n, wide));
    product::<V>(&block.target, tall, &block.half, &mut block.to.gradient, (m, m, wide));
    squares::<V>(&block.target, &block.to.v, &mut terms[..tall], m);
    // The cells of `half` are free again: its first column takes the rows' part.
    let row_part = &mut block.half[..wide];
    squares::<V>(&block.source, &block.to.u, row_part, n);
    let gradient = &mut block.to.gradient[..m * wide];
    for j in 0..m {
        let col = V::splat(terms[j].get(0));
        let column = &mut gradient[j * wide..(j + 1) * wide];
        let mut i = 0;
        while i < wide {
            apart();
            let product = V::load(&column[i..]);
            (V::load(&row_part[i..]) + col - (product + product)).store(&mut column[i..]);
            i += V::LANES;
        }
    }
}

/// out = sum_k matrix_k^2 weights_k over the first `count` rows.
#[inline(always)]
fn squares<V: Vector>(matrix: &[V::One], weights: &[V::One], out: &mut [V::One], count: usize) {
    let width = out.len();
    let mut at = 0;
    while at < width {
        let mut sum = V::splat(0.0);
        for k in 0..count {
            apart();
            let x = V::load(&matrix[k * width + at..]);
            sum = sum + x * x * V::splat(weights[k].get(0));
        }
        sum.store(&mut out[at..]);
        at += V::LANES;
    }
}

/// out = X Y for the first rows of X (`stride` apart) and as many rows of Y as X has columns.
#[inline(always)]
fn product<V: Vector>(
    x: &[V::One],
    stride: usize,
    y: &[V::One],
    out: &mut [V::One],
    (rows, inner, width): (usize, usize, usize),
) {
    let mut at = 0;
    // A panel of Y stays in the cache for all rows of X.
    while at < width {
        let two = at + 2 * V::LANES <= width;
        let mut i = 0;
        while i < rows {
            let some = if i + ROWS <= rows { ROWS } else { 1 };
            let (x, out) = (&x[i * stride..], &mut out[i * width + at..]);
            match (some, two) {
                (ROWS, true) => tile::<V, ROWS, 2>(x, stride, &y[at..], out, inner, width),
                (ROWS, false) => tile::<V, ROWS, 1>(x, stride, &y[at..], out, inner, width),
                (_, true) => tile::<V, 1, 2>(x, stride, &y[at..], out, inner, width),
                (_, false) => tile::<V, 1, 1>(x, stride, &y[at..], out, inner, width),
            }
            i += some;
        }
        at += if two { 2 * V::LANES } else { V::LANES };
    }
}

#[inline(always)]
fn tile<V: Vector, const R: usize, const C: usize>(
    x: &[V::One],
    stride: usize,
    y: &[V::One],
    out: &mut [V::One],
    inner: usize,
    width: usize,
) {
    let rows: [&[V::One]; R] = std::array::from_fn(|r| &x[r * stride..r * stride + inner]);
    let mut sums = [[V::splat(0.0); C]; R];
    for l in 0..inner {
        apart();
        let y = &y[l * width..l * width + C * V::LANES];
        for r in 0..R {
            let x = V::splat(rows[r][l].get(0));
            for c in 0..C {
                sums[r][c] = sums[r][c] + x * V::load(&y[c * V::LANES..]);
            }
        }
    }
    for r in 0..R {
        for c in 0..C {
            sums[r][c].store(&mut out[r * width + c * V::LANES..]);
        }
    }
}

/// <C_GW(D), D> of the step D.
#[inline(always)]
fn curvature<V: Vector>(single: &mut Single<V>) {
    let block = &mut single.block;
    let wide = block.n;
    let len = single.m * wide;
    let (g0, g1) = (&block.at.gradient[..len], &block.to.gradient[..len]);
    let (t0, t1) = (&block.at.plan[..len], &block.to.plan[..len]);
    let mut total = V::One::splat(0.0);
    let mut i = 0;
    while i < wide {
        let mut sum = V::splat(0.0);
        let mut at = i;
        while at < len {
            apart();
            let slope = V::load(&g1[at..]) - V::load(&g0[at..]);
            sum = sum + slope * (V::load(&t1[at..]) - V::load(&t0[at..]));
            at += wide;
        }
        for k in 0..V::LANES.min(single.n - i) {
            total = total + V::One::splat(sum.get(k));
        }
        i += V::LANES;
    }
    block.report.curvature = total;
}
