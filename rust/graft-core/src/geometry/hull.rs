//! Convex hull by parry's quickhull; the only place that speaks parry's vectors.

use parry3d_f64::math::Vector as ParryVector;
use parry3d_f64::transformation::try_convex_hull;

use super::Vec3;
use super::affine::{Span, span};

/// A convex polyhedron with triangular faces, wound outward.
#[derive(Debug, Clone, Default)]
pub struct Hull {
    /// Corners, some of the points it was made from.
    pub vertices: Vec<Vec3>,
    /// Triangles, counter-clockwise from outside; none when the points do not span a solid.
    pub faces: Vec<[u32; 3]>,
}

impl Hull {
    /// Return the enclosed volume; 0 for a flat hull.
    #[must_use]
    pub fn volume(&self) -> f64 {
        let Some(origin) = self.vertices.first() else { return 0.0 };
        let six: f64 = self
            .faces
            .iter()
            .map(|f| {
                let [a, b, c] = f.map(|i| self.vertices[i as usize] - origin);
                a.dot(&b.cross(&c))
            })
            .sum();
        six.abs() / 6.0
    }
}

/// Compute the convex hull of a point set.
///
/// Points on a plane, a line or a point, and the rare sets on which quickhull gives up, come back as all their points
/// without faces.
#[must_use]
pub fn convex_hull(points: &[Vec3]) -> Hull {
    if points.is_empty() {
        return Hull::default();
    }
    hull_in(points, &span(points))
}

/// Like [`convex_hull`], for a caller that knows the span.
#[must_use]
pub fn hull_in(points: &[Vec3], span: &Span) -> Hull {
    let flat = || Hull { vertices: points.to_vec(), faces: Vec::new() };
    if span.dimension < 3 {
        return flat();
    }
    // Hulls commute with affine maps. Stretching the set to the unit cube keeps thin sheets from counting as flat.
    let stretched: Vec<ParryVector> = points
        .iter()
        .map(|p| {
            let d = p - span.origin;
            let [u, v, w] = [0, 1, 2].map(|k| d.dot(&span.axes[k]) / span.reach[k]);
            ParryVector::new(u, v, w)
        })
        .collect();
    // Quickhull asserts invariants that rounding can break; a broken one means no hull, not the end of the process.
    let found = std::panic::catch_unwind(|| try_convex_hull(&stretched));
    let Ok(Ok((corners, faces))) = found else { return flat() };
    let back = |c: &ParryVector| {
        span.origin
            + span.axes[0] * (c.x * span.reach[0])
            + span.axes[1] * (c.y * span.reach[1])
            + span.axes[2] * (c.z * span.reach[2])
    };
    Hull { vertices: corners.iter().map(back).collect(), faces }
}
