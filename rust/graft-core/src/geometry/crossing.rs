//! Where a line crosses a triangle.

use super::Vec3;

/// Distance, in lengths of the direction, and the weights of the second and third corner; from either side.
///
/// Möller and Trumbore 1997. Lines in the triangle's plane do not cross it.
#[inline]
#[must_use]
pub fn crossing(corners: &[Vec3; 3], origin: &Vec3, direction: &Vec3) -> Option<(f64, [f64; 2])> {
    let (first, second) = (corners[1] - corners[0], corners[2] - corners[0]);
    let p = direction.cross(&second);
    let determinant = first.dot(&p);
    if determinant == 0.0 {
        return None;
    }
    let from = origin - corners[0];
    let u = from.dot(&p) / determinant;
    if !(0.0..=1.0).contains(&u) {
        return None;
    }
    let q = from.cross(&first);
    let v = direction.dot(&q) / determinant;
    if v < 0.0 || u + v > 1.0 {
        return None;
    }
    let distance = second.dot(&q) / determinant;
    distance.is_finite().then_some((distance, [u, v]))
}
