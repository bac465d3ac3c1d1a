//! Edge lengths between parts: how far apart their centres are and how their long axes turn.

use std::f64::consts::PI;

use crate::geometry::frame::EXTENT_TIE;
use crate::geometry::{OrientedBox, box_gap};

/// Return the (n, n) row-major distances between boxes.
#[must_use]
pub fn gaps(boxes: &[OrientedBox]) -> Vec<f64> {
    let n = boxes.len();
    let mut table = vec![0.0; n * n];
    for i in 0..n {
        for j in i + 1..n {
            let gap = box_gap(&boxes[i], &boxes[j]);
            table[i * n + j] = gap;
            table[j * n + i] = gap;
        }
    }
    table
}

/// Dimension of the space in which a box's long axis may lie: 1 when its longest extent stands out, else 2 or 3.
fn long_dimension(b: &OrientedBox) -> usize {
    let [e1, e2, e3] = b.half_extents;
    let ties = |e: f64| e1 - e <= EXTENT_TIE * e1;
    1 + usize::from(ties(e2)) + usize::from(ties(e2) && ties(e3))
}

/// Return the unsigned angle in [0, pi/2] between the long axes of two boxes.
///
/// Where extents tie the long axis is any direction in their plane (or space), and the smallest angle counts: a number
/// that does not depend on which of the equal directions the box search came upon.
fn long_axis_angle(a: &OrientedBox, b: &OrientedBox) -> f64 {
    // The angle between two lines, by sine and cosine: neither alone is exact at both ends.
    let lines = |x: &OrientedBox, y: &OrientedBox, k: usize| {
        let (u, v) = (x.axes[0], y.axes[k]);
        u.cross(&v).norm().atan2(u.dot(&v).abs())
    };
    match (long_dimension(a), long_dimension(b)) {
        (1, 1) => lines(a, b, 0),
        // Between a line and a plane: what the angle to the plane's normal lacks to a right angle.
        (1, 2) => (PI / 2.0 - lines(a, b, 2)).max(0.0),
        (2, 1) => (PI / 2.0 - lines(b, a, 2)).max(0.0),
        _ => 0.0,
    }
}

/// `|c_i - c_j| / unit + angle(a_i, a_j) / pi`.
fn separation(a: &OrientedBox, b: &OrientedBox, unit: f64) -> f64 {
    (a.center - b.center).norm() / unit + long_axis_angle(a, b) / PI
}

/// Return the (n, n) row-major edge lengths l = x / (1 + x) of all pairs; `unit` is the object's diagonal, or 1 for
/// lengths in metres.
#[must_use]
pub fn all_pairs(boxes: &[OrientedBox], unit: f64) -> Vec<f64> {
    table(boxes, |i, j| separation(&boxes[i], &boxes[j], unit)).into_iter().map(|x| x / (1.0 + x)).collect()
}

/// Return the (n, n) row-major lengths l = x / (1 + x), x the shortest path along adjacent parts (Floyd and Warshall).
#[must_use]
pub fn shortest_paths(boxes: &[OrientedBox], adjacency: &[bool], unit: f64) -> Vec<f64> {
    let n = boxes.len();
    let mut x =
        table(boxes, |i, j| if adjacency[i * n + j] { separation(&boxes[i], &boxes[j], unit) } else { f64::INFINITY });
    for k in 0..n {
        for i in 0..n {
            for j in 0..n {
                x[i * n + j] = x[i * n + j].min(x[i * n + k] + x[k * n + j]);
            }
        }
    }
    // No way at all is the limit of a long way.
    x.into_iter().map(|x| if x.is_finite() { x / (1.0 + x) } else { 1.0 }).collect()
}

fn table(boxes: &[OrientedBox], value: impl Fn(usize, usize) -> f64) -> Vec<f64> {
    let n = boxes.len();
    let mut rows = vec![0.0; n * n];
    for i in 0..n {
        for j in i + 1..n {
            let x = value(i, j);
            rows[i * n + j] = x;
            rows[j * n + i] = x;
        }
    }
    rows
}
