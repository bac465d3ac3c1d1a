//! How a part lies in its object: its size among the others, where it is, and how it is attached.
//!
//! A handle, a spout and a lid may look alike as shapes; what tells them apart is their share of the object, how far they
//! stand out, and where along the part the rest of the object touches it. Every feature is free of pose and scale,
//! standardised by fixed constants and bent onto an arc, so that `1 - cosine` of two rows is the mean over the
//! features of `1 - cos` of their difference. What an object cannot answer (no up axis, no other part) is 0 in both
//! coordinates and counts as a difference of a right angle.

use std::f64::consts::FRAC_PI_2;

use nalgebra::Vector3;
use rayon::prelude::*;

use super::nearest::Nearest;
use crate::geometry::OrientedBox;

/// Number of features before they are bent onto arcs.
pub const FEATURES: usize = 17;
/// Width of a row.
pub const WIDTH: usize = 2 * FEATURES;

/// Surface points within this share of the diagonal of another part are where the part is attached: half a wall of a
/// mug, twice the spacing of samples on a handle.
const ATTACHED: f64 = 0.03;
/// Where fewer points are that near, as many of the nearest stand for the attachment.
const FEWEST_ATTACHED: usize = 16;
/// Points of a part whose distance to the others is taken.
const PROBES: usize = 512;
/// Standard deviations at which the arc has bent to tanh(1) of its right angle. Between 1.5 and 2.5 the share of
/// transferred contacts that land changes by less than 1 % (`benches/results`).
const BEND: f64 = 2.0;
/// No extent, area or volume counts as smaller than this share of the object's.
const SMALLEST: f64 = 1e-6;

/// What the relations of a part are taken from.
#[derive(Debug, Clone, Copy)]
pub struct PartSurface<'a> {
    /// Its box.
    pub bounds: &'a OrientedBox,
    /// Its surface samples.
    pub points: &'a [[f64; 3]],
    /// Its surface area.
    pub area: f64,
}

/// Return (n, WIDTH) rows of length at most 1.
///
/// `diagonal` is the object's, in the unit of the points; `up` its up axis, of length 1, when it has one.
#[must_use]
pub fn relations(parts: &[PartSurface], diagonal: f64, up: Option<Vector3<f64>>) -> Vec<f64> {
    raw_relations(parts, diagonal, up).iter().flat_map(embed).collect()
}

/// Return the features before standardisation; None where the object cannot answer.
#[must_use]
pub fn raw_relations(parts: &[PartSurface], diagonal: f64, up: Option<Vector3<f64>>) -> Vec<[Option<f64>; FEATURES]> {
    let whole = Whole::new(parts, diagonal, up);
    (0..parts.len()).into_par_iter().map(|part| whole.features(part)).collect()
}

fn embed(features: &[Option<f64>; FEATURES]) -> [f64; WIDTH] {
    let scale = (FEATURES as f64).sqrt().recip();
    let mut row = [0.0; WIDTH];
    for (k, feature) in features.iter().enumerate() {
        if let Some(x) = feature {
            let [mean, deviation] = STANDARD[k];
            let angle = FRAC_PI_2 * ((x - mean) / (deviation * BEND)).tanh();
            row[2 * k] = scale * angle.cos();
            row[2 * k + 1] = scale * angle.sin();
        }
    }
    row
}

struct Whole<'a> {
    parts: &'a [PartSurface<'a>],
    diagonal: f64,
    trees: Vec<Nearest>,
    centroids: Vec<Vector3<f64>>,
    centroid: Vector3<f64>,
    area: f64,
    up: Option<(Vector3<f64>, f64, f64)>,
}

impl<'a> Whole<'a> {
    fn new(parts: &'a [PartSurface<'a>], diagonal: f64, up: Option<Vector3<f64>>) -> Self {
        let centroids: Vec<_> = parts.iter().map(|part| mean(part.points.iter())).collect();
        let area: f64 = parts.iter().map(|part| part.area).sum();
        let trees = parts.par_iter().map(|part| Nearest::new(part.points)).collect();
        let centroid = weighted(parts.iter().zip(&centroids).map(|(part, c)| (part.area, *c)));
        let up = up.map(|up| {
            let heights = || parts.iter().flat_map(|part| part.points).map(|p| Vector3::from(*p).dot(&up));
            (up, heights().fold(f64::INFINITY, f64::min), heights().fold(f64::NEG_INFINITY, f64::max))
        });
        Self { parts, diagonal, trees, centroids, centroid, area, up }
    }

    fn features(&self, part: usize) -> [Option<f64>; FEATURES] {
        let PartSurface { bounds, area, .. } = self.parts[part];
        let centroid = self.centroids[part];
        let share = |x: f64| Some((x / self.diagonal).max(SMALLEST).ln());
        let extents = bounds.half_extents;
        let volume: f64 = extents.iter().map(|e| (2.0 * e / self.diagonal).max(SMALLEST)).product();
        let mut features = [None; FEATURES];
        features[0] = share(extents[0]);
        features[1] = share(extents[1]);
        features[2] = share(extents[2]);
        features[3] = Some((area / self.area.max(f64::MIN_POSITIVE)).max(SMALLEST).ln());
        features[4] = Some(volume.ln());
        features[5] = Some((centroid - self.centroid).norm() / self.diagonal);
        if self.parts.len() > 1 {
            features[6..14].copy_from_slice(&self.attachment(part).map(Some));
        }
        if let Some((up, low, high)) = self.up {
            let offset = centroid - self.centroid;
            features[14] = Some((centroid.dot(&up) - low) / (high - low).max(SMALLEST * self.diagonal));
            features[15] = Some(bounds.axes[0].dot(&up).abs());
            features[16] = Some((offset - up * offset.dot(&up)).norm() / self.diagonal);
        }
        features
    }

    /// Distance of the rest's centroid; greatest and median distance of the surface from the other parts; where along the
    /// long axis, how widely, how far from the centroid and over how much of the surface the part is attached.
    fn attachment(&self, part: usize) -> [f64; 8] {
        let others = || (0..self.parts.len()).filter(|&k| k != part);
        let centroid = self.centroids[part];
        let rest = weighted(others().map(|k| (self.parts[k].area, self.centroids[k])));
        let bounds = self.parts[part].bounds;
        let points = self.parts[part].points;
        let step = points.len().div_ceil(PROBES).max(1);
        let mut probes: Vec<(f64, Vector3<f64>)> = points
            .iter()
            .step_by(step)
            .map(|p| {
                let squared = others().fold(f64::INFINITY, |best, k| self.trees[k].squared_distance(p, best));
                (squared.sqrt() / self.diagonal, Vector3::from(*p))
            })
            .collect();
        probes.sort_by(|a, b| a.0.total_cmp(&b.0));
        let near = probes.iter().take_while(|(d, _)| *d < ATTACHED).count();
        let attached = &probes[..near.max(FEWEST_ATTACHED).min(probes.len())];
        let along = |p: &Vector3<f64>| (p - bounds.center).dot(&bounds.axes[0]) / bounds.half_extents[0];
        let count = attached.len() as f64;
        let mean_along = attached.iter().map(|(_, p)| along(p)).sum::<f64>() / count;
        let variance = attached.iter().map(|(_, p)| (along(p) - mean_along).powi(2)).sum::<f64>() / count;
        let place = attached.iter().map(|(_, p)| *p).sum::<Vector3<f64>>() / count;
        let spread = attached.iter().map(|(_, p)| (p - place).norm()).sum::<f64>() / count;
        [
            (centroid - rest).norm() / self.diagonal,
            probes.last().map_or(0.0, |(d, _)| *d),
            probes[probes.len() / 2].0,
            mean_along.abs(),
            variance.sqrt(),
            (place - centroid).norm() / self.diagonal,
            spread / self.diagonal,
            near as f64 / probes.len() as f64,
        ]
    }
}

fn mean<'p>(points: impl ExactSizeIterator<Item = &'p [f64; 3]>) -> Vector3<f64> {
    let count = points.len().max(1) as f64;
    points.map(|p| Vector3::from(*p)).sum::<Vector3<f64>>() / count
}

fn weighted(items: impl Iterator<Item = (f64, Vector3<f64>)> + Clone) -> Vector3<f64> {
    let total: f64 = items.clone().map(|(weight, _)| weight).sum();
    if total > 0.0 {
        return items.map(|(weight, x)| x * weight).sum::<Vector3<f64>>() / total;
    }
    let count = items.clone().count().max(1) as f64;
    items.map(|(_, x)| x).sum::<Vector3<f64>>() / count
}

/// Mean and standard deviation of every feature.
///
/// Measured with `benches/relations.py` over the parts of 19 meshes of the Princeton segmentation benchmark, 9 YCB scans
/// (every other object of each set in the order of their names) and two variants of every category of the zoo.
#[rustfmt::skip]
const STANDARD: [[f64; 2]; FEATURES] = [
    [-1.9816, 0.7729], [-2.6070, 0.8051], [-3.5606, 0.9590], [-2.2982, 1.4461], [-6.0698, 2.0529], [0.2461, 0.1318],
    [0.3087, 0.1311], [0.1718, 0.1725], [0.0816, 0.0923], [0.2531, 0.3427], [0.5096, 0.2637], [0.0712, 0.0943],
    [0.1054, 0.0783], [0.4797, 0.3700], [0.5518, 0.2908], [0.3943, 0.4622], [0.1066, 0.1356],
];
