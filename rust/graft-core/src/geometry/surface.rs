//! Surfaces: area, volume, centroid, samples with normals; of meshes and of point clouds.

use nalgebra::Matrix3;
use rand::RngExt;
use rand_pcg::Pcg64;

use super::Vec3;
use super::affine::any_normal;
use super::moments::{Moments, surface_moments};

/// Neighbours by whose plane a cloud's normal and by whose disk its area are estimated.
const NEIGHBOURS: usize = 16;

/// Normals are estimated from at most this many points of a cloud, evenly strided; more only cost time.
const CLOUD_CAP: usize = 16_384;

/// Area, volume, centroid and covariance of a surface.
#[derive(Debug, Clone, Copy)]
pub struct Measure {
    /// Surface area.
    pub area: f64,
    /// Signed enclosed volume: meaningful for closed surfaces, positive when they are wound outward.
    pub volume: f64,
    /// Centroid of the surface.
    pub centroid: Vec3,
    /// Covariance of the surface about it.
    pub covariance: Matrix3<f64>,
}

/// Surface samples.
#[derive(Debug, Clone, Default)]
pub struct Samples {
    /// Points on the surface.
    pub points: Vec<Vec3>,
    /// Outward unit normals there.
    pub normals: Vec<Vec3>,
}

fn corners(vertices: &[Vec3], face: [usize; 3]) -> [Vec3; 3] {
    face.map(|i| vertices[i])
}

fn mean(points: &[Vec3]) -> Vec3 {
    points.iter().sum::<Vec3>() / points.len() as f64
}

/// Measure a mesh; a mesh without area has its vertices' mean and covariance.
#[must_use]
pub fn measure(vertices: &[Vec3], faces: &[[usize; 3]]) -> Measure {
    let Moments { area, centroid, covariance } = surface_moments(vertices, faces, |i| i);
    let six_volumes = faces.iter().map(|&face| {
        let [a, b, c] = corners(vertices, face).map(|p| p - centroid);
        a.dot(&b.cross(&c))
    });
    Measure { area, volume: six_volumes.sum::<f64>() / 6.0, centroid, covariance }
}

/// Whether every directed edge is met once in each direction.
#[must_use]
pub fn is_closed(faces: &[[usize; 3]]) -> bool {
    let directed = |flip: bool| {
        let mut edges: Vec<(usize, usize)> = faces
            .iter()
            .flat_map(|f| (0..3).map(move |k| (f[k], f[(k + 1) % 3])))
            .map(|(a, b)| if flip { (b, a) } else { (a, b) })
            .collect();
        edges.sort_unstable();
        edges
    };
    let forward = directed(false);
    forward.windows(2).all(|w| w[0] != w[1]) && forward == directed(true)
}

/// Sample `count` points of a mesh of positive area, stratified by area: sample k lies at a random place of the k-th of
/// `count` equal pieces of the surface, so that every face gets its share to within one sample.
///
/// Normals are the faces', reversed when the surface is closed and wound inward.
#[must_use]
pub fn sample_mesh(vertices: &[Vec3], faces: &[[usize; 3]], count: usize, seed: u64, stream: u64) -> Samples {
    let doubled: Vec<Vec3> = faces
        .iter()
        .map(|&f| {
            let [a, b, c] = corners(vertices, f);
            (b - a).cross(&(c - a))
        })
        .collect();
    let mut total = 0.0;
    let cumulative: Vec<f64> = doubled
        .iter()
        .map(|d| {
            total += d.norm();
            total
        })
        .collect();
    let inward = measure(vertices, faces).volume < 0.0 && is_closed(faces);
    let sign = if inward { -1.0 } else { 1.0 };
    let mut random = generator(seed, stream);
    let mut samples = Samples::default();
    for k in 0..count {
        let at = (k as f64 + random.random::<f64>()) / count as f64 * total;
        let (r1, r2) = (random.random::<f64>().sqrt(), random.random::<f64>());
        // The first face whose end lies beyond; faces without area are never it.
        let mut face = cumulative.partition_point(|&c| c <= at).min(faces.len() - 1);
        while doubled[face].norm_squared() <= 0.0 && face > 0 {
            face -= 1;
        }
        let [a, b, c] = corners(vertices, faces[face]);
        samples.points.push(a * (1.0 - r1) + b * (r1 * (1.0 - r2)) + c * (r1 * r2));
        samples.normals.push(doubled[face].normalize() * sign);
    }
    samples
}

/// Choose `count` points of a cloud, without repeats until all have been taken, and give them normals.
///
/// `normals` may be empty or have zero rows, which are estimated: the least direction of the nearest neighbours, turned
/// away from the cloud's centroid. Also returns the cloud's estimated area: each chosen point's neighbours cover a disk.
#[must_use]
pub fn sample_cloud(points: &[Vec3], normals: &[Vec3], count: usize, seed: u64, stream: u64) -> (Samples, f64) {
    let mut random = generator(seed, stream);
    let mut order: Vec<usize> = (0..points.len()).collect();
    let distinct = count.min(points.len());
    for k in 0..distinct {
        order.swap(k, random.random_range(k..points.len()));
    }
    let centroid = mean(points);
    let stride = points.len().div_ceil(CLOUD_CAP);
    let thinned: Vec<Vec3> = points.iter().step_by(stride).copied().collect();
    let mut samples = Samples::default();
    let (mut disks, mut near) = (0.0, Vec::new());
    for &i in &order[..distinct] {
        let p = points[i];
        let (estimated, disk) = neighbourhood(&thinned, &p, &centroid, &mut near);
        disks += disk;
        let given = normals.get(i).and_then(|n| n.try_normalize(1e-12));
        samples.points.push(p);
        samples.normals.push(given.unwrap_or(estimated));
    }
    for k in distinct..count {
        samples.points.push(samples.points[k - distinct]);
        samples.normals.push(samples.normals[k - distinct]);
    }
    let area = if distinct == 0 { 0.0 } else { disks / distinct as f64 * thinned.len() as f64 };
    (samples, area)
}

/// Estimate the normal at `p` and the area that one point stands for.
fn neighbourhood(cloud: &[Vec3], p: &Vec3, centroid: &Vec3, near: &mut Vec<(f64, usize)>) -> (Vec3, f64) {
    near.clear();
    near.extend(cloud.iter().enumerate().map(|(i, q)| ((q - p).norm_squared(), i)));
    let k = NEIGHBOURS.min(near.len());
    near.select_nth_unstable_by(k - 1, |a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    let disk = std::f64::consts::PI * near[k - 1].0 / k as f64;
    let middle = near[..k].iter().map(|n| cloud[n.1]).sum::<Vec3>() / k as f64;
    let size = near[k - 1].0.max(f64::MIN_POSITIVE);
    let mut covariance = Matrix3::zeros();
    for (_, i) in &near[..k] {
        let d = cloud[*i] - middle;
        covariance += d * d.transpose() / size;
    }
    let away = p - centroid;
    let eigen = covariance.symmetric_eigen();
    let mut rank = [0, 1, 2];
    rank.sort_by(|&a, &b| eigen.eigenvalues[a].total_cmp(&eigen.eigenvalues[b]));
    let middle_value = eigen.eigenvalues[rank[1]];
    // Neighbours on a line or a point have no least direction: look away from the centroid, across the line.
    let normal = if middle_value > 1e-9 {
        eigen.eigenvectors.column(rank[0]).into_owned()
    } else {
        let line = eigen.eigenvectors.column(rank[2]).into_owned();
        let line = if eigen.eigenvalues[rank[2]] > 1e-9 { line } else { Vec3::zeros() };
        let across = away - line * away.dot(&line);
        let fallback = if line.norm_squared() > 0.5 { any_normal(&line) } else { Vec3::z() };
        across.try_normalize(1e-9 * away.norm().max(f64::MIN_POSITIVE)).unwrap_or(fallback)
    };
    (if normal.dot(&away) < 0.0 { -normal } else { normal }.normalize(), disk)
}

fn generator(seed: u64, stream: u64) -> Pcg64 {
    // PCG's streams are independent: parts differ, whatever thread they are on.
    let mut random = Pcg64::new(u128::from(seed), u128::from(stream));
    let _warm: u64 = random.random();
    random
}
