//! Distances along a part: shortest paths in a nearest-neighbour graph of its samples.

use super::surface::Point;
use std::cmp::Ordering;
use std::collections::BinaryHeap;

/// Neighbours joined with each sample.
const NEIGHBOURS: usize = 12;

/// Samples and their neighbours (ascending), with distances.
pub struct Graph {
    /// The samples.
    pub points: Vec<Point>,
    /// Symmetric: j is in i's list when i is in j's.
    pub links: Vec<Vec<(usize, f64)>>,
}

impl Graph {
    /// Join nearest neighbours, then add shortest links until the graph is connected.
    pub fn new(points: Vec<Point>) -> Self {
        let n = points.len();
        let mut links = vec![Vec::with_capacity(2 * NEIGHBOURS); n];
        let mut row = vec![0.0; n];
        for i in 0..n {
            for (distance, point) in row.iter_mut().zip(&points) {
                *distance = (points[i] - point).norm_squared();
            }
            row[i] = f64::INFINITY;
            let mut near = [(f64::INFINITY, usize::MAX); NEIGHBOURS];
            for (j, &distance) in row.iter().enumerate() {
                if distance < near[NEIGHBOURS - 1].0 {
                    let mut at = NEIGHBOURS - 1;
                    while at > 0 && near[at - 1].0 > distance {
                        near[at] = near[at - 1];
                        at -= 1;
                    }
                    near[at] = (distance, j);
                }
            }
            for &(distance, j) in near.iter().filter(|&&(_, j)| j != usize::MAX) {
                links[i].push((j, distance.sqrt()));
                links[j].push((i, distance.sqrt()));
            }
        }
        for list in &mut links {
            list.sort_unstable_by_key(|&(j, _)| j);
            list.dedup_by_key(|&mut (j, _)| j);
        }
        let mut graph = Self { points, links };
        graph.connect();
        graph
    }

    /// Join what is not yet reached from sample 0, nearest first.
    fn connect(&mut self) {
        let n = self.points.len();
        let mut reached = vec![false; n];
        let mut nearest = vec![(f64::INFINITY, 0); n];
        let mut fresh = vec![0];
        loop {
            let mut added = Vec::new();
            while let Some(i) = fresh.pop() {
                if !std::mem::replace(&mut reached[i], true) {
                    added.push(i);
                    fresh.extend(self.links[i].iter().map(|&(j, _)| j).filter(|&j| !reached[j]));
                }
            }
            let left: Vec<usize> = (0..n).filter(|&i| !reached[i]).collect();
            for &i in &left {
                for &j in &added {
                    let distance = (self.points[i] - self.points[j]).norm();
                    if distance < nearest[i].0 {
                        nearest[i] = (distance, j);
                    }
                }
            }
            let Some(&next) = left.iter().min_by(|&&i, &&j| nearest[i].0.total_cmp(&nearest[j].0)) else {
                return;
            };
            let (distance, other) = nearest[next];
            for (i, j) in [(next, other), (other, next)] {
                let at = self.links[i].partition_point(|&(k, _)| k < j);
                self.links[i].insert(at, (j, distance));
            }
            fresh.push(next);
        }
    }

    /// Lengths of the shortest paths from one sample to all (Dijkstra).
    pub fn distances(&self, from: usize) -> Vec<f64> {
        let mut distance = vec![f64::INFINITY; self.points.len()];
        distance[from] = 0.0;
        let mut front = BinaryHeap::from([Reached(0.0, from)]);
        while let Some(Reached(length, i)) = front.pop() {
            if length > distance[i] {
                continue;
            }
            for &(j, step) in &self.links[i] {
                if length + step < distance[j] {
                    distance[j] = length + step;
                    front.push(Reached(length + step, j));
                }
            }
        }
        distance
    }

    /// Size of the largest connected piece of some of the samples (ascending).
    pub fn largest_piece(&self, samples: &[usize]) -> usize {
        let mut seen = vec![false; samples.len()];
        let mut largest = 0;
        for start in 0..samples.len() {
            let mut stack = vec![start];
            let mut size = 0;
            while let Some(k) = stack.pop() {
                if !std::mem::replace(&mut seen[k], true) {
                    size += 1;
                    let joined = self.links[samples[k]].iter().filter_map(|(j, _)| samples.binary_search(j).ok());
                    stack.extend(joined.filter(|&at| !seen[at]));
                }
            }
            largest = largest.max(size);
        }
        largest
    }
}

/// A sample on Dijkstra's front: the nearest is the greatest, the first of equals.
#[derive(PartialEq)]
struct Reached(f64, usize);

impl Eq for Reached {}

impl Ord for Reached {
    fn cmp(&self, other: &Self) -> Ordering {
        other.0.total_cmp(&self.0).then(other.1.cmp(&self.1))
    }
}

impl PartialOrd for Reached {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}
