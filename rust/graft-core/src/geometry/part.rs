//! The geometry of an object's parts, all at once.

use nalgebra::Matrix3;
use rayon::prelude::*;

use super::Vec3;
use super::affine::{Span, span};
use super::frame::{FLOOR_THICKNESS, Frame, stated_frame};
use super::hull::{Hull, hull_in};
use super::moments::skewness;
use super::obb::{minimal_box, minimal_box_of};
use super::surface::{Samples, measure, sample_cloud, sample_mesh};
use super::ties::settled;

/// One part as it comes in.
#[derive(Debug, Clone)]
pub struct PartShape {
    /// At least one point.
    pub vertices: Vec<Vec3>,
    /// Vertex indices, in range; none for a cloud.
    pub faces: Vec<[usize; 3]>,
    /// A cloud's normals; zero vectors or none at all where they are unknown.
    pub normals: Vec<Vec3>,
}

/// One part, measured.
#[derive(Debug, Clone)]
pub struct PartGeometry {
    /// The minimal box in its stated frame.
    pub frame: Frame,
    /// Surface area, estimated for clouds.
    pub area: f64,
    /// Enclosed volume of the surface, signed by its winding; 0 for clouds.
    pub volume: f64,
    /// Volume of the convex hull.
    pub hull_volume: f64,
    /// No surface could be measured or the points do not span a plane.
    pub degenerate: bool,
    /// Surface samples.
    pub samples: Samples,
}

/// Measure all parts of an object, in parallel; `samples` points of each.
///
/// Returns the parts and the diagonal of the minimal box about the whole object (1 when all points coincide), which
/// also sets the floor of thin extents.
#[must_use]
pub fn object_geometry(parts: &[PartShape], samples: usize, seed: u64) -> (Vec<PartGeometry>, f64) {
    // The parts with the most points take longest: they are begun first.
    let mut order: Vec<usize> = (0..parts.len()).collect();
    order.sort_by_key(|&i| std::cmp::Reverse(parts[i].vertices.len() + parts[i].faces.len()));
    let hulls: Vec<(Span, Hull)> = in_order(&order, |i| {
        let points = used_vertices(&parts[i]);
        let found = span(&points);
        (found, hull_in(&points, &found))
    });
    // The hull of the whole is that of the parts' hulls. Its box is one task among the parts' boxes, the first of them.
    let whole = || match &hulls[..] {
        [] | [_] => None,
        _ => {
            let corners: Vec<Vec3> = hulls.iter().flat_map(|(_, hull)| hull.vertices.iter().copied()).collect();
            Some(minimal_box(&corners))
        }
    };
    let measured = || {
        in_order(&order, |i| {
            let (found, hull) = &hulls[i];
            (minimal_box_of(hull, found), surface(&parts[i], samples, seed, i as u64))
        })
    };
    let (whole, measured) = rayon::join(whole, measured);
    let diagonal = whole.or(measured.first().map(|(bounds, _)| *bounds)).map_or(0.0, |bounds| bounds.diagonal());
    let diagonal = if diagonal > 0.0 { diagonal } else { 1.0 };
    let area: f64 = measured.iter().map(|(_, surface)| surface.area).sum();
    let share = |surface: &Surface| surface.area / area.max(f64::MIN_POSITIVE);
    let middle = measured.iter().map(|(_, s)| s.centroid * share(s)).sum::<Vec3>();
    let spread = measured.iter().map(|(_, s)| {
        let offset = s.centroid - middle;
        (s.covariance + offset * offset.transpose()) * share(s)
    });
    let spread = spread.sum::<Matrix3<f64>>();
    let measured = measured
        .into_iter()
        .zip(hulls)
        .zip(parts)
        .map(|(((bounds, surface), (found, hull)), part)| {
            let toward = if area > 0.0 { middle - bounds.center } else { Vec3::zeros() };
            let bounds = settled(bounds, &hull.vertices, &toward, &spread);
            let skewness = |origin: &Vec3, axis: &Vec3| skewness(&part.vertices, &part.faces, |i| i, origin, axis);
            PartGeometry {
                frame: stated_frame(bounds, &surface.centroid, &toward, FLOOR_THICKNESS * diagonal, skewness),
                area: surface.area,
                volume: surface.volume,
                hull_volume: hull.volume(),
                degenerate: surface.degenerate || found.dimension < 2,
                samples: surface.samples,
            }
        })
        .collect();
    (measured, diagonal)
}

/// Compute a value for every index, in parallel, beginning in the given order.
fn in_order<T: Send>(order: &[usize], compute: impl Fn(usize) -> T + Sync) -> Vec<T> {
    let mut found: Vec<(usize, T)> = order.par_iter().with_max_len(1).map(|&i| (i, compute(i))).collect();
    found.sort_unstable_by_key(|(i, _)| *i);
    found.into_iter().map(|(_, value)| value).collect()
}

struct Surface {
    area: f64,
    volume: f64,
    centroid: Vec3,
    covariance: Matrix3<f64>,
    degenerate: bool,
    samples: Samples,
}

/// The vertices that faces use; all of a cloud's, or when no face is left.
fn used_vertices(part: &PartShape) -> Vec<Vec3> {
    if part.faces.is_empty() {
        return part.vertices.clone();
    }
    let mut used = vec![false; part.vertices.len()];
    for i in part.faces.iter().flatten() {
        used[*i] = true;
    }
    part.vertices.iter().zip(used).filter(|(_, used)| *used).map(|(p, _)| *p).collect()
}

fn surface(part: &PartShape, count: usize, seed: u64, stream: u64) -> Surface {
    let measured = measure(&part.vertices, &part.faces);
    if measured.area > 0.0 {
        let samples = sample_mesh(&part.vertices, &part.faces, count, seed, stream);
        let empty = part.faces.iter().any(|f| {
            let [a, b, c] = f.map(|i| part.vertices[i]);
            (b - a).cross(&(c - a)).norm_squared() <= 0.0
        });
        return Surface {
            area: measured.area,
            volume: measured.volume,
            centroid: measured.centroid,
            covariance: measured.covariance,
            degenerate: empty,
            samples,
        };
    }
    let (samples, area) = sample_cloud(&part.vertices, &part.normals, count, seed, stream);
    Surface {
        area,
        volume: 0.0,
        centroid: measured.centroid,
        covariance: measured.covariance,
        degenerate: !part.faces.is_empty(),
        samples,
    }
}
