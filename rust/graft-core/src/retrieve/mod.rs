//! One target against a library of packed graphs: the k sources of least cost, exactly.
//!
//! Every graph gets a cheap lower bound of its cost ([`bounds`]); graphs are then solved in the order of their bounds
//! until no bound left is below the k-th best cost. What comes out is what solving all of them would give; equal costs
//! are in the order of the library. Results do not depend on the threads.

// M_ij and T_ij are mathematics, not code.
#![allow(clippy::doc_markdown)]

pub mod bounds;
pub mod ranking;

use rayon::prelude::*;

use self::bounds::{LANES, Query, bound_parts};
pub use self::ranking::Ranking;
use crate::Error;
use crate::transport::batch::{Precision, Run, solve_batch};
use crate::transport::feature::{Features, Variant};
use crate::transport::lanes::dispatch::instructions;
use crate::transport::{Input, Solution};

/// Graphs solved first, beyond k: their costs set the bar for all others.
const FIRST: usize = 64;

/// Graphs solved at a time after that.
const ROUND: usize = 512;

/// Relative and absolute rounding of a sum of bounds in single precision (masses, exp and sums, a few ulp each).
const ROUNDING: f64 = 2e-6;

/// Graphs end to end. `hot` data is what bounds read: blocks of [`LANES`] parts side by side, padded with zeros.
#[derive(Debug, Clone, Copy)]
pub struct Library<'a> {
    /// First part of every graph, and the number of all parts.
    pub offsets: &'a [i64],
    /// Demonstrated part of every graph.
    pub parts: &'a [i64],
    /// Half extents in diagonals (parts x 3).
    pub extents: &'a [f64],
    /// Relations (parts x width).
    pub relations: &'a [f64],
    /// Descriptors (parts x dim), or none.
    pub descriptors: Option<&'a [f64]>,
    /// Structures, n n numbers a graph.
    pub structures: &'a [f64],
    /// Source masses (parts).
    pub masses: &'a [f64],
    /// Half extents, hot.
    pub hot_extents: &'a [f32],
    /// Unit descriptors and relations, hot.
    pub hot_features: &'a [f32],
    /// Source masses, hot.
    pub hot_masses: &'a [f32],
}

/// The target of a query.
#[derive(Debug, Clone, Copy)]
pub struct Target<'a> {
    /// Boxes, relations, descriptors of its parts.
    pub features: Features<'a>,
    /// Structure (m x m).
    pub structure: &'a [f64],
    /// Prior (m).
    pub prior: &'a [f64],
}

/// Which graphs are wanted.
#[derive(Debug, Clone, Copy)]
pub struct Wanted<'a> {
    /// How many, at most.
    pub k: usize,
    /// Graphs that cost more than this need not be found: a bar, or the k-th best cost of another part of the library.
    pub bar: f64,
    /// Only these graphs, rising; all when absent.
    pub among: Option<&'a [i64]>,
    /// Leave out graphs whose bounds rule them out; false solves every graph.
    pub prune: bool,
}

impl Wanted<'_> {
    fn candidates(&self, graphs: usize) -> Result<Vec<usize>, Error> {
        let Some(among) = self.among else { return Ok((0..graphs).collect()) };
        let rising = among.windows(2).all(|w| w[0] < w[1]);
        let inside = among.first().is_none_or(|i| *i >= 0) && among.last().is_none_or(|i| (*i as usize) < graphs);
        if !rising || !inside {
            return Err(Error::value("among", format!("rising numbers from 0 to {}", graphs - 1), "others"));
        }
        Ok(among.iter().map(|i| *i as usize).collect())
    }
}

/// The best graphs, best first, and how much work it was.
#[derive(Debug, Clone)]
pub struct Ranked {
    /// Index and cost.
    pub best: Vec<(usize, f64)>,
    /// Graphs that had to be solved.
    pub solved: usize,
}

impl Library<'_> {
    /// Number of graphs.
    #[must_use]
    pub fn len(&self) -> usize {
        self.parts.len()
    }

    /// Whether there is none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.parts.is_empty()
    }

    fn check(&self, target: &Target) -> Result<(usize, usize), Error> {
        let total = usize::try_from(self.offsets.last().copied().unwrap_or(-1)).unwrap_or(0);
        let rising = self.offsets.first() == Some(&0) && self.offsets.windows(2).all(|w| w[0] < w[1]);
        if self.offsets.len() != self.len() + 1 || !rising {
            let expected = format!("{} numbers rising from 0", self.len() + 1);
            return Err(Error::shape("offsets", expected, self.offsets.len()));
        }
        let inside = |(part, w): (&i64, &[i64])| *part >= 0 && *part < w[1] - w[0];
        if !self.parts.iter().zip(self.offsets.windows(2)).all(inside) {
            return Err(Error::value("parts", "a part of each graph", "another"));
        }
        let m = target.prior.len();
        let square: i64 = self.offsets.windows(2).map(|w| (w[1] - w[0]) * (w[1] - w[0])).sum();
        let (width, dim) = (
            target.features.relations.len().checked_div(m).unwrap_or(0),
            target.features.descriptors.map_or(0, |d| d.len().checked_div(m).unwrap_or(0)),
        );
        let own = self.descriptors.map_or(0, |d| d.len() / total.max(1));
        let padded = total.div_ceil(LANES) * LANES;
        let lengths = [
            ("extents", self.extents.len(), 3 * total),
            ("relations", self.relations.len(), width * total),
            ("descriptors", self.descriptors.map_or(0, <[f64]>::len), own * total),
            ("structures", self.structures.len(), usize::try_from(square).unwrap_or(0)),
            ("masses", self.masses.len(), total),
            ("hot extents", self.hot_extents.len(), 3 * padded),
            ("hot features", self.hot_features.len(), (own + width) * padded),
            ("hot masses", self.hot_masses.len(), padded),
            ("target structure", target.structure.len(), m * m),
            ("target half extents", target.features.extents.len(), 3 * m),
        ];
        if let Some((name, got, expected)) = lengths.iter().find(|(_, got, expected)| got != expected) {
            return Err(Error::shape(name, format!("{expected} numbers"), got));
        }
        if dim > 0 && own > 0 && dim != own {
            return Err(Error::shape("target descriptors", format!("{own} numbers a part"), dim));
        }
        Ok((if dim > 0 { own } else { 0 }, own))
    }

    fn range(&self, k: usize) -> std::ops::Range<usize> {
        self.offsets[k] as usize..self.offsets[k + 1] as usize
    }
}

/// Rank the library's graphs by what it costs to match them with the target; return the `wanted.k` best.
///
/// Graphs above `wanted.bar` may be among the answers: whoever sets a bar drops them.
///
/// # Errors
/// Arrays whose lengths contradict each other, or a pair that is no problem (see [`Input::check`]).
pub fn rank(library: &Library, target: &Target, ranking: &Ranking, wanted: &Wanted) -> Result<Ranked, Error> {
    let (used, own) = library.check(target)?;
    let (k, prune) = (wanted.k, wanted.prune);
    let mut order = wanted.candidates(library.len())?;
    ranking.options.check()?;
    // Checks the weights, once.
    ranking.feature.matrix(target.features, target.features)?;
    let bounds = if prune && ranking.feature.variant == Variant::Graft {
        bound_graphs(library, target, ranking, used, own)
    } else {
        vec![0.0; library.len()]
    };
    let starts: Vec<usize> = std::iter::once(0)
        .chain(library.offsets.windows(2).scan(0, |at, w| {
            *at += ((w[1] - w[0]) * (w[1] - w[0])) as usize;
            Some(*at)
        }))
        .collect();
    let by_bound = |a: &usize, b: &usize| bounds[*a].total_cmp(&bounds[*b]).then(a.cmp(b));
    let mut best: Vec<(usize, f64)> = Vec::new();
    let (mut done, mut solved) = (0, 0);
    while done < order.len() {
        let round = if done == 0 { k + FIRST } else { ROUND };
        let waiting = &mut order[done..];
        let count = round.min(waiting.len());
        if count < waiting.len() {
            waiting.select_nth_unstable_by(count - 1, by_bound);
        }
        let bar = if best.len() < k { wanted.bar } else { best[k - 1].1.min(wanted.bar) };
        let chosen: Vec<usize> = waiting[..count].iter().copied().filter(|i| bounds[*i] <= bar).collect();
        if chosen.is_empty() {
            break;
        }
        done += count;
        solved += chosen.len();
        best.extend(costs(library, target, ranking, &starts, &chosen)?);
        best.sort_by(|a, b| a.1.total_cmp(&b.1).then(a.0.cmp(&b.0)));
        best.truncate(k);
        if best.len() == k && done == k + FIRST {
            // With the bar known most graphs are out at once, without being sorted.
            let bar = best[k - 1].1.min(wanted.bar);
            let mut left: Vec<usize> = order[done..].iter().copied().filter(|i| bounds[*i] <= bar).collect();
            order.truncate(done);
            order.append(&mut left);
        }
    }
    Ok(Ranked { best, solved })
}

fn bound_graphs(library: &Library, target: &Target, ranking: &Ranking, used: usize, own: usize) -> Vec<f64> {
    let m = target.prior.len();
    let weights = &ranking.feature;
    let width = target.features.relations.len() / m;
    let dim = own + width;
    let mut features = vec![0.0_f32; m * dim];
    for (j, row) in features.chunks_exact_mut(dim.max(1)).enumerate() {
        if used > 0 {
            let d = &target.features.descriptors.unwrap_or_default()[j * used..(j + 1) * used];
            let top = d.iter().fold(0.0_f64, |top, x| top.max(x.abs()));
            let norm = top * d.iter().map(|x| (x / top) * (x / top)).sum::<f64>().sqrt();
            if top > 0.0 {
                row.iter_mut().zip(d).for_each(|(x, d)| *x = (weights.lambda_global * d / norm) as f32);
            }
        }
        let relations = &target.features.relations[j * width..(j + 1) * width];
        row[own..].iter_mut().zip(relations).for_each(|(x, r)| *x = (weights.lambda_relation * r) as f32);
    }
    let query = Query {
        extents: target.features.extents.iter().map(|x| *x as f32).collect(),
        features,
        dim,
        constant: (weights.lambda_relation + if used > 0 { weights.lambda_global } else { 0.0 }) as f32,
        lambda_obb: weights.lambda_obb as f32,
        alpha: ranking.options.alpha as f32,
        tau_s: ranking.options.tau_s as f32,
    };
    let (least, shares) =
        bound_parts(&query, library.hot_extents, library.hot_features, library.hot_masses, instructions());
    (0..library.len())
        .into_par_iter()
        .with_min_len(4096)
        .map(|k| {
            let range = library.range(k);
            let rows: f64 = shares[range.clone()].iter().map(|x| f64::from(*x)).sum();
            let mass: f64 = library.masses[range.clone()].iter().sum();
            let price = if ranking.options.tau_s.is_finite() { ranking.options.tau_s } else { 1.0 };
            let own = ranking.part_weight * f64::from(least[range.start + library.parts[k] as usize]);
            (rows + own) * (1.0 - ROUNDING) - ROUNDING * price * mass
        })
        .collect()
}

/// Solve the chosen graphs and return their costs.
fn costs(
    library: &Library,
    target: &Target,
    ranking: &Ranking,
    starts: &[usize],
    chosen: &[usize],
) -> Result<Vec<(usize, f64)>, Error> {
    let parts = library.offsets[library.len()] as usize;
    let width = library.relations.len() / parts;
    let dim = library.descriptors.map_or(0, |d| d.len() / parts);
    let matrix = |&k: &usize| {
        let range = library.range(k);
        let rows = |width: usize| range.start * width..range.end * width;
        let source = Features {
            extents: &library.extents[rows(3)],
            relations: &library.relations[rows(width)],
            descriptors: library.descriptors.map(|d| &d[rows(dim)]),
        };
        ranking.feature.matrix(source, target.features)
    };
    let matrices: Vec<Vec<f64>> = chosen.par_iter().map(matrix).collect::<Result<_, _>>()?;
    let inputs: Vec<Input> = chosen
        .iter()
        .zip(&matrices)
        .map(|(&k, features)| Input {
            features,
            source: &library.structures[starts[k]..starts[k + 1]],
            target: target.structure,
            source_mass: &library.masses[library.range(k)],
            target_mass: target.prior,
            prior: None,
            start: None,
            start_potential: None,
        })
        .collect();
    let run = Run { threads: 0, precision: Precision::F64, history: false, instructions: instructions() };
    let solutions = solve_batch(&inputs, &ranking.options, &run).map_err(|(_, error)| error)?;
    let cost = |((&k, features), solution): ((&usize, &Vec<f64>), &Solution)| {
        (k, ranking.cost(solution, features, library.parts[k] as usize))
    };
    Ok(chosen.iter().zip(&matrices).zip(&solutions).map(cost).collect())
}
