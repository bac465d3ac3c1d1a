//! What dimension a point set has, and a frame in which it fills the unit cube.

use super::Vec3;

/// A point set whose deviation from a plane, a line or a point is below this share of its size lies on it. Rounding of
/// coordinates that were rotated in double precision stays below 1e-14 of the size; files in single precision give 1e-7.
pub const FLAT_TOLERANCE: f64 = 1e-9;

/// Four points that span a set as widely as a greedy choice can, and the frame they give.
#[derive(Debug, Clone, Copy)]
pub struct Span {
    /// 0 a point, 1 a line, 2 a plane, 3 a solid.
    pub dimension: usize,
    /// The point the frame starts from.
    pub origin: Vec3,
    /// Orthonormal, right-handed; the first `dimension` of them span the set.
    pub axes: [Vec3; 3],
    /// Size of the set along each axis, as seen from `origin`.
    pub reach: [f64; 3],
    /// Indices of the origin and of the points that are farthest from it, from the line and from the plane.
    pub corners: [usize; 4],
}

/// Return the index and the value of the largest score; the first one of equals.
fn farthest(points: &[Vec3], score: impl Fn(&Vec3) -> f64) -> (usize, f64) {
    let mut best = (0, f64::NEG_INFINITY);
    for (i, p) in points.iter().enumerate() {
        let s = score(p);
        if s > best.1 {
            best = (i, s);
        }
    }
    best
}

/// Return a unit vector normal to the unit vector `axis`.
#[must_use]
pub fn any_normal(axis: &Vec3) -> Vec3 {
    let least = axis.iamin();
    let mut unit = Vec3::zeros();
    unit[least] = 1.0;
    (unit - axis * axis[least]).normalize()
}

/// Find the dimension of a non-empty point set: the farthest point from the centroid, from that point, from the line
/// through both, from the plane through all three.
#[must_use]
pub fn span(points: &[Vec3]) -> Span {
    let centroid = points.iter().sum::<Vec3>() / points.len() as f64;
    let start = farthest(points, |p| (p - centroid).norm_squared()).0;
    let origin = points[start];
    let (first, reach0) = farthest(points, |p| (p - origin).norm_squared());
    let reach0 = reach0.sqrt();
    let mut found = Span {
        dimension: 0,
        origin,
        axes: [Vec3::x(), Vec3::y(), Vec3::z()],
        reach: [reach0, 0.0, 0.0],
        corners: [start, first, start, start],
    };
    // Coordinates far from zero cannot tell sizes below their rounding.
    let floor = points.iter().map(Vec3::amax).fold(0.0, f64::max) * f64::EPSILON * 4.0;
    if reach0 <= floor {
        return found;
    }
    let x = (points[first] - origin) / reach0;
    let off_line = |p: &Vec3| {
        let d = p - origin;
        d - x * d.dot(&x)
    };
    let (second, reach1) = farthest(points, |p| off_line(p).norm_squared());
    let reach1 = reach1.sqrt();
    let tolerance = (FLAT_TOLERANCE * reach0).max(floor);
    found.dimension = 1;
    found.reach[1] = reach1;
    found.corners[2] = second;
    let y = if reach1 <= tolerance { any_normal(&x) } else { off_line(&points[second]) / reach1 };
    let z = x.cross(&y).normalize();
    found.axes = [x, z.cross(&x).normalize(), z];
    if reach1 <= tolerance {
        return found;
    }
    let (third, reach2) = farthest(points, |p| (p - origin).dot(&z).abs());
    found.reach[2] = reach2;
    found.corners[3] = third;
    found.dimension = if reach2 <= tolerance { 2 } else { 3 };
    found
}
