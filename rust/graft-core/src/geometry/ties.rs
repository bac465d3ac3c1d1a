//! Boxes of round parts: which of many equal ones.
//!
//! The minimal box of a cylinder with n sides can be turned about its axis by any multiple of a side. Left to rounding,
//! copies of an object in two poses would get different frames; the rest of the object tells which one to take.

use nalgebra::{Matrix2, Matrix3};

use super::Vec3;
use super::obb::OrientedBox;
use super::rectangle::{Rectangle, Vec2, each_rectangle, planar_hull};
use super::search::plane_axes;

/// Rectangles within this share of the smallest are equal.
const AREA_TIE: f64 = 1e-7;

/// Cosines within this of each other, and offsets below this share of the box's size, are equal or nothing.
const DIRECTION_TIE: f64 = 1e-6;

/// Of the equal boxes that share an axis with `bounds`, take the one with another axis nearest to the direction `toward`,
/// seen from the box's centre; of two on either side of it the one ahead in the turn about the axis, which points to the
/// side of `toward`. Where `toward` lies on the axis, the direction in which the covariance `spread` is widest takes its place.
#[must_use]
pub fn settled(mut bounds: OrientedBox, corners: &[Vec3], toward: &Vec3, spread: &Matrix3<f64>) -> OrientedBox {
    for k in 0..3 {
        let axis = bounds.axes[k];
        let axis = if axis.dot(toward) < 0.0 { -axis } else { axis };
        let (u, v) = plane_axes(&axis);
        let offset = Vec2::new(toward.dot(&u), toward.dot(&v));
        let seen = if offset.norm() < DIRECTION_TIE * bounds.diagonal() {
            widest(spread, &u, &v)
        } else {
            Some(offset.normalize())
        };
        let Some(seen) = seen else { continue };
        let mut outline: Vec<Vec2> = corners.iter().map(|p| Vec2::new(p.dot(&u), p.dot(&v))).collect();
        let mut polygon = Vec::new();
        planar_hull(&mut outline, &mut polygon);
        let mut found: Vec<Rectangle> = Vec::new();
        each_rectangle(&mut polygon, |rectangle| found.push(rectangle));
        let least = found.iter().map(|r| r.area).fold(f64::INFINITY, f64::min);
        found.retain(|r| r.area <= least * (1.0 + AREA_TIE));
        // Each rectangle by whichever of its four directions is nearest, and how far that is ahead.
        let nearest = |r: &Rectangle| {
            let across = Vec2::new(-r.side.y, r.side.x);
            let side = if r.side.dot(&seen).abs() >= across.dot(&seen).abs() { r.side } else { across };
            let side = if side.dot(&seen) < 0.0 { -side } else { side };
            (side, side.dot(&seen), seen.perp(&side))
        };
        let mut best: Option<(Vec2, f64, f64)> = None;
        for rectangle in &found {
            let (side, cosine, ahead) = nearest(rectangle);
            let better = best.is_none_or(|(_, c, a)| {
                cosine > c + DIRECTION_TIE || (cosine > c - DIRECTION_TIE && ahead > a + DIRECTION_TIE)
            });
            if better {
                best = Some((side, cosine, ahead));
            }
        }
        let Some((side, ..)) = best else { continue };
        let x = u * side.x + v * side.y;
        // One rectangle, however it is found: the box stays as it is.
        if bounds.axes.iter().all(|a| a.dot(&x).abs() < 1.0 - DIRECTION_TIE * DIRECTION_TIE) {
            let settled = OrientedBox::about(corners, [x, axis.cross(&x), axis]);
            if settled.volume() <= bounds.volume() * (1.0 + AREA_TIE) {
                bounds = settled;
            }
        }
    }
    bounds
}

/// The direction in the plane of `u` and `v` in which a covariance is widest; None when it is round there.
fn widest(spread: &Matrix3<f64>, u: &Vec3, v: &Vec3) -> Option<Vec2> {
    let across = u.dot(&(spread * v));
    let eigen = Matrix2::new(u.dot(&(spread * u)), across, across, v.dot(&(spread * v))).symmetric_eigen();
    let wide = eigen.eigenvalues.imax();
    let difference = eigen.eigenvalues[wide] - eigen.eigenvalues[1 - wide];
    (difference > DIRECTION_TIE * eigen.eigenvalues[wide]).then(|| eigen.eigenvectors.column(wide).into_owned())
}
