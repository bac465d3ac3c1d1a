//! Convex hull of points.

use super::Vec3;
use super::affine::{Span, span};
use super::quickhull::quickhull;

/// Ways in which the hull is sought in turn: whether points see the faces in whose planes they lie, and by which share of
/// the set's size the points are shifted first. Rounding can contradict itself where many points lie on one plane; shifted
/// points do not, and the shift is below what any box is compared to.
const ATTEMPTS: [(bool, f64); 5] = [(true, 0.0), (false, 0.0), (true, 1e-11), (false, 1e-11), (false, 1e-9)];

/// Faces lower than this share of their longest side have their corners on a line.
const SLIVER: f64 = 1e-7;

/// Slivers that lie side by side are flipped one after the other, at most so many deep.
const FLIPS: usize = 16;

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

/// Give faces whose three corners lie on a line to the face along their longest side, until none is left.
///
/// The middle corner would else have no neighbour on that side: who walks uphill over the hull would be caught there.
fn flip_slivers(vertices: &[Vec3], faces: &mut [[u32; 3]]) {
    for _ in 0..FLIPS {
        let slivers: Vec<(usize, usize)> =
            faces.iter().enumerate().filter_map(|(f, c)| Some((f, sliver(vertices, c)?))).collect();
        if slivers.is_empty() {
            return;
        }
        let (across, closed) = neighbours(faces);
        if !closed {
            return;
        }
        let mut changed = vec![false; faces.len()];
        for (f, side) in slivers {
            let other = across[3 * f + side] as usize;
            let (g, edge) = (other / 3, other % 3);
            let [a, c, b] = [0, 1, 2].map(|k| faces[f][(side + k) % 3]);
            let d = faces[g][(edge + 2) % 3];
            if !changed[f] && !changed[g] && d != b {
                faces[f] = [a, d, b];
                faces[g] = [d, c, b];
                changed[f] = true;
                changed[g] = true;
            }
        }
    }
}

/// The longest side of a face that has hardly a height.
fn sliver(vertices: &[Vec3], corners: &[u32; 3]) -> Option<usize> {
    let sides = [0, 1, 2].map(|k| vertices[corners[(k + 1) % 3] as usize] - vertices[corners[k] as usize]);
    let squares = sides.map(|s| s.norm_squared());
    let longest = (1..3).fold(0, |l, k| if squares[k] > squares[l] { k } else { l });
    (sides[0].cross(&sides[1]).norm() <= SLIVER * squares[longest]).then_some(longest)
}

/// Pair the half-edges of a triangle mesh, 3 * face + corner; also whether each has exactly one partner.
#[must_use]
pub fn neighbours(faces: &[[u32; 3]]) -> (Vec<u32>, bool) {
    let mut keyed: Vec<(u64, u32)> = faces
        .iter()
        .enumerate()
        .flat_map(|(f, c)| {
            (0..3).map(move |k| {
                let (a, b) = (u64::from(c[k]), u64::from(c[(k + 1) % 3]));
                ((a.min(b) << 32) | a.max(b), (3 * f + k) as u32)
            })
        })
        .collect();
    keyed.sort_unstable();
    let mut across = vec![0; keyed.len()];
    let mut closed = !faces.is_empty() && keyed.len().is_multiple_of(2);
    for pair in keyed.chunks_exact(2) {
        closed &= pair[0].0 == pair[1].0;
        across[pair[0].1 as usize] = pair[1].1;
        across[pair[1].1 as usize] = pair[0].1;
    }
    (across, closed)
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
    flip_slivers(&vertices, &mut faces);
    Hull { vertices, faces }
}
