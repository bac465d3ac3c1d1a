//! Laws of the transport solver over random problems.
#![allow(missing_docs, clippy::unwrap_used)]

use graft_core::transport::batch::{Packed, Precision, Run, solve_batch};
use graft_core::transport::lanes::dispatch::{Instructions, instructions};
use graft_core::transport::lanes::vector::{F32x16, F32x32, F64x8, F64x16, Vector};
use graft_core::transport::{Entropy, Input, Loss, Options, Solution, lanes, solve};
use proptest::prelude::*;

fn options() -> Options {
    Options {
        alpha: 0.5,
        tau_s: 1.0,
        tau_t: 1.0,
        eps: 0.05,
        loss: Loss::Square,
        entropy: Entropy::Relative,
        em_rate: None,
        tol: 1e-6,
        max_outer: 200,
    }
}

/// M, A, B, mu, nu.
#[derive(Debug, Clone)]
struct Pair([Vec<f64>; 5]);

impl Pair {
    fn input(&self) -> Input<'_> {
        let [features, source, target, source_mass, target_mass] = &self.0;
        Input { features, source, target, source_mass, target_mass, prior: None, start: None, start_potential: None }
    }

    /// The same pair with symmetric structures, as the lanes want them.
    fn symmetric(mut self) -> Self {
        for (matrix, side) in [(1, 3), (2, 4)] {
            let n = self.0[side].len();
            for i in 0..n {
                for k in 0..i {
                    self.0[matrix][i * n + k] = self.0[matrix][k * n + i];
                }
            }
        }
        self
    }
}

fn run(threads: usize) -> Run {
    Run { threads, precision: Precision::F64, history: false, instructions: instructions() }
}

/// Objective and plan of every pair; None where it was out of range.
type Found = Vec<Option<(f64, Vec<f64>)>>;

/// Solve side by side in lanes of one kind.
fn in_lanes<V: Vector>(pairs: &[Pair], options: &Options, with: Instructions) -> Found {
    found(pairs, |numbered| lanes::run::<V>(numbered, options, false, with))
}

/// Solve one after the other with vectors along the nodes.
fn alone<V: Vector>(pairs: &[Pair], options: &Options, with: Instructions) -> Found {
    found(pairs, |numbered| lanes::run_alone::<V>(numbered, options, false, with))
}

fn found(pairs: &[Pair], solve: impl Fn(&[(usize, &Input)]) -> (Vec<(usize, Solution)>, Vec<usize>)) -> Found {
    let inputs: Vec<Input> = pairs.iter().map(Pair::input).collect();
    let numbered: Vec<(usize, &Input)> = inputs.iter().enumerate().collect();
    let (solved, rejected) = solve(&numbered);
    assert_eq!(solved.len() + rejected.len(), pairs.len());
    let mut found = vec![None; pairs.len()];
    for (k, solution) in solved {
        found[k] = Some((solution.terms.objective(), solution.plan));
    }
    found
}

fn pair() -> impl Strategy<Value = Pair> {
    (1_usize..7, 1_usize..7, prop::sample::select(vec![0.1, 1.0, 100.0])).prop_flat_map(|(n, m, scale)| {
        let numbers = |len| prop::collection::vec(0.01..1.0, len);
        (numbers(n * m), numbers(n * n), numbers(m * m), numbers(n), numbers(m)).prop_map(
            move |(features, mut source, mut target, mu, nu)| {
                source.iter_mut().chain(&mut target).for_each(|x| *x *= scale);
                Pair([features, source, target, mu, nu])
            },
        )
    })
}

/// Pairs around the widths of vectors, some nodes without mass.
fn large_pair() -> impl Strategy<Value = Pair> {
    (14_usize..50, 14_usize..50).prop_flat_map(|(n, m)| {
        let numbers = |len| prop::collection::vec(0.01..1.0, len);
        let masses = |len| prop::collection::vec(prop_oneof![1 => Just(0.0), 9 => 0.01..1.0], len);
        (numbers(n * m), numbers(n * n), numbers(m * m), masses(n), masses(m)).prop_map(
            |(features, source, target, mut mu, mut nu)| {
                (mu[0], nu[0]) = (0.5, 0.5);
                for masses in [&mut mu, &mut nu] {
                    let total: f64 = masses.iter().sum();
                    for x in masses.iter_mut() {
                        *x /= total;
                    }
                }
                Pair([features, source, target, mu, nu])
            },
        )
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    #[test]
    fn em_descends_and_stays_finite(pair in pair(), alpha in 0.0..=1.0, tau in 1e-3..10.0, eps in 1e-4..1.0) {
        let options = Options { alpha, tau_s: tau, eps, em_rate: Some(0.4), max_outer: 40, ..options() };
        let solution = solve(&pair.input(), &options).unwrap();
        prop_assert!(solution.plan.iter().all(|t| t.is_finite() && *t >= 0.0));
        // The structure term is a difference of losses up to (2 * 100)^2 at masses up to 7.
        let rounding = 1e-12 * (solution.history[0].abs() + 4e4 * 49.0);
        for step in solution.history.windows(2) {
            prop_assert!(step[1] <= step[0] + rounding, "{step:?}");
        }
    }

    #[test]
    fn lanes_solve_what_the_scalar_solver_solves(pairs in prop::collection::vec(pair(), 1..40), em in any::<bool>()) {
        let small = |pair: Pair| {
            let mut pair = pair.symmetric();
            // Lengths are below 1 in what lanes are for.
            for k in [1, 2] {
                pair.0[k].iter_mut().for_each(|x| *x /= 1.0 + *x);
            }
            pair
        };
        let pairs: Vec<Pair> = pairs.into_iter().map(small).collect();
        let options = Options { tol: 1e-10, max_outer: 2000, em_rate: em.then_some(0.4), ..options() };
        let best = in_lanes::<F64x16>(&pairs, &options, instructions());
        for (pair, found) in pairs.iter().zip(&best) {
            let (objective, plan) = found.as_ref().unwrap();
            let scalar = solve(&pair.input(), &options).unwrap();
            prop_assert!((scalar.terms.objective() - objective).abs() <= 1e-9 * (1.0 + objective.abs()));
            let mass: f64 = plan.iter().sum();
            let apart: f64 = plan.iter().zip(&scalar.plan).map(|(a, b)| (a - b).abs()).sum();
            prop_assert!(apart <= 1e-7 * mass, "{apart} of {mass}");
        }
        // Bits depend neither on the width nor on the instructions.
        for with in [Instructions::Baseline, Instructions::Avx2, Instructions::Avx512] {
            prop_assert!(best == in_lanes::<F64x8>(&pairs, &options, with));
            prop_assert!(best == in_lanes::<F64x16>(&pairs, &options, with));
            prop_assert!(best == alone::<F64x8>(&pairs, &options, with));
        }
        let coarse = Options { tol: 1e-5, ..options };
        let single = in_lanes::<F32x32>(&pairs, &coarse, instructions());
        prop_assert!(single == alone::<F32x16>(&pairs, &coarse, instructions()));
        // Single precision may hand a pair back; what it solves is near.
        for found in single.iter().zip(&best) {
            if let (Some((single, _)), Some((double, _))) = found {
                prop_assert!((single - double).abs() <= 1e-4 * (1.0 + double.abs()), "{single} {double}");
            }
        }
    }

    #[test]
    fn a_constant_added_to_both_structures_changes_nothing(pair in pair()) {
        let mut shifted = pair.clone();
        for k in [1, 2] {
            shifted.0[k].iter_mut().for_each(|x| *x += 0.5);
        }
        let once = Options { max_outer: 1, ..options() };
        let (a, b) = (solve(&pair.input(), &once).unwrap(), solve(&shifted.input(), &once).unwrap());
        let (x, y) = (a.terms.objective(), b.terms.objective());
        prop_assert!((x - y).abs() <= 1e-6 * (1.0 + x.abs()), "{x} {y}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(12))]

    #[test]
    fn a_large_pair_alone_is_the_pair_in_a_lane(pairs in prop::collection::vec(large_pair(), 1..4), scale in 1..4) {
        // Up to structures where steps need the line search, and pairs leave the range.
        let pairs: Vec<Pair> = pairs.into_iter().map(|mut pair| {
            for k in [1, 2] {
                pair.0[k].iter_mut().for_each(|x| *x *= f64::from(scale));
            }
            pair.symmetric()
        }).collect();
        let options = Options { em_rate: Some(0.4), alpha: 0.2, max_outer: 60, ..options() };
        let side_by_side = in_lanes::<F64x8>(&pairs, &options, instructions());
        prop_assert!(side_by_side == alone::<F64x8>(&pairs, &options, Instructions::Baseline));
        prop_assert!(side_by_side == alone::<F64x8>(&pairs, &options, instructions()));
        let single = in_lanes::<F32x16>(&pairs, &options, instructions());
        prop_assert!(single == alone::<F32x16>(&pairs, &options, instructions()));
    }
}

#[test]
fn a_batch_says_which_array_its_sizes_contradict() {
    let data = Packed {
        sizes: &[(1, 1), (1, 2)],
        features: &[1.0; 3],
        source: &[0.0; 2],
        target: &[0.0; 4],
        source_mass: &[1.0; 2],
        target_mass: &[1.0; 3],
        prior: None,
        start: None,
        start_potential: None,
    };
    let error = data.inputs().unwrap_err().to_string();
    assert_eq!(error, "B: expected 4 more numbers, got 3");
    let target = [0.0; 6];
    let error = Packed { target: &target, ..data }.inputs().unwrap_err().to_string();
    assert_eq!(error, "B: expected as many numbers as sizes say, got 1 more");
    let fitting = Packed { target: &target[..5], ..data };
    let inputs = fitting.inputs().unwrap();
    assert_eq!(solve_batch(&inputs, &options(), &run(2)).unwrap().len(), 2);
    let (pair, error) = solve_batch(&inputs, &Options { eps: 0.0, ..options() }, &run(2)).unwrap_err();
    assert_eq!((pair, error.to_string().as_str()), (0, "eps: expected a finite number of at least 1e-9, got 0"));
}
