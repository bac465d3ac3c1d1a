//! The families of hull and surface moments.

use super::hull::Hull;
use super::surface::{Point, Surface, principal};
use std::f64::consts::PI;

/// Number of hull features.
pub const HULL: usize = 10;
/// Number of surface moments.
pub const INERTIA: usize = 7;
/// Ratios below this are indistinguishable from zero; it keeps logarithms finite.
const SMALL: f64 = 1e-4;

/// Proportions of the convex hull and how the surface lies in it; NaN where clouds have no answer.
pub fn hull(surface: &Surface) -> Vec<f64> {
    let hull = Hull::new(surface);
    let (axes, deviations) = principal(&hull.covariance);
    let extents: Vec<f64> = (0..3)
        .map(|k| {
            let axis = axes.column(k).into_owned();
            let along = hull.facets.iter().flatten().map(|p| axis.dot(p));
            let (low, high) = along.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), x| (l.min(x), h.max(x)));
            (high - low).max(SMALL)
        })
        .collect();
    let box_volume: f64 = extents.iter().product();
    let size = deviations.iter().map(|s| s * s).sum::<f64>().sqrt();
    let depths = {
        let mut depths: Vec<f64> = surface.few.iter().map(|p| hull.depth(p)).collect();
        depths.sort_by(f64::total_cmp);
        depths
    };
    let area: f64 = surface.areas.iter().sum();
    let cloud = surface.faces.is_empty();
    vec![
        (deviations[1] / deviations[0]).ln(),
        (deviations[2] / deviations[1]).ln(),
        (36.0 * PI * hull.volume.powi(2) / hull.area.powi(3).max(f64::MIN_POSITIVE)).max(SMALL * SMALL).ln(),
        (hull.volume / box_volume).min(1.0),
        hull.centroid.norm() / size,
        depths.iter().sum::<f64>() / depths.len() as f64 / size,
        depths[depths.len() * 9 / 10] / size,
        size.ln(),
        if cloud { f64::NAN } else { (capped_volume(surface) / hull.volume).clamp(0.0, 1.0).sqrt() },
        if cloud { f64::NAN } else { (area / hull.area.max(SMALL)).clamp(SMALL, 1.0 / SMALL).ln() },
    ]
}

/// Proportions and shape of the distribution of surface about its centre.
pub fn inertia(surface: &Surface) -> Vec<f64> {
    let [s1, s2, s3] = surface.deviations;
    let n = surface.samples.len() as f64;
    let mean = |f: &dyn Fn(&Point) -> f64| surface.samples.iter().map(f).sum::<f64>() / n;
    let centre = surface.samples.iter().sum::<Point>() / n;
    let cubic = surface.samples.iter().map(|p| (p - centre) * (p - centre).norm_squared()).sum::<Point>() / n;
    vec![
        (s2 / s1).ln(),
        (s3 / s2).ln(),
        cubic.norm(),
        mean(&|p| (p - centre).norm_squared().powi(2)),
        mean(&|p| (p - centre).norm()),
        mean(&|p| ((p - centre).x / s1).powi(4)).min(20.0),
        mean(&|p| ((p - centre).x / s1).powi(3)).abs().min(10.0),
    ]
}

/// Volume enclosed once every hole is closed by a fan to its centroid; the absolute value.
///
/// With a x b summed over the directed edges of a hole's rim (edges inside the surface cancel), a fan to the apex o
/// adds -o . sum(a x b) / 6: no hole has to be walked around.
pub fn capped_volume(surface: &Surface) -> f64 {
    let vertices = &surface.vertices;
    let welded = weld(vertices);
    let mut open = vec![Point::zeros(); vertices.len()];
    let mut volume = 0.0;
    for face in &surface.faces {
        let [a, b, c] = face.map(|i| welded[i]);
        volume += vertices[a].dot(&vertices[b].cross(&vertices[c])) / 6.0;
        open[a] += vertices[c] - vertices[b];
        open[b] += vertices[a] - vertices[c];
        open[c] += vertices[b] - vertices[a];
    }
    // Around an inner vertex the opposite edges form a closed ring and sum to zero.
    let rim: Vec<bool> = open.iter().map(|sum| sum.norm() > 1e-9).collect();
    let mut parent: Vec<usize> = (0..vertices.len()).collect();
    let edges: Vec<(usize, usize)> = surface
        .faces
        .iter()
        .flat_map(|face| {
            let [a, b, c] = face.map(|i| welded[i]);
            [(a, b), (b, c), (c, a)]
        })
        .filter(|&(a, b)| rim[a] && rim[b])
        .collect();
    for &(a, b) in &edges {
        let (a, b) = (root(&mut parent, a), root(&mut parent, b));
        parent[a.max(b)] = a.min(b);
    }
    let mut apex = vec![(Point::zeros(), 0.0); vertices.len()];
    for i in (0..vertices.len()).filter(|&i| rim[i]) {
        let hole = root(&mut parent, i);
        apex[hole].0 += vertices[i];
        apex[hole].1 += 1.0;
    }
    for &(a, b) in &edges {
        let (sum, count) = apex[root(&mut parent, a)];
        volume -= (sum / count).dot(&vertices[a].cross(&vertices[b])) / 6.0;
    }
    volume.abs()
}

/// For every vertex the first one at the same place: some files repeat the corners of every triangle.
fn weld(vertices: &[Point]) -> Vec<usize> {
    let mut order: Vec<(u64, u64, u64, usize)> = vertices
        .iter()
        .enumerate()
        .map(|(i, v)| ((v.x + 0.0).to_bits(), (v.y + 0.0).to_bits(), (v.z + 0.0).to_bits(), i))
        .collect();
    order.sort_unstable();
    let mut first = vec![0; vertices.len()];
    let mut at = 0;
    for (k, &(x, y, z, i)) in order.iter().enumerate() {
        let (px, py, pz, _) = order[at];
        if (x, y, z) != (px, py, pz) {
            at = k;
        }
        first[i] = order[at].3;
    }
    first
}

fn root(parent: &mut [usize], mut i: usize) -> usize {
    while parent[i] != i {
        parent[i] = parent[parent[i]];
        i = parent[i];
    }
    i
}
