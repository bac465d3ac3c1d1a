//! Nearest points: a static k-d tree over a part's surface samples.

/// Points below which a node is searched one by one; at 8 a tree of 1024 samples is seven levels deep.
const LEAF: usize = 8;

/// A balanced k-d tree, stored as one permuted list: the median of every range splits it.
#[derive(Debug)]
pub struct Nearest {
    points: Vec<[f64; 3]>,
    axes: Vec<u8>,
}

impl Nearest {
    /// Build the tree; splits the widest axis, ties to the first.
    #[must_use]
    pub fn new(points: &[[f64; 3]]) -> Self {
        let mut tree = Self { points: points.to_vec(), axes: vec![0; points.len()] };
        tree.split(0, points.len());
        tree
    }

    fn split(&mut self, low: usize, high: usize) {
        if high - low <= LEAF {
            return;
        }
        let mut spread = [0.0; 3];
        for (axis, width) in spread.iter_mut().enumerate() {
            let (mut least, mut most) = (f64::INFINITY, f64::NEG_INFINITY);
            for p in &self.points[low..high] {
                least = least.min(p[axis]);
                most = most.max(p[axis]);
            }
            *width = most - least;
        }
        let mut axis = 0;
        for candidate in 1..3 {
            if spread[candidate] > spread[axis] {
                axis = candidate;
            }
        }
        let middle = usize::midpoint(low, high);
        self.points[low..high].select_nth_unstable_by(middle - low, |a, b| a[axis].total_cmp(&b[axis]));
        self.axes[middle] = axis as u8;
        self.split(low, middle);
        self.split(middle + 1, high);
    }

    /// Return the squared distance from `query` to the nearest point, or `bound` when none is nearer than that.
    #[must_use]
    pub fn squared_distance(&self, query: &[f64; 3], bound: f64) -> f64 {
        self.search(query, 0, self.points.len(), bound)
    }

    fn search(&self, query: &[f64; 3], low: usize, high: usize, mut best: f64) -> f64 {
        if high - low <= LEAF {
            for p in &self.points[low..high] {
                best = best.min(squared(p, query));
            }
            return best;
        }
        let middle = usize::midpoint(low, high);
        best = best.min(squared(&self.points[middle], query));
        let axis = usize::from(self.axes[middle]);
        let offset = query[axis] - self.points[middle][axis];
        let (near, far) =
            if offset < 0.0 { ((low, middle), (middle + 1, high)) } else { ((middle + 1, high), (low, middle)) };
        best = self.search(query, near.0, near.1, best);
        if offset * offset < best {
            best = self.search(query, far.0, far.1, best);
        }
        best
    }
}

fn squared(a: &[f64; 3], b: &[f64; 3]) -> f64 {
    let d = [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
    d[0] * d[0] + d[1] * d[1] + d[2] * d[2]
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn agrees_with_trying_all(
            points in prop::collection::vec(prop::array::uniform3(-1.0..1.0_f64), 1..200),
            query in prop::array::uniform3(-2.0..2.0_f64),
        ) {
            let all = points.iter().map(|p| squared(p, &query)).fold(f64::INFINITY, f64::min);
            let tree = Nearest::new(&points);
            prop_assert_eq!(tree.squared_distance(&query, f64::INFINITY).to_bits(), all.to_bits());
            prop_assert_eq!(tree.squared_distance(&query, all / 2.0).to_bits(), (all / 2.0).to_bits());
        }
    }

    #[test]
    fn many_equal_points_and_none() {
        let tree = Nearest::new(&[[1.0, 2.0, 3.0]; 100]);
        assert_eq!(tree.squared_distance(&[1.0, 2.0, 5.0], f64::INFINITY).to_bits(), 4.0_f64.to_bits());
        assert_eq!(Nearest::new(&[]).squared_distance(&[0.0; 3], 7.0).to_bits(), 7.0_f64.to_bits());
    }
}
