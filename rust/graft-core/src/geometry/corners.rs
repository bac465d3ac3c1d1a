//! Points laid out for the question that the search for the minimal box asks: how far do they reach along an axis?
//!
//! Every point is looked at. For the few hundred points the search works on this is faster than walking uphill over a
//! hull from neighbour to neighbour, and it cannot end early on a side that is flat but for rounding.

use super::Vec3;

/// Points that are looked at together: the loops over them become vector instructions.
const LANES: usize = 8;

/// Points by coordinate in groups; the first one is repeated to fill the last group.
pub struct Corners {
    groups: Vec<[[f64; LANES]; 3]>,
}

/// Smaller of two numbers, as the processor has it; not for NaN.
fn least(a: f64, b: f64) -> f64 {
    if a < b { a } else { b }
}

/// Larger of two numbers, as the processor has it; not for NaN.
fn most(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}

/// How high the points of a group are along a direction.
#[inline]
fn heights([x, y, z]: &[[f64; LANES]; 3], d: &Vec3) -> [f64; LANES] {
    let mut heights = [0.0; LANES];
    for l in 0..LANES {
        heights[l] = x[l] * d.x + y[l] * d.y + z[l] * d.z;
    }
    heights
}

impl Corners {
    /// Lay out non-empty points.
    #[must_use]
    pub fn new(points: &[Vec3]) -> Self {
        let group = |chunk: &[Vec3]| {
            [0, 1, 2].map(|k| std::array::from_fn(|l| if l < chunk.len() { chunk[l][k] } else { points[0][k] }))
        };
        Self { groups: points.chunks(LANES).map(group).collect() }
    }

    /// The lowest and the highest height along a direction.
    #[must_use]
    pub fn reach(&self, direction: &Vec3) -> (f64, f64) {
        let (mut low, mut high) = ([f64::INFINITY; LANES], [f64::NEG_INFINITY; LANES]);
        for group in &self.groups {
            let heights = heights(group, direction);
            for l in 0..LANES {
                low[l] = least(heights[l], low[l]);
                high[l] = most(heights[l], high[l]);
            }
        }
        (low.into_iter().fold(f64::INFINITY, least), high.into_iter().fold(f64::NEG_INFINITY, most))
    }

    /// Size along a direction.
    #[must_use]
    pub fn extent(&self, direction: &Vec3) -> f64 {
        let (low, high) = self.reach(direction);
        high - low
    }

    /// Volume of the box with these axes.
    #[must_use]
    pub fn volume(&self, axes: &[Vec3; 3]) -> f64 {
        axes.iter().map(|axis| self.extent(axis)).product()
    }

    /// The first point at a height along a direction, as [`Self::reach`] has it.
    #[must_use]
    pub fn at(&self, direction: &Vec3, height: f64) -> usize {
        for (g, group) in self.groups.iter().enumerate() {
            let heights = heights(group, direction);
            if let Some(l) = heights.iter().position(|h| *h == height) {
                return g * LANES + l;
            }
        }
        0
    }

    /// The lowest and the highest point along a direction.
    #[must_use]
    pub fn ends(&self, direction: &Vec3) -> [usize; 2] {
        let (low, high) = self.reach(direction);
        [self.at(direction, low), self.at(direction, high)]
    }
}

/// Directions spread evenly over half a sphere.
pub fn spread_directions(count: usize) -> impl Iterator<Item = Vec3> {
    let golden = std::f64::consts::PI * (3.0 - 5.0f64.sqrt());
    (0..count).map(move |i| {
        let z = 1.0 - (i as f64 + 0.5) / count as f64;
        let (s, c) = (golden * i as f64).sin_cos();
        let r = (1.0 - z * z).sqrt();
        Vec3::new(r * c, r * s, z)
    })
}
