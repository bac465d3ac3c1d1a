//! The solver: linearise, sweep, step, update the target masses; F (with EM: J) never rises.
//!
//! One outer iteration linearises the structure term at T, does a few Sinkhorn sweeps with the potentials carried
//! over, moves T along the segment to the plan found, T + s (T* - T), by Armijo backtracking, and sets nu by the
//! M-step. Backtracking costs no further matrix product, as C_GW is linear in the plan.

use super::cost::Structure;
use super::objective::{Objective, Point, Terms};
use super::problem::{Input, Options, Problem};
use super::sinkhorn::Sinkhorn;
use super::wide;
use crate::Error;

/// Sweeps after each linearisation: two are enough while the plan still moves (more would solve the wrong problem).
const SWEEPS: usize = 2;

/// Go on sweeping while the marginal residual exceeds this share of the plan's move.
const RESIDUAL_SHARE: f64 = 0.3;

/// Sweeps for one linearisation at most.
const MAX_SWEEPS: usize = 400;

/// Armijo's constant: share of the predicted decrease that a step must realise.
const ARMIJO: f64 = 1e-4;

/// Shortest step tried.
const SHORTEST: f64 = 1e-7;

/// Rounding allowed in comparisons of F, relative to [`Objective::magnitude`].
pub(super) const ROUNDING: f64 = 4.0 * f64::EPSILON;

/// What a solve found, over all nodes of the caller; nodes left out have zeros.
#[derive(Debug, Clone)]
pub struct Solution {
    /// T (n x m).
    pub plan: Vec<f64>,
    /// nu after EM (m).
    pub target_mass: Vec<f64>,
    /// f (n): T is near R exp((f + g - C) / eps), C = (1-alpha) C_GW(T) + alpha M.
    pub source_potential: Vec<f64>,
    /// g (m).
    pub target_potential: Vec<f64>,
    /// Weighted terms of F and J at the plan.
    pub terms: Terms,
    /// J (without EM: F) at the start and after every iteration.
    pub history: Vec<f64>,
    /// Linearisations.
    pub iterations: usize,
    /// Sinkhorn sweeps, annealing included.
    pub sweeps: usize,
    /// Whether the plan, the target masses and the marginals settled to the tolerance.
    pub converged: bool,
}

/// Solve one pair.
///
/// # Errors
/// See [`Problem::new`].
pub fn solve(input: &Input, options: &Options) -> Result<Solution, Error> {
    Ok(solve_checked(&Problem::new(input, options)?, options))
}

/// Solve a pair whose problem was checked.
#[must_use]
pub fn solve_checked(problem: &Problem, options: &Options) -> Solution {
    let (n, m) = (problem.n, problem.m);
    let mut objective = Objective::new(problem, options);
    let mut structure = (options.alpha < 1.0).then(|| Structure::new(problem, options.loss));
    let mut linearise = |point: &mut Point| {
        if let Some(structure) = &mut structure {
            structure.gradient(&point.plan, &point.u, &point.v, &mut point.gradient);
        }
    };
    let mut at = start(problem, options, &objective);
    linearise(&mut at);
    let (mut to, mut trial) = (Point::zeros(n, m), Point::zeros(n, m));
    let mut sinkhorn = Sinkhorn::new(problem, options, &objective);
    let mut cost = vec![0.0; n * m];
    let mut terms = objective.terms(&at);
    let mut history = vec![terms.em_objective()];
    let (mut iterations, mut sweeps, mut converged) = (0, 0, false);
    while iterations < options.max_outer && !converged {
        iterations += 1;
        for k in 0..n * m {
            cost[k] = (1.0 - options.alpha) * at.gradient[k] + options.alpha * problem.features[k];
        }
        if iterations == 1 {
            sweeps += match &problem.start_potential {
                Some(g) => sinkhorn.start(g),
                None => sinkhorn.anneal(&cost),
            };
        }
        sinkhorn.absorb(&cost);
        let (mut done, mut budget) = (0, SWEEPS);
        let (moved, residual) = loop {
            while done < budget {
                sinkhorn.sweep(&cost);
                done += 1;
            }
            let residual = sinkhorn.plan(&cost, &objective, &mut to);
            if make_feasible(problem, options, &objective.nu, &mut to) {
                to.entropy = objective.entropy(&to);
            }
            let moved = difference(&to, &at);
            let fine = residual <= RESIDUAL_SHARE * moved.max(options.tol);
            if done >= MAX_SWEEPS || (fine && gain(&cost, &objective, &at, &to) >= 0.0) {
                break (moved, residual);
            }
            if fine && residual <= ROUNDING {
                break (moved, residual);
            }
            budget *= 2;
        };
        sweeps += done;
        linearise(&mut to);
        let stuck = !step(&cost, &objective, &mut at, &mut to, &mut trial, &mut terms);
        let mut shift = 0.0;
        if let Some(rate) = options.em_rate.filter(|_| options.em_moves()) {
            shift = objective.update_target(&mut at, rate);
            sinkhorn.set_target(&objective);
            terms = objective.terms(&at);
        }
        history.push(terms.em_objective());
        converged = moved.max(shift).max(residual) <= options.tol;
        if stuck && shift <= options.tol {
            break;
        }
    }
    finish(problem, &objective, &sinkhorn, &at, terms, (history, iterations, sweeps, converged))
}

/// Relative L1 distance of two plans.
fn difference(a: &Point, b: &Point) -> f64 {
    let apart = wide::distance(&a.plan, &b.plan);
    if apart == 0.0 { 0.0 } else { apart / a.mass().max(b.mass()) }
}

/// Decrease from `at` to `to` of the convex model with cost C in place of the structure and feature terms.
///
/// Rounding is forgiven: a gain that is negative by no more than that is zero.
pub(super) fn gain(cost: &[f64], objective: &Objective, at: &Point, to: &Point) -> f64 {
    let step: Vec<f64> = at.plan.iter().zip(&to.plan).map(|(a, t)| a - t).collect();
    let linear = wide::dot(cost, &step);
    let (before, after) = (objective.terms(at), objective.terms(to));
    let gain = linear
        + (before.marginal_source - after.marginal_source)
        + (before.marginal_target - after.marginal_target)
        + (before.entropy - after.entropy);
    let slack = ROUNDING * objective.magnitude(at, &before).max(objective.magnitude(to, &after));
    if gain.abs() <= slack { 0.0 } else { gain }
}

/// Move `at` towards `to` as far as Armijo's rule allows; return whether it moved.
pub(super) fn step(
    cost: &[f64],
    objective: &Objective,
    at: &mut Point,
    to: &mut Point,
    trial: &mut Point,
    terms: &mut Terms,
) -> bool {
    let predicted = gain(cost, objective, at, to).max(0.0);
    let before = terms.objective();
    let mut next = objective.terms(to);
    let slack = ROUNDING * objective.magnitude(at, terms);
    // False for NaN.
    let allowed = |s: f64, next: &Terms| next.objective() <= before - ARMIJO * s * predicted + slack;
    let mut s = 1.0;
    if allowed(s, &next) {
        std::mem::swap(at, to);
        *terms = next;
        return true;
    }
    while s > SHORTEST {
        s *= 0.5;
        trial.between(at, to, s);
        trial.entropy = objective.entropy(trial);
        next = objective.terms(trial);
        if allowed(s, &next) {
            std::mem::swap(at, trial);
            *terms = next;
            return true;
        }
    }
    false
}

/// The given start, or the product plan mu nu' / sqrt(sum mu sum nu); feasible where a marginal is fixed.
fn start(problem: &Problem, options: &Options, objective: &Objective) -> Point {
    let mut at = Point::zeros(problem.n, problem.m);
    if let Some(plan) = &problem.start {
        at.plan.copy_from_slice(plan);
    } else {
        let totals = problem.mu.iter().sum::<f64>() * problem.nu.iter().sum::<f64>();
        for (row, mu) in at.plan.chunks_exact_mut(problem.m).zip(&problem.mu) {
            for (t, nu) in row.iter_mut().zip(&problem.nu) {
                *t = mu * (nu / totals.sqrt());
            }
        }
    }
    at.sum();
    make_feasible(problem, options, &objective.nu, &mut at);
    at.entropy = objective.entropy(&at);
    at
}

/// Make the marginals that are fixed exact; return whether the plan changed.
///
/// With both fixed: scale rows and columns down, then add the missing mass as a product (Altschuler, Weed, Rigollet
/// 2017, algorithm 2). With one fixed: scale its rows or columns.
fn make_feasible(problem: &Problem, options: &Options, nu: &[f64], point: &mut Point) -> bool {
    let (fix_rows, fix_cols) = (options.tau_s.is_infinite(), options.tau_t.is_infinite());
    let m = problem.m;
    if !fix_rows && !fix_cols {
        return false;
    }
    let both = fix_rows && fix_cols;
    let factor = |want: f64, have: f64| {
        let ratio = if have > 0.0 { want / have } else { 0.0 };
        if both { ratio.min(1.0) } else { ratio }
    };
    if fix_rows {
        for (i, row) in point.plan.chunks_exact_mut(m).enumerate() {
            let scale = factor(problem.mu[i], point.u[i]);
            for t in row.iter_mut() {
                *t *= scale;
            }
        }
        point.sum();
    }
    if fix_cols {
        for j in 0..m {
            let scale = factor(nu[j], point.v[j]);
            point.plan.iter_mut().skip(j).step_by(m).for_each(|t| *t *= scale);
        }
        point.sum();
    }
    let missing =
        |want: &[f64], have: &[f64]| -> Vec<f64> { want.iter().zip(have).map(|(w, h)| (w - h).max(0.0)).collect() };
    // Where one side only is fixed, only rows or columns that had no mass at all still miss theirs: spread it.
    let rows = if fix_rows { missing(&problem.mu, &point.u) } else { problem.mu.clone() };
    let cols = if fix_cols { missing(nu, &point.v) } else { nu.to_vec() };
    let total: f64 = if fix_rows { cols.iter().sum() } else { rows.iter().sum() };
    if total > 0.0 {
        for (row, r) in point.plan.chunks_exact_mut(m).zip(&rows) {
            for (t, c) in row.iter_mut().zip(&cols) {
                *t += r * (c / total);
            }
        }
        point.sum();
    }
    true
}

fn finish(
    problem: &Problem,
    objective: &Objective,
    sinkhorn: &Sinkhorn,
    at: &Point,
    terms: Terms,
    (history, iterations, sweeps, converged): (Vec<f64>, usize, usize, bool),
) -> Solution {
    let (n, m) = problem.full;
    let (f, g) = sinkhorn.potentials();
    let mut solution = Solution {
        plan: vec![0.0; n * m],
        target_mass: vec![0.0; m],
        source_potential: vec![0.0; n],
        target_potential: vec![0.0; m],
        terms,
        history,
        iterations,
        sweeps,
        converged,
    };
    for (i, &row) in problem.rows.iter().enumerate() {
        solution.source_potential[row] = f[i];
        for (j, &col) in problem.cols.iter().enumerate() {
            solution.plan[row * m + col] = at.plan[i * problem.m + j];
        }
    }
    for (j, &col) in problem.cols.iter().enumerate() {
        solution.target_mass[col] = objective.nu[j];
        solution.target_potential[col] = g[j];
    }
    solution
}
