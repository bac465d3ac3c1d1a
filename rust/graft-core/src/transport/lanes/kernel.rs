//! One outer iteration of every lane: linearise, three translation-invariant sweeps, the new plan and its gradient.
//!
//! Scalings are kept up to one factor a side whose logarithm is added where logarithms are taken anyway, so that the
//! shift that makes a sweep translation-invariant costs one logarithm, not three exponentials (the mathematics is in
//! [`crate::transport::sinkhorn`]). Sums run in the order of the nodes and nodes that pad have no mass, so padding
//! changes no bit.

// Every function is compiled into its caller so that it takes over the caller's instruction set.
#![allow(clippy::inline_always)]

use super::block::{Block, Rates, Report};
use super::dispatch::{self, Instructions, Kernel};
use super::product::gradient;
use super::vector::Vector;

/// Sweeps an iteration: 2 leave Sinkhorn the slowest part of the iteration, 4 are no better than 3.
pub const SWEEPS: usize = 3;

/// Keep one pass of a loop from being merged with the next.
///
/// Lanes are the vectors here. Left alone LLVM sees arrays of floats in a loop, and may prefer vectors across the passes
/// of the loop, made with gathers and shuffles: five times slower. This compiles to nothing.
#[inline(always)]
pub fn apart() {
    std::hint::black_box(());
}

/// One iteration from `block.at` to `block.to`; the potentials move on whether or not the step is taken.
pub fn iterate<V: Vector>(block: &mut Block<V>, rates: &Rates, with: Instructions) {
    dispatch::run(Iteration { block, rates }, with);
}

struct Iteration<'a, V> {
    block: &'a mut Block<V>,
    rates: &'a Rates,
}

impl<V: Vector> Kernel for Iteration<'_, V> {
    #[inline(always)]
    fn run(self) {
        step(self.block, self.rates);
    }
}

#[inline(always)]
fn step<V: Vector>(block: &mut Block<V>, rates: &Rates) {
    absorb(block, rates);
    let shifts = sweep(block, rates);
    plan(block, rates, &shifts);
    gradient(&block.source, &block.target, &mut block.to, &mut block.half, block.n, block.m);
    curvature(block);
    target_mass(block, rates);
}

/// K = exp((f + g - C) / eps).
#[inline(always)]
fn absorb<V: Vector>(block: &mut Block<V>, rates: &Rates) {
    let m = block.m;
    let (structure, momentum) = (V::splat(rates.structure), V::splat(rates.momentum));
    let g = &block.g[..m];
    for i in 0..block.n {
        let f = block.f[i];
        let kernel = &mut block.kernel[i * m..(i + 1) * m];
        let gradient = &block.at.gradient[i * m..(i + 1) * m];
        let before = &block.to.gradient[i * m..(i + 1) * m];
        let features = &block.features[i * m..(i + 1) * m];
        for j in 0..m {
            apart();
            let cost = structure * gradient[j] + momentum * (gradient[j] - before[j]) + features[j];
            kernel[j] = (f + g[j] - cost).exp();
        }
    }
}

/// What remains of the sweeps beside the scalings: logs of their common factors.
struct Shifts<V> {
    rows: V,
    cols: V,
    asked_rows: V,
}

#[inline(always)]
fn sweep<V: Vector>(block: &mut Block<V>, rates: &Rates) -> Shifts<V> {
    let (n, m) = (block.n, block.m);
    let (follow_s, follow_t) = (V::splat(rates.follow_s), V::splat(rates.follow_t));
    let (slack_s, slack_t) = (V::splat(rates.slack_s), V::splat(rates.slack_t));
    let (pull_s, relax) = (V::splat(rates.pull_s), V::splat(rates.relax));
    let zero = V::splat(0.0);
    let mu = &block.mu[..n];
    let nu = &block.at.nu[..m];
    let (rows, cols) = (&mut block.rows[..n], &mut block.cols[..m]);
    let (log_rows, log_cols) = (&mut block.log_rows[..n], &mut block.log_cols[..m]);
    let (asked_rows, asked) = (&mut block.asked_rows[..n], &mut block.asked[..m]);
    let (f, g) = (&block.f[..n], &block.g[..m]);

    for i in 0..n {
        log_rows[i] = zero;
    }
    let mut asked_mass = zero;
    for j in 0..m {
        apart();
        cols[j] = nu[j];
        asked_mass = asked_mass + nu[j] * asked[j];
    }
    let mut log_asked_t = asked_mass.ln() + block.asked_log;
    let mut shifts = Shifts { rows: zero, cols: zero, asked_rows: zero };
    for _ in 0..SWEEPS {
        // f given g.
        let mut mass = zero;
        for i in 0..n {
            let kernel = &block.kernel[i * m..(i + 1) * m];
            let mut sum = zero;
            for j in 0..m {
                apart();
                sum = sum + kernel[j] * cols[j];
            }
            let best = zero - follow_s * (sum.ln() + shifts.cols) - slack_s * f[i];
            let log = best + block.relax * (best - (log_rows[i] + shifts.rows));
            log_rows[i] = log;
            rows[i] = mu[i] * log.exp();
            asked_rows[i] = (zero - pull_s * (f[i] + log)).exp();
            mass = mass + mu[i] * asked_rows[i];
        }
        block.relax = relax;
        let log_asked_s = mass.ln();
        let shift = V::splat(rates.balance_s) * (log_asked_s - log_asked_t);
        let log_asked_s = log_asked_s - slack_s * shift;
        shifts.asked_rows = zero - slack_s * shift;
        shifts.rows = follow_s * shift;

        // g given f.
        for j in 0..m {
            apart();
            asked[j] = zero;
        }
        for i in 0..n {
            let kernel = &block.kernel[i * m..(i + 1) * m];
            let row = rows[i];
            for j in 0..m {
                apart();
                asked[j] = asked[j] + kernel[j] * row;
            }
        }
        let mut mass = zero;
        for j in 0..m {
            apart();
            let log = zero - follow_t * (asked[j].ln() + shifts.rows) - slack_t * g[j];
            let scaling = log.exp();
            log_cols[j] = log;
            cols[j] = nu[j] * scaling;
            asked[j] = asked[j] * scaling;
            mass = mass + nu[j] * asked[j];
        }
        let log_mass = mass.ln() + shifts.rows;
        let shift = V::splat(rates.balance_t) * (log_mass - log_asked_s);
        log_asked_t = log_mass - slack_t * shift;
        block.asked_log = shifts.rows - slack_t * shift;
        shifts.asked_rows = shifts.asked_rows + pull_s * shift;
        shifts.cols = follow_t * shift;
        shifts.rows = shifts.rows - shift;
    }
    shifts
}

/// The new plan, its marginals, and how far it is from the old one and from what the prices ask for.
#[inline(always)]
fn plan<V: Vector>(block: &mut Block<V>, rates: &Rates, shifts: &Shifts<V>) {
    let (n, m) = (block.n, block.m);
    let zero = V::splat(0.0);
    let tiny = V::splat(V::TINY);
    let scale = (shifts.rows + shifts.cols).exp();
    let asked_scale = shifts.asked_rows.exp();
    let (mut moved, mut rows_moved, mut mass) = (zero, zero, zero);
    let (mut residual, mut residual_gain, mut log_scaling) = (zero, zero, zero);
    let (mut momentum_gain, mut cost, mut potential) = (zero, zero, zero);
    let (structure, momentum) = (V::splat(rates.structure), V::splat(rates.momentum));
    let cols = &block.cols[..m];
    for i in 0..n {
        let kernel = &block.kernel[i * m..(i + 1) * m];
        let from = &block.at.plan[i * m..(i + 1) * m];
        let to = &mut block.to.plan[i * m..(i + 1) * m];
        let gradient = &block.at.gradient[i * m..(i + 1) * m];
        let before = &block.to.gradient[i * m..(i + 1) * m];
        let features = &block.features[i * m..(i + 1) * m];
        let row = block.rows[i] * scale;
        let (mut sum, mut row_moved, mut row_gain, mut row_cost) = (zero, zero, zero, zero);
        for j in 0..m {
            apart();
            let t = row * kernel[j] * cols[j];
            let step = t - from[j];
            let ahead = momentum * (gradient[j] - before[j]);
            row_moved = row_moved + step.abs();
            row_gain = row_gain + ahead * step;
            row_cost = row_cost + t * (structure * gradient[j] + ahead + features[j]);
            sum = sum + t;
            to[j] = t;
        }
        moved = moved + row_moved;
        momentum_gain = momentum_gain + row_gain;
        cost = cost + row_cost;
        block.to.u[i] = sum;
        mass = mass + sum;
        let asked = block.mu[i] * block.asked_rows[i] * asked_scale;
        let (excess, left) = (sum - asked, block.at.u[i] - sum);
        residual = residual + excess.abs();
        rows_moved = rows_moved + left.abs();
        // log x is between 1 - 1/x and x - 1.
        residual_gain = residual_gain + excess * left / (left.positive(sum, asked) + tiny);
        let log = block.log_rows[i];
        log_scaling = log_scaling.max(block.mu[i].positive(log.abs(), zero));
        block.f[i] = block.f[i] + log + shifts.rows;
        potential = potential + sum * block.f[i];
    }
    let mut cols_moved = zero;
    for j in 0..m {
        apart();
        // T'1 is what its price asks for, exactly.
        let v = block.at.nu[j] * block.asked[j] * scale;
        cols_moved = cols_moved + (v - block.at.v[j]).abs();
        block.to.v[j] = v;
        let log = block.log_cols[j];
        log_scaling = log_scaling.max(block.at.nu[j].positive(log.abs(), zero));
        block.g[j] = block.g[j] + log + shifts.cols;
        potential = potential + v * block.g[j];
    }
    let residual_gain = V::splat(rates.tau_s) * residual_gain;
    block.report = Report {
        moved,
        rows_moved,
        cols_moved,
        mass,
        residual,
        residual_gain,
        momentum_gain,
        log_scaling,
        sum_t_log: potential - cost,
        ..block.report
    };
}

#[inline(always)]
fn curvature<V: Vector>(block: &mut Block<V>) {
    let m = block.m;
    let (from, to) = (&block.at, &block.to);
    let mut total = V::splat(0.0);
    for i in 0..block.n {
        let row = i * m..(i + 1) * m;
        let (g0, g1) = (&from.gradient[row.clone()], &to.gradient[row.clone()]);
        let (t0, t1) = (&from.plan[row.clone()], &to.plan[row]);
        let mut sum = V::splat(0.0);
        for j in 0..m {
            apart();
            sum = sum + (g1[j] - g0[j]) * (t1[j] - t0[j]);
        }
        total = total + sum;
    }
    block.report.curvature = total;
}

/// The M-step at the new plan.
#[inline(always)]
pub fn target_mass<V: Vector>(block: &mut Block<V>, rates: &Rates) {
    let zero = V::splat(0.0);
    let (mut moved, mut mass) = (zero, zero);
    let (given, taken) = (V::splat(1.0 - rates.em_rate), V::splat(rates.em_rate));
    let (beyond, half) = (V::splat(rates.em_beyond), V::splat(0.5));
    for j in 0..block.m {
        apart();
        let nu = block.at.nu[j];
        let next = if rates.em_rate > 0.0 {
            let best = (given * block.prior[j] + taken * block.to.v[j]) * block.em_scale;
            (best + beyond * (best - nu)).max(half * best)
        } else {
            nu
        };
        moved = moved + (next - nu).abs();
        mass = mass + nu;
        block.to.nu[j] = next;
    }
    block.report.nu_moved = moved;
    block.report.nu_mass = mass;
}
