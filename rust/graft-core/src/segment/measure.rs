//! What is measured on patches: how thick the solid is there, and how well two of them see each other inside it.
//!
//! Thickness is the shape diameter (Shapira, Shamir, Cohen-Or 2008): the trimmed mean of how far rays of a cone
//! about the inward normal go, here through the solid with its cavities closed. Visibility is the line of sight of
//! weakly convex decomposition (Asafi, Goren, Cohen-Or 2013; van Kaick et al. 2014).

use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

use super::Vec3;
use super::elements::Elements;
use super::voxels::Voxels;

/// Points spread by area over the whole surface; with [`PER_PATCH`] they make some 1,300.
const SPREAD: usize = 700;

/// Points that even the smallest patch gets.
const PER_PATCH: usize = 2;

/// Rays of a cone.
const RAYS: usize = 24;

/// Half the opening of the cone, radians; Shapira et al. take 60 degrees.
const OPENING: f64 = 50.0 * std::f64::consts::PI / 180.0;

/// Rays left out at either end of the order: those that slip out at once or run along the part.
const TRIMMED: usize = RAYS / 4;

/// Two points see each other when at most this share of their segment lies outside: less than a voxel or two of
/// roughness, or the bulge of a surface that is hardly concave.
const OUTSIDE: f64 = 0.05;

/// How far points are moved inwards before they look, in voxels.
const INWARD: f64 = 0.8;

/// The golden angle: turns of it spread directions evenly.
const GOLDEN_ANGLE: f64 = 2.399_963_229_728_653;

/// Measurements of n patches.
#[derive(Debug, Clone)]
pub struct Patches {
    /// Number of patches.
    pub count: usize,
    /// Share of the whole area.
    pub share: Vec<f64>,
    /// Mean logarithm of the thickness over the diagonal.
    pub log_thickness: Vec<f64>,
    /// (n, n) share of pairs of points that see each other.
    pub visible: Vec<f64>,
    /// Area-weighted centres, in diagonals.
    pub centers: Vec<Vec3>,
    /// Area in squared diagonals.
    pub areas: Vec<f64>,
}

impl Patches {
    /// Measure the patches given by `patch`, one per element.
    #[must_use]
    pub fn of(elements: &Elements, patch: &[u32], count: usize, grid: &Voxels, diagonal: f64, seed: u64) -> Self {
        let samples = samples(elements, patch, count, seed);
        let mut areas = vec![0.0; count];
        let mut centers = vec![Vec3::zeros(); count];
        for (i, &p) in patch.iter().enumerate() {
            areas[p as usize] += elements.areas[i];
            centers[p as usize] += elements.centers[i] * elements.areas[i];
        }
        let total: f64 = areas.iter().sum();
        for (center, area) in centers.iter_mut().zip(&areas) {
            *center /= area.max(f64::MIN_POSITIVE) * diagonal;
        }
        let mut held = vec![0.0; count];
        let mut log_thickness = vec![0.0; count];
        for &i in &samples {
            held[patch[i] as usize] += 1.0;
            log_thickness[patch[i] as usize] += (thickness(elements, i, grid) / diagonal).ln();
        }
        for (sum, held) in log_thickness.iter_mut().zip(&held) {
            *sum /= f64::max(*held, 1.0);
        }
        Self {
            count,
            share: areas.iter().map(|a| a / total).collect(),
            log_thickness,
            visible: visibility(elements, patch, count, grid, &samples, &held),
            centers,
            areas: areas.iter().map(|a| a / (diagonal * diagonal)).collect(),
        }
    }
}

/// Elements that stand for the surface: every so much area, and some of each patch; in order.
fn samples(elements: &Elements, patch: &[u32], count: usize, seed: u64) -> Vec<usize> {
    let total: f64 = elements.areas.iter().sum();
    let step = total / SPREAD as f64;
    let mut next = Pcg64Mcg::seed_from_u64(seed).random::<f64>() * step;
    let mut covered = 0.0;
    let mut chosen = Vec::with_capacity(SPREAD + PER_PATCH * count);
    let mut members = vec![Vec::new(); count];
    for i in 0..elements.len() {
        covered += elements.areas[i];
        if covered > next {
            chosen.push(i);
            while next < covered {
                next += step;
            }
        }
        members[patch[i] as usize].push(i);
    }
    for own in members {
        for k in 0..PER_PATCH {
            if let Some(&i) = own.get(own.len() * (2 * k + 1) / (2 * PER_PATCH)) {
                chosen.push(i);
            }
        }
    }
    chosen.sort_unstable();
    chosen.dedup();
    chosen
}

/// Return the shape diameter at an element, in the elements' unit. On the wall of a cavity rays go both ways.
#[must_use]
pub fn thickness(elements: &Elements, i: usize, grid: &Voxels) -> f64 {
    let (normal, center) = (elements.normals[i], elements.centers[i]);
    let across = normal.cross(&if normal.x.abs() < 0.6 { Vec3::x() } else { Vec3::y() }).normalize();
    let other = normal.cross(&across);
    let both = grid.in_cavity(&(center + normal * (1.8 * grid.size)))
        || grid.in_cavity(&(center + normal * (1.2 * grid.size)));
    let mut lengths = [0.0; RAYS];
    for (k, length) in lengths.iter_mut().enumerate() {
        let cos = 1.0 - (k as f64 + 0.5) / RAYS as f64 * (1.0 - OPENING.cos());
        let sin = (1.0 - cos * cos).sqrt();
        let turn = k as f64 * GOLDEN_ANGLE;
        let inward = -(normal * cos + (across * turn.cos() + other * turn.sin()) * sin);
        *length = grid.depth(&center, &inward);
        if both {
            *length += grid.depth(&center, &-inward);
        }
    }
    lengths.sort_by(f64::total_cmp);
    lengths[TRIMMED..RAYS - TRIMMED].iter().sum::<f64>() / (RAYS - 2 * TRIMMED) as f64
}

fn visibility(
    elements: &Elements,
    patch: &[u32],
    count: usize,
    grid: &Voxels,
    samples: &[usize],
    held: &[f64],
) -> Vec<f64> {
    // Of a sheet there is no inside: its points look along it.
    let inner: Vec<Vec3> = samples
        .iter()
        .map(|&i| {
            let inward = elements.centers[i] - elements.normals[i] * (INWARD * grid.size);
            if grid.filled(&inward) { inward } else { elements.centers[i] }
        })
        .collect();
    let mut visible = vec![0.0; count * count];
    for (a, &i) in samples.iter().enumerate() {
        let p = patch[i] as usize;
        visible[p * count + p] += 1.0;
        for (b, &j) in samples[..a].iter().enumerate() {
            if grid.sees(&inner[a], &inner[b], OUTSIDE) {
                let q = patch[j] as usize;
                visible[p * count + q] += 1.0;
                visible[q * count + p] += 1.0;
            }
        }
    }
    for p in 0..count {
        for q in 0..count {
            visible[p * count + q] /= (held[p] * held[q]).max(1.0);
        }
    }
    visible
}
