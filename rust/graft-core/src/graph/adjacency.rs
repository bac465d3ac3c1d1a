//! Which parts touch, and how many steps lie between them.

use std::collections::VecDeque;

/// Return the (n, n) row-major adjacency: the joints; then pairs with a gap of at most `threshold` of which one part has no
/// joint at all (a format may joint two bodies of several pieces each); then components are connected by their smallest
/// gaps (Kruskal; ties go to the lower indices).
#[must_use]
pub fn adjacency(n: usize, gaps: &[f64], joints: &[(usize, usize)], threshold: f64) -> Vec<bool> {
    let mut edges = vec![false; n * n];
    let mut component: Vec<usize> = (0..n).collect();
    let mut join = |i: usize, j: usize, component: &mut Vec<usize>| {
        edges[i * n + j] = true;
        edges[j * n + i] = true;
        let (keep, drop) = (component[i].min(component[j]), component[i].max(component[j]));
        for c in component.iter_mut().filter(|c| **c == drop) {
            *c = keep;
        }
    };
    let mut pairs: Vec<(usize, usize)> = (0..n).flat_map(|i| (i + 1..n).map(move |j| (i, j))).collect();
    pairs.sort_by(|&(a, b), &(c, d)| gaps[a * n + b].total_cmp(&gaps[c * n + d]));
    for &(i, j) in joints.iter().filter(|(i, j)| i != j) {
        join(i, j, &mut component);
    }
    let jointed = |part: usize| joints.iter().any(|&(i, j)| i != j && (i == part || j == part));
    for (i, j) in pairs {
        let touching = !(jointed(i) && jointed(j)) && gaps[i * n + j] <= threshold;
        if touching || component[i] != component[j] {
            join(i, j, &mut component);
        }
    }
    edges
}

/// Return each part's number of steps from `start`, breadth first; `n` where there is no way.
#[must_use]
pub fn hops(n: usize, adjacency: &[bool], start: usize) -> Vec<usize> {
    let mut steps = vec![n; n];
    steps[start] = 0;
    let mut queue = VecDeque::from([start]);
    while let Some(i) = queue.pop_front() {
        for j in 0..n {
            if adjacency[i * n + j] && steps[j] == n && j != start {
                steps[j] = steps[i] + 1;
                queue.push_back(j);
            }
        }
    }
    steps
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn joints_win_and_the_rest_is_connected_by_its_smallest_gap() {
        // 0 and 1 touch, 3 is loose and nearest to 0.
        let mut gaps = vec![0.9; 16];
        let mut set = |i: usize, j: usize, g: f64| (gaps[i * 4 + j], gaps[j * 4 + i]) = (g, g);
        set(0, 1, 0.0);
        set(0, 3, 0.3);
        set(2, 3, 0.5);
        let free = adjacency(4, &gaps, &[], 0.02);
        let edges = |a: &[bool]| -> Vec<(usize, usize)> {
            (0..16).filter(|k| a[*k] && k / 4 < k % 4).map(|k| (k / 4, k % 4)).collect()
        };
        assert_eq!(edges(&free), [(0, 1), (0, 3), (2, 3)]);
        // 2 hangs off 1 by a joint; 0 has none and counts as touching 1.
        assert_eq!(edges(&adjacency(4, &gaps, &[(2, 1)], 0.02)), [(0, 1), (0, 3), (1, 2)]);
        // Jointed parts do not touch beside their joints: 0 and 1 hang off 2.
        assert_eq!(edges(&adjacency(4, &gaps, &[(2, 1), (2, 0)], 0.02)), [(0, 2), (0, 3), (1, 2)]);
    }

    #[test]
    fn hops_count_edges() {
        let mut chain = vec![false; 9];
        for (i, j) in [(0, 1), (1, 0), (1, 2), (2, 1)] {
            chain[i * 3 + j] = true;
        }
        assert_eq!(hops(3, &chain, 2), [2, 1, 0]);
    }
}
