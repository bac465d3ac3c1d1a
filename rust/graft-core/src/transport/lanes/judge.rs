//! Whether a lane's step is taken: never if F would rise.
//!
//! With D the step from T to T', F(T') - F(T) = (1-alpha)/2 <C_GW(D), D> - (phi(T) - phi(T')), phi the convex model
//! that the sweeps minimise, and with r its gradient's remainder, r_i = tau_s log(u'_i / asked_i),
//! phi(T) - phi(T') = eps KL(T|T') + tau_s KL(u|u') + tau_t KL(v|v') + sum r_i (u - u')_i. Since
//! KL(p|q) >= 3/2 |p - q|_1^2 / (|p|_1 + 2 |q|_1) (Pinsker's inequality for masses), sums that the kernel makes anyway
//! prove most steps to descend without one more logarithm; the others go through the line search of
//! [`crate::transport::ufgw`].

use super::block::{Block, State};
use super::lane::Lane;
use super::vector::Vector;
use crate::transport::objective::{Objective, Point};
use crate::transport::problem::{Options, Problem};
use crate::transport::ufgw::{Solution, gain, step};

/// The verdict on a lane.
#[derive(Debug)]
pub enum Verdict {
    /// Go on.
    Running,
    /// Settled, or out of iterations.
    Done(Solution),
    /// Out of the range of this kernel.
    Rejected,
}

/// Iterations in a row that may sweep on without a step.
const MOST_HELD: usize = 8;

/// Rounding allowed in <C_GW(D), D>, in units of roundoff times its largest possible size.
const ROUNDING: f64 = 8.0;

/// What became of a step that the cheap test did not prove.
enum Searched {
    /// `block.to` is where the search led; sum T log(T / (mu nu')) there.
    Moved(f64),
    /// `block.to` is `block.at`: more sweeps are needed.
    Held,
    /// `block.to` is `block.at`: no step descends.
    Stuck,
}

/// Judge the step from `block.at` to `block.to`, which is changed to what is accepted.
pub fn judge<V: Vector>(
    block: &mut Block<V>,
    lane: usize,
    pair: &mut Lane,
    options: &Options,
    history: bool,
) -> Verdict {
    let report = &block.report;
    let (moved, mass) = (report.moved.get(lane), report.mass.get(lane));
    let curvature = report.curvature.get(lane);
    // Written so that NaN is out of range too.
    let in_range = mass > V::TINY && mass.is_finite() && moved.is_finite() && curvature.is_finite();
    if !(in_range && report.log_scaling.get(lane) <= V::LOG_RANGE) {
        return Verdict::Rejected;
    }
    pair.rounds += 1;
    let (rows, cols) = (report.rows_moved.get(lane), report.cols_moved.get(lane));
    let convex = options.eps * moved * moved + options.tau_s * rows * rows + options.tau_t * cols * cols;
    let gained = 1.5 / (pair.mass + 2.0 * mass) * convex
        + report.residual_gain.get(lane)
        + options.eps * report.momentum_gain.get(lane);
    let slack = ROUNDING * V::EPSILON * pair.largest_loss * mass * moved;
    let settled = moved <= options.tol * mass.max(pair.mass) && report.residual.get(lane) <= options.tol * mass;
    let searched = if 0.5 * (1.0 - options.alpha) * (curvature - slack) <= gained {
        None
    } else {
        Some(search(block, lane, pair, options))
    };
    match searched {
        Some(Searched::Held) => {
            pair.held += 1;
            return if pair.held > MOST_HELD { Verdict::Rejected } else { Verdict::Running };
        }
        Some(Searched::Stuck) if !settled => return Verdict::Rejected,
        _ => pair.held = 0,
    }
    pair.iterations += 1;
    let nu_settled = block.report.nu_moved.get(lane) <= options.tol * block.report.nu_mass.get(lane);
    let converged = settled && nu_settled;
    let done = converged || pair.iterations >= options.max_outer;
    if done || history {
        let sum_t_log = match searched {
            Some(Searched::Moved(sum)) => sum,
            Some(_) => sum_t_log(block, lane, pair, options),
            None => block.report.sum_t_log.get(lane),
        };
        let terms = pair.terms(block, lane, options, sum_t_log);
        if history {
            pair.history.push(terms.em_objective());
        }
        if done {
            return Verdict::Done(pair.solution(block, lane, options.eps, terms, converged));
        }
    }
    pair.mass = block.to.u.iter().map(|u| u.get(lane)).sum();
    Verdict::Running
}

/// J at the start, `block.at`.
pub fn start_objective<V: Vector>(block: &Block<V>, lane: usize, pair: &Lane, options: &Options) -> f64 {
    let problem = Problem::of_checked(pair.input, options);
    let objective = Objective::new(&problem, options);
    let mut at = take(block, &block.at, lane, &problem);
    at.entropy = objective.entropy(&at);
    objective.terms(&at).em_objective()
}

/// sum T log(T / (mu nu')) of `block.to`, whatever the plan.
fn sum_t_log<V: Vector>(block: &Block<V>, lane: usize, pair: &Lane, options: &Options) -> f64 {
    let problem = Problem::of_checked(pair.input, options);
    let mut objective = Objective::new(&problem, options);
    objective.nu = problem.cols.iter().map(|&j| block.at.nu[j].get(lane)).collect();
    let point = take(block, &block.to, lane, &problem);
    let constant = pair.mu_mass * objective.nu.iter().sum::<f64>();
    objective.entropy(&point) + point.mass() - constant
}

fn take<V: Vector>(block: &Block<V>, state: &State<V>, lane: usize, problem: &Problem) -> Point {
    let mut point = Point::zeros(problem.n, problem.m);
    for (i, &row) in problem.rows.iter().enumerate() {
        point.u[i] = state.u[row].get(lane);
        for (j, &col) in problem.cols.iter().enumerate() {
            point.plan[i * problem.m + j] = state.plan[block.cell(row, col)].get(lane);
            point.gradient[i * problem.m + j] = state.gradient[block.cell(row, col)].get(lane);
        }
    }
    for (j, &col) in problem.cols.iter().enumerate() {
        point.v[j] = state.v[col].get(lane);
    }
    point
}

fn search<V: Vector>(block: &mut Block<V>, lane: usize, pair: &Lane, options: &Options) -> Searched {
    let problem = Problem::of_checked(pair.input, options);
    let mut objective = Objective::new(&problem, options);
    objective.nu = problem.cols.iter().map(|&j| block.at.nu[j].get(lane)).collect();
    let mut at = take(block, &block.at, lane, &problem);
    let mut to = take(block, &block.to, lane, &problem);
    at.entropy = objective.entropy(&at);
    to.entropy = objective.entropy(&to);
    let mix = |(gradient, feature): (&f64, &f64)| (1.0 - options.alpha) * gradient + options.alpha * feature;
    let cost: Vec<f64> = at.gradient.iter().zip(&problem.features).map(mix).collect();
    let hopeful = gain(&cost, &objective, &at, &to) >= 0.0;
    let mut trial = Point::zeros(problem.n, problem.m);
    let mut terms = objective.terms(&at);
    let moved = hopeful && step(&cost, &objective, &mut at, &mut to, &mut trial, &mut terms);
    // After a step `at` is the new point, otherwise it is where it was.
    for (i, &row) in problem.rows.iter().enumerate() {
        block.to.u[row].set(lane, at.u[i]);
        for (j, &col) in problem.cols.iter().enumerate() {
            let cell = block.cell(row, col);
            block.to.plan[cell].set(lane, at.plan[i * problem.m + j]);
            block.to.gradient[cell].set(lane, at.gradient[i * problem.m + j]);
        }
    }
    for (j, &col) in problem.cols.iter().enumerate() {
        block.to.v[col].set(lane, at.v[j]);
        block.to.nu[col].set(lane, objective.nu[j]);
    }
    if !moved {
        block.report.nu_moved.set(lane, 0.0);
        return if hopeful { Searched::Stuck } else { Searched::Held };
    }
    let constant = pair.mu_mass * objective.nu.iter().sum::<f64>();
    let sum_t_log = at.entropy + at.mass() - constant;
    if let Some(rate) = options.em_rate.filter(|_| options.em_moves()) {
        let before = objective.nu.iter().sum::<f64>();
        let change = objective.update_target(&mut at, rate);
        block.report.nu_moved.set(lane, change * before);
        for (j, &col) in problem.cols.iter().enumerate() {
            block.to.nu[col].set(lane, objective.nu[j]);
        }
    }
    Searched::Moved(sum_t_log)
}
