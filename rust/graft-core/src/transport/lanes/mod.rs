//! Many small pairs at once, one pair in each lane of the processor's vectors.
//!
//! The iteration is that of [`super::ufgw`]: linearise, two translation-invariant sweeps, a step that never lets F (with
//! EM: J) rise, the M-step. Lanes never exchange numbers, so a pair's solution does not depend on its neighbours, on
//! the padding, on the number of threads or on the instruction set. A lane that is done takes the next pair waiting.
//!
//! [`vector`] has the arithmetic, [`block`] the arrays, [`kernel`] one iteration and [`product`] its matrix products, [`dispatch`] compiles it for
//! several instruction sets, [`lane`] puts pairs in and takes solutions out, [`judge`] decides about steps.

pub mod aligned;
pub mod block;
pub mod dispatch;
pub mod judge;
pub mod kernel;
pub mod lane;
pub mod product;
pub mod single;
pub mod vector;

use block::{Block, Rates};
use dispatch::Instructions;
use judge::{Verdict, judge};
use lane::Lane;
use single::Single;
use vector::Vector;

use super::problem::{Entropy, Input, Loss, Options};
use super::ufgw::Solution;

/// Largest graph solved in lanes: beyond it the arrays of a block leave the processor's caches.
pub const LARGEST: usize = 24;

/// Smallest tolerance: below it the rounding of C / eps may keep a plan moving.
const FINEST: f64 = 1e-12;

/// Whether the kernel knows these options.
#[must_use]
pub fn suits(options: &Options) -> bool {
    let price = |tau: f64| tau > 0.0 && tau.is_finite();
    options.loss == Loss::Square
        && options.entropy == Entropy::Relative
        && price(options.tau_s)
        && price(options.tau_t)
        && options.tol >= FINEST
}

/// Whether the kernel knows this pair: both structures symmetric.
#[must_use]
pub fn suits_pair(input: &Input) -> bool {
    let symmetric = |a: &[f64], n: usize| {
        let mut same = true;
        for i in 0..n {
            for k in 0..i {
                same &= a[i * n + k].to_bits() == a[k * n + i].to_bits();
            }
        }
        same
    };
    let (n, m) = (input.source_mass.len(), input.target_mass.len());
    symmetric(input.source, n) && symmetric(input.target, m)
}

/// Solve checked pairs given with their index; return what was solved, and the indices of what was out of range.
#[must_use]
pub fn run<V: Vector>(
    pairs: &[(usize, &Input)],
    options: &Options,
    history: bool,
    with: Instructions,
) -> (Vec<(usize, Solution)>, Vec<usize>) {
    let (mut solved, mut rejected) = (Vec::with_capacity(pairs.len()), Vec::new());
    let n = pairs.iter().map(|(_, input)| input.source_mass.len()).max().unwrap_or(0);
    let m = pairs.iter().map(|(_, input)| input.target_mass.len()).max().unwrap_or(0);
    if pairs.is_empty() {
        return (solved, rejected);
    }
    let mut block = Block::<V>::new(n, m);
    let rates = Rates::new(options);
    let mut waiting = pairs.iter();
    // Lanes without a pair of their own compute along with a copy of the first.
    let mut lanes: Vec<Option<Lane>> = (0..V::LANES)
        .map(|lane| {
            let next = waiting.next();
            let (index, input) = next.unwrap_or(&pairs[0]);
            let pair = Lane::load(&mut block, lane, *index, input, options, history);
            next.map(|_| pair)
        })
        .collect();
    let mut live = lanes.iter().flatten().count();
    while live > 0 {
        kernel::iterate(&mut block, &rates, with);
        let mut free = [false; 64];
        for (lane, slot) in lanes.iter_mut().enumerate() {
            let Some(pair) = slot else { continue };
            match judge(&mut block, lane, pair, options, history) {
                Verdict::Running => continue,
                Verdict::Done(solution) => solved.push((pair.index, solution)),
                Verdict::Rejected => rejected.push(pair.index),
            }
            free[lane] = true;
            *slot = None;
            live -= 1;
        }
        std::mem::swap(&mut block.at, &mut block.to);
        for lane in (0..V::LANES).filter(|lane| free[*lane]) {
            if let Some((index, input)) = waiting.next() {
                lanes[lane] = Some(Lane::load(&mut block, lane, *index, input, options, history));
                live += 1;
            }
        }
    }
    (solved, rejected)
}

/// Solve checked pairs one after the other; the same as [`run`] to the last bit.
#[must_use]
pub fn run_alone<V: Vector>(
    pairs: &[(usize, &Input)],
    options: &Options,
    history: bool,
    with: Instructions,
) -> (Vec<(usize, Solution)>, Vec<usize>) {
    let (mut solved, mut rejected) = (Vec::with_capacity(pairs.len()), Vec::new());
    let mut single = Single::<V>::default();
    for (index, input) in pairs {
        match single.solve(input, options, history, with) {
            Some(solution) => solved.push((*index, solution)),
            None => rejected.push(*index),
        }
    }
    (solved, rejected)
}
