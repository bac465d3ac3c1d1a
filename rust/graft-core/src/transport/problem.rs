//! What is to be solved: data and options, checked once; nodes without mass are left out.

use crate::Error;

/// How edge lengths are compared.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Loss {
    /// (a - b)^2; C_GW costs O(n^2 m + n m^2).
    Square,
    /// |a - b|; C_GW costs O(n^2 m^2).
    Absolute,
}

/// What the entropy eps KL(T | R) is relative to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Entropy {
    /// R = mu nu': splitting a node in two changes nothing.
    Relative,
    /// eps sum T log T, the paper's -eps H(T).
    Plain,
    /// R = 1 everywhere.
    Unit,
}

/// Least entropy: below, costs over `eps` have no digits left after the point and no iteration can tell its next from
/// its last.
const LEAST_EPS: f64 = 1e-9;

/// Parameters of the objective and of the solver.
#[derive(Debug, Clone, Copy)]
pub struct Options {
    /// Weight of the features, in [0, 1]; 1 - alpha weighs the structure.
    pub alpha: f64,
    /// Price of a source marginal that differs from mu; 0 = free, infinity = fixed.
    pub tau_s: f64,
    /// Price of a target marginal that differs from nu; 0 = free, infinity = fixed.
    pub tau_t: f64,
    /// Weight of the entropy, positive.
    pub eps: f64,
    /// Structure loss.
    pub loss: Loss,
    /// Reference of the entropy.
    pub entropy: Entropy,
    /// lambda of the M-step nu <- (1-lambda) prior + lambda T'1, in [0, 1); None keeps nu.
    pub em_rate: Option<f64>,
    /// Stop when plan, target masses and marginal residual change by less, relative L1.
    pub tol: f64,
    /// Linearisations at most.
    pub max_outer: usize,
}

impl Options {
    /// Check every number's range.
    ///
    /// # Errors
    /// The parameter that is out of range.
    pub fn check(&self) -> Result<(), Error> {
        let range = |name, ok: bool, expected: &str, got: f64| {
            if ok { Ok(()) } else { Err(Error::value(name, expected, got)) }
        };
        range("alpha", (0.0..=1.0).contains(&self.alpha), "a number in [0, 1]", self.alpha)?;
        range("tau_s", self.tau_s >= 0.0, "a number >= 0 (inf fixes the marginal)", self.tau_s)?;
        range("tau_t", self.tau_t >= 0.0, "a number >= 0 (inf fixes the marginal)", self.tau_t)?;
        range("eps", self.eps >= LEAST_EPS && self.eps.is_finite(), "a finite number of at least 1e-9", self.eps)?;
        range("tol", self.tol > 0.0 && self.tol.is_finite(), "a finite number > 0", self.tol)?;
        if let Some(rate) = self.em_rate {
            range("em_rate", (0.0..1.0).contains(&rate), "None or a number in [0, 1)", rate)?;
        }
        if self.max_outer == 0 {
            return Err(Error::value("max_outer", "at least 1", 0));
        }
        Ok(())
    }

    /// Whether the target masses move: a rate of 0, or a fixed target marginal (whose M-step can only
    /// converge to the prior), pins them to the prior from the start.
    #[must_use]
    pub fn em_moves(&self) -> bool {
        self.em_rate.is_some_and(|rate| rate > 0.0) && self.tau_t.is_finite()
    }
}

/// One pair as the caller has it; matrices are row-major.
#[derive(Debug, Clone, Copy)]
pub struct Input<'a> {
    /// M (n x m), non-negative.
    pub features: &'a [f64],
    /// A (n x n).
    pub source: &'a [f64],
    /// B (m x m).
    pub target: &'a [f64],
    /// mu (n), non-negative.
    pub source_mass: &'a [f64],
    /// nu (m), non-negative.
    pub target_mass: &'a [f64],
    /// delta (m), non-negative; read when EM is on, nu when None.
    pub prior: Option<&'a [f64]>,
    /// Plan to start from (n x m), non-negative.
    pub start: Option<&'a [f64]>,
    /// Target potential g to start from (m).
    pub start_potential: Option<&'a [f64]>,
}

/// A checked problem over the nodes that have mass.
#[derive(Debug, Clone)]
pub struct Problem {
    /// Source nodes with mass.
    pub n: usize,
    /// Target nodes with mass.
    pub m: usize,
    /// M (n x m).
    pub features: Vec<f64>,
    /// A (n x n).
    pub source: Vec<f64>,
    /// B (m x m).
    pub target: Vec<f64>,
    /// mu (n).
    pub mu: Vec<f64>,
    /// nu at the start (m).
    pub nu: Vec<f64>,
    /// delta (m).
    pub prior: Vec<f64>,
    /// Start plan (n x m).
    pub start: Option<Vec<f64>>,
    /// Start potential g (m).
    pub start_potential: Option<Vec<f64>>,
    /// The caller's index of each source node.
    pub rows: Vec<usize>,
    /// The caller's index of each target node.
    pub cols: Vec<usize>,
    /// Source and target nodes of the caller.
    pub full: (usize, usize),
}

/// Rounding below zero, relative to the largest entry, that a feature cost such as 1 - cos may have.
const NEGATIVE_ROUNDING: f64 = 1e-12;

/// Relative difference of totals at which two fixed marginals contradict each other.
const TOTAL_MISMATCH: f64 = 1e-9;

/// Largest total mass and largest squared structure entry whose products stay finite.
const LARGEST: f64 = 1e100;

fn numbers(name: &'static str, values: &[f64], len: usize, nonnegative: bool) -> Result<(), Error> {
    if values.len() != len {
        return Err(Error::shape(name, format!("{len} numbers"), values.len()));
    }
    let lowest = if nonnegative { 0.0 } else { -LARGEST };
    let good = |x: f64| (x >= lowest) & (x.abs() < LARGEST);
    // Without an early exit the loop runs in vectors; where it fails is looked up afterwards.
    if values.iter().fold(true, |all, x| all & good(*x)) {
        return Ok(());
    }
    let at = values.iter().position(|x| !good(*x)).unwrap_or(0);
    let kind = if nonnegative { "finite numbers >= 0" } else { "finite numbers" };
    Err(Error::value(name, kind, format!("{} at flat index {at}", values[at])))
}

fn masses(name: &'static str, values: &[f64], len: usize) -> Result<(), Error> {
    numbers(name, values, len, true)?;
    if values.iter().sum::<f64>() > 0.0 { Ok(()) } else { Err(Error::value(name, "a positive total mass", 0)) }
}

fn pick(matrix: &[f64], width: usize, rows: &[usize], cols: &[usize]) -> Vec<f64> {
    rows.iter().flat_map(|&i| cols.iter().map(move |&j| matrix[i * width + j])).collect()
}

impl<'a> Input<'a> {
    /// The masses that nu starts from and that EM pulls to.
    #[must_use]
    pub fn target_masses(&self, options: &Options) -> (&'a [f64], &'a [f64]) {
        let em = options.em_rate.is_some();
        let prior = self.prior.filter(|_| em).unwrap_or(self.target_mass);
        let nu = if em && !options.em_moves() { prior } else { self.target_mass };
        (nu, prior)
    }

    /// Check the data of a pair; the options are [`Options::check`]'s.
    ///
    /// # Errors
    /// The argument that is empty, of another size, negative, not finite; two fixed marginals with different totals.
    pub fn check(&self, options: &Options) -> Result<(), Error> {
        let (n, m) = (self.source_mass.len(), self.target_mass.len());
        if n == 0 {
            return Err(Error::shape("mu", "at least one node", 0));
        }
        if m == 0 {
            return Err(Error::shape("nu", "at least one node", 0));
        }
        masses("mu", self.source_mass, n)?;
        masses("nu", self.target_mass, m)?;
        numbers("M", self.features, n * m, false)?;
        numbers("A", self.source, n * n, false)?;
        numbers("B", self.target, m * m, false)?;
        let (least, largest) =
            self.features.iter().fold((0.0_f64, 0.0_f64), |(least, most), x| (least.min(*x), most.max(x.abs())));
        if least < -NEGATIVE_ROUNDING * largest {
            let at = self.features.iter().position(|x| *x < -NEGATIVE_ROUNDING * largest).unwrap_or(0);
            return Err(Error::value("M", "costs >= 0", format!("{} at flat index {at}", self.features[at])));
        }
        if let Some(prior) = self.prior.filter(|_| options.em_rate.is_some()) {
            masses("prior", prior, m)?;
        }
        if let Some(start) = self.start {
            numbers("start", start, n * m, true)?;
        }
        if let Some(g) = self.start_potential {
            numbers("start_g", g, m, false)?;
        }
        let (nu, prior) = self.target_masses(options);
        let total = nu.iter().zip(prior).filter(|(_, prior)| **prior > 0.0).map(|(nu, _)| nu).sum::<f64>();
        if total <= 0.0 {
            return Err(Error::value("prior", "mass on a node that has mass in nu", "none"));
        }
        if options.tau_s.is_infinite() && options.tau_t.is_infinite() {
            let s = self.source_mass.iter().sum::<f64>();
            if (s - total).abs() > TOTAL_MISMATCH * s.max(total) {
                return Err(Error::value("nu", format!("mu's total {s}, as both tau are inf"), total));
            }
        }
        Ok(())
    }
}

impl Problem {
    /// Check a pair against its options.
    ///
    /// # Errors
    /// See [`Options::check`] and [`Input::check`].
    pub fn new(input: &Input, options: &Options) -> Result<Self, Error> {
        options.check()?;
        input.check(options)?;
        Ok(Self::of_checked(input, options))
    }

    /// Keep the nodes with mass of a pair that was checked.
    #[must_use]
    pub fn of_checked(input: &Input, options: &Options) -> Self {
        let (n, m) = (input.source_mass.len(), input.target_mass.len());
        let (nu, prior) = input.target_masses(options);
        let rows: Vec<usize> = (0..n).filter(|&i| input.source_mass[i] > 0.0).collect();
        let cols: Vec<usize> = (0..m).filter(|&j| nu[j] > 0.0 && prior[j] > 0.0).collect();
        Self {
            n: rows.len(),
            m: cols.len(),
            features: pick(input.features, m, &rows, &cols).into_iter().map(|x| x.max(0.0)).collect(),
            source: pick(input.source, n, &rows, &rows),
            target: pick(input.target, m, &cols, &cols),
            mu: rows.iter().map(|&i| input.source_mass[i]).collect(),
            nu: cols.iter().map(|&j| nu[j]).collect(),
            prior: cols.iter().map(|&j| prior[j]).collect(),
            start: input.start.map(|start| pick(start, m, &rows, &cols)),
            start_potential: input.start_potential.map(|g| cols.iter().map(|&j| g[j]).collect()),
            rows,
            cols,
            full: (n, m),
        }
    }
}
