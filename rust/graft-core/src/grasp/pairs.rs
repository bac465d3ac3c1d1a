//! Antipodal pairs: two places whose connecting line lies in both friction cones (Nguyen 1988).

use std::f64::consts::TAU;

use rand::RngExt;
use rand_pcg::Pcg64;
use rayon::prelude::*;

use super::collision::Collider;
use super::samples::Sample;
use super::sides::Side;
use crate::geometry::Vec3;
use crate::geometry::search::plane_axes;

/// How far beyond the stroke an opposite wall is looked for, in strokes: to tell "too wide" from "no other side".
const LOOK_BEYOND: f64 = 3.0;

/// Hits nearer than this, in metres, are the place itself.
const NOTHING: f64 = 1e-7;

/// The mesh, and what is known of its faces.
#[derive(Debug)]
pub struct Sheet<'a> {
    /// Corners.
    pub vertices: &'a [Vec3],
    /// Triangles.
    pub faces: &'a [[usize; 3]],
    /// The part of each.
    pub face_parts: &'a [usize],
    /// What is known of each part.
    pub sides: &'a [Side],
}

impl Sheet<'_> {
    /// A face's outward unit normal; None when it has no area.
    #[must_use]
    pub fn normal(&self, face: usize) -> Option<Vec3> {
        let [a, b, c] = self.faces[face].map(|v| self.vertices[v]);
        let normal = (b - a).cross(&(c - a)).try_normalize(0.0)?;
        Some(self.side(face).outward(normal))
    }

    /// What is known of a face.
    #[must_use]
    pub fn side(&self, face: usize) -> Side {
        self.sides[self.face_parts[face]]
    }
}

/// Two places that pads could press on.
#[derive(Debug, Clone, Copy)]
pub struct Pair {
    /// Where the pad at +y presses, and where the one at -y does.
    pub points: [Vec3; 2],
    /// Unit closing axis, from the second to the first.
    pub axis: Vec3,
    /// Between them, metres.
    pub width: f64,
    /// Cosine of the greater of the angles between the axis and the normals.
    pub aligned: f64,
    /// The faces they lie on.
    pub faces: [usize; 2],
}

/// What became of one sample.
#[derive(Debug, Default)]
pub struct Found {
    /// Pairs within the stroke.
    pub pairs: Vec<Pair>,
    /// Opposite walls beyond it.
    pub too_wide: u64,
}

/// Unit directions about `axis`: itself, then `count` - 1 spread evenly over the cap of half angle acos(`cos_cone`).
fn directions(axis: &Vec3, cos_cone: f64, count: usize, rng: &mut Pcg64) -> Vec<Vec3> {
    let (u, v) = plane_axes(axis);
    (0..count)
        .map(|k| {
            if k == 0 {
                return *axis;
            }
            let cosine = rng.random_range(cos_cone..1.0);
            let (s, c) = rng.random_range(0.0..TAU).sin_cos();
            axis * cosine + (u * c + v * s) * (1.0 - cosine * cosine).sqrt()
        })
        .collect()
}

/// From every sample, look along `rays` directions within the friction cone for every opposite wall.
///
/// Of closed parts only walls that face away from each other count. Sheets have no inside: both directions are looked
/// along, either winding will do, and a sheet is its own opposite wall at no width.
#[must_use]
pub fn pairs(
    sheet: &Sheet<'_>,
    collider: &Collider,
    samples: &[Sample],
    stroke: f64,
    cos_cone: f64,
    rays: usize,
    rng: &mut Pcg64,
) -> Vec<Found> {
    let planned: Vec<(Sample, Vec3, Vec<Vec3>)> = samples
        .iter()
        .filter_map(|sample| {
            let normal = sheet.normal(sample.face)?;
            Some((*sample, normal, directions(&-normal, cos_cone, rays, rng)))
        })
        .collect();
    let search = |hits: &mut Vec<(f64, usize)>, (sample, normal, directions): &(Sample, Vec3, Vec<Vec3>)| {
        let mut found = Found::default();
        let is_sheet = sheet.side(sample.face) == Side::Both;
        if is_sheet {
            let points = [sample.point; 2];
            found.pairs.push(Pair { points, axis: *normal, width: 0.0, aligned: 1.0, faces: [sample.face; 2] });
        }
        let turned = directions.iter().map(|d| -d).filter(|_| is_sheet);
        for direction in directions.iter().copied().chain(turned) {
            collider.crossings(&sample.point, &direction, stroke * LOOK_BEYOND, hits);
            let here = normal.dot(&direction).abs();
            for &(distance, face) in hits.iter().filter(|(t, face)| *t > NOTHING && *face != sample.face) {
                let Some(there) = sheet.normal(face).map(|n| n.dot(&direction)) else { continue };
                let there = if sheet.side(face) == Side::Both { there.abs() } else { there };
                if there < cos_cone {
                    continue;
                }
                if distance > stroke {
                    found.too_wide += 1;
                    continue;
                }
                found.pairs.push(Pair {
                    points: [sample.point, sample.point + direction * distance],
                    axis: -direction,
                    width: distance,
                    aligned: here.min(there),
                    faces: [sample.face, face],
                });
            }
        }
        found
    };
    planned.par_iter().with_min_len(16).map_init(Vec::new, search).collect()
}
