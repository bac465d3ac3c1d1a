//! The arrays of one block: pairs of one padded size side by side, one in each lane.

// As in the kernel.
#![allow(clippy::inline_always)]

use super::aligned::Aligned;
use super::product;
use super::vector::Vector;
use crate::transport::problem::Options;

/// A plan and what goes with it, of every lane.
#[derive(Debug)]
pub struct State<V> {
    /// T (n x m).
    pub plan: Aligned<V>,
    /// T1 (n).
    pub u: Aligned<V>,
    /// T'1 (m).
    pub v: Aligned<V>,
    /// C_GW(T) (n x m).
    pub gradient: Aligned<V>,
    /// nu (m).
    pub nu: Aligned<V>,
}

impl<V: Vector> State<V> {
    fn zeros(n: usize, m: usize) -> Self {
        let zeros = |len: usize| Aligned::new(V::splat(0.0), len);
        Self { plan: zeros(n * m), u: zeros(n), v: zeros(m), gradient: zeros(n * m), nu: zeros(m) }
    }
}

/// What an iteration tells about its step, by lane.
#[derive(Debug, Clone, Copy)]
pub struct Report<V> {
    /// L1 distance of the plans.
    pub moved: V,
    /// L1 distance of their row sums.
    pub rows_moved: V,
    /// L1 distance of their column sums.
    pub cols_moved: V,
    /// Mass of the new plan.
    pub mass: V,
    /// L1 distance of the new row sums and the masses that their price asks for.
    pub residual: V,
    /// <C_GW(D), D> of the step D.
    pub curvature: V,
    /// Lower bound of sum r_i (u - u')_i, r = tau_s log(u'/asked), the first order of a residual in the decrease.
    pub residual_gain: V,
    /// eps-scaled <C' - C, D>: what the step owes to momentum, see [`Rates::momentum`].
    pub momentum_gain: V,
    /// sum T log(T / (mu nu')) of the new plan.
    pub sum_t_log: V,
    /// Largest |log| of a scaling.
    pub log_scaling: V,
    /// L1 change of nu in the M-step.
    pub nu_moved: V,
    /// Total of nu before it.
    pub nu_mass: V,
}

/// Everything that a block of equal padded sizes needs.
#[derive(Debug)]
pub struct Block<V> {
    /// Padded source nodes.
    pub n: usize,
    /// Padded target nodes.
    pub m: usize,
    // Where the cell of a row and a column is in an n x m array: i down + j across.
    down: usize,
    across: usize,
    /// A (n x n).
    pub source: Aligned<V>,
    /// B (m x m).
    pub target: Aligned<V>,
    /// alpha M / eps (n x m).
    pub features: Aligned<V>,
    /// mu (n).
    pub mu: Aligned<V>,
    /// delta (m).
    pub prior: Aligned<V>,
    /// Where the lanes are.
    pub at: State<V>,
    /// Where the last iteration would take them.
    pub to: State<V>,
    /// f / eps (n), absorbed in the kernel.
    pub f: Aligned<V>,
    /// g / eps (m).
    pub g: Aligned<V>,
    /// exp(-g / tau_t) up to a factor (m): the share of nu that its price asks for.
    pub asked: Aligned<V>,
    /// Log of that factor.
    pub asked_log: V,
    /// 1 / c of the M-step, see [`crate::transport::objective::Objective::update_target`].
    pub em_scale: V,
    /// How far beyond its best f goes, as a share of its way there; 0 while a lane has no f to come from.
    pub relax: V,
    /// The last iteration's report.
    pub report: Report<V>,
    /// exp((f + g - C) / eps) (n x m).
    pub kernel: Aligned<V>,
    /// Some rows of A T, and B^2 v.
    pub half: Aligned<V>,
    /// mu a (n).
    pub rows: Aligned<V>,
    /// nu b (m).
    pub cols: Aligned<V>,
    /// Numbers of the pair that is being loaded.
    pub loading: Loading,
    /// Logs of the scalings (n, m), and the source's asked shares (n).
    pub log_rows: Aligned<V>,
    /// See `log_rows`.
    pub log_cols: Aligned<V>,
    /// See `log_rows`.
    pub asked_rows: Aligned<V>,
}

impl<V: Vector> Block<V> {
    /// Allocate for a padded size.
    #[must_use]
    pub fn new(n: usize, m: usize) -> Self {
        let zero = V::splat(0.0);
        let zeros = |len: usize| Aligned::new(zero, len);
        Self {
            n,
            m,
            down: m,
            across: 1,
            source: zeros(n * n),
            target: zeros(m * m),
            features: zeros(n * m),
            mu: zeros(n),
            prior: zeros(m),
            at: State::zeros(n, m),
            to: State::zeros(n, m),
            f: zeros(n),
            g: zeros(m),
            asked: zeros(m),
            asked_log: zero,
            em_scale: V::splat(1.0),
            relax: zero,
            report: Report {
                moved: zero,
                rows_moved: zero,
                cols_moved: zero,
                mass: zero,
                residual: zero,
                curvature: zero,
                residual_gain: zero,
                momentum_gain: zero,
                sum_t_log: zero,
                log_scaling: zero,
                nu_moved: zero,
                nu_mass: zero,
            },
            kernel: zeros(n * m),
            half: zeros((product::ROWS + 1) * m),
            rows: zeros(n),
            cols: zeros(m),
            loading: Loading::default(),
            log_rows: zeros(n),
            log_cols: zeros(m),
            asked_rows: zeros(n),
        }
    }

    /// Allocate with n x m arrays column by column; `half` takes a whole array.
    #[must_use]
    pub fn by_columns(n: usize, m: usize) -> Self {
        let block = Self::new(n, m);
        Self { down: 1, across: n, half: Aligned::new(V::splat(0.0), n * m), ..block }
    }

    /// Where row i and column j meet in an n x m array.
    #[inline(always)]
    #[must_use]
    pub fn cell(&self, i: usize, j: usize) -> usize {
        i * self.down + j * self.across
    }

    /// How far apart the rows and the columns of an n x m array are.
    #[must_use]
    pub fn strides(&self) -> (usize, usize) {
        (self.down, self.across)
    }
}

/// What loading a pair works out by target node on the way.
#[derive(Debug, Default)]
pub struct Loading {
    /// nu where both it and the prior have mass.
    pub nu: Vec<f64>,
    /// The prior where both have mass.
    pub prior: Vec<f64>,
    /// B nu.
    pub by_col: Vec<f64>,
    /// What B^2 nu adds to a column of the first gradient.
    pub col_part: Vec<f64>,
    /// g / eps to start from.
    pub start_g: Vec<f64>,
}

impl Loading {
    /// Zeros for that many target nodes.
    pub fn clear(&mut self, m: usize) {
        for numbers in [&mut self.nu, &mut self.prior, &mut self.by_col, &mut self.col_part, &mut self.start_g] {
            numbers.clear();
            numbers.resize(m, 0.0);
        }
    }
}

/// Share of the structure gradient's last change that is added to it (heavy ball). The three accelerations below were
/// tuned together on random pairs of 3 to 20 nodes: at n = 6 they take the mean number of iterations from 13.3 to 9.7.
/// None of them moves the fixed point, and [`super::judge`] takes no step that it cannot show to descend.
const MOMENTUM: f64 = 0.12;

/// How far beyond its best given g the potential f goes, as a share of its way there (over-relaxed Sinkhorn).
const RELAX: f64 = 0.4;

/// How far beyond its minimiser the M-step goes, as a share of its way there.
///
/// Its error shrinks by up to lambda = 0.4 an iteration, and 2 / (2 - lambda) = 1.25 is the factor that halves the worst
/// case. J still descends: with x = nu / minimiser, J is a sum of x - 1 - log x, which is smaller at 1 - y than at
/// 1 + 4 y for y up to 1/2, where the kernel clamps it.
const EM_BEYOND: f64 = 0.25;

/// The options as the kernel wants them.
#[derive(Debug, Clone, Copy)]
pub struct Rates {
    /// (1 - alpha) / eps.
    pub structure: f64,
    /// The same times the share of the gradient's last change that is added to it.
    pub momentum: f64,
    /// tau_s.
    pub tau_s: f64,
    /// tau_s / (tau_s + eps).
    pub follow_s: f64,
    /// tau_t / (tau_t + eps).
    pub follow_t: f64,
    /// eps / (tau_s + eps): how a shift of f that keeps it exact moves the log of the mass asked for.
    pub slack_s: f64,
    /// eps / (tau_t + eps).
    pub slack_t: f64,
    /// eps / tau_s.
    pub pull_s: f64,
    /// Shift of f, in eps, by the log of a ratio of masses.
    pub balance_s: f64,
    /// Shift of g.
    pub balance_t: f64,
    /// lambda of the M-step, 0 without.
    pub em_rate: f64,
    /// How far beyond its best f goes.
    pub relax: f64,
    /// How far beyond its minimiser nu goes, as a share of its way there.
    pub em_beyond: f64,
}

impl Rates {
    /// Derive from checked options with finite positive prices.
    #[must_use]
    pub fn new(o: &Options) -> Self {
        Self {
            structure: (1.0 - o.alpha) / o.eps,
            momentum: (1.0 - o.alpha) / o.eps * MOMENTUM,
            tau_s: o.tau_s,
            follow_s: o.tau_s / (o.tau_s + o.eps),
            follow_t: o.tau_t / (o.tau_t + o.eps),
            slack_s: o.eps / (o.tau_s + o.eps),
            slack_t: o.eps / (o.tau_t + o.eps),
            pull_s: o.eps / o.tau_s,
            balance_s: 1.0 / (o.eps * (1.0 / o.tau_t + 1.0 / (o.tau_s + o.eps))),
            balance_t: 1.0 / (o.eps * (1.0 / o.tau_s + 1.0 / (o.tau_t + o.eps))),
            em_rate: o.em_rate.filter(|_| o.em_moves()).unwrap_or(0.0),
            relax: RELAX,
            em_beyond: EM_BEYOND,
        }
    }
}
