//! A coarser copy of a large mesh by vertex clustering (Rossignac and Borrel 1993), and the way back.

use std::collections::HashMap;

use super::Vec3;

/// Faces above which a mesh is segmented on a coarser copy.
pub const MOST_FACES: usize = 60_000;

/// By how much cells grow until few enough faces are left.
const GROWTH: f64 = 1.25;

/// A coarser mesh.
#[derive(Debug)]
pub struct Coarse {
    /// Corners: the means of those in each cell.
    pub vertices: Vec<Vec3>,
    /// Faces whose corners lie in three cells, each once.
    pub faces: Vec<[usize; 3]>,
    /// The coarse face that stands for each face.
    pub stands_for: Vec<u32>,
}

/// Cluster the corners until at most [`MOST_FACES`] faces are left.
#[must_use]
pub fn coarse(vertices: &[Vec3], faces: &[[usize; 3]], low: &Vec3, diagonal: f64) -> Coarse {
    let area: f64 = faces
        .iter()
        .map(|f| (vertices[f[1]] - vertices[f[0]]).cross(&(vertices[f[2]] - vertices[f[0]])).norm() / 2.0)
        .sum();
    // Cells of side h leave about two faces per h squared; loose sheets never need cells below a 2000th.
    let mut cell = (2.0 * area / MOST_FACES as f64).sqrt().clamp(diagonal / 2000.0, diagonal / 20.0);
    loop {
        let found = clustered(vertices, faces, low, cell);
        if found.faces.len() <= MOST_FACES || cell > diagonal {
            return found;
        }
        cell *= GROWTH;
    }
}

fn clustered(vertices: &[Vec3], faces: &[[usize; 3]], low: &Vec3, cell: f64) -> Coarse {
    let mut number: HashMap<[i32; 3], u32> = HashMap::new();
    let mut sums: Vec<(Vec3, f64)> = Vec::new();
    let cluster: Vec<u32> = vertices
        .iter()
        .map(|v| {
            let key = [0, 1, 2].map(|k| ((v[k] - low[k]) / cell) as i32);
            let n = *number.entry(key).or_insert_with(|| {
                sums.push((Vec3::zeros(), 0.0));
                sums.len() as u32 - 1
            });
            sums[n as usize].0 += v;
            sums[n as usize].1 += 1.0;
            n
        })
        .collect();
    let mut seen: HashMap<[u32; 3], u32> = HashMap::new();
    let mut kept: Vec<[usize; 3]> = Vec::new();
    let mut at_corner = vec![u32::MAX; sums.len()];
    let mut stands_for = vec![u32::MAX; faces.len()];
    for (i, face) in faces.iter().enumerate() {
        let corners = face.map(|v| cluster[v]);
        let mut key = corners;
        key.sort_unstable();
        if key[0] == key[1] || key[1] == key[2] {
            continue;
        }
        let n = *seen.entry(key).or_insert_with(|| {
            kept.push(corners.map(|c| c as usize));
            kept.len() as u32 - 1
        });
        stands_for[i] = n;
        for c in corners {
            at_corner[c as usize] = n;
        }
    }
    // A face that fell into one or two cells goes where another face of its cells went.
    let mut last = 0;
    for (i, face) in faces.iter().enumerate() {
        if stands_for[i] == u32::MAX {
            let near = face.iter().map(|&v| at_corner[cluster[v] as usize]).find(|&n| n != u32::MAX);
            stands_for[i] = near.unwrap_or(last);
        }
        last = stands_for[i];
    }
    Coarse { vertices: sums.iter().map(|(sum, n)| sum / *n).collect(), faces: kept, stands_for }
}
