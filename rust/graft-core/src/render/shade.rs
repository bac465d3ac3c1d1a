//! From samples to colours: two lights, occlusion by what lies in front, and lines where surfaces end.

use nalgebra::Vector3;
use rayon::prelude::*;

use super::{SUPERSAMPLING, Sample};

/// Share of a colour that needs no light.
const AMBIENT: f64 = 0.40;

/// Weight of the lamp at the viewer's head.
const HEADLIGHT: f64 = 0.38;

/// Weight of the lamp above the viewer's left shoulder.
const KEY_LIGHT: f64 = 0.30;

/// Where that lamp stands: left, up, and towards the viewer; unit length (2, 3, 6) / 7.
const KEY_DIRECTION: [f64; 3] = [-2.0 / 7.0, -3.0 / 7.0, -6.0 / 7.0];

/// Share of white in a highlight.
const GLOSS: f64 = 0.16;

/// Reach of the occlusion as a share of the picture's shorter side.
const OCCLUSION_REACH: f64 = 0.05;

/// How dark a corner that is open to nothing gets.
const OCCLUSION_STRENGTH: f64 = 0.75;

/// Where, in reaches, the occlusion looks: three rings of eight.
const OCCLUSION_PROBES: [[f64; 2]; 24] = probes();

/// What is left of a colour on an outline or where two groups meet.
const OUTLINE: f64 = 0.35;

/// What is left of it on a crease.
const CREASE: f64 = 0.72;

/// Neighbouring normals with a smaller cosine make a crease.
const CREASE_COSINE: f64 = 0.6;

/// A neighbour that lies farther back than this many pixels (and than the slope explains) makes an outline.
const OUTLINE_STEP: f64 = 3.0;

const fn probes() -> [[f64; 2]; 24] {
    // Eight directions, turned by half a step from ring to ring: cosines of multiples of 22.5 degrees.
    const COSINES: [f64; 5] =
        [1.0, 0.923_879_532_511_286_7, std::f64::consts::FRAC_1_SQRT_2, 0.382_683_432_365_089_8, 0.0];
    const fn cosine(step: usize) -> f64 {
        match step % 16 {
            s @ 0..=4 => COSINES[s],
            s @ 5..=8 => -COSINES[8 - s],
            s @ 9..=12 => -COSINES[s - 8],
            s => COSINES[16 - s],
        }
    }
    let mut result = [[0.0; 2]; 24];
    let mut i = 0;
    while i < 24 {
        let (ring, turn) = (i / 8, 2 * (i % 8) + (i / 8) % 2);
        let radius = (ring + 1) as f64 / 3.0;
        result[i] = [radius * cosine(turn), radius * cosine(turn + 12)];
        i += 1;
    }
    result
}

/// Return (height, width, 4) colours of (height, width) pixels of `SUPERSAMPLING`^2 samples each.
pub(super) fn shade(samples: &[Option<Sample>], width: usize, height: usize, colors: &[u8]) -> Vec<u8> {
    let grid = Grid { samples, columns: width * SUPERSAMPLING, rows: height * SUPERSAMPLING };
    let reach = OCCLUSION_REACH * width.min(height) as f64;
    let mut picture = vec![0_u8; width * height * 4];
    picture.par_chunks_mut(width * 4).enumerate().for_each(|(y, line)| {
        for (x, pixel) in line.chunks_exact_mut(4).enumerate() {
            let mut sum = Vector3::zeros();
            let mut covered = 0_usize;
            let mut openness = None;
            for i in 0..SUPERSAMPLING * SUPERSAMPLING {
                let column = x * SUPERSAMPLING + i % SUPERSAMPLING;
                let row = y * SUPERSAMPLING + i / SUPERSAMPLING;
                let Some(sample) = grid.at(column, row) else { continue };
                // Occlusion is soft, so one value per pixel will do.
                let open = *openness.get_or_insert_with(|| grid.openness(column, row, sample, reach));
                let base = Vector3::from_fn(|k, _| f64::from(colors[3 * sample.group + k]));
                sum += lit(base, &sample.normal, open) * grid.line(column, row, sample);
                covered += 1;
            }
            if covered > 0 {
                let mean = sum / covered as f64;
                for k in 0..3 {
                    pixel[k] = (mean[k] + 0.5).clamp(0.0, 255.0) as u8;
                }
                pixel[3] = (255 * covered / (SUPERSAMPLING * SUPERSAMPLING)) as u8;
            }
        }
    });
    picture
}

/// Colour of a surface under the two lamps.
fn lit(base: Vector3<f64>, normal: &Vector3<f64>, open: f64) -> Vector3<f64> {
    let key = Vector3::from(KEY_DIRECTION);
    let head = -normal.z;
    let light = AMBIENT + HEADLIGHT * head + KEY_LIGHT * normal.dot(&key).max(0.0);
    let half = (key + Vector3::new(0.0, 0.0, -1.0)).normalize();
    let mut shine = normal.dot(&half).max(0.0);
    for _ in 0..5 {
        shine *= shine; // the 32nd power
    }
    (base * light).map(|c| c + (255.0 - c).max(0.0) * GLOSS * shine) * open
}

struct Grid<'a> {
    samples: &'a [Option<Sample>],
    columns: usize,
    rows: usize,
}

impl Grid<'_> {
    fn at(&self, column: usize, row: usize) -> Option<&Sample> {
        self.samples[row * self.columns + column].as_ref()
    }

    /// Index of a neighbour, if it is in the picture.
    fn near(&self, column: usize, row: usize, right: isize, down: isize) -> Option<usize> {
        let column = column.checked_add_signed(right).filter(|&c| c < self.columns)?;
        let row = row.checked_add_signed(down).filter(|&r| r < self.rows)?;
        Some(row * self.columns + column)
    }

    /// 1 where nothing stands before the surface, less in corners (screen-space ambient occlusion, Mittring 2007).
    fn openness(&self, column: usize, row: usize, sample: &Sample, reach: f64) -> f64 {
        let mut blocked = 0.0;
        for [right, down] in OCCLUSION_PROBES {
            let (right, down) = (right * reach * SUPERSAMPLING as f64, down * reach * SUPERSAMPLING as f64);
            let Some(index) = self.near(column, row, right.round() as isize, down.round() as isize) else {
                continue;
            };
            let Some(other) = &self.samples[index] else { continue };
            let step = SUPERSAMPLING as f64;
            let toward = Vector3::new(right.round() / step, down.round() / step, other.depth - sample.depth);
            let distance = toward.norm();
            if distance > 0.0 {
                let rise = toward.dot(&sample.normal) / distance - 0.15;
                let fade = 1.0 / (1.0 + distance * distance / (reach * reach));
                blocked += rise.max(0.0) * fade;
            }
        }
        1.0 - OCCLUSION_STRENGTH * (3.0 * blocked / OCCLUSION_PROBES.len() as f64).min(1.0)
    }

    /// What a line leaves of the colour: outlines on the nearer surface, borders of groups on both, creases faintly.
    fn line(&self, column: usize, row: usize, sample: &Sample) -> f64 {
        let sideways = (1.0 - sample.normal.z * sample.normal.z).max(0.0).sqrt();
        let slope = sideways / (-sample.normal.z).max(0.05);
        let mut left: f64 = 1.0;
        for (right, down) in [(1, 0), (-1, 0), (0, 1), (0, -1)] {
            let Some(neighbour) = self.near(column, row, right, down) else { continue };
            left = left.min(match &self.samples[neighbour] {
                None => OUTLINE,
                Some(other) if other.depth - sample.depth > OUTLINE_STEP + slope => OUTLINE,
                Some(other) if sample.depth - other.depth > OUTLINE_STEP + slope => 1.0,
                Some(other) if other.group != sample.group => OUTLINE,
                Some(other) if other.normal.dot(&sample.normal) < CREASE_COSINE => CREASE,
                Some(_) => 1.0,
            });
        }
        left
    }
}
