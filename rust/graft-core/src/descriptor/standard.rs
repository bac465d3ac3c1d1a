//! Makes features commensurate, and comparable by cosine.
//!
//! Each feature is centred, divided by its spread and bent onto an arc, `theta = pi/2 tanh(z / BEND)`, and stored as
//! `(cos theta, sin theta)` times the root of its weight. Rows have length 1, and one minus the cosine of two rows is
//! the weighted mean of `1 - cos(theta_f - theta_g)`: it grows with every single difference, whereas the cosine of
//! the standardised features themselves compares directions from the average part and loses how far.

use super::Family;
use super::constants::{CURVE, DISTRIBUTIONS, HARMONICS, HULL, INERTIA};
use std::f64::consts::FRAC_PI_2;

/// Columns per feature.
pub const WIDTH: usize = 2;
/// Deviations from the mean at which the arc bends off: two ordinary parts then differ by .1 to .95 (5th and 95th
/// percentile over the parts the constants were measured on).
const BEND: f64 = 1.5;

/// What one family contributes to the distance, before division by the sum over the chosen families.
///
/// Chosen on the half of the objects that `benches/descriptor.py` calls the tuning half: the tube carries what
/// handles of different objects share, the others keep parts of one category together. The optimum is flat.
fn weight(family: Family) -> f64 {
    match family {
        Family::Curve => 4.0,
        Family::Hull => 0.5,
        Family::Inertia | Family::Distributions | Family::Harmonics => 0.25,
    }
}

/// Append one family's columns; `all` are the families of the row. NaN, what a part cannot answer, is average.
pub fn embed(all: &[Family], family: Family, features: &[f64], row: &mut Vec<f64>) {
    let constants: &[[f64; 2]] = match family {
        Family::Hull => &HULL,
        Family::Inertia => &INERTIA,
        Family::Curve => &CURVE,
        Family::Distributions => &DISTRIBUTIONS,
        Family::Harmonics => &HARMONICS,
    };
    let total: f64 = all.iter().map(|&other| weight(other)).sum();
    let share = (weight(family) / total / features.len() as f64).sqrt();
    for (feature, [mean, deviation]) in features.iter().zip(constants) {
        let z = if feature.is_finite() { (feature - mean) / deviation } else { 0.0 };
        let (sin, cos) = (FRAC_PI_2 * (z / BEND).tanh()).sin_cos();
        row.extend([share * cos, share * sin]);
    }
}
