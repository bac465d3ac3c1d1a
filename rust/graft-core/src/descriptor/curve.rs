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
/// Nodes of the graph in which distances along the part are measured.
const NODES: usize = 256;
/// Ends looked from: each the farthest from those before it.
const ENDS: usize = 10;
/// How much less a nearer end counts: to this power of its reach along the surface.
const SHARPNESS: i32 = 8;
/// Lengths below this share of the part's size are treated as it.
const SMALL: f64 = 1e-3;

/// Features of the part as a tube.
pub fn curve(surface: &Surface) -> Vec<f64> {
    let (graph, nearest) = spread(&surface.samples);
    let tube = Tube::new(&surface.samples, &graph, &nearest);
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
        looks.push((length, tube.features(&along, length)));
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

/// Choose nodes spread evenly over the samples, each the farthest from those before it, and join neighbours.
///
/// Evenly spread nodes bridge the same gaps whatever the samples, which random ones do not. Also returns each sample's
/// nearest node.
fn spread(samples: &[Point]) -> (Graph, Vec<usize>) {
    let mut next = farthest(&samples.iter().map(Point::norm).collect::<Vec<_>>());
    let mut gaps = vec![f64::INFINITY; samples.len()];
    let mut nearest = vec![0; samples.len()];
    let mut nodes = Vec::with_capacity(NODES);
    while nodes.len() < NODES.min(samples.len()) {
        let node = samples[next];
        let number = nodes.len();
        nodes.push(node);
        let mut widest = (0, f64::NEG_INFINITY);
        for (i, (sample, gap)) in samples.iter().zip(&mut gaps).enumerate() {
            let distance = (sample - node).norm_squared();
            if distance < *gap {
                *gap = distance;
                nearest[i] = number;
            }
            if *gap > widest.1 {
                widest = (i, *gap);
            }
        }
        if widest.1 <= 0.0 {
            break;
        }
        next = widest.0;
    }
    (Graph::new(nodes), nearest)
}

/// Number, sum and sum of squares of points.
#[derive(Debug, Clone, Copy, Default)]
struct Heap {
    count: f64,
    first: Point,
    second: Matrix3<f64>,
}

impl Heap {
    fn add(&mut self, other: &Self, share: f64) {
        self.count += share * other.count;
        self.first += other.first * share;
        self.second += other.second * share;
    }

    fn covariance(&self) -> Matrix3<f64> {
        let centre = self.first / self.count;
        self.second / self.count - centre * centre.transpose()
    }
}

/// The samples, heaped up at their nearest nodes of the graph.
struct Tube<'a> {
    graph: &'a Graph,
    heaps: Vec<Heap>,
    total: f64,
}

impl<'a> Tube<'a> {
    fn new(samples: &[Point], graph: &'a Graph, nearest: &[usize]) -> Self {
        let mut heaps = vec![Heap::default(); graph.points.len()];
        for (sample, &node) in samples.iter().zip(nearest) {
            heaps[node].add(&Heap { count: 1.0, first: *sample, second: sample * sample.transpose() }, 1.0);
        }
        Self { graph, heaps, total: samples.len() as f64 }
    }

    /// Features of the tube; `along` are the distances of the nodes from its end, `length` the largest.
    fn features(&self, along: &[f64], length: f64) -> [f64; CURVE] {
        // A node's heap is shared between the two slabs whose middles it lies between: no node tips a slab over.
        let mut slabs = [Heap::default(); SLABS];
        let mut pieces = vec![Vec::new(); SLABS];
        for (i, (distance, heap)) in along.iter().zip(&self.heaps).enumerate() {
            let place = distance / length * SLABS as f64;
            pieces[(place as usize).min(SLABS - 1)].push(i);
            let place = (place - 0.5).clamp(0.0, (SLABS - 1) as f64);
            let low = (place as usize).min(SLABS - 2);
            let share = place - low as f64;
            slabs[low].add(heap, 1.0 - share);
            slabs[low + 1].add(heap, share);
        }
        let slabs: Vec<&Heap> = slabs.iter().filter(|slab| slab.count > 0.0).collect();
        pieces.retain(|nodes| !nodes.is_empty());
        let n = slabs.len();
        let (mut radii, mut flatness) = (Vec::with_capacity(n), Vec::with_capacity(n));
        for slab in &slabs {
            let covariance = slab.covariance();
            let (_, [a, b, _]) = principal(&covariance);
            radii.push(covariance.trace().max(0.0).sqrt());
            flatness.push(if a > 0.0 { b / a } else { 1.0 });
        }
        // 1 where a ring or the wall of a vessel is cut into two halves.
        let cut =
            |nodes: &Vec<usize>| (2.0 * (1.0 - self.graph.largest_piece(nodes) as f64 / nodes.len() as f64)).min(1.0);
        let split: Vec<f64> = pieces.iter().map(cut).collect();
        let uneven = slabs.iter().map(|slab| (slab.count / self.total * n as f64 - 1.0).powi(2));
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
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

/// Index of the largest value; the first of equals.
fn farthest(values: &[f64]) -> usize {
    (0..values.len()).fold(0, |best, i| if values[i] > values[best] { i } else { best })
}
