//! Ray casting: pictures without OpenGL, the same bytes on every machine.
//!
//! Only additions, products, quotients and square roots are used, which IEEE 754 rounds the same way everywhere.

mod bvh;
mod normals;
mod shade;

use nalgebra::{Matrix3, Vector3};
use rayon::prelude::*;

pub use bvh::{Bvh, Hit, Primitive, Ray};

use crate::Error;

/// Rays per pixel and axis.
pub const SUPERSAMPLING: usize = 2;

/// Largest width or height of a picture: 2^26 pixels take 2.5 GB of samples.
pub const MAX_SIZE: usize = 8192;

/// Coloured triangles and spheres. All arrays are row-major.
#[derive(Debug, Clone, Copy)]
pub struct Scene<'a> {
    /// (v, 3) positions.
    pub vertices: &'a [f64],
    /// (f, 3) vertex indices.
    pub faces: &'a [i64],
    /// (f,) what each face belongs to; lines are drawn where groups meet.
    pub face_groups: &'a [i64],
    /// (s, 3) centres of spheres.
    pub centers: &'a [f64],
    /// (s,) their radii.
    pub radii: &'a [f64],
    /// (s,) what each sphere belongs to.
    pub center_groups: &'a [i64],
    /// (g, 3) sRGB colours of the groups.
    pub colors: &'a [u8],
}

/// An orthographic camera.
#[derive(Debug, Clone, Copy)]
pub struct Camera {
    /// (3, 4) row-major: takes a point to (pixels to the right, pixels down, depth away from the viewer).
    /// The top left corner of the picture is the origin; a similarity keeps shapes.
    pub matrix: [f64; 12],
    /// Pixels.
    pub width: usize,
    /// Pixels.
    pub height: usize,
}

/// What one ray has seen.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Sample {
    pub depth: f64,
    /// Unit, towards the viewer: z <= 0.
    pub normal: Vector3<f64>,
    pub group: usize,
}

/// Draw `scene`: (height, width, 4) sRGB colours with straight alpha, 0 where nothing is.
///
/// # Errors
/// A shape, an index, a size or a number that cannot be used; it is named.
pub fn render(scene: &Scene<'_>, camera: &Camera) -> Result<Vec<u8>, Error> {
    for (name, size) in [("width", camera.width), ("height", camera.height)] {
        if !(1..=MAX_SIZE).contains(&size) {
            return Err(Error::value(name, format!("1 to {MAX_SIZE} pixels"), size));
        }
    }
    let linear = Matrix3::from_fn(|row, column| camera.matrix[4 * row + column]);
    if !camera.matrix.iter().all(|x| x.is_finite()) || linear.determinant() == 0.0 {
        return Err(Error::value("camera", "a finite matrix that can be inverted", format!("{:?}", camera.matrix)));
    }
    let shift = Vector3::from_fn(|row, _| camera.matrix[4 * row + 3]);
    // Rays run along z in the camera's frame, so the scene is moved there once. Spheres stay spheres.
    let scale = linear.column(0).norm();
    let to_camera = |points: &[f64], name| -> Result<Vec<Vector3<f64>>, Error> {
        let moved: Vec<_> = vectors(points).map(|p| linear * p + shift).collect();
        match moved.iter().find(|p| !p.iter().all(|x| x.is_finite())) {
            None => Ok(moved),
            Some(p) => Err(Error::value(name, "finite numbers before the camera", format!("{p:?}"))),
        }
    };
    let vertices = to_camera(scene.vertices, "vertices")?;
    let centers = to_camera(scene.centers, "centers")?;
    let faces = triples("faces", scene.faces, vertices.len())?;
    let groups = scene.colors.len() / 3;
    let face_groups = indices("face_groups", scene.face_groups, faces.len(), groups)?;
    let center_groups = indices("center_groups", scene.center_groups, centers.len(), groups)?;
    if scene.radii.len() != centers.len() {
        return Err(Error::shape("radii", centers.len(), scene.radii.len()));
    }
    if let Some(radius) = scene.radii.iter().find(|r| !(**r > 0.0 && (**r * scale).is_finite())) {
        return Err(Error::value("radii", "positive numbers", radius));
    }

    let normals = normals::corner_normals(&vertices, &faces);
    let mut primitives: Vec<Primitive> = faces.iter().map(|f| Primitive::Triangle(f.map(|v| vertices[v]))).collect();
    primitives.extend(centers.iter().zip(scene.radii).map(|(c, r)| Primitive::Sphere(*c, r * scale)));
    let front = vertices
        .iter()
        .map(|v| v.z)
        .chain(centers.iter().zip(scene.radii).map(|(c, r)| c.z - r * scale))
        .fold(f64::INFINITY, f64::min);
    let bvh = Bvh::new(primitives);

    let see = |ray: &Ray| -> Option<Sample> {
        let hit = bvh.nearest(ray)?;
        let (normal, group) = if let Some(corners) = normals.get(hit.primitive) {
            let [u, v] = hit.weights;
            (corners[0] * (1.0 - u - v) + corners[1] * u + corners[2] * v, face_groups[hit.primitive])
        } else {
            let sphere = hit.primitive - faces.len();
            (ray.origin + ray.direction * hit.distance - centers[sphere], center_groups[sphere])
        };
        let toward = Vector3::new(0.0, 0.0, -1.0);
        let unit = normal.try_normalize(0.0).unwrap_or(toward);
        let facing = if unit.z > 0.0 { -unit } else { unit };
        Some(Sample { depth: ray.origin.z + hit.distance, normal: facing, group })
    };
    let columns = camera.width * SUPERSAMPLING;
    let mut samples: Vec<Option<Sample>> = vec![None; columns * camera.height * SUPERSAMPLING];
    samples.par_chunks_mut(columns).enumerate().for_each(|(row, line)| {
        for (column, sample) in line.iter_mut().enumerate() {
            let step = SUPERSAMPLING as f64;
            let origin = Vector3::new((column as f64 + 0.5) / step, (row as f64 + 0.5) / step, front - 1.0);
            *sample = see(&Ray { origin, direction: Vector3::z() });
        }
    });
    Ok(shade::shade(&samples, camera.width, camera.height, scene.colors))
}

/// Return how far each ray goes until it hits a mesh, in lengths of its direction; infinity where it does not.
///
/// # Arguments
/// `vertices` (v, 3), `faces` (f, 3), `origins` (r, 3), `directions` (r, 3), not zero.
///
/// # Errors
/// A shape, an index or a direction that cannot be used; it is named.
pub fn cast_rays(vertices: &[f64], faces: &[i64], origins: &[f64], directions: &[f64]) -> Result<Vec<f64>, Error> {
    if origins.len() != directions.len() {
        return Err(Error::shape("directions", origins.len() / 3, directions.len() / 3));
    }
    if vectors(directions).any(|d| d == Vector3::zeros()) {
        return Err(Error::value("directions", "directions", "the zero vector"));
    }
    let points: Vec<_> = vectors(vertices).collect();
    let corners = triples("faces", faces, points.len())?;
    let bvh = Bvh::new(corners.iter().map(|f| Primitive::Triangle(f.map(|v| points[v]))).collect());
    let rays: Vec<Ray> =
        vectors(origins).zip(vectors(directions)).map(|(origin, direction)| Ray { origin, direction }).collect();
    Ok(rays.par_iter().map(|ray| bvh.nearest(ray).map_or(f64::INFINITY, |hit| hit.distance)).collect())
}

fn vectors(rows: &[f64]) -> impl Iterator<Item = Vector3<f64>> {
    rows.chunks_exact(3).map(|row| Vector3::new(row[0], row[1], row[2]))
}

fn indices(name: &'static str, values: &[i64], rows: usize, bound: usize) -> Result<Vec<usize>, Error> {
    if values.len() != rows {
        return Err(Error::shape(name, rows, values.len()));
    }
    values
        .iter()
        .map(|&value| {
            usize::try_from(value)
                .ok()
                .filter(|&index| index < bound)
                .ok_or_else(|| Error::value(name, format!("indices below {bound}"), value))
        })
        .collect()
}

fn triples(name: &'static str, values: &[i64], bound: usize) -> Result<Vec<[usize; 3]>, Error> {
    let flat = indices(name, values, values.len(), bound)?;
    Ok(flat.chunks_exact(3).map(|face| [face[0], face[1], face[2]]).collect())
}

#[cfg(test)]
mod tests;
