//! One lane of a block: putting a pair in, judging its step, taking its solution out.

use super::block::Block;
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
        let masses = |j: usize| if nus[j] > 0.0 && priors[j] > 0.0 { (nus[j], priors[j]) } else { (0.0, 0.0) };
        let (mut mu_mass, mut nu_mass) = (0.0, 0.0);
        input.source_mass.iter().for_each(|mu| mu_mass += mu);
        (0..m).for_each(|j| nu_mass += masses(j).0);
        let scale = 1.0 / (mu_mass * nu_mass).sqrt();
        for j in 0..wide {
            let (nu, prior) = if j < m { masses(j) } else { (0.0, 0.0) };
            block.at.nu[j].set(lane, nu);
            block.prior[j].set(lane, prior);
            let g = input.start_potential.map_or(0.0, |g| if j < m && nu > 0.0 { g[j] } else { 0.0 });
            block.g[j].set(lane, g / options.eps);
            block.asked[j].set(lane, (-g / options.tau_t).exp());
            let mut square = 0.0;
            let mut sum = 0.0;
            for l in 0..wide {
                let b = if j < m && l < m { input.target[j * m + l] } else { 0.0 };
                block.target[j * wide + l].set(lane, b);
                if l < m {
                    let weight = masses(l).0;
                    square += b * b * weight;
                    sum += b * weight;
                }
            }
            // B nu and B^2 nu, for the gradient at a plan of rank one.
            block.cols[j].set(lane, sum);
            block.log_cols[j].set(lane, square);
        }
        block.asked_log.set(lane, 0.0);
        block.relax.set(lane, 0.0);
        for i in 0..tall {
            let mu = if i < n { input.source_mass[i] } else { 0.0 };
            block.mu[i].set(lane, mu);
            let mut square = 0.0;
            let mut sum = 0.0;
            for k in 0..tall {
                let a = if i < n && k < n { input.source[i * n + k] } else { 0.0 };
                block.source[i * tall + k].set(lane, a);
                if k < n {
                    square += a * a * input.source_mass[k];
                    sum += a * input.source_mass[k];
                }
            }
            let mut lowest = f64::INFINITY;
            let mut row_sum = 0.0;
            for j in 0..wide {
                let at = i * wide + j;
                let inside = i < n && j < m;
                let feature =
                    if inside { input.features[i * m + j].max(0.0) * options.alpha / options.eps } else { 0.0 };
                block.features[at].set(lane, feature);
                let nu = block.at.nu[j].get(lane);
                let plan = match input.start {
                    Some(start) if inside && mu * nu > 0.0 => start[i * m + j],
                    Some(_) => 0.0,
                    None => mu * (nu * scale),
                };
                block.at.plan[at].set(lane, plan);
                row_sum += plan;
                let gradient = (square * nu_mass + block.log_cols[j].get(lane) * mu_mass
                    - 2.0 * sum * block.cols[j].get(lane))
                    * scale;
                block.at.gradient[at].set(lane, gradient);
                block.to.gradient[at].set(lane, gradient);
                if inside && nu > 0.0 {
                    let cost = (1.0 - options.alpha) / options.eps * gradient + feature - block.g[j].get(lane);
                    lowest = lowest.min(cost);
                }
            }
            block.at.u[i].set(lane, row_sum);
            // The kernel's largest entry of every row is 1.
            block.f[i].set(lane, if lowest.is_finite() { lowest } else { 0.0 });
        }
        for j in 0..wide {
            let sum: f64 = (0..tall).map(|i| block.at.plan[i * wide + j].get(lane)).sum();
            block.at.v[j].set(lane, sum);
        }
        let top = |x: &[f64]| x.iter().fold(0.0_f64, |top, x| top.max(x.abs()));
        let apart = top(input.source) + top(input.target);
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
        let (mut structure, mut feature, mut source, mut mass) = (0.0, 0.0, 0.0, 0.0);
        for i in 0..n {
            for j in 0..m {
                let t = to.plan[i * block.m + j].get(lane);
                structure += to.gradient[i * block.m + j].get(lane) * t;
                feature += self.input.features[i * m + j].max(0.0) * t;
            }
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
        for i in 0..n {
            plan.extend((0..m).map(|j| block.to.plan[i * block.m + j].get(lane)));
        }
        // Nodes without mass have no potential.
        let of = |x: &V, mass: &V| if mass.get(lane) > 0.0 { eps * x.get(lane) } else { 0.0 };
        Solution {
            plan,
            target_mass: block.to.nu[..m].iter().map(|nu| nu.get(lane)).collect(),
            source_potential: block.f[..n].iter().zip(&block.mu).map(|(f, mu)| of(f, mu)).collect(),
            target_potential: block.g[..m].iter().zip(&block.at.nu).map(|(g, nu)| of(g, nu)).collect(),
            terms,
            history: self.history.clone(),
            iterations: self.iterations,
            sweeps: super::kernel::SWEEPS * self.rounds,
            converged,
        }
    }
}

/// C_GW at a start plan that need not have rank one.
fn full_gradient<V: Vector>(block: &mut Block<V>, lane: usize, input: &Input) {
    let (n, m, wide) = (input.source_mass.len(), input.target_mass.len(), block.m);
    let (a, b) = (input.source, input.target);
    let plan = |block: &Block<V>, i: usize, j: usize| block.at.plan[i * wide + j].get(lane);
    for i in 0..n {
        let row: f64 = (0..n).map(|k| a[i * n + k] * a[i * n + k] * block.at.u[k].get(lane)).sum();
        let half: Vec<f64> = (0..m).map(|j| (0..n).map(|k| a[i * n + k] * plan(block, k, j)).sum()).collect();
        for j in 0..m {
            let col: f64 = (0..m).map(|l| b[j * m + l] * b[j * m + l] * block.at.v[l].get(lane)).sum();
            let product: f64 = half.iter().zip(0..m).map(|(h, l)| h * b[l * m + j]).sum();
            let gradient = row + col - 2.0 * product;
            block.at.gradient[i * wide + j].set(lane, gradient);
            block.to.gradient[i * wide + j].set(lane, gradient);
        }
    }
}
