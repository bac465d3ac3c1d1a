//! The stated frame of a box: longest extent first, right-handed, signs by the part's centroid.

use super::Vec3;
use super::obb::OrientedBox;

/// Extents within this share of each other tie: which of their axes is longer says nothing about the part. A polygon
/// of 23 sides or more stands for a circle to within 1 %.
pub const EXTENT_TIE: f64 = 1e-2;

/// A flat part's extents are at least this share of the object's diagonal: thinner than any household wall (.1 mm on a
/// bucket of 30 cm), thick enough to divide by.
pub const FLOOR_THICKNESS: f64 = 3e-4;

/// Extents within this share of each other are equal: minimal boxes are found to about this.
const EXTENT_EQUAL: f64 = 1e-6;

/// A centroid off the box's centre by less than this share of the half extent does not choose a sign.
const SIGN_FLOOR: f64 = 1e-6;

/// A box in its stated frame.
#[derive(Debug, Clone, Copy)]
pub struct Frame {
    /// The box.
    pub bounds: OrientedBox,
    /// An extent was raised to the floor.
    pub flat: bool,
    /// Two extents tie.
    pub symmetric: bool,
}

/// Put a box into its stated frame.
///
/// * The axes are sorted by extent, longest first; equal extents by closeness to the direction `toward` the rest of the
///   object, then to the object's x and y axes.
/// * The first two axes point to the side of the box's centre on which the part's `centroid` lies; where it lies in the
///   middle, to the side on which the surface reaches farther (`skewness`, its third moment about a point along an axis);
///   where that tells nothing, to the side `toward` which the rest of the object lies; else the axis's component of largest magnitude (the first of equals) is positive.
/// * The third axis makes the frame right-handed.
/// * Half extents below half the `floor` are raised to it.
#[must_use]
pub fn stated_frame(
    mut bounds: OrientedBox,
    centroid: &Vec3,
    toward: &Vec3,
    floor: f64,
    skewness: impl Fn(&Vec3, &Vec3) -> f64,
) -> Frame {
    let mut order = [0, 1, 2];
    let equal = |a: f64, b: f64| (a - b).abs() <= EXTENT_EQUAL * a.max(b).max(floor);
    let longer = |a: usize, b: usize| {
        let (ea, eb) = (bounds.half_extents[a], bounds.half_extents[b]);
        if !equal(ea, eb) {
            return ea > eb;
        }
        let nearer = bounds.axes[a].dot(toward).abs() - bounds.axes[b].dot(toward).abs();
        if nearer.abs() > SIGN_FLOOR * ea.max(floor) {
            return nearer > 0.0;
        }
        let (va, vb) = (bounds.axes[a].abs(), bounds.axes[b].abs());
        let x = va.x - vb.x;
        if x.abs() > SIGN_FLOOR { x > 0.0 } else { va.y > vb.y + SIGN_FLOOR }
    };
    // Three compare-and-swaps instead of a sort: near ties need not be transitive.
    for (i, j) in [(0, 1), (1, 2), (0, 1)] {
        if longer(order[j], order[i]) {
            order.swap(i, j);
        }
    }
    let axes = order.map(|k| bounds.axes[k]);
    let mut half_extents = order.map(|k| bounds.half_extents[k]);
    let signed = |k: usize| {
        let offset = (centroid - bounds.center).dot(&axes[k]);
        let size = half_extents[k].max(floor);
        let positive = if offset.abs() > SIGN_FLOOR * size {
            offset > 0.0
        } else if let skew = skewness(&bounds.center, &axes[k])
            && skew.abs() > SIGN_FLOOR * size.powi(3)
        {
            skew > 0.0
        } else if let ahead = toward.dot(&axes[k])
            && ahead.abs() > SIGN_FLOOR * size
        {
            ahead > 0.0
        } else {
            let largest = axes[k].amax();
            axes[k].iter().find(|c| c.abs() > largest - SIGN_FLOOR).is_none_or(|c| *c > 0.0)
        };
        if positive { axes[k] } else { -axes[k] }
    };
    let (first, second) = (signed(0), signed(1));
    let mut flat = false;
    for e in &mut half_extents {
        if *e < floor / 2.0 {
            *e = floor / 2.0;
            flat = true;
        }
    }
    // Floors may have overtaken nothing: all of them are equal and last, so the order still holds.
    let tie = |a: f64, b: f64| a - b <= EXTENT_TIE * a;
    let symmetric = tie(half_extents[0], half_extents[1]) || tie(half_extents[1], half_extents[2]);
    bounds.axes = [first, second, first.cross(&second)];
    bounds.half_extents = half_extents;
    Frame { bounds, flat, symmetric }
}
