//! Corner normals: smooth over gentle bends, sharp across creases.

use std::collections::HashMap;

use nalgebra::Vector3;

/// Cosine of the angle between faces beyond which an edge is a crease (about 40 degrees).
const CREASE_COSINE: f64 = 0.766;

/// A vertex with more faces than this (the hub of a fan) keeps flat corners: averaging costs the square of it.
const MAX_VALENCE: usize = 64;

/// Return the unit normals of the three corners of every face.
///
/// A corner's normal is the area-weighted mean over the faces at its place that bend by less than the crease angle.
/// Vertices are joined by place, so that parts cut from one mesh, and soups of triangles, are shaded as one surface.
/// Faces without area get zero normals.
pub fn corner_normals(vertices: &[Vector3<f64>], faces: &[[usize; 3]]) -> Vec<[Vector3<f64>; 3]> {
    let mut places: HashMap<[u64; 3], usize> = HashMap::with_capacity(vertices.len());
    let place: Vec<usize> = vertices
        .iter()
        .map(|v| {
            let next = places.len();
            // Adding 0 turns -0 into 0, which is the same place.
            *places.entry([v.x, v.y, v.z].map(|x| (x + 0.0).to_bits())).or_insert(next)
        })
        .collect();
    let areas: Vec<Vector3<f64>> =
        faces.iter().map(|f| (vertices[f[1]] - vertices[f[0]]).cross(&(vertices[f[2]] - vertices[f[0]]))).collect();
    let units: Vec<Vector3<f64>> = areas.iter().map(|a| a.try_normalize(0.0).unwrap_or_else(Vector3::zeros)).collect();

    let mut starts = vec![0_usize; places.len() + 1];
    for face in faces {
        for &v in face {
            starts[place[v] + 1] += 1;
        }
    }
    for i in 1..starts.len() {
        starts[i] += starts[i - 1];
    }
    let mut around = vec![0_usize; 3 * faces.len()];
    let mut filled = starts.clone();
    for (index, face) in faces.iter().enumerate() {
        for &v in face {
            around[filled[place[v]]] = index;
            filled[place[v]] += 1;
        }
    }

    faces
        .iter()
        .enumerate()
        .map(|(index, face)| {
            face.map(|v| {
                let ring = &around[starts[place[v]]..starts[place[v] + 1]];
                if ring.len() > MAX_VALENCE {
                    return units[index];
                }
                let sum = ring
                    .iter()
                    .filter(|&&other| units[other].dot(&units[index]) > CREASE_COSINE)
                    .fold(Vector3::zeros(), |sum, &other| sum + areas[other]);
                sum.try_normalize(0.0).unwrap_or(units[index])
            })
        })
        .collect()
}
