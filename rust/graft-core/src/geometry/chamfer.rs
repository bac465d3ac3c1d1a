//! The chamfer distance of small point sets, many candidates against one cloud.

/// Neighbours handled together, so that minima run in vector registers.
const LANES: usize = 8;

/// Half the sum of the mean nearest distances from `cloud` to each candidate and back.
///
/// `cloud` is (a, 3) and `candidates` (k, b, 3), row-major, a and b positive; k numbers come back.
#[must_use]
pub fn chamfer(cloud: &[f64], candidates: &[f64], b: usize) -> Vec<f64> {
    let blocks = b.div_ceil(LANES);
    // Padding lies at infinity: nobody's nearest neighbour.
    let mut coordinates = vec![[[f64::INFINITY; LANES]; 3]; blocks];
    let mut back = vec![[f64::INFINITY; LANES]; blocks];
    let mut found = Vec::with_capacity(candidates.len() / (3 * b));
    for candidate in candidates.chunks_exact(3 * b) {
        for (j, point) in candidate.chunks_exact(3).enumerate() {
            for (axis, &value) in point.iter().enumerate() {
                coordinates[j / LANES][axis][j % LANES] = value;
            }
        }
        back.fill([f64::INFINITY; LANES]);
        let mut there = 0.0;
        for point in cloud.chunks_exact(3) {
            there += nearest([point[0], point[1], point[2]], &coordinates, &mut back).sqrt();
        }
        let home: f64 = back.iter().flatten().take(b).map(|squared| squared.sqrt()).sum();
        found.push(there.mul_add(3.0 / length(cloud.len()), home / length(b)) / 2.0);
    }
    found
}

/// Return the squared distance of `point` to the nearest of the others, and lower each one's own minimum.
fn nearest(point: [f64; 3], others: &[[[f64; LANES]; 3]], back: &mut [[f64; LANES]]) -> f64 {
    let mut least = [f64::INFINITY; LANES];
    for ([xs, ys, zs], minima) in others.iter().zip(back) {
        for lane in 0..LANES {
            let (dx, dy, dz) = (xs[lane] - point[0], ys[lane] - point[1], zs[lane] - point[2]);
            let squared = dx * dx + dy * dy + dz * dz;
            // Comparisons, not f64::min: they are one instruction.
            least[lane] = if squared < least[lane] { squared } else { least[lane] };
            minima[lane] = if squared < minima[lane] { squared } else { minima[lane] };
        }
    }
    least.into_iter().fold(f64::INFINITY, f64::min)
}

/// A count as a number.
#[allow(clippy::cast_precision_loss)]
fn length(count: usize) -> f64 {
    count as f64
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn brute(from: &[f64], to: &[f64]) -> f64 {
        let distance = |p: &[f64], q: &[f64]| p.iter().zip(q).map(|(x, y)| (x - y).powi(2)).sum::<f64>().sqrt();
        let nearest = |p: &[f64]| to.chunks_exact(3).map(|q| distance(p, q)).fold(f64::INFINITY, f64::min);
        from.chunks_exact(3).map(nearest).sum::<f64>() / length(from.len() / 3)
    }

    fn cloud(most: usize) -> impl Strategy<Value = Vec<f64>> {
        prop::collection::vec(prop::array::uniform3(-2.0..2.0f64), 1..most).prop_map(|points| points.concat())
    }

    proptest! {
        #[test]
        fn agrees_with_brute_force(a in cloud(20), b in cloud(20)) {
            let twice = [b.clone(), b.iter().map(|x| x + 0.5).collect()].concat();
            let found = chamfer(&a, &twice, b.len() / 3);
            prop_assert_eq!(found.len(), 2);
            for (value, other) in found.iter().zip(twice.chunks_exact(b.len())) {
                prop_assert!((value - f64::midpoint(brute(&a, other), brute(other, &a))).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn a_cloud_is_at_no_distance_from_itself() {
        let points: Vec<f64> = (0..33).map(|i| f64::from(i * i)).collect();
        assert_eq!(chamfer(&points, &points, 11), [0.0]);
    }
}
