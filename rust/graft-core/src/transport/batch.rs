//! Many pairs at once: ragged arrays end to end, solved in parallel; the answers do not depend on the threads.

use rayon::prelude::*;

use super::lanes;
use super::lanes::dispatch::Instructions;
use super::lanes::vector::{F32x16, F32x32, F64x8, F64x16, Vector};
use super::problem::{Input, Options, Problem};
use super::ufgw::{Solution, solve_checked};
use crate::Error;

/// Pairs packed end to end: pair k has `sizes[k] = (n, m)` and the next n m, n n, m m, n and m numbers.
#[derive(Debug, Clone, Copy)]
pub struct Packed<'a> {
    /// (n, m) of every pair.
    pub sizes: &'a [(usize, usize)],
    /// All M.
    pub features: &'a [f64],
    /// All A.
    pub source: &'a [f64],
    /// All B.
    pub target: &'a [f64],
    /// All mu.
    pub source_mass: &'a [f64],
    /// All nu.
    pub target_mass: &'a [f64],
    /// All priors.
    pub prior: Option<&'a [f64]>,
    /// All start plans.
    pub start: Option<&'a [f64]>,
    /// All start potentials g.
    pub start_potential: Option<&'a [f64]>,
}

/// Split off the next `len` numbers.
fn take<'a>(name: &'static str, rest: &mut &'a [f64], len: usize) -> Result<&'a [f64], Error> {
    let (head, tail) =
        rest.split_at_checked(len).ok_or_else(|| Error::shape(name, format!("{len} more numbers"), rest.len()))?;
    *rest = tail;
    Ok(head)
}

impl<'a> Packed<'a> {
    /// Unpack into pairs.
    ///
    /// # Errors
    /// The array whose length the sizes contradict.
    pub fn inputs(&self) -> Result<Vec<Input<'a>>, Error> {
        let (mut features, mut source, mut target) = (self.features, self.source, self.target);
        let (mut source_mass, mut target_mass) = (self.source_mass, self.target_mass);
        let (mut prior, mut start, mut potential) = (self.prior, self.start, self.start_potential);
        let mut inputs = Vec::with_capacity(self.sizes.len());
        for &(n, m) in self.sizes {
            inputs.push(Input {
                features: take("M", &mut features, n * m)?,
                source: take("A", &mut source, n * n)?,
                target: take("B", &mut target, m * m)?,
                source_mass: take("mu", &mut source_mass, n)?,
                target_mass: take("nu", &mut target_mass, m)?,
                prior: prior.as_mut().map(|rest| take("prior", rest, m)).transpose()?,
                start: start.as_mut().map(|rest| take("start", rest, n * m)).transpose()?,
                start_potential: potential.as_mut().map(|rest| take("start_g", rest, m)).transpose()?,
            });
        }
        let rests = [
            ("M", features),
            ("A", source),
            ("B", target),
            ("mu", source_mass),
            ("nu", target_mass),
            ("prior", prior.unwrap_or_default()),
            ("start", start.unwrap_or_default()),
            ("start_g", potential.unwrap_or_default()),
        ];
        match rests.iter().find(|(_, rest)| !rest.is_empty()) {
            None => Ok(inputs),
            Some((name, rest)) => {
                Err(Error::shape(name, "as many numbers as sizes say", format!("{} more", rest.len())))
            }
        }
    }
}

/// Floats that the lanes compute in.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Precision {
    /// Double.
    F64,
    /// Single; pairs that it cannot hold, or does not settle, are solved again in double.
    F32,
}

/// Pairs that one task solves at least: few enough to spread, enough to keep the lanes full.
const TASK: usize = 64;

/// Pairs that one task solves at most.
const LARGEST_TASK: usize = 512;

/// Padded sizes: a graph takes the next one up.
const CLASSES: [usize; 13] = [1, 2, 3, 4, 5, 6, 7, 8, 10, 12, 16, 20, lanes::LARGEST];

/// So few pairs are solved sooner one after the other: at n = 6 eight lanes take as long as three pairs, at n = 20 as five.
const ALONE: usize = 3;

fn class(n: usize) -> usize {
    CLASSES.partition_point(|&size| size < n)
}

/// Whether vectors along the nodes are full enough, and pairs side by side would leave the processor's caches.
fn large(input: &Input) -> bool {
    input.source_mass.len().max(input.target_mass.len()) > lanes::LARGEST
}

/// How a batch is to be run.
#[derive(Debug, Clone, Copy)]
pub struct Run {
    /// Threads; 0 takes rayon's own pool.
    pub threads: usize,
    /// Precision of pairs solved in lanes.
    pub precision: Precision,
    /// Keep the objective of every iteration.
    pub history: bool,
    /// Instruction set of the lanes.
    pub instructions: Instructions,
}

/// Solve all pairs, in order; the answers depend neither on the threads nor on the instructions.
///
/// # Errors
/// The index of the first pair that is not a problem, and why.
pub fn solve_batch(inputs: &[Input], options: &Options, run: &Run) -> Result<Vec<Solution>, (usize, Error)> {
    options.check().map_err(|error| (0, error))?;
    if run.threads <= 1 || inputs.len() == 1 {
        if run.threads == 1 || inputs.len() == 1 {
            return solve_all(inputs, options, run, true);
        }
        return solve_all(inputs, options, run, false);
    }
    if run.threads == rayon::current_num_threads() {
        return solve_all(inputs, options, run, false);
    }
    match rayon::ThreadPoolBuilder::new().num_threads(run.threads).build() {
        Ok(pool) => pool.install(|| solve_all(inputs, options, run, false)),
        // The system gave no threads: slower, the same answers.
        Err(_) => solve_all(inputs, options, run, true),
    }
}

fn solve_all(inputs: &[Input], options: &Options, run: &Run, serial: bool) -> Result<Vec<Solution>, (usize, Error)> {
    let wrong = |(k, input): (usize, &Input)| input.check(options).err().map(|error| (k, error));
    let error = if serial {
        inputs.iter().enumerate().find_map(wrong)
    } else {
        inputs.par_iter().enumerate().with_min_len(TASK).filter_map(wrong).min_by_key(|(k, _)| *k)
    };
    if let Some(error) = error {
        return Err(error);
    }
    let mut solutions: Vec<Option<Solution>> = vec![None; inputs.len()];
    let mut waiting: Vec<usize> = Vec::new();
    let mut scalar: Vec<usize> = (0..inputs.len()).collect();
    if lanes::suits(options) {
        (waiting, scalar) = (0..inputs.len()).partition(|&k| lanes::suits_pair(&inputs[k]));
        let size = |k: usize| (inputs[k].source_mass.len(), inputs[k].target_mass.len());
        waiting.sort_by_key(|&k| (class(size(k).0), class(size(k).1)));
    }
    let tasks = if serial { 1 } else { 4 * rayon::current_num_threads() };
    let length = waiting.len().div_ceil(tasks).clamp(TASK, LARGEST_TASK);
    // Large pairs are worth a task each.
    let length_of = |group: &[usize]| if group.first().is_some_and(|&k| large(&inputs[k])) { 1 } else { length };
    let groups = |order: &[usize]| -> Vec<Vec<(usize, &Input)>> {
        let same = |a: &usize, b: &usize| {
            let of = |k: usize| (class(inputs[k].source_mass.len()), class(inputs[k].target_mass.len()));
            of(*a) == of(*b)
        };
        let pairs = |chunk: &[usize]| chunk.iter().map(|&k| (k, &inputs[k])).collect::<Vec<_>>();
        order.chunk_by(same).flat_map(|group| group.chunks(length_of(group))).map(pairs).collect()
    };
    if run.precision == Precision::F32 && !waiting.is_empty() {
        let task = |group: &Vec<(usize, &Input)>| in_lanes::<F32x16, F32x32>(group, options, run);
        let again = collect(spread(&groups(&waiting), task, serial), &mut solutions);
        // Out of range, or not settled: noise of single precision may keep a plan moving.
        let unsettled = |k: &usize| solutions[*k].as_ref().is_none_or(|s| !s.converged);
        let mut again: Vec<usize> = again.into_iter().chain(waiting.iter().copied().filter(unsettled)).collect();
        again.sort_unstable();
        again.dedup();
        waiting.retain(|k| again.binary_search(k).is_ok());
    }
    if !waiting.is_empty() {
        let task = |group: &Vec<(usize, &Input)>| in_lanes::<F64x8, F64x16>(group, options, run);
        scalar.extend(collect(spread(&groups(&waiting), task, serial), &mut solutions));
        scalar.sort_unstable();
    }
    let one = |&k: &usize| (vec![(k, solve_checked(&Problem::of_checked(&inputs[k], options), options))], Vec::new());
    collect(spread(&scalar, one, serial), &mut solutions);
    Ok(solutions.into_iter().flatten().collect())
}

/// Solve a group in as few lanes as hold it: the width changes no bit.
fn in_lanes<Few: Vector, Many: Vector>(group: &[(usize, &Input)], options: &Options, run: &Run) -> Outcome {
    if group.len() <= ALONE || group.first().is_some_and(|(_, input)| large(input)) {
        lanes::run_alone::<Few>(group, options, run.history, run.instructions)
    } else if group.len() <= Few::LANES {
        lanes::run::<Few>(group, options, run.history, run.instructions)
    } else {
        lanes::run::<Many>(group, options, run.history, run.instructions)
    }
}

type Outcome = (Vec<(usize, Solution)>, Vec<usize>);

fn spread<T: Sync>(tasks: &[T], work: impl Fn(&T) -> Outcome + Sync + Send, serial: bool) -> Vec<Outcome> {
    if serial { tasks.iter().map(work).collect() } else { tasks.par_iter().map(work).collect() }
}

/// Put solutions in their places; return the rejected indices.
fn collect(outcomes: Vec<Outcome>, solutions: &mut [Option<Solution>]) -> Vec<usize> {
    let mut rejected = Vec::new();
    for (solved, left) in outcomes {
        rejected.extend(left);
        for (k, solution) in solved {
            solutions[k] = Some(solution);
        }
    }
    rejected
}
