//! Several starts a pair: the product plan and random ones; the lowest objective wins.

use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

use super::batch::{Run, solve_batch};
use super::problem::{Input, Options};
use super::ufgw::Solution;
use crate::Error;

/// Solve every pair from its own start and from `starts - 1` random ones; keep the least J (ties: the earliest start).
///
/// A random start is the product plan with every entry multiplied by an exponential variate, at the product's mass.
/// Pair k of any batch gets the same starts for the same seed.
///
/// # Errors
/// See [`solve_batch`].
pub fn solve_from_starts(
    inputs: &[Input],
    options: &Options,
    run: &Run,
    starts: usize,
    seed: u64,
) -> Result<Vec<Solution>, (usize, Error)> {
    if starts <= 1 {
        return solve_batch(inputs, options, run);
    }
    options.check().map_err(|error| (0, error))?;
    if let Some(wrong) = inputs.iter().enumerate().find_map(|(k, i)| i.check(options).err().map(|e| (k, e))) {
        return Err(wrong);
    }
    let plans: Vec<Vec<f64>> = inputs
        .iter()
        .enumerate()
        .flat_map(|(k, input)| {
            let mut random = Pcg64::seed_from_u64(seed ^ (k as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15));
            (1..starts).map(move |_| random_plan(input, &mut random)).collect::<Vec<_>>()
        })
        .collect();
    let all: Vec<Input> = inputs
        .iter()
        .zip(plans.chunks(starts - 1))
        .flat_map(|(input, plans)| {
            std::iter::once(*input).chain(plans.iter().map(|plan| Input { start: Some(plan), ..*input }))
        })
        .collect();
    let solutions = solve_batch(&all, options, run).map_err(|(k, error)| (k / starts, error))?;
    let mut solutions = solutions.into_iter();
    let best =
        |_| {
            let first = solutions.next()?;
            Some(solutions.by_ref().take(starts - 1).fold(first, |best, next| {
                if next.terms.em_objective() < best.terms.em_objective() { next } else { best }
            }))
        };
    Ok((0..inputs.len()).filter_map(best).collect())
}

fn random_plan(input: &Input, random: &mut Pcg64) -> Vec<f64> {
    let (mu, nu) = (input.source_mass, input.target_mass);
    let mut plan: Vec<f64> = mu
        .iter()
        .flat_map(|mu| nu.iter().map(move |nu| mu * nu))
        .map(|x| x * -(1.0 - random.random::<f64>()).ln())
        .collect();
    let total = (mu.iter().sum::<f64>() * nu.iter().sum::<f64>()).sqrt();
    let sum: f64 = plan.iter().sum();
    if sum > 0.0 {
        for t in &mut plan {
            *t *= total / sum;
        }
    }
    plan
}
