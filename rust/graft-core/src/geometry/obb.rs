//! Oriented bounding box of minimal volume.

use super::Vec3;
use super::affine::{Span, any_normal, span};
use super::hull::{Hull, hull_in};
use super::rectangle::{Vec2, minimal_rectangle, planar_hull};
use super::solid::solid_axes;

/// A box.
#[derive(Debug, Clone, Copy)]
pub struct OrientedBox {
    /// Centre.
    pub center: Vec3,
    /// Orthonormal axes, right-handed.
    pub axes: [Vec3; 3],
    /// Half of the box's size along each axis; zero along the thin axes of flat sets.
    pub half_extents: [f64; 3],
}

impl OrientedBox {
    /// The box with given axes about non-empty `points`.
    #[must_use]
    pub fn about(points: &[Vec3], axes: [Vec3; 3]) -> Self {
        let mut center = Vec3::zeros();
        let mut half_extents = [0.0; 3];
        for k in 0..3 {
            let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
            for p in points {
                let s = p.dot(&axes[k]);
                low = low.min(s);
                high = high.max(s);
            }
            center += axes[k] * f64::midpoint(low, high);
            half_extents[k] = (high - low) / 2.0;
        }
        Self { center, axes, half_extents }
    }

    /// Volume.
    #[must_use]
    pub fn volume(&self) -> f64 {
        8.0 * self.half_extents.iter().product::<f64>()
    }

    /// Length of the diagonal.
    #[must_use]
    pub fn diagonal(&self) -> f64 {
        2.0 * Vec3::from(self.half_extents).norm()
    }
}

/// Find the minimal box about non-empty `points`.
///
/// Points on a plane get the plane's normal and their minimal rectangle, points on a line that line, coinciding
/// points the frame of the coordinates.
#[must_use]
pub fn minimal_box(points: &[Vec3]) -> OrientedBox {
    let found = span(points);
    box_in(points, &hull_in(points, &found), &found)
}

/// Like [`minimal_box`], for a caller that has the hull of the points and their span.
#[must_use]
pub fn minimal_box_of(hull: &Hull, found: &Span) -> OrientedBox {
    box_in(&hull.vertices, hull, found)
}

/// The box about `points` with the axes of their hull's box.
fn box_in(points: &[Vec3], hull: &Hull, found: &Span) -> OrientedBox {
    let solid = if hull.faces.is_empty() { None } else { solid_axes(hull) };
    let axes = solid.unwrap_or_else(|| match found.dimension {
        0 => [Vec3::x(), Vec3::y(), Vec3::z()],
        1 => {
            let y = any_normal(&found.axes[0]);
            [found.axes[0], y, found.axes[0].cross(&y)]
        }
        // A plane, or a solid so thin that quickhull gave up.
        _ => planar_axes(&hull.vertices, found.axes),
    });
    OrientedBox::about(points, axes)
}

fn planar_axes(points: &[Vec3], [u, v, normal]: [Vec3; 3]) -> [Vec3; 3] {
    let mut flat: Vec<Vec2> = points.iter().map(|p| Vec2::new(p.dot(&u), p.dot(&v))).collect();
    let mut polygon = Vec::new();
    planar_hull(&mut flat, &mut polygon);
    let side = minimal_rectangle(&mut polygon).map_or(Vec2::x(), |r| r.side);
    let x = u * side.x + v * side.y;
    [x, normal.cross(&x), normal]
}
