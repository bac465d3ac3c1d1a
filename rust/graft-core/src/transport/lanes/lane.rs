//! One lane of a block: putting a pair in, judging its step, taking its solution out.

use super::block::{Block, Loading};
use super::vector::Vector;
use crate::transport::objective::{Terms, kl_scalar};
use crate::transport::problem::{Input, Options};
use crate::transport::ufgw::Solution;

/// What has become of a pair in its lane.
#[derive(Debug)]
pub struct Lane<'a> {
    /// The caller's index.
    pub index: usize,
    /// The pair.
    pub input: &'a Input<'a>,
    /// Iterations that moved the plan.
    pub iterations: usize,
    /// Iterations altogether.
    pub rounds: usize,
    /// Iterations in a row that did not.
    pub held: usize,
    /// J at the start and after every iteration, when asked for.
    pub history: Vec<f64>,
    /// Total of mu.
    pub mu_mass: f64,
    /// Largest loss of two structure entries.
    pub largest_loss: f64,
    /// Mass of the plan.
    pub mass: f64,
}

impl<'a> Lane<'a> {
    /// Put a pair into a lane of `block`, at its start.
    pub fn load<V: Vector>(
        block: &mut Block<V>,
        lane: usize,
        index: usize,
        input: &'a Input<'a>,
        options: &Options,
        history: bool,
    ) -> Self {
        let (n, m) = (input.source_mass.len(), input.target_mass.len());
        let (wide, tall) = (block.m, block.n);
        let (nus, priors) = input.target_masses(options);
        // A node of the target counts where it has mass in both.
        let mut loading = std::mem::take(&mut block.loading);
        loading.clear(wide);
        let Loading { nu, prior, by_col, col_part, start_g } = &mut loading;
        for j in (0..m).filter(|&j| nus[j] > 0.0 && priors[j] > 0.0) {
            (nu[j], prior[j]) = (nus[j], priors[j]);
        }
        let (mu_mass, nu_mass) = (input.source_mass.iter().sum::<f64>(), nu[..m].iter().sum::<f64>());
        let scale = 1.0 / (mu_mass * nu_mass).sqrt();
        put(&mut block.mu, lane, input.source_mass);
        put(&mut block.at.nu, lane, &nu[..m]);
        put(&mut block.prior, lane, &prior[..m]);
        for j in 0..wide {
            let row = if j < m { &input.target[j * m..(j + 1) * m] } else { &[] };
            put(&mut block.target[j * wide..(j + 1) * wide], lane, row);
            let (sum, squares) = moments(row, nu);
            (by_col[j], col_part[j]) = (sum, squares * mu_mass * scale);
            let g = input.start_potential.filter(|_| nu[j] > 0.0).map_or(0.0, |g| g[j]);
            start_g[j] = g / options.eps;
            block.g[j].set(lane, start_g[j]);
            block.asked[j].set(lane, if g == 0.0 { 1.0 } else { (-g / options.tau_t).exp() });
        }
        block.asked_log.set(lane, 0.0);
        block.relax.set(lane, 0.0);
        let (feature_rate, structure_rate) = (options.alpha / options.eps, (1.0 - options.alpha) / options.eps);
        let (down, across) = block.strides();
        // Slices of their own: through the block the compiler would look every array up again after every store.
        let (features, plan) = (&mut block.features[..], &mut block.at.plan[..]);
        let (gradient, before) = (&mut block.at.gradient[..], &mut block.to.gradient[..]);
        let (nu, start_g, by_col, col_part) = (&nu[..wide], &start_g[..wide], &by_col[..wide], &col_part[..wide]);
        for i in 0..tall {
            let row = if i < n { &input.source[i * n..(i + 1) * n] } else { &[] };
            put(&mut block.source[i * tall..(i + 1) * tall], lane, row);
            let (by_row, squares) = moments(row, input.source_mass);
            let (by_row, row_part) = (2.0 * by_row * scale, squares * nu_mass * scale);
            let mu = if i < n { input.source_mass[i] } else { 0.0 };
            let costs = if i < n { &input.features[i * m..(i + 1) * m] } else { &[] };
            let start = input.start.filter(|_| mu > 0.0).map_or(&[][..], |start| &start[i * m..(i + 1) * m]);
            let product = if input.start.is_some() { 0.0 } else { mu * scale };
            let (mut lowest, mut sum) = (f64::INFINITY, 0.0);
            for j in 0..wide {
                let feature = if j < costs.len() { costs[j].max(0.0) * feature_rate } else { 0.0 };
                let t = if j < start.len() && nu[j] > 0.0 { start[j] } else { product * nu[j] };
                sum += t;
                let slope = row_part + col_part[j] - by_row * by_col[j];
                let cell = i * down + j * across;
                features[cell].set(lane, feature);
                plan[cell].set(lane, t);
                gradient[cell].set(lane, slope);
                before[cell].set(lane, slope);
                let cost = structure_rate * slope + feature - start_g[j];
                lowest = if nu[j] > 0.0 && cost < lowest { cost } else { lowest };
            }
            block.at.u[i].set(lane, sum);
            // The kernel's largest entry of every row is 1.
            block.f[i].set(lane, lowest);
        }
        if input.start.is_some() {
            for j in 0..wide {
                let sum: f64 = (0..tall).map(|i| block.at.plan[block.cell(i, j)].get(lane)).sum();
                block.at.v[j].set(lane, sum);
            }
        } else {
            for j in 0..wide {
                block.at.v[j].set(lane, nu[j] * scale * mu_mass);
            }
        }
        block.loading = loading;
        let apart = largest(input.source) + largest(input.target);
        let (rate, relative) = (options.em_rate.unwrap_or(0.0), options.tau_t + options.eps);
        block.em_scale.set(lane, 1.0 / (rate * (options.tau_t + options.eps * mu_mass) / relative + 1.0 - rate));
        if input.start.is_some() {
            full_gradient(block, lane, input);
        }
        let mass = block.at.u.iter().map(|u| u.get(lane)).sum();
        let mut pair = Self {
            index,
            input,
            iterations: 0,
            rounds: 0,
            held: 0,
            history: Vec::new(),
            mu_mass,
            largest_loss: apart * apart,
            mass,
        };
        if history {
            pair.history.push(super::judge::start_objective(block, lane, &pair, options));
        }
        pair
    }

    /// All terms at `block.to`, nu after the M-step.
    pub fn terms<V: Vector>(&self, block: &Block<V>, lane: usize, options: &Options, sum_t_log: f64) -> Terms {
        let (n, m) = (self.input.source_mass.len(), self.input.target_mass.len());
        let to = &block.to;
        let (plan, gradient) = (&to.plan[..], &to.gradient[..]);
        let (down, across) = block.strides();
        let (mut structure, mut feature, mut source, mut mass) = (0.0, 0.0, 0.0, 0.0);
        for i in 0..n {
            // By rows, so that one row's sums need not wait for the last's.
            let (mut row_structure, mut row_feature) = (0.0, 0.0);
            let features = &self.input.features[i * m..(i + 1) * m];
            for (j, cost) in features.iter().enumerate() {
                let cell = i * down + j * across;
                let t = plan[cell].get(lane);
                row_structure += gradient[cell].get(lane) * t;
                row_feature += cost.max(0.0) * t;
            }
            structure += row_structure;
            feature += row_feature;
            let (u, mu) = (to.u[i].get(lane), self.input.source_mass[i]);
            mass += u;
            source += if mu > 0.0 { kl_scalar(u, mu) } else { 0.0 };
        }
        let (mut target, mut nu_mass, mut shift, mut prior_term) = (0.0, 0.0, 0.0, 0.0);
        for j in 0..m {
            let (before, nu, v) = (block.at.nu[j].get(lane), to.nu[j].get(lane), to.v[j].get(lane));
            if nu > 0.0 {
                nu_mass += nu;
                target += kl_scalar(v, nu);
                if options.em_moves() {
                    shift += v * (nu / before).ln();
                    prior_term += kl_scalar(block.prior[j].get(lane), nu);
                }
            }
        }
        let rate = options.em_rate.filter(|_| options.em_moves());
        Terms {
            structure: (1.0 - options.alpha) * 0.5 * structure,
            feature: options.alpha * feature,
            marginal_source: options.tau_s * source,
            marginal_target: options.tau_t * target,
            entropy: options.eps * (sum_t_log - shift - mass + self.mu_mass * nu_mass),
            prior: rate.map_or(0.0, |rate| (options.tau_t + options.eps) * (1.0 - rate) / rate * prior_term),
        }
    }

    /// The solution at `block.to`.
    pub fn solution<V: Vector>(
        &self,
        block: &Block<V>,
        lane: usize,
        eps: f64,
        terms: Terms,
        converged: bool,
    ) -> Solution {
        let (n, m) = (self.input.source_mass.len(), self.input.target_mass.len());
        let mut plan = Vec::with_capacity(n * m);
        let from = &block.to.plan[..];
        let (down, across) = block.strides();
        for i in 0..n {
            plan.extend((0..m).map(|j| from[i * down + j * across].get(lane)));
        }
        // Nodes without mass have no potential.
        let of = |x: &V, mass: &V| if mass.get(lane) > 0.0 { eps * x.get(lane) } else { 0.0 };
        Solution {
            plan,
            target_mass: block.to.nu[..m].iter().map(|nu| nu.get(lane)).collect(),
            source_potential: block.f[..n].iter().zip(&block.mu[..]).map(|(f, mu)| of(f, mu)).collect(),
            target_potential: block.g[..m].iter().zip(&block.at.nu[..]).map(|(g, nu)| of(g, nu)).collect(),
            terms,
            history: self.history.clone(),
            iterations: self.iterations,
            sweeps: super::kernel::SWEEPS * self.rounds,
            converged,
        }
    }
}

/// Set one lane of a row, zeros beyond the numbers.
fn put<V: Vector>(out: &mut [V], lane: usize, numbers: &[f64]) {
    let (inside, padding) = out.split_at_mut(numbers.len());
    for (o, x) in inside.iter_mut().zip(numbers) {
        o.set(lane, *x);
    }
    for o in padding {
        o.set(lane, 0.0);
    }
}

/// Sums of a structure's row and of its squares over the nodes' masses, in the order of the nodes.
fn moments(row: &[f64], masses: &[f64]) -> (f64, f64) {
    row.iter().zip(masses).fold((0.0, 0.0), |(sum, square), (a, mass)| (sum + a * mass, square + a * a * mass))
}

/// Largest absolute value, four at a time.
fn largest(x: &[f64]) -> f64 {
    let (fours, last) = x.as_chunks::<4>();
    let mut tops = [0.0_f64; 4];
    let larger = |top: f64, x: f64| if x.abs() > top { x.abs() } else { top };
    for four in fours {
        for k in 0..4 {
            tops[k] = larger(tops[k], four[k]);
        }
    }
    last.iter().chain(&tops).fold(0.0, |top, x| larger(top, *x))
}

/// C_GW at a start plan that need not have rank one.
fn full_gradient<V: Vector>(block: &mut Block<V>, lane: usize, input: &Input) {
    let (n, m) = (input.source_mass.len(), input.target_mass.len());
    let (a, b) = (input.source, input.target);
    let plan = |block: &Block<V>, i: usize, j: usize| block.at.plan[block.cell(i, j)].get(lane);
    for i in 0..n {
        let row: f64 = (0..n).map(|k| a[i * n + k] * a[i * n + k] * block.at.u[k].get(lane)).sum();
        let half: Vec<f64> = (0..m).map(|j| (0..n).map(|k| a[i * n + k] * plan(block, k, j)).sum()).collect();
        for j in 0..m {
            let col: f64 = (0..m).map(|l| b[j * m + l] * b[j * m + l] * block.at.v[l].get(lane)).sum();
            let product: f64 = half.iter().zip(0..m).map(|(h, l)| h * b[l * m + j]).sum();
            let gradient = row + col - 2.0 * product;
            let cell = block.cell(i, j);
            block.at.gradient[cell].set(lane, gradient);
            block.to.gradient[cell].set(lane, gradient);
        }
    }
}
