//! Shape distributions (Osada, Funkhouser, Chazelle, Dobkin 2002) as quantiles instead of bins.
//!
//! The Euclidean distance between two quantile functions is the Wasserstein distance of the histograms: it grows
//! smoothly with the change of shape, where bins jump.

use super::surface::{Point, Surface};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

/// Quantiles of each distribution.
pub const QUANTILES: usize = 8;
/// D1 (centre to point), D2 (pairs), D3 (triangle areas), A3 (angles).
pub const DISTRIBUTIONS: usize = 4 * QUANTILES;
/// Triples drawn for D3 and A3.
const TRIPLES: usize = 2048;

/// Quantiles of D1, D2, D3 and A3.
pub fn distributions(surface: &Surface, seed: u64) -> Vec<f64> {
    let mut random = Pcg64::seed_from_u64(seed);
    let mut d1: Vec<f64> = surface.samples.iter().map(Point::norm).collect();
    let mut d2 = Vec::with_capacity(2 * TRIPLES);
    let (mut d3, mut a3) = (Vec::with_capacity(TRIPLES), Vec::with_capacity(TRIPLES));
    let n = surface.samples.len();
    for _ in 0..TRIPLES {
        let [a, b, c] = [(); 3].map(|()| surface.samples[random.random_range(0..n)]);
        let (u, v) = (b - a, c - a);
        let cross = u.cross(&v).norm();
        d2.extend([u.norm(), v.norm()]);
        d3.push((0.5 * cross).sqrt());
        a3.push(cross.atan2(u.dot(&v)));
    }
    [&mut d1, &mut d2, &mut d3, &mut a3].into_iter().flat_map(|values| quantiles(values)).collect()
}

/// Values at the middles of equal shares of the sorted list.
fn quantiles(values: &mut [f64]) -> [f64; QUANTILES] {
    values.sort_unstable_by(f64::total_cmp);
    let step = values.len() as f64 / QUANTILES as f64;
    std::array::from_fn(|k| values[((k as f64 + 0.5) * step) as usize])
}
