//! Many pairs at once: ragged arrays end to end, solved in parallel; the answers do not depend on the threads.

use rayon::prelude::*;

use super::problem::{Input, Options};
use super::ufgw::{Solution, solve};
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
        let (mut prior, mut start) = (self.prior, self.start);
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
        ];
        match rests.iter().find(|(_, rest)| !rest.is_empty()) {
            None => Ok(inputs),
            Some((name, rest)) => {
                Err(Error::shape(name, "as many numbers as sizes say", format!("{} more", rest.len())))
            }
        }
    }
}

/// Solve all pairs, in order, on `threads` threads; 0 takes rayon's own pool.
///
/// # Errors
/// The index of the first pair that is not a problem, and why.
pub fn solve_batch(inputs: &[Input], options: &Options, threads: usize) -> Result<Vec<Solution>, (usize, Error)> {
    let serial = || inputs.iter().map(|input| solve(input, options)).collect::<Vec<_>>();
    let parallel = || inputs.par_iter().map(|input| solve(input, options)).collect::<Vec<_>>();
    let results = if threads == 1 || inputs.len() == 1 {
        serial()
    } else if threads == 0 {
        parallel()
    } else {
        match rayon::ThreadPoolBuilder::new().num_threads(threads).build() {
            Ok(pool) => pool.install(parallel),
            // The system gave no threads: slower, the same answers.
            Err(_) => serial(),
        }
    };
    results.into_iter().enumerate().map(|(k, result)| result.map_err(|error| (k, error))).collect()
}
