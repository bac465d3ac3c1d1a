//! One part in its own frame: centred, root-mean-square radius 1, principal axes, and evenly sampled.
//!
//! Everything later reads this form, so that no feature depends on where the part lies or how large it is.

use crate::geometry::moments::{self, Moments, surface_moments};
use nalgebra::{Matrix3, Vector3};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

pub type Point = Vector3<f64>;

/// Extent below which a part counts as one point, relative to its coordinates' magnitude.
const POINT_EXTENT: f64 = 1e-12;
/// Principal standard deviations are at least this share of the largest: flat and straight parts get a thickness.
pub const FLOOR: f64 = 1e-3;
/// Points in the smaller sample: nearest neighbours and depths of more would dominate the cost.
const FEW: usize = 512;

/// A part in its own frame.
pub struct Surface {
    /// Vertices; those that no face uses are left out when there are faces.
    pub vertices: Vec<Point>,
    /// Triangles of non-zero area; empty for clouds.
    pub faces: Vec<[usize; 3]>,
    /// Area of every triangle.
    pub areas: Vec<f64>,
    /// Principal standard deviations of the surface, longest first, floored.
    pub deviations: [f64; 3],
    /// Points spread evenly over the surface (for clouds: points of the cloud).
    pub samples: Vec<Point>,
    /// A smaller, independent sample for what costs the square of its size.
    pub few: Vec<Point>,
}

impl Surface {
    /// Bring a part to its own frame and sample it; `None` when all its points coincide.
    pub fn new(vertices: &[[f64; 3]], faces: &[[i64; 3]], n_samples: usize, seed: u64) -> Option<Self> {
        let (mut vertices, faces) = used(vertices, faces);
        // Dividing first keeps the differences of huge coordinates finite.
        let magnitude = vertices.iter().flat_map(|v| v.iter()).fold(0.0_f64, |m, x| m.max(x.abs()));
        if magnitude == 0.0 {
            return None;
        }
        for vertex in &mut vertices {
            *vertex = Point::new(vertex.x / magnitude, vertex.y / magnitude, vertex.z / magnitude);
        }
        let low = vertices.iter().fold(vertices[0], |a, b| a.inf(b));
        let high = vertices.iter().fold(vertices[0], |a, b| a.sup(b));
        let extent = (high - low).max();
        if extent < POINT_EXTENT {
            return None;
        }
        for vertex in &mut vertices {
            *vertex = (*vertex - low) / extent;
        }

        let areas: Vec<f64> = faces
            .iter()
            .map(|&[a, b, c]| 0.5 * (vertices[b] - vertices[a]).cross(&(vertices[c] - vertices[a])).norm())
            .collect();
        let (faces, areas): (Vec<_>, Vec<_>) = faces.into_iter().zip(areas).filter(|&(_, area)| area > 0.0).unzip();

        let Moments { centroid: centre, covariance, .. } = surface_moments(&vertices, &faces, |i| i);
        let (axes, deviations) = principal(&covariance);
        let radius = deviations.iter().map(|s| s * s).sum::<f64>().sqrt();
        for vertex in &mut vertices {
            *vertex = axes.transpose() * (*vertex - centre) / radius;
        }
        let areas = areas.iter().map(|area| area / (radius * radius)).collect::<Vec<_>>();
        let mut random = Pcg64::seed_from_u64(seed);
        let samples = sample(&vertices, &faces, &areas, n_samples, &mut random);
        let few = sample(&vertices, &faces, &areas, n_samples.min(FEW), &mut random);
        let deviations = deviations.map(|s| s / radius);
        Some(Self { vertices, faces, areas, deviations, samples, few })
    }
}

/// Vertices that faces use, with the faces renumbered; all vertices when there are no faces.
fn used(vertices: &[[f64; 3]], faces: &[[i64; 3]]) -> (Vec<Point>, Vec<[usize; 3]>) {
    if faces.is_empty() {
        return (vertices.iter().map(|&v| Point::from(v)).collect(), Vec::new());
    }
    let mut number = vec![usize::MAX; vertices.len()];
    let mut kept = Vec::with_capacity(vertices.len());
    let mut renumbered = Vec::with_capacity(faces.len());
    for face in faces {
        renumbered.push(face.map(|index| {
            let old = index as usize;
            if number[old] == usize::MAX {
                number[old] = kept.len();
                kept.push(Point::from(vertices[old]));
            }
            number[old]
        }));
    }
    (kept, renumbered)
}

/// Axes (columns, longest first) and floored standard deviations of a covariance.
pub fn principal(covariance: &Matrix3<f64>) -> (Matrix3<f64>, [f64; 3]) {
    let (axes, variances) = moments::principal(covariance);
    let deviations = variances.map(f64::sqrt);
    (axes, deviations.map(|s| s.max(FLOOR * deviations[0])))
}

/// Stratified sampling by area in face order: one point in each of `n` equal shares of the area.
///
/// Neighbouring faces share points evenly, so the noise is small; the place within a share is random, so that no
/// regular order of the faces can fall into step with the shares.
fn sample(vertices: &[Point], faces: &[[usize; 3]], areas: &[f64], n: usize, random: &mut Pcg64) -> Vec<Point> {
    if faces.is_empty() {
        let step = vertices.len() as f64 / n as f64;
        if step <= 1.0 {
            return vertices.to_vec();
        }
        let at = |i: usize, shift: f64| ((i as f64 + shift) * step) as usize;
        return (0..n).map(|i| vertices[at(i, random.random()).min(vertices.len() - 1)]).collect();
    }
    let total: f64 = areas.iter().sum();
    let (mut face, mut passed) = (0, areas[0]);
    (0..n)
        .map(|i| {
            let [shift, mut s, mut t]: [f64; 3] = random.random();
            let target = (i as f64 + shift) / n as f64 * total;
            while passed < target && face + 1 < faces.len() {
                face += 1;
                passed += areas[face];
            }
            if s + t > 1.0 {
                (s, t) = (1.0 - s, 1.0 - t);
            }
            let [a, b, c] = faces[face];
            vertices[a] * (1.0 - s - t) + vertices[b] * s + vertices[c] * t
        })
        .collect()
}
