//! Spherical harmonics on shells around the centre (Kazhdan, Funkhouser, Rusinkiewicz 2003).
//!
//! The energy of each degree on each shell does not change under rotation or mirroring.

use super::surface::Surface;

/// Middles of the shells, in root-mean-square radii; each sample is shared linearly between its two nearest.
const SHELLS: [f64; 5] = [0.3, 0.65, 1.0, 1.35, 1.7];
/// Highest degree.
const DEGREE: usize = 6;
/// Shells x degrees 0 to 6.
pub const HARMONICS: usize = SHELLS.len() * (DEGREE + 1);
/// Coefficients of one shell, order m >= 0 with cosine and sine.
const ORDERS: usize = (DEGREE + 1) * (DEGREE + 1);

/// Root of the energy of each degree on each shell; the samples weigh 1 together.
pub fn harmonics(surface: &Surface) -> Vec<f64> {
    let mut sums = [[0.0; ORDERS]; SHELLS.len()];
    let n = surface.samples.len() as f64;
    let norms = norms();
    for point in &surface.samples {
        let radius = point.norm();
        let values = basis(if radius > 0.0 { *point / radius } else { nalgebra::Vector3::z() }, &norms);
        let at = ((radius - SHELLS[0]) / (SHELLS[1] - SHELLS[0])).clamp(0.0, SHELLS.len() as f64 - 1.0);
        let inner = (at as usize).min(SHELLS.len() - 2);
        let share = at - inner as f64;
        for k in 0..ORDERS {
            sums[inner][k] += (1.0 - share) * values[k] / n;
            sums[inner + 1][k] += share * values[k] / n;
        }
    }
    sums.iter()
        .flat_map(|shell| {
            (0..=DEGREE).map(|l| shell[l * l..(l + 1) * (l + 1)].iter().map(|c| c * c).sum::<f64>().sqrt())
        })
        .collect()
}

/// Real spherical harmonics times sqrt(4 pi) up to `DEGREE` at a unit vector; degree l fills l^2 .. (l + 1)^2.
fn basis(unit: nalgebra::Vector3<f64>, norms: &[[f64; DEGREE + 1]; DEGREE + 1]) -> [f64; ORDERS] {
    let mut result = [0.0; ORDERS];
    let (x, y, z) = (unit.x, unit.y, unit.z);
    // (x + i y)^m carries the sine of the polar angle, so the Legendre factors below have none.
    let (mut cosine, mut sine, mut diagonal) = (1.0, 0.0, 1.0);
    for m in 0..=DEGREE {
        let (mut before, mut legendre) = (0.0, diagonal);
        for l in m..=DEGREE {
            let norm = norms[l][m];
            if m == 0 {
                result[l * l] = norm * legendre;
            } else {
                result[l * l + 2 * m - 1] = norm * legendre * cosine;
                result[l * l + 2 * m] = norm * legendre * sine;
            }
            let next = ((2 * l + 1) as f64 * z * legendre - (l + m) as f64 * before) / (l + 1 - m) as f64;
            (before, legendre) = (legendre, next);
        }
        diagonal *= (2 * m + 1) as f64;
        (cosine, sine) = (x * cosine - y * sine, x * sine + y * cosine);
    }
    result
}

/// Root of (2l + 1) (l - m)! / (l + m)!, doubled for m > 0.
fn norms() -> [[f64; DEGREE + 1]; DEGREE + 1] {
    std::array::from_fn(|l| {
        std::array::from_fn(|m| {
            let ratio: f64 = (l + 1 - m.min(l)..=l + m).map(|k| k as f64).product();
            ((2 * l + 1) as f64 / ratio * if m > 0 { 2.0 } else { 1.0 }).sqrt()
        })
    })
}
