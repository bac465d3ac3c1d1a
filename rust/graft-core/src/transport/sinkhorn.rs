//! Translation-invariant Sinkhorn sweeps for min <C, T> + tau_s KL(T1|mu) + tau_t KL(T'1|nu) + eps KL(T|R).
//!
//! The solution is T = R exp((f + g - C) / eps). Shifting f up and g down by one constant leaves T as it is, and plain
//! Sinkhorn is slow in just that direction; each half sweep here is therefore exact in one potential *and* in the
//! shift (Séjourné, Vialard, Peyré 2022, "Faster unbalanced optimal transport: translation invariant Sinkhorn").
//!
//! Potentials are carried from one cost to the next. Sweeps multiply a kernel that has absorbed them, as long as its
//! rows and columns stay within the range of floats; otherwise they run in the log domain, which cannot overflow.

use super::objective::{Objective, Point};
use super::problem::{Options, Problem};
use super::wide;

/// Exponents beyond which the kernel is rebuilt in, or left for, the log domain. exp(+-300) is far enough inside the
/// range of f64 (exp(+-700)) for sums, products with masses and [`DRIFT`].
const EXPONENT_RANGE: f64 = 300.0;

/// How far (in units of eps) potentials may move from what the kernel absorbed.
const DRIFT: f64 = 100.0;

/// Annealing divides eps by this from step to step; larger steps leave the carried potentials too far off.
const ANNEAL_FACTOR: f64 = 4.0;

/// Annealing starts with eps at this share of the largest cost.
const ANNEAL_START: f64 = 0.25;

/// Sweeps at each annealed eps: translation-invariant sweeps at eps = C/4 contract about tenfold each.
const ANNEAL_SWEEPS: usize = 3;

/// Potentials and the kernel that absorbed them.
#[derive(Debug)]
pub struct Sinkhorn {
    n: usize,
    m: usize,
    eps: f64,
    source: Side,
    target: Side,
    kernel: Vec<f64>,
    in_range: bool,
}

/// One side's marginal, price and potential.
#[derive(Debug)]
struct Side {
    tau: f64,
    log_mass: Vec<f64>,
    log_reference: Vec<f64>,
    reference: Vec<f64>,
    potential: Vec<f64>,
    absorbed: Vec<f64>,
    // exp((potential - absorbed) / eps) * reference
    scaling: Vec<f64>,
    log_sums: Vec<f64>,
}

impl Side {
    fn new(tau: f64, mass: &[f64], log_reference: Vec<f64>) -> Self {
        let k = mass.len();
        let mut side = Self {
            tau,
            log_mass: vec![0.0; k],
            log_reference: Vec::new(),
            reference: Vec::new(),
            potential: vec![0.0; k],
            absorbed: vec![0.0; k],
            scaling: vec![0.0; k],
            log_sums: vec![0.0; k],
        };
        side.set(mass, log_reference);
        side
    }

    fn set(&mut self, mass: &[f64], log_reference: Vec<f64>) {
        self.log_mass = mass.iter().map(|x| x.ln()).collect();
        self.reference = log_reference.iter().map(|x| x.exp()).collect();
        self.log_reference = log_reference;
    }

    /// tau / (tau + eps): how far a potential follows its marginal.
    fn follow(&self, eps: f64) -> f64 {
        if self.tau.is_infinite() { 1.0 } else { self.tau / (self.tau + eps) }
    }

    /// Half sweep: the best potential given the other, from log of R exp((other - C) / eps) summed over the other.
    fn update(&mut self, eps: f64) {
        let rate = eps * self.follow(eps);
        for k in 0..self.potential.len() {
            self.potential[k] = rate * (self.log_mass[k] - self.log_reference[k] - self.log_sums[k]);
        }
    }

    /// log sum mass exp(-potential / tau): the mass that the marginal's price asks for.
    fn log_asked(&self) -> f64 {
        let exponents = self.log_mass.iter().zip(&self.potential).map(|(l, p)| l - p / self.tau);
        log_sum_exp(exponents)
    }

    fn shift(&mut self, by: f64) {
        self.potential.iter_mut().for_each(|p| *p += by);
    }

    fn scale(&mut self, eps: f64) -> bool {
        let mut near = true;
        for k in 0..self.potential.len() {
            let moved = (self.potential[k] - self.absorbed[k]) / eps;
            near &= moved.abs() <= DRIFT;
            self.scaling[k] = self.reference[k] * moved.exp();
        }
        near
    }
}

fn log_sum_exp(exponents: impl Iterator<Item = f64> + Clone) -> f64 {
    let top = exponents.clone().fold(f64::NEG_INFINITY, f64::max);
    if top.is_finite() { top + exponents.map(|x| (x - top).exp()).sum::<f64>().ln() } else { top }
}

impl Sinkhorn {
    /// Potentials of zero.
    #[must_use]
    pub fn new(problem: &Problem, options: &Options, objective: &Objective) -> Self {
        let (rows, cols) = objective.log_reference();
        Self {
            n: problem.n,
            m: problem.m,
            eps: options.eps,
            source: Side::new(options.tau_s, &problem.mu, rows),
            target: Side::new(options.tau_t, &objective.nu, cols),
            kernel: vec![0.0; problem.n * problem.m],
            in_range: false,
        }
    }

    /// The potentials f (n) and g (m).
    #[must_use]
    pub fn potentials(&self) -> (&[f64], &[f64]) {
        (&self.source.potential, &self.target.potential)
    }

    /// Start from a target potential, from which the first sweep derives the other; no sweep is spent.
    pub fn start(&mut self, g: &[f64]) -> usize {
        self.target.potential.copy_from_slice(g);
        self.in_range = false;
        0
    }

    /// Take over target masses that EM has moved.
    pub fn set_target(&mut self, objective: &Objective) {
        let (_, cols) = objective.log_reference();
        self.target.set(&objective.nu, cols);
    }

    /// Start on another cost (n x m) with the potentials of the last.
    pub fn absorb(&mut self, cost: &[f64]) {
        let (f, g) = (&self.source.potential, &self.target.potential);
        self.source.absorbed.copy_from_slice(f);
        self.target.absorbed.copy_from_slice(g);
        // A row or column far below 1 would lose its sum, one far above would overflow it.
        self.in_range = wide::exponents(f, g, cost, 1.0 / self.eps, &mut self.kernel) <= EXPONENT_RANGE;
        if self.in_range {
            wide::exp(&mut self.kernel);
        }
    }

    fn row_sums(&mut self, cost: &[f64]) {
        let kernel = self.in_range && self.target.scale(self.eps);
        if !kernel {
            self.in_range = false;
        }
        let (m, eps) = (self.m, self.eps);
        if kernel {
            wide::row_sums(&self.kernel, &self.target.scaling, &mut self.source.log_sums);
            for (sum, f) in self.source.log_sums.iter_mut().zip(&self.source.absorbed) {
                *sum = sum.ln() - f / eps;
            }
            return;
        }
        for i in 0..self.n {
            let (row, target) = (&cost[i * m..(i + 1) * m], &self.target);
            self.source.log_sums[i] =
                log_sum_exp((0..m).map(|j| target.log_reference[j] + (target.potential[j] - row[j]) / eps));
        }
    }

    fn col_sums(&mut self, cost: &[f64]) {
        let kernel = self.in_range && self.source.scale(self.eps);
        if !kernel {
            self.in_range = false;
        }
        let (n, m, eps) = (self.n, self.m, self.eps);
        if kernel {
            wide::col_sums(&self.kernel, &self.source.scaling, &mut self.target.log_sums);
            for (s, g) in self.target.log_sums.iter_mut().zip(&self.target.absorbed) {
                *s = s.ln() - g / eps;
            }
        } else {
            for j in 0..m {
                let source = &self.source;
                self.target.log_sums[j] = log_sum_exp(
                    (0..n).map(|i| source.log_reference[i] + (source.potential[i] - cost[i * m + j]) / eps),
                );
            }
        }
    }

    /// One sweep: f given g, then g given f, each exact in the common shift too.
    pub fn sweep(&mut self, cost: &[f64]) {
        if !self.in_range {
            self.absorb(cost);
        }
        self.row_sums(cost);
        self.source.update(self.eps);
        balance(&mut self.source, &mut self.target, self.eps);
        self.col_sums(cost);
        self.target.update(self.eps);
        balance(&mut self.target, &mut self.source, self.eps);
    }

    /// Bring the potentials near the solution from a large eps down, so that a small one needs few sweeps.
    ///
    /// Returns the number of sweeps.
    pub fn anneal(&mut self, cost: &[f64]) -> usize {
        let eps = self.eps;
        let top = cost.iter().fold(0.0_f64, |top, c| top.max(*c));
        let mut sweeps = 0;
        let mut annealed = top * ANNEAL_START;
        while annealed > eps * ANNEAL_FACTOR {
            self.eps = annealed;
            self.in_range = false;
            for _ in 0..ANNEAL_SWEEPS {
                self.sweep(cost);
            }
            sweeps += ANNEAL_SWEEPS;
            annealed /= ANNEAL_FACTOR;
        }
        self.eps = eps;
        self.in_range = false;
        sweeps
    }

    /// Write T = R exp((f + g - C) / eps), its marginals and entropy; return the relative L1 residual of T1.
    ///
    /// T1 should be mu exp(-f / tau_s); T'1 = nu exp(-g / tau_t) holds exactly after a sweep.
    pub fn plan(&mut self, cost: &[f64], objective: &Objective, out: &mut Point) -> f64 {
        let (m, eps) = (self.m, self.eps);
        let kernel = self.in_range && self.source.scale(eps) && self.target.scale(eps);
        let (source, target) = (&self.source, &self.target);
        for i in 0..self.n {
            let (row, kernels) = (&mut out.plan[i * m..(i + 1) * m], &self.kernel[i * m..(i + 1) * m]);
            if kernel {
                let scale = source.scaling[i];
                for (j, t) in row.iter_mut().enumerate() {
                    *t = scale * kernels[j] * target.scaling[j];
                }
            } else {
                let (potential, log) = (source.potential[i], source.log_reference[i]);
                for (j, t) in row.iter_mut().enumerate() {
                    *t = (log + target.log_reference[j] + (potential + target.potential[j] - cost[i * m + j]) / eps)
                        .exp();
                }
            }
        }
        out.sum();
        // sum T log(T / R), from the logarithm that each entry was made of.
        let logs = wide::dot(&out.u, &source.potential) + wide::dot(&out.v, &target.potential);
        let sum_t_log = (logs - wide::dot(&out.plan, cost)) / eps;
        let mass = out.mass();
        out.entropy = objective.entropy_from(sum_t_log, mass);
        if self.source.tau == 0.0 || mass == 0.0 {
            return 0.0;
        }
        let asked = source.log_mass.iter().zip(&source.potential).map(|(l, f)| (l - f / source.tau).exp());
        asked.zip(&out.u).map(|(asked, u)| (u - asked).abs()).sum::<f64>() / mass
    }
}

/// Shift both potentials to where the masses that both prices ask for agree, `fresh` having just been updated:
/// other <- other - s, and fresh <- fresh + follow s, which keeps fresh exact given other.
fn balance(fresh: &mut Side, other: &mut Side, eps: f64) {
    let fixed = fresh.tau.is_infinite() && other.tau.is_infinite();
    if fresh.tau == 0.0 || other.tau == 0.0 || fixed {
        return;
    }
    let shift = (fresh.log_asked() - other.log_asked()) / (1.0 / other.tau + 1.0 / (fresh.tau + eps));
    other.shift(-shift);
    fresh.shift(fresh.follow(eps) * shift);
}
