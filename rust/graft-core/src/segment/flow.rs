//! Minimum cuts of small graphs: Dinic's maximum flow (1970).

/// Flows below this share of the largest capacity are rounding.
const ROUNDING: f64 = 1e-12;

#[derive(Debug, Clone, Copy)]
struct Arc {
    to: usize,
    left: f64,
}

/// A directed graph with a source and a sink; arcs come in pairs, there and back.
#[derive(Debug, Clone)]
pub struct Network {
    arcs: Vec<Arc>,
    out: Vec<Vec<usize>>,
    level: Vec<usize>,
    next: Vec<usize>,
    least: f64,
}

impl Network {
    /// A graph of `nodes` nodes, the source and the sink among them.
    #[must_use]
    pub fn new(nodes: usize) -> Self {
        Self { arcs: Vec::new(), out: vec![Vec::new(); nodes], level: Vec::new(), next: Vec::new(), least: 0.0 }
    }

    /// Add an arc, with the capacities there and back.
    pub fn connect(&mut self, from: usize, to: usize, there: f64, back: f64) {
        self.out[from].push(self.arcs.len());
        self.arcs.push(Arc { to, left: there });
        self.out[to].push(self.arcs.len());
        self.arcs.push(Arc { to: from, left: back });
        self.least = self.least.max(ROUNDING * there.max(back));
    }

    /// Return for each node whether it is on the source's side of the minimum cut.
    #[must_use]
    pub fn source_side(mut self, source: usize, sink: usize) -> Vec<bool> {
        loop {
            self.rank(source);
            if self.level[sink] == usize::MAX {
                return self.level.iter().map(|&l| l != usize::MAX).collect();
            }
            self.next = vec![0; self.out.len()];
            while self.augment(source, sink) {}
        }
    }

    /// Rank nodes by how many arcs with capacity left lead to them.
    fn rank(&mut self, source: usize) {
        self.level = vec![usize::MAX; self.out.len()];
        self.level[source] = 0;
        let mut queue = vec![source];
        let mut at = 0;
        while at < queue.len() {
            let node = queue[at];
            at += 1;
            for &a in &self.out[node] {
                let Arc { to, left } = self.arcs[a];
                if left > self.least && self.level[to] == usize::MAX {
                    self.level[to] = self.level[node] + 1;
                    queue.push(to);
                }
            }
        }
    }

    /// Push flow along one path of rising rank; false when there is none left.
    fn augment(&mut self, source: usize, sink: usize) -> bool {
        let mut path: Vec<usize> = Vec::new();
        let mut node = source;
        while node != sink {
            let found = loop {
                let Some(&a) = self.out[node].get(self.next[node]) else { break None };
                let Arc { to, left } = self.arcs[a];
                if left > self.least && self.level[to] == self.level[node] + 1 {
                    break Some(a);
                }
                self.next[node] += 1;
            };
            if let Some(a) = found {
                path.push(a);
                node = self.arcs[a].to;
            } else if let Some(a) = path.pop() {
                // A dead end: go back and never try this arc again in this phase.
                node = self.arcs[a ^ 1].to;
                self.next[node] += 1;
            } else {
                return false;
            }
        }
        let flow = path.iter().map(|&a| self.arcs[a].left).fold(f64::INFINITY, f64::min);
        for a in path {
            self.arcs[a].left -= flow;
            self.arcs[a ^ 1].left += flow;
        }
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// The value of the cut that a side makes.
    fn value(arcs: &[(usize, usize, f64)], side: &[bool]) -> f64 {
        arcs.iter().filter(|(a, b, _)| side[*a] && !side[*b]).map(|x| x.2).sum()
    }

    proptest! {
        #[test]
        fn no_cut_is_cheaper(arcs in prop::collection::vec((0_usize..7, 0_usize..7, 0.0_f64..1.0), 0..24)) {
            let mut network = Network::new(7);
            for &(a, b, c) in &arcs {
                network.connect(a, b, c, 0.0);
            }
            let found = value(&arcs, &network.source_side(0, 6));
            for mask in 0_u32..32 {
                let side: Vec<bool> = (0..7).map(|n| n == 0 || (n < 6 && mask >> (n - 1) & 1 == 1)).collect();
                prop_assert!(found <= value(&arcs, &side) + 1e-9);
            }
        }
    }
}
