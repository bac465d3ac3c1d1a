//! The part as a bent tube: how thin, how even, how flat, and whether it closes to a ring.
//!
//! Distances along the surface do not change when a handle is bent, so a straight temple and a curved mug handle get
//! the same thickness. How bent the part is does not enter: it tells handles of different objects apart. The tube is cut into slabs by the distance from one of its ends; which end is
//! arbitrary on a round part, so the features are averages over several, the farthest counting most.

use super::graph::Graph;
use super::surface::{Point, Surface, principal};
use nalgebra::Matrix3;

/// Number of curve features.
pub const CURVE: usize = 8;
/// Slabs along the part.
const SLABS: usize = 8;
/// Ends looked from: each the farthest from those before it.
const ENDS: usize = 6;
/// How much less a nearer end counts: to this power of its reach along the surface.
const SHARPNESS: i32 = 12;
/// Lengths below this share of the part's size are treated as it.
const SMALL: f64 = 1e-3;

/// Features of the part as a tube.
pub fn curve(surface: &Surface) -> Vec<f64> {
    let graph = Graph::new(surface.few.clone());
    let start = farthest(&graph.points.iter().map(Point::norm).collect::<Vec<_>>());
    let mut end = farthest(&graph.distances(start));
    let mut nearest = vec![f64::INFINITY; graph.points.len()];
    let mut looks = Vec::with_capacity(ENDS);
    for _ in 0..ENDS {
        let along = graph.distances(end);
        for (near, distance) in nearest.iter_mut().zip(&along) {
            *near = near.min(*distance);
        }
        let length = along[farthest(&along)].max(SMALL);
        looks.push((length, features(&graph, &along, length)));
        end = farthest(&nearest);
    }
    let longest = looks.iter().map(|look| look.0).fold(SMALL, f64::max);
    let mut total = 0.0;
    let mut sums = [0.0; CURVE];
    for (length, features) in &looks {
        let weight = (length / longest).powi(SHARPNESS);
        total += weight;
        for (sum, feature) in sums.iter_mut().zip(features) {
            *sum += weight * feature;
        }
    }
    sums.iter().map(|sum| sum / total).collect()
}

/// Features of the tube; `along` are the distances from its end, `length` the largest.
fn features(graph: &Graph, along: &[f64], length: f64) -> [f64; CURVE] {
    let points = &graph.points;
    let mut slabs = vec![Vec::new(); SLABS];
    for (i, distance) in along.iter().enumerate() {
        slabs[((distance / length * SLABS as f64) as usize).min(SLABS - 1)].push(i);
    }
    slabs.retain(|slab| !slab.is_empty());
    let n = slabs.len();
    let (mut radii, mut flatness, mut split) = (Vec::with_capacity(n), Vec::with_capacity(n), Vec::with_capacity(n));
    for slab in &slabs {
        let size = slab.len() as f64;
        let centre = slab.iter().map(|&i| points[i]).sum::<Point>() / size;
        let offsets = slab.iter().map(|&i| points[i] - centre);
        let covariance = offsets.map(|p| p * p.transpose()).sum::<Matrix3<f64>>() / size;
        let (_, [a, b, _]) = principal(&covariance);
        radii.push(covariance.trace().max(0.0).sqrt());
        flatness.push(if a > 0.0 { b / a } else { 1.0 });
        // 1 where a ring or the wall of a vessel is cut into two halves.
        split.push((2.0 * (1.0 - graph.largest_piece(slab) as f64 / size)).min(1.0));
    }
    let uneven = slabs.iter().map(|slab| (slab.len() as f64 / points.len() as f64 * n as f64 - 1.0).powi(2));
    let uneven = (uneven.sum::<f64>() / n as f64).sqrt();
    let radius = mean(&radii);
    let spread = mean(&radii.iter().map(|r| (r - radius).powi(2)).collect::<Vec<_>>()).sqrt();
    let half = (n / 2).max(1);
    let taper = (mean(&radii[..half]) - mean(&radii[n - half..])).abs();
    let quarter = (n / 4).max(1);
    let tips = 0.5 * (mean(&radii[..quarter]) + mean(&radii[n - quarter..]));
    let middle = if n > 2 * quarter { mean(&radii[quarter..n - quarter]) } else { radius };
    radii.sort_by(f64::total_cmp);
    let second = usize::from(n > 2);
    [
        (radius / length).max(SMALL).ln(),
        spread / radius.max(SMALL),
        taper / radius.max(SMALL),
        mean(&flatness),
        mean(&split),
        uneven,
        radii[second] / radii[n - 1 - second].max(SMALL),
        (tips.max(SMALL) / middle.max(SMALL)).ln(),
    ]
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

/// Index of the largest value; the first of equals.
fn farthest(values: &[f64]) -> usize {
    (0..values.len()).fold(0, |best, i| if values[i] > values[best] { i } else { best })
}
