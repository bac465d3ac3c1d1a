//! The part as a bent tube: how long, how thick, how bent, and whether it closes to a ring.
//!
//! Distances along the surface (shortest paths in a nearest-neighbour graph of the samples) do not change when a
//! handle is bent, so a straight temple and a curved mug handle get the same length and thickness.

use super::surface::{Point, Surface, principal};
use nalgebra::Matrix3;

/// Number of curve features.
pub const CURVE: usize = 11;
/// Samples in the graph: distances between all pairs of more would dominate the cost.
pub const GRAPH_SAMPLES: usize = 512;
/// Neighbours joined with each sample.
const NEIGHBOURS: usize = 8;
/// Slabs along the part.
const SLABS: usize = 10;
/// Lengths below this share of the part's are treated as it.
const SMALL: f64 = 1e-3;

/// Features of the tube through `points`.
pub fn curve(surface: &Surface) -> Vec<f64> {
    let step = surface.samples.len().div_ceil(GRAPH_SAMPLES);
    let points: Vec<Point> = surface.samples.iter().step_by(step).copied().collect();
    let neighbours = neighbours(&points);
    let start = farthest(&points.iter().map(Point::norm).collect::<Vec<_>>());
    let first = farthest(&shortest(&points, &neighbours, start));
    let along = shortest(&points, &neighbours, first);
    let last = farthest(&along);
    let length = along[last].max(SMALL);
    let reach = points.iter().map(|p| (p - points[first]).norm()).fold(SMALL, f64::max);

    let slabs: Vec<Vec<usize>> = {
        let mut slabs = vec![Vec::new(); SLABS];
        for (i, distance) in along.iter().enumerate() {
            slabs[((distance / length * SLABS as f64) as usize).min(SLABS - 1)].push(i);
        }
        slabs.into_iter().filter(|slab| !slab.is_empty()).collect()
    };
    let centres: Vec<Point> =
        slabs.iter().map(|slab| slab.iter().map(|&i| points[i]).sum::<Point>() / slab.len() as f64).collect();
    let spine: f64 = centres.windows(2).map(|pair| (pair[1] - pair[0]).norm()).sum();
    let mut radii = Vec::new();
    let mut flatness = Vec::new();
    for (slab, centre) in slabs.iter().zip(&centres) {
        let covariance = slab
            .iter()
            .map(|&i| (points[i] - centre) * (points[i] - centre).transpose())
            .sum::<Matrix3<f64>>()
            / slab.len() as f64;
        let (_, [a, b, _]) = principal(&covariance);
        radii.push(covariance.trace().max(0.0).sqrt());
        flatness.push(if a > 0.0 { b / a } else { 1.0 });
    }
    let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
    let radius = mean(&radii);
    let spread = (mean(&radii.iter().map(|r| (r - radius).powi(2)).collect::<Vec<_>>())).sqrt();
    let half = radii.len() / 2;
    let (head, tail) = (mean(&radii[..half.max(1)]), mean(&radii[half..]));
    let ends = (centres[0] - centres[centres.len() - 1]).norm();
    let share = 1.0 / slabs.len() as f64;
    let shares: Vec<f64> =
        slabs.iter().map(|slab| slab.len() as f64 / points.len() as f64 / share - 1.0).collect();
    let split: Vec<f64> = slabs.iter().map(|slab| split(slab, &neighbours)).collect();
    let quarter = (radii.len() / 4).max(1);
    let tips = 0.5 * (mean(&radii[..quarter]) + mean(&radii[radii.len() - quarter..]));
    let middle =
        mean(&radii[quarter.min(radii.len() - 1)..(radii.len() - quarter).max(quarter + 1).min(radii.len())]);
    radii.sort_by(f64::total_cmp);
    let second = 1.min(radii.len() - 1);
    vec![
        length.ln(),
        reach / length,
        (ends / spine.max(SMALL)).min(1.0),
        (radius / length).max(SMALL).ln(),
        spread / radius.max(SMALL),
        (head - tail).abs() / radius.max(SMALL),
        mean(&flatness),
        mean(&split),
        mean(&shares.iter().map(|x| x * x).collect::<Vec<_>>()).sqrt(),
        radii[second] / radii[radii.len() - 1 - second].max(SMALL),
        (tips.max(SMALL) / middle.max(SMALL)).ln(),
    ]
}

/// Index of the largest value; the first of equals.
fn farthest(values: &[f64]) -> usize {
    (0..values.len()).fold(0, |best, i| if values[i] > values[best] { i } else { best })
}

/// Symmetric nearest-neighbour lists, with shortest links added until the graph is connected.
fn neighbours(points: &[Point]) -> Vec<Vec<usize>> {
    let n = points.len();
    let mut lists = vec![Vec::new(); n];
    let mut near: Vec<(f64, usize)> = Vec::with_capacity(n);
    for i in 0..n {
        near.clear();
        near.extend((0..n).filter(|&j| j != i).map(|j| ((points[i] - points[j]).norm_squared(), j)));
        let k = NEIGHBOURS.min(near.len());
        if k < near.len() {
            near.select_nth_unstable_by(k, |a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        }
        for &(_, j) in &near[..k] {
            lists[i].push(j);
            lists[j].push(i);
        }
    }
    for list in &mut lists {
        list.sort_unstable();
        list.dedup();
    }
    connect(points, &mut lists);
    lists
}

/// Join every component to what is reached from sample 0 by the shortest link, nearest component first.
fn connect(points: &[Point], lists: &mut [Vec<usize>]) {
    let n = points.len();
    let mut reached = vec![false; n];
    let mut nearest = vec![(f64::INFINITY, 0); n];
    let mut fresh = vec![0];
    let mut count = 0;
    loop {
        while let Some(i) = fresh.pop() {
            if !std::mem::replace(&mut reached[i], true) {
                count += 1;
                fresh.extend(lists[i].iter().copied().filter(|&j| !reached[j]));
            }
        }
        if count == n {
            return;
        }
        // Few parts come here: only those whose samples fall into separate clusters.
        for i in (0..n).filter(|&i| !reached[i]) {
            nearest[i] = (0..n)
                .filter(|&j| reached[j])
                .map(|j| ((points[i] - points[j]).norm_squared(), j))
                .fold((f64::INFINITY, 0), |a, b| if b.0 < a.0 { b } else { a });
        }
        let next = (0..n).filter(|&i| !reached[i]).fold(None, |best: Option<usize>, i| match best {
            Some(b) if nearest[b].0 <= nearest[i].0 => Some(b),
            _ => Some(i),
        });
        let Some(next) = next else { return };
        lists[next].push(nearest[next].1);
        lists[nearest[next].1].push(next);
        fresh.push(next);
    }
}

/// Lengths of the shortest paths from one sample to all (Dijkstra on a dense front: n is a few hundred).
fn shortest(points: &[Point], neighbours: &[Vec<usize>], from: usize) -> Vec<f64> {
    let n = points.len();
    let mut distance = vec![f64::INFINITY; n];
    let mut open: Vec<usize> = vec![from];
    let mut done = vec![false; n];
    distance[from] = 0.0;
    while !open.is_empty() {
        let at = (0..open.len()).fold(0, |b, k| if distance[open[k]] < distance[open[b]] { k } else { b });
        let i = open.swap_remove(at);
        if std::mem::replace(&mut done[i], true) {
            continue;
        }
        for &j in &neighbours[i] {
            let through = distance[i] + (points[i] - points[j]).norm();
            if through < distance[j] {
                if distance[j].is_infinite() {
                    open.push(j);
                }
                distance[j] = through;
            }
        }
    }
    distance
}

/// Share of a slab outside its largest connected piece, doubled: 1 where a ring or a wall is cut twice.
fn split(slab: &[usize], neighbours: &[Vec<usize>]) -> f64 {
    let mut left: Vec<usize> = slab.to_vec();
    let mut largest = 0;
    while let Some(start) = left.pop() {
        let mut stack = vec![start];
        let mut size = 0;
        while let Some(i) = stack.pop() {
            size += 1;
            left.retain(|j| {
                let joined = neighbours[i].binary_search(j).is_ok();
                if joined {
                    stack.push(*j);
                }
                !joined
            });
        }
        largest = largest.max(size);
    }
    (2.0 * (slab.len() - largest) as f64 / slab.len() as f64).min(1.0)
}
