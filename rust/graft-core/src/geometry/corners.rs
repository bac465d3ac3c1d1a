//! Points laid out for the question that the search for the minimal box asks: how far do they reach along an axis?
//!
//! Every point is looked at. For the few hundred points the search works on this is faster than walking uphill over a
//! hull from neighbour to neighbour, and it cannot end early on a side that is flat but for rounding.

use wide::f64x4;

use super::Vec3;

/// Points that are looked at together.
const LANES: usize = 4;

/// Points by coordinate in groups; the last group is filled with copies of its first point.
#[derive(Default)]
pub struct Corners {
    groups: Vec<[f64x4; 3]>,
    count: usize,
}

/// How high the points of a group are along a direction.
#[inline]
fn heights([x, y, z]: &[f64x4; 3], d: &[f64x4; 3]) -> f64x4 {
    *x * d[0] + *y * d[1] + *z * d[2]
}

/// A direction for all points of a group.
fn splat(direction: &Vec3) -> [f64x4; 3] {
    [0, 1, 2].map(|k| f64x4::splat(direction[k]))
}

impl Corners {
    /// Lay out points.
    #[must_use]
    pub fn new(points: &[Vec3]) -> Self {
        let mut corners = Self { groups: Vec::with_capacity(points.len().div_ceil(LANES)), count: 0 };
        for p in points {
            corners.push(p);
        }
        corners
    }

    /// Add a point.
    pub fn push(&mut self, p: &Vec3) {
        let lane = self.count % LANES;
        self.count += 1;
        match self.groups.last_mut() {
            Some(group) if lane > 0 => {
                for k in 0..3 {
                    group[k].as_mut_array()[lane] = p[k];
                }
            }
            _ => self.groups.push(splat(p)),
        }
    }

    /// The lowest and the highest height along a direction.
    #[must_use]
    pub fn reach(&self, direction: &Vec3) -> (f64, f64) {
        let direction = splat(direction);
        let (mut low, mut high) = (f64x4::splat(f64::INFINITY), f64x4::splat(f64::NEG_INFINITY));
        for group in &self.groups {
            let heights = heights(group, &direction);
            low = low.fast_min(heights);
            high = high.fast_max(heights);
        }
        let low = low.to_array().into_iter().fold(f64::INFINITY, f64::min);
        (low, high.to_array().into_iter().fold(f64::NEG_INFINITY, f64::max))
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
    // The same products and sums give the same height, to the last bit.
    #[allow(clippy::float_cmp)]
    pub fn at(&self, direction: &Vec3, height: f64) -> usize {
        let direction = splat(direction);
        for (g, group) in self.groups.iter().enumerate() {
            let heights = heights(group, &direction).to_array();
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
