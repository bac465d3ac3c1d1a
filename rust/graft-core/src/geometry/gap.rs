//! Exact distance between oriented boxes.

use super::Vec3;
use super::obb::OrientedBox;

/// Return the distance between two boxes; 0 when they touch or overlap.
///
/// Boxes without a separating axis (the 15 of Gottschalk 1996) overlap. Otherwise the closest pair of points is a corner
/// and a point of the other box, or lies on two edges.
#[must_use]
pub fn box_gap(a: &OrientedBox, b: &OrientedBox) -> f64 {
    if boxes_overlap(a, b) {
        return 0.0;
    }
    let (corners_a, corners_b) = (corners(a), corners(b));
    let mut nearest = f64::INFINITY;
    for p in &corners_a {
        nearest = nearest.min(point_distance_squared(b, p));
    }
    for p in &corners_b {
        nearest = nearest.min(point_distance_squared(a, p));
    }
    for (p, q) in edges() {
        for (r, s) in edges() {
            nearest =
                nearest.min(segment_distance_squared([&corners_a[p], &corners_a[q]], [&corners_b[r], &corners_b[s]]));
        }
    }
    nearest.sqrt()
}

/// Whether two boxes share a point.
#[must_use]
pub fn boxes_overlap(a: &OrientedBox, b: &OrientedBox) -> bool {
    !separated(a, b)
}

/// Corner k lies on the positive side of axis i when bit i of k is set.
fn corners(b: &OrientedBox) -> [Vec3; 8] {
    std::array::from_fn(|k| {
        (0..3)
            .fold(b.center, |p, i| p + b.axes[i] * if k >> i & 1 == 1 { b.half_extents[i] } else { -b.half_extents[i] })
    })
}

/// The 12 edges as pairs of corners that differ in one bit.
fn edges() -> impl Iterator<Item = (usize, usize)> {
    (0..8usize).flat_map(|k| (0..3).filter(move |i| k >> i & 1 == 0).map(move |i| (k, k | 1 << i)))
}

fn separated(a: &OrientedBox, b: &OrientedBox) -> bool {
    let offset = b.center - a.center;
    let splits = |axis: Vec3| {
        let reach = |x: &OrientedBox| -> f64 { (0..3).map(|i| x.half_extents[i] * x.axes[i].dot(&axis).abs()).sum() };
        offset.dot(&axis).abs() > reach(a) + reach(b)
    };
    a.axes.iter().chain(&b.axes).any(|x| splits(*x))
        || a.axes.iter().any(|x| {
            b.axes.iter().any(|y| {
                // Almost parallel axes give a direction of rounding errors; the face axes decide those.
                x.cross(y).try_normalize(1e-8).is_some_and(splits)
            })
        })
}

fn point_distance_squared(b: &OrientedBox, point: &Vec3) -> f64 {
    let offset = point - b.center;
    (0..3).map(|i| (offset.dot(&b.axes[i]).abs() - b.half_extents[i]).max(0.0).powi(2)).sum()
}

/// Squared distance of segments (Ericson, Real-Time Collision Detection, 5.1.9).
fn segment_distance_squared([p, p_end]: [&Vec3; 2], [q, q_end]: [&Vec3; 2]) -> f64 {
    let (d, e, r) = (p_end - p, q_end - q, p - q);
    let (dd, ee, de) = (d.norm_squared(), e.norm_squared(), d.dot(&e));
    let (dr, er) = (d.dot(&r), e.dot(&r));
    let denominator = dd * ee - de * de;
    let mut s = if denominator > 1e-14 * dd * ee { ((de * er - dr * ee) / denominator).clamp(0.0, 1.0) } else { 0.0 };
    let mut t = if ee > 0.0 { (de * s + er) / ee } else { 0.0 };
    if !(0.0..=1.0).contains(&t) {
        t = t.clamp(0.0, 1.0);
        s = if dd > 0.0 { ((de * t - dr) / dd).clamp(0.0, 1.0) } else { 0.0 };
    }
    (r + d * s - e * t).norm_squared()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cube(x: f64, y: f64, z: f64) -> OrientedBox {
        OrientedBox { center: Vec3::new(x, y, z), axes: [Vec3::x(), Vec3::y(), Vec3::z()], half_extents: [1.0; 3] }
    }

    fn turned(mut b: OrientedBox, turn: Vec3) -> OrientedBox {
        b.axes = b.axes.map(|a| nalgebra::Rotation3::new(turn) * a);
        b
    }

    #[test]
    fn face_edge_and_corner_distances_have_closed_forms() {
        assert!((box_gap(&cube(0., 0., 0.), &cube(3., 0.5, 0.)) - 1.0).abs() < 1e-12);
        assert!((box_gap(&cube(0., 0., 0.), &cube(3., 3., 0.)) - 2f64.sqrt()).abs() < 1e-12);
        assert!((box_gap(&cube(0., 0., 0.), &cube(3., 3., 3.)) - 3f64.sqrt()).abs() < 1e-12);
        // A cube turned by 45 degrees points an edge at the other's face.
        let edge_on = turned(cube(4., 0., 0.), Vec3::z() * std::f64::consts::FRAC_PI_4);
        assert!((box_gap(&cube(0., 0., 0.), &edge_on) - (3.0 - 2f64.sqrt())).abs() < 1e-12);
    }

    #[test]
    fn crossed_edges_are_closest_in_their_middle() {
        // Both cubes on edge, the edges at right angles.
        let below = turned(cube(0., 0., 0.), Vec3::x() * std::f64::consts::FRAC_PI_4);
        let above = turned(cube(0., 0., 4.), Vec3::y() * std::f64::consts::FRAC_PI_4);
        assert!((box_gap(&below, &above) - (4.0 - 2.0 * 2f64.sqrt())).abs() < 1e-12);
    }

    #[test]
    fn boxes_inside_or_touching_have_no_gap() {
        let mut small = cube(0.2, 0.1, 0.0);
        small.half_extents = [0.1; 3];
        assert!(box_gap(&cube(0., 0., 0.), &small) <= 0.0);
        assert!(box_gap(&cube(0., 0., 0.), &cube(2., 0., 0.)) < 1e-12);
    }
}
