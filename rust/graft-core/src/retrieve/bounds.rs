//! A lower bound of every graph's ranking cost, in single precision, from features alone.
//!
//! Whatever the plan and the target masses, row i of a plan pays at least the least feature cost of its row for the
//! mass u_i that it sends, and tau_s KL(u_i | mu_i) for sending no more: at best
//! tau_s mu_i (1 - exp(-alpha min_j M_ij / tau_s)). Structure, target marginal and entropy are not negative. The
//! demonstrated part p adds at least `part_weight` min_j M_pj, the doubt about it nothing.
//!
//! tanh(d / 2) is bounded below by d / sqrt(4 + d^2); rounding is paid for by [`Query::rounding`].

// As in the lanes' kernel.
#![allow(clippy::inline_always)]

use rayon::prelude::*;

use crate::transport::lanes::dispatch::{self, Instructions, Kernel};
use crate::transport::lanes::kernel::apart;
use crate::transport::lanes::vector::{F32x32, Vector};

/// Parts side by side.
pub const LANES: usize = F32x32::LANES;

/// Blocks of parts that one task bounds: 2 MB of 64-d features.
const TASK: usize = 256;

/// What all bounds of one query share.
#[derive(Debug)]
pub struct Query {
    /// Half extents of the target's parts (m x 3).
    pub extents: Vec<f32>,
    /// Their features, weighted (m x dim).
    pub features: Vec<f32>,
    /// Numbers of a part's features.
    pub dim: usize,
    /// Feature cost of a pair with equal boxes and no product of features.
    pub constant: f32,
    /// Weight of the boxes.
    pub lambda_obb: f32,
    /// Weight of the features.
    pub alpha: f32,
    /// Price of the source's marginal.
    pub tau_s: f32,
}

impl Query {
    /// Largest rounding of a feature cost: dim products and sums of numbers whose total is at most `constant`, each
    /// factor rounded once, and a few operations on the boxes.
    fn rounding(&self) -> f32 {
        (self.dim + 16) as f32 * f32::EPSILON * (self.constant + self.lambda_obb)
    }
}

struct Blocks<'a> {
    query: &'a Query,
    // Lanes of parts: (blocks x 3), (blocks x dim), (blocks).
    extents: &'a [[f32; LANES]],
    features: &'a [[f32; LANES]],
    masses: &'a [[f32; LANES]],
    least: &'a mut [[f32; LANES]],
    shares: &'a mut [[f32; LANES]],
}

impl Kernel for Blocks<'_> {
    #[inline(always)]
    fn run(self) {
        for b in 0..self.masses.len() {
            let extents = &self.extents[3 * b..3 * b + 3];
            let features = &self.features[self.query.dim * b..self.query.dim * (b + 1)];
            let least = least_costs(self.query, extents, features);
            let share = shares(self.query, least, F32x32(self.masses[b]));
            self.least[b] = least.0;
            self.shares[b] = share.0;
        }
    }
}

/// min_j M_ij of the block's parts i, rounded down.
#[inline(always)]
fn least_costs(query: &Query, extents: &[[f32; LANES]], features: &[[f32; LANES]]) -> F32x32 {
    let splat = |x: f32| F32x32([x; LANES]);
    let (zero, dim) = (splat(0.0), query.dim);
    let parts = query.extents.len() / 3;
    let mut most = splat(f32::MIN);
    let mut j = 0;
    while j < parts {
        // Four of the target's parts at once; the last ones again where four do not divide them.
        let at = [j, (j + 1).min(parts - 1), (j + 2).min(parts - 1), (j + 3).min(parts - 1)];
        let rows = [
            &query.features[at[0] * dim..(at[0] + 1) * dim],
            &query.features[at[1] * dim..(at[1] + 1) * dim],
            &query.features[at[2] * dim..(at[2] + 1) * dim],
            &query.features[at[3] * dim..(at[3] + 1) * dim],
        ];
        let (mut s0, mut s1, mut s2, mut s3) = (zero, zero, zero, zero);
        for d in 0..dim {
            apart();
            let x = F32x32(features[d]);
            s0 = s0 + x * splat(rows[0][d]);
            s1 = s1 + x * splat(rows[1][d]);
            s2 = s2 + x * splat(rows[2][d]);
            s3 = s3 + x * splat(rows[3][d]);
        }
        let products = [s0, s1, s2, s3];
        for c in 0..4 {
            apart();
            let mut square = zero;
            for e in 0..3 {
                let gap = F32x32(extents[e]) - splat(query.extents[3 * at[c] + e]);
                square = square + gap * gap;
            }
            let boxes = (square / (splat(4.0) + square)).sqrt();
            most = most.max(products[c] - splat(query.lambda_obb) * boxes);
        }
        j += 4;
    }
    (splat(query.constant - query.rounding()) - most).max(zero)
}

/// tau_s mu (1 - exp(-alpha c / tau_s)) of the block's parts.
#[inline(always)]
fn shares(query: &Query, least: F32x32, mass: F32x32) -> F32x32 {
    let splat = |x: f32| F32x32([x; LANES]);
    if query.tau_s.is_infinite() {
        return splat(query.alpha) * mass * least;
    }
    if query.tau_s == 0.0 {
        return splat(0.0);
    }
    let kept = (splat(-query.alpha / query.tau_s) * least).exp();
    splat(query.tau_s) * mass * (splat(1.0) - kept)
}

/// Bound every part: its least feature cost, and what its row pays at least.
///
/// `extents`, `features` and `masses` hold blocks of [`LANES`] parts side by side: 3, `query.dim` and 1 rows a block.
#[must_use]
pub fn bound_parts(
    query: &Query,
    extents: &[f32],
    features: &[f32],
    masses: &[f32],
    with: Instructions,
) -> (Vec<f32>, Vec<f32>) {
    let (extents, features, masses) = (extents.as_chunks().0, features.as_chunks().0, masses.as_chunks().0);
    let mut least = vec![[0.0; LANES]; masses.len()];
    let mut shares = vec![[0.0; LANES]; masses.len()];
    least.par_chunks_mut(TASK).zip(shares.par_chunks_mut(TASK)).enumerate().for_each(|(task, (least, shares))| {
        let (from, to) = (task * TASK, task * TASK + least.len());
        let blocks = Blocks {
            query,
            extents: &extents[3 * from..3 * to],
            features: &features[query.dim * from..query.dim * to],
            masses: &masses[from..to],
            least,
            shares,
        };
        dispatch::run(blocks, with);
    });
    (least.into_flattened(), shares.into_flattened())
}
