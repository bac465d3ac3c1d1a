//! Convex hull of points.

use super::Vec3;
use super::affine::{Span, span};
use super::quickhull::quickhull;

/// Ways in which the hull is sought in turn: whether points see the faces in whose planes they lie, and by which share of
/// the set's size the points are shifted first. Rounding can contradict itself where many points lie on one plane; shifted
/// points do not, and the shift is below what any box is compared to.
const ATTEMPTS: [(bool, f64); 5] = [(true, 0.0), (false, 0.0), (true, 1e-11), (false, 1e-11), (false, 1e-9)];

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
/// Points on a plane, a line or a point come back as all their points without faces.
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
    if span.dimension == 3 {
        // Hulls commute with affine maps. Stretched to the unit cube, a thin sheet is as well conditioned as a ball.
        let stretched: Vec<Vec3> = points
            .iter()
            .map(|p| {
                let d = p - span.origin;
                Vec3::from([0, 1, 2].map(|k| d.dot(&span.axes[k]) / span.reach[k]))
            })
            .collect();
        for (coplanar, shift) in ATTEMPTS {
            if let Some(faces) = quickhull(&shifted(&stretched, shift), span.corners, coplanar) {
                return compact(points, faces);
            }
        }
    }
    Hull { vertices: points.to_vec(), faces: Vec::new() }
}

/// Move every point by at most `shift` along each axis, each by its own fixed pseudo-random amount.
fn shifted(points: &[Vec3], shift: f64) -> Vec<Vec3> {
    // The fractional parts of multiples of the inverses of the plastic number (Roberts 2018) are spread evenly.
    let amount = |i: usize, g: f64| ((i as f64 * g).fract() * 2.0 - 1.0) * shift;
    let move_by = |(i, p): (usize, &Vec3)| p + Vec3::new(amount(i, 0.819_17), amount(i, 0.671_04), amount(i, 0.549_70));
    points.iter().enumerate().map(move_by).collect()
}

/// Keep only the points that faces use.
fn compact(points: &[Vec3], mut faces: Vec<[u32; 3]>) -> Hull {
    let mut renumbered = vec![u32::MAX; points.len()];
    let mut vertices = Vec::new();
    for i in faces.iter_mut().flatten() {
        let slot = &mut renumbered[*i as usize];
        if *slot == u32::MAX {
            *slot = vertices.len() as u32;
            vertices.push(points[*i as usize]);
        }
        *i = *slot;
    }
    Hull { vertices, faces }
}
