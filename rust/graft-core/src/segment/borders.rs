//! The borders of parts, drawn along creases: alpha-expansion (Boykov, Veksler, Zabih 2001) near where they are.
//!
//! An edge between parts costs its length, less where the surface is concave; an element that leaves its part costs
//! its area, more the farther it lies from the part that takes it, and what its thickness says for or against
//! it: the logarithms of the thickness in a part are a normal distribution, one component of the mixture of all.

use std::collections::BinaryHeap;

use super::Vec3;
use super::elements::Elements;
use super::flow::Network;
use super::measure::thickness;
use super::merge::Reach;
use super::patches::concavity;
use super::voxels::Voxels;

/// How far a border may move, in diagonals.
const BAND: f64 = 0.03;

/// The angle between normals over a hundredth of the diagonal at which a crease costs 1/e of a flat edge, radians.
const CREASE: f64 = 0.1;

/// Weight of the thickness.
const THICKNESS: f64 = 0.05;

/// The deviation of the logarithm of a part's thickness is at least this: half a voxel of a part four voxels thick.
const DEVIATION: f64 = 0.12;

/// Rounds over all parts; the second changes little, a third nothing.
const ROUNDS: usize = 2;

/// Where and what the borders are.
pub struct Borders<'a> {
    /// The surface.
    pub elements: &'a Elements,
    /// Smoothed normals.
    pub normals: &'a [Vec3],
    /// The solid.
    pub grid: &'a Voxels,
    /// Of the object, elements' unit.
    pub diagonal: f64,
    /// Component that each element belongs to; borders between two meaningful ones stay.
    pub groups: &'a [u32],
}

impl Borders<'_> {
    /// Move the borders of `labels`, 0 to `count` - 1; no label vanishes.
    #[must_use]
    pub fn refined(&self, labels: &[u32], count: usize) -> Vec<u32> {
        let mut current = labels.to_vec();
        if count < 2 {
            return current;
        }
        let reach: Vec<Vec<f64>> = (0..count).map(|part| self.reach(labels, part as u32)).collect();
        let logs: Vec<Option<f64>> = (0..labels.len())
            .map(|i| {
                let near = (0..count).any(|part| reach[part][i] > 0.0 && reach[part][i] <= BAND * self.diagonal);
                near.then(|| thickness(self.elements, i, self.grid).ln())
            })
            .collect();
        let normal = mixture(labels, &logs, count);
        for _ in 0..ROUNDS {
            for part in 0..count as u32 {
                self.expand(part, labels, &mut current, &reach, &logs, &normal);
            }
        }
        if (0..count as u32).all(|part| current.contains(&part)) { current } else { labels.to_vec() }
    }

    /// Geodesic distance of each element from a part, as far as the band reaches.
    fn reach(&self, labels: &[u32], part: u32) -> Vec<f64> {
        let mut far = vec![f64::INFINITY; labels.len()];
        let mut heap = BinaryHeap::new();
        for i in (0..labels.len()).filter(|&i| labels[i] == part) {
            far[i] = 0.0;
            if self.elements.edges_of(i).iter().any(|e| labels[e.to as usize] != part) {
                heap.push(Reach { cost: 0.0, place: i });
            }
        }
        while let Some(Reach { cost, place: i }) = heap.pop() {
            if cost > far[i] {
                continue;
            }
            for edge in self.elements.edges_of(i) {
                let (j, way) = (edge.to as usize, cost + edge.distance);
                if way < far[j] && way <= BAND * self.diagonal && self.groups[i] == self.groups[j] {
                    far[j] = way;
                    heap.push(Reach { cost: way, place: j });
                }
            }
        }
        far
    }

    fn price(&self, i: usize, j: usize, length: f64, distance: f64) -> f64 {
        let turn =
            concavity(self.elements, self.normals, i, j) * 0.01 * self.diagonal / distance.max(f64::MIN_POSITIVE);
        length / self.diagonal * (-turn / CREASE).exp()
    }

    fn expand(
        &self,
        part: u32,
        labels: &[u32],
        current: &mut [u32],
        reach: &[Vec<f64>],
        logs: &[Option<f64>],
        normal: &[(f64, f64)],
    ) {
        let nodes: Vec<usize> =
            (0..labels.len()).filter(|&i| current[i] != part && reach[part as usize][i].is_finite()).collect();
        if nodes.is_empty() {
            return;
        }
        let mut place = vec![usize::MAX; labels.len()];
        for (n, &i) in nodes.iter().enumerate() {
            place[i] = n;
        }
        let (source, sink) = (nodes.len(), nodes.len() + 1);
        let mut network = Network::new(nodes.len() + 2);
        let unary = |i: usize, label: u32| {
            let scale = self.elements.areas[i] / (BAND * self.diagonal * self.diagonal);
            let away = reach[label as usize][i] / (BAND * self.diagonal);
            let (mean, deviation) = normal[label as usize];
            let odd = logs[i].map_or(0.0, |log| ((log - mean) / deviation).powi(2) / 2.0 + deviation.ln());
            scale * (away + THICKNESS * odd)
        };
        for (n, &i) in nodes.iter().enumerate() {
            let (mut keep, mut take) = (unary(i, current[i]), unary(i, part));
            for edge in self.elements.edges_of(i) {
                let j = edge.to as usize;
                let price = self.price(i, j, edge.length, edge.distance);
                let m = place[j];
                if m == usize::MAX {
                    keep += if current[j] == current[i] { 0.0 } else { price };
                    take += if current[j] == part { 0.0 } else { price };
                } else if n < m {
                    if current[i] == current[j] {
                        network.connect(n, m, price, price);
                    } else {
                        // Apart unless both are taken (Kolmogorov and Zabih 2004): the later one pays to stay.
                        network.connect(n, m, price, 0.0);
                    }
                } else if current[i] != current[j] {
                    keep += price;
                }
            }
            // On the source's side an element stays, so that cutting the sink's arc pays for it.
            let low = keep.min(take);
            network.connect(source, n, take - low, 0.0);
            network.connect(n, sink, keep - low, 0.0);
        }
        let stays = network.source_side(source, sink);
        for (n, &i) in nodes.iter().enumerate() {
            if !stays[n] {
                current[i] = part;
            }
        }
    }
}

/// Mean and deviation of the logarithm of the thickness near the borders of each part.
fn mixture(labels: &[u32], logs: &[Option<f64>], count: usize) -> Vec<(f64, f64)> {
    let mut sums = vec![(0.0, 0.0, 0.0); count];
    for (&label, log) in labels.iter().zip(logs) {
        if let Some(log) = log {
            let sum = &mut sums[label as usize];
            *sum = (sum.0 + 1.0, sum.1 + log, sum.2 + log * log);
        }
    }
    sums.iter()
        .map(|&(n, sum, squares)| {
            let n = f64::max(n, 1.0);
            let mean = sum / n;
            (mean, (squares / n - mean * mean).max(DEVIATION * DEVIATION).sqrt())
        })
        .collect()
}
