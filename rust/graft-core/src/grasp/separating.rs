//! Whether a box meets a triangle or a ball: exact tests. Touching counts as meeting.

use crate::geometry::{OrientedBox, Vec3};

/// Whether a box meets a triangle, by the thirteen separating axes (Akenine-Möller 2001): the box's three, the
/// triangle's normal, and the products of their edges. Segments and points, as degenerate triangles are, come out right.
#[must_use]
pub fn meets_triangle(given: &OrientedBox, corners: &[Vec3; 3]) -> bool {
    let h = &given.half_extents;
    let [a, b, c] = corners.map(|p| {
        let from = p - given.center;
        Vec3::new(from.dot(&given.axes[0]), from.dot(&given.axes[1]), from.dot(&given.axes[2]))
    });
    for k in 0..3 {
        if a[k].min(b[k]).min(c[k]) > h[k] || a[k].max(b[k]).max(c[k]) < -h[k] {
            return false;
        }
    }
    let edges = [b - a, c - b, a - c];
    let normal = edges[0].cross(&edges[1]);
    if normal.dot(&a).abs() > h[0] * normal.x.abs() + h[1] * normal.y.abs() + h[2] * normal.z.abs() {
        return false;
    }
    // e_k x edge for each axis k: two corners share a projection (the edge's ends), the third is opposite it.
    let spans = [(&a, &c), (&b, &a), (&c, &b)];
    for (edge, (on, opposite)) in edges.iter().zip(spans) {
        for k in 0..3 {
            let (i, j) = ((k + 1) % 3, (k + 2) % 3);
            let first = edge[i] * on[j] - edge[j] * on[i];
            let second = edge[i] * opposite[j] - edge[j] * opposite[i];
            let reach = h[i] * edge[j].abs() + h[j] * edge[i].abs();
            if first.min(second) > reach || first.max(second) < -reach {
                return false;
            }
        }
    }
    true
}

/// Whether a box meets a ball.
#[must_use]
pub fn meets_ball(given: &OrientedBox, center: &Vec3, radius: f64) -> bool {
    let from = center - given.center;
    let outside: f64 = (0..3)
        .map(|k| {
            let beyond = (from.dot(&given.axes[k]).abs() - given.half_extents[k]).max(0.0);
            beyond * beyond
        })
        .sum();
    outside <= radius * radius
}
