//! The geometry of an object's parts, all at once.

use rayon::prelude::*;

use super::frame::{FLOOR_THICKNESS, Frame, stated_frame};
use super::obb::minimal_box;
use super::surface::{Samples, measure, sample_cloud, sample_mesh};
use super::{Boxed, Vec3};

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
    let boxed: Vec<(Boxed, Surface)> = parts
        .par_iter()
        .enumerate()
        .map(|(i, part)| (minimal_box(&used_vertices(part)), surface(part, samples, seed, i as u64)))
        .collect();
    let corners: Vec<Vec3> = boxed.iter().flat_map(|(b, _)| b.corners.iter().copied()).collect();
    let diagonal = match &boxed[..] {
        [] => 0.0,
        [(only, _)] => only.bounds.diagonal(),
        _ => minimal_box(&corners).bounds.diagonal(),
    };
    let diagonal = if diagonal > 0.0 { diagonal } else { 1.0 };
    let measured = boxed
        .into_iter()
        .map(|(found, surface)| PartGeometry {
            frame: stated_frame(found.bounds, &surface.centroid, FLOOR_THICKNESS * diagonal),
            area: surface.area,
            volume: surface.volume,
            hull_volume: found.hull_volume,
            degenerate: surface.degenerate || found.dimension < 2,
            samples: surface.samples,
        })
        .collect();
    (measured, diagonal)
}

struct Surface {
    area: f64,
    volume: f64,
    centroid: Vec3,
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
            degenerate: empty,
            samples,
        };
    }
    let (samples, area) = sample_cloud(&part.vertices, &part.normals, count, seed, stream);
    Surface { area, volume: 0.0, centroid: measured.centroid, degenerate: !part.faces.is_empty(), samples }
}
