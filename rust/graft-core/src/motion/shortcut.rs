//! Paths made shorter by cutting corners.

use rand::RngExt;
use rand_pcg::Pcg64;

use super::edges::edge_free;
use super::space::Space;

/// A shortcut must save this share of the path between its ends: rounding saves less.
const LEAST_SAVING: f64 = 1e-6;

/// Drop every vertex whose neighbours see each other; by the triangle inequality no path becomes longer.
pub fn prune<S: Space>(space: &S, path: &mut Vec<S::State>, clearance: f64, checks: &mut usize) {
    let mut at = 1;
    while at + 1 < path.len() {
        if edge_free(space, &path[at - 1], &path[at + 1], clearance, checks) {
            path.remove(at);
        } else {
            at += 1;
        }
    }
}

/// Try `attempts` random shortcuts between two places of the path, vertices or not; keep those that are free and shorter.
pub fn shortcut<S: Space>(
    space: &S,
    path: &mut Vec<S::State>,
    attempts: usize,
    clearance: f64,
    random: &mut Pcg64,
    checks: &mut usize,
) {
    for _ in 0..attempts {
        if path.len() < 3 {
            return;
        }
        let mut lengths = vec![0.0];
        for pair in path.windows(2) {
            lengths.push(lengths[lengths.len() - 1] + space.distance(&pair[0], &pair[1]));
        }
        let total = lengths[lengths.len() - 1];
        let (x, y) = (random.random::<f64>() * total, random.random::<f64>() * total);
        let (low, high) = (x.min(y), x.max(y));
        // Segment i runs from vertex i to i + 1.
        let segment = |at: f64| lengths.partition_point(|&l| l <= at).clamp(1, path.len() - 1) - 1;
        let (i, j) = (segment(low), segment(high));
        if i == j {
            continue;
        }
        let place = |k: usize, at: f64| {
            let length = lengths[k + 1] - lengths[k];
            let t = if length > 0.0 { ((at - lengths[k]) / length).clamp(0.0, 1.0) } else { 0.0 };
            space.between(&path[k], &path[k + 1], t)
        };
        let (a, b) = (place(i, low), place(j, high));
        let saved = (high - low) - space.distance(&a, &b);
        if saved > LEAST_SAVING * (high - low) && edge_free(space, &a, &b, clearance, checks) {
            path.splice(i + 1..=j, [a, b]);
        }
    }
}
