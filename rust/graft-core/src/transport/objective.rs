//! The terms of F at a plan, and the plan's place on a line search.

use super::problem::{Entropy, Loss, Options, Problem};
use super::wide::{self, dot};

/// p log(p / q) - p + q, with 0 log 0 = 0; q > 0.
#[must_use]
pub fn kl_scalar(p: f64, q: f64) -> f64 {
    // Two logarithms: p / q underflows to 0 for subnormal p.
    if p > 0.0 { p * (p.ln() - q.ln()) - p + q } else { q }
}

/// Generalised Kullback-Leibler divergence sum p log(p/q) - p + q.
#[must_use]
pub fn kl(p: &[f64], q: &[f64]) -> f64 {
    p.iter().zip(q).map(|(&p, &q)| kl_scalar(p, q)).sum()
}

/// Weighted terms of the objective; the first five sum to F.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Terms {
    /// (1-alpha) 1/2 <C_GW(T), T>.
    pub structure: f64,
    /// alpha <M, T>.
    pub feature: f64,
    /// tau_s KL(T1 | mu); 0 when tau_s is infinite.
    pub marginal_source: f64,
    /// tau_t KL(T'1 | nu); 0 when tau_t is infinite.
    pub marginal_target: f64,
    /// eps KL(T | R).
    pub entropy: f64,
    /// eta KL(prior | nu), what EM adds to F to make J; 0 without EM.
    pub prior: f64,
}

impl Terms {
    /// F.
    #[must_use]
    pub fn objective(&self) -> f64 {
        self.structure + self.feature + self.marginal_source + self.marginal_target + self.entropy
    }

    /// J = F + eta KL(prior | nu).
    #[must_use]
    pub fn em_objective(&self) -> f64 {
        self.objective() + self.prior
    }
}

/// A plan with what F needs of it.
#[derive(Debug, Clone)]
pub struct Point {
    /// T (n x m).
    pub plan: Vec<f64>,
    /// T1 (n).
    pub u: Vec<f64>,
    /// T'1 (m).
    pub v: Vec<f64>,
    /// C_GW(T) (n x m).
    pub gradient: Vec<f64>,
    /// sum T log(T / R) - T + R, without the constant for the plain entropy.
    pub entropy: f64,
}

impl Point {
    /// An empty point of a problem's size.
    #[must_use]
    pub fn zeros(n: usize, m: usize) -> Self {
        Self { plan: vec![0.0; n * m], u: vec![0.0; n], v: vec![0.0; m], gradient: vec![0.0; n * m], entropy: 0.0 }
    }

    /// Recompute both marginals.
    pub fn sum(&mut self) {
        wide::row_sums(&self.plan, &vec![1.0; self.v.len()], &mut self.u);
        wide::col_sums(&self.plan, &vec![1.0; self.u.len()], &mut self.v);
    }

    /// Total mass.
    #[must_use]
    pub fn mass(&self) -> f64 {
        self.u.iter().sum()
    }

    /// Put the point at from + s (to - from); everything linear is interpolated.
    pub fn between(&mut self, from: &Self, to: &Self, s: f64) {
        let mix = |out: &mut [f64], a: &[f64], b: &[f64]| {
            for ((o, a), b) in out.iter_mut().zip(a).zip(b) {
                *o = (1.0 - s) * a + s * b;
            }
        };
        mix(&mut self.plan, &from.plan, &to.plan);
        mix(&mut self.u, &from.u, &to.u);
        mix(&mut self.v, &from.v, &to.v);
        mix(&mut self.gradient, &from.gradient, &to.gradient);
    }
}

/// What F needs beside the plan: the problem, its options, the target masses of now.
#[derive(Debug)]
pub struct Objective<'a> {
    problem: &'a Problem,
    options: &'a Options,
    /// nu (m).
    pub nu: Vec<f64>,
    // Largest loss of two structure entries: what the structure term's differences cancel from.
    largest_loss: f64,
}

fn sum(x: &[f64]) -> f64 {
    x.iter().sum()
}

fn priced(tau: f64, p: &[f64], q: &[f64]) -> f64 {
    if tau == 0.0 || tau.is_infinite() { 0.0 } else { tau * kl(p, q) }
}

impl<'a> Objective<'a> {
    /// F at the starting target masses.
    #[must_use]
    pub fn new(problem: &'a Problem, options: &'a Options) -> Self {
        let top = |x: &[f64]| x.iter().fold(0.0_f64, |top, x| top.max(x.abs()));
        let apart = top(&problem.source) + top(&problem.target);
        let largest_loss = if options.loss == Loss::Square { apart * apart } else { apart };
        Self { problem, options, nu: problem.nu.clone(), largest_loss }
    }

    /// What rounding in F at a plan is relative to: the numbers whose differences its terms are.
    #[must_use]
    pub fn magnitude(&self, point: &Point, terms: &Terms) -> f64 {
        let o = self.options;
        let mass = point.mass().max(sum(&self.problem.mu)).max(sum(&self.nu));
        let finite = |tau: f64| if tau.is_finite() { tau } else { 0.0 };
        let marginals = terms.marginal_source.abs() + terms.marginal_target.abs() + terms.entropy.abs();
        terms.feature
            + marginals
            + (finite(o.tau_s) + finite(o.tau_t) + o.eps) * mass
            + (1.0 - o.alpha) * self.largest_loss * point.mass() * point.mass()
    }

    /// Log of the rank-one reference: log R_ij = rows_i + cols_j.
    #[must_use]
    pub fn log_reference(&self) -> (Vec<f64>, Vec<f64>) {
        let (n, m) = (self.problem.n, self.problem.m);
        match self.options.entropy {
            Entropy::Relative => {
                (self.problem.mu.iter().map(|x| x.ln()).collect(), self.nu.iter().map(|x| x.ln()).collect())
            }
            Entropy::Plain => (vec![-1.0; n], vec![0.0; m]),
            Entropy::Unit => (vec![0.0; n], vec![0.0; m]),
        }
    }

    /// The entropy from sum T log(T / R) and the mass, where R is [`Self::log_reference`].
    #[must_use]
    pub fn entropy_from(&self, sum_t_log: f64, mass: f64) -> f64 {
        match self.options.entropy {
            Entropy::Relative => sum_t_log - mass + sum(&self.problem.mu) * sum(&self.nu),
            // R = 1/e: sum T (log T + 1) - T, the constant n m / e left out.
            Entropy::Plain => sum_t_log - mass,
            Entropy::Unit => sum_t_log - mass + (self.problem.full.0 * self.problem.full.1) as f64,
        }
    }

    /// The entropy of any plan.
    #[must_use]
    pub fn entropy(&self, point: &Point) -> f64 {
        let (rows, cols) = self.log_reference();
        let mut sum_t_log = 0.0;
        for (row, log_r) in point.plan.chunks_exact(self.problem.m).zip(&rows) {
            for (&t, log_c) in row.iter().zip(&cols) {
                if t > 0.0 {
                    sum_t_log += t * (t.ln() - log_r - log_c);
                }
            }
        }
        self.entropy_from(sum_t_log, point.mass())
    }

    /// All terms; the point's marginals, gradient and entropy must be current.
    #[must_use]
    pub fn terms(&self, point: &Point) -> Terms {
        let o = self.options;
        let structure = if o.alpha < 1.0 { dot(&point.gradient, &point.plan) } else { 0.0 };
        Terms {
            structure: (1.0 - o.alpha) * 0.5 * structure,
            feature: o.alpha * dot(&self.problem.features, &point.plan),
            marginal_source: priced(o.tau_s, &point.u, &self.problem.mu),
            marginal_target: priced(o.tau_t, &point.v, &self.nu),
            entropy: o.eps * point.entropy,
            prior: self.prior_term(),
        }
    }

    /// Weight of KL(. | nu) inside F, per unit of v: tau_t, plus eps when the entropy is relative to nu.
    fn pull(&self) -> f64 {
        self.options.tau_t + if self.options.entropy == Entropy::Relative { self.options.eps } else { 0.0 }
    }

    fn prior_term(&self) -> f64 {
        match self.options.em_rate {
            Some(rate) if self.options.em_moves() => {
                self.pull() * (1.0 - rate) / rate * kl(&self.problem.prior, &self.nu)
            }
            _ => 0.0,
        }
    }

    /// M-step: set nu to the exact minimiser of J given the plan; return its relative L1 change.
    ///
    /// nu = ((1-lambda) prior + lambda T'1) / c, where c = 1 whenever mu sums to 1 or the entropy does not refer
    /// to nu; otherwise the entropy's own mass, eps sum(mu) sum(nu), enters.
    pub fn update_target(&mut self, point: &mut Point, rate: f64) -> f64 {
        let o = self.options;
        let relative = o.entropy == Entropy::Relative;
        let c = if relative {
            rate * (o.tau_t + o.eps * sum(&self.problem.mu)) / (o.tau_t + o.eps) + 1.0 - rate
        } else {
            1.0
        };
        let (mut change, mut shift) = (0.0, 0.0);
        let before = sum(&self.nu);
        for ((nu, &prior), &v) in self.nu.iter_mut().zip(&self.problem.prior).zip(&point.v) {
            let next = ((1.0 - rate) * prior + rate * v) / c;
            change += (next - *nu).abs();
            shift += v * (next / *nu).ln();
            *nu = next;
        }
        if relative {
            point.entropy += sum(&self.problem.mu) * (sum(&self.nu) - before) - shift;
        }
        change / before
    }
}
