//! A tree of four-way nodes over boxes, single precision and four at a time; what it hands on is tested exactly after.
//!
//! Splits are medians over a total order of the centres, so the tree is the same everywhere. Bounds are rounded outward
//! and queries inflated by [`SLACK`], so nothing that touches is lost to rounding.

use wide::f32x4;

use crate::geometry::{OrientedBox, Vec3};

/// Share of the largest coordinate by which a query grows: some ten roundings of single precision (6e-8 each).
const SLACK: f64 = 2e-6;

/// Each level leaves at most three children waiting; sixteen levels hold 2^32 primitives.
const STACK_SIZE: usize = 64;

/// Marks a child that is a primitive.
const PRIMITIVE: u32 = 1 << 31;

/// An axis-aligned box.
#[derive(Debug, Clone, Copy)]
pub struct Aabb {
    /// Lowest corner.
    pub low: Vec3,
    /// Highest corner.
    pub high: Vec3,
}

impl Aabb {
    /// Holds nothing.
    pub const EMPTY: Self = Self {
        low: Vec3::new(f64::INFINITY, f64::INFINITY, f64::INFINITY),
        high: Vec3::new(f64::NEG_INFINITY, f64::NEG_INFINITY, f64::NEG_INFINITY),
    };

    /// Holds both.
    #[must_use]
    pub fn union(&self, other: &Self) -> Self {
        Self { low: self.low.inf(&other.low), high: self.high.sup(&other.high) }
    }
}

/// Four children: their boxes coordinate by coordinate. Empty places have half extents of minus infinity.
#[derive(Debug, Clone, Copy)]
struct Node {
    center: [f32x4; 3],
    half: [f32x4; 3],
    child: [u32; 4],
}

impl Node {
    fn new(children: &[(u32, Aabb)]) -> Self {
        let mut center = [[0.0_f32; 4]; 3];
        let mut half = [[f32::NEG_INFINITY; 4]; 3];
        let mut child = [PRIMITIVE; 4];
        for (slot, (reference, bounds)) in children.iter().enumerate() {
            child[slot] = *reference;
            for k in 0..3 {
                let middle = f64::midpoint(bounds.low[k], bounds.high[k]) as f32;
                let reach = (bounds.high[k] - f64::from(middle)).max(f64::from(middle) - bounds.low[k]);
                center[k][slot] = middle;
                half[k][slot] = (reach as f32).next_up();
            }
        }
        Self { center: center.map(f32x4::new), half: half.map(f32x4::new), child }
    }
}

/// The tree.
#[derive(Debug)]
pub struct Tree {
    nodes: Vec<Node>,
    /// Largest magnitude of a coordinate.
    extent: f64,
}

/// A primitive while the tree is built.
#[derive(Clone, Copy)]
struct Item {
    center: [f32; 3],
    index: u32,
}

impl Tree {
    /// Build it over finite boxes, fewer than 2^31.
    #[must_use]
    pub fn new(bounds: &[Aabb]) -> Self {
        let mut items: Vec<Item> = bounds
            .iter()
            .enumerate()
            .map(|(index, b)| {
                let middle = (b.low + b.high) * 0.5;
                Item { center: [middle.x as f32, middle.y as f32, middle.z as f32], index: index as u32 }
            })
            .collect();
        let mut nodes = Vec::with_capacity(bounds.len() / 2 + 1);
        let mut extent = 0.0;
        if !items.is_empty() {
            let around = grow(bounds, &mut items, &mut nodes).1;
            extent = around.low.amax().max(around.high.amax());
        }
        Self { nodes, extent }
    }

    /// Whether `hit` says yes to any primitive whose box may meet a given one.
    pub fn any(&self, given: &OrientedBox, mut hit: impl FnMut(usize) -> bool) -> bool {
        if self.nodes.is_empty() {
            return false;
        }
        let probe = Probe::new(given, self.extent);
        let mut stack = [0_u32; STACK_SIZE];
        let mut depth = 1;
        while depth > 0 {
            depth -= 1;
            let node = &self.nodes[stack[depth] as usize];
            let mut met = probe.meets(node);
            while met != 0 {
                let reference = node.child[met.trailing_zeros() as usize];
                met &= met - 1;
                if reference & PRIMITIVE == 0 {
                    stack[depth] = reference;
                    depth += 1;
                } else if hit((reference & !PRIMITIVE) as usize) {
                    return true;
                }
            }
        }
        false
    }

    /// Visit every primitive whose box a line from `origin` along `direction`, `0 <= t <= longest`, may pass.
    pub fn along(&self, origin: &Vec3, direction: &Vec3, longest: f64, mut visit: impl FnMut(usize)) {
        if self.nodes.is_empty() {
            return;
        }
        let slack = SLACK * (self.extent + origin.amax());
        // A component of zero becomes a tiny one: the slab is then left at once or never, as it should be.
        let inverse = direction.map(|x| 1.0 / if x.abs() < f64::from(f32::MIN_POSITIVE) { 1e-30 } else { x });
        let from = [0, 1, 2].map(|k| f32x4::splat(origin[k] as f32));
        let over = [0, 1, 2].map(|k| f32x4::splat(inverse[k] as f32));
        let magnitude = over.map(f32x4::abs);
        let grown = f32x4::splat(slack as f32);
        let limit = f32x4::splat(longest as f32) * f32x4::splat(1.000_001);
        let mut stack = [0_u32; STACK_SIZE];
        let mut depth = 1;
        while depth > 0 {
            depth -= 1;
            let node = &self.nodes[stack[depth] as usize];
            let (mut enter, mut leave) = (f32x4::splat(0.0), limit);
            for k in 0..3 {
                let middle = (node.center[k] - from[k]) * over[k];
                let reach = (node.half[k] + grown) * magnitude[k];
                enter = enter.max(middle - reach);
                leave = leave.min(middle + reach);
            }
            // Empty places: minus infinity makes them leave before they enter.
            let mut met = enter.simd_le(leave).to_bitmask();
            while met != 0 {
                let reference = node.child[met.trailing_zeros() as usize];
                met &= met - 1;
                if reference & PRIMITIVE == 0 {
                    stack[depth] = reference;
                    depth += 1;
                } else {
                    visit((reference & !PRIMITIVE) as usize);
                }
            }
        }
    }
}

/// An oriented box, four times over.
struct Probe {
    center: [f32x4; 3],
    axes: [[f32x4; 3]; 3],
    reach: [[f32x4; 3]; 3],
    half: [f32x4; 3],
    around: [f32x4; 3],
}

impl Probe {
    fn new(given: &OrientedBox, extent: f64) -> Self {
        let slack = SLACK * (extent + given.center.amax() + given.half_extents.iter().fold(0.0, |a: f64, &b| a.max(b)));
        let axes = given.axes.map(|axis| [0, 1, 2].map(|k| f32x4::splat(axis[k] as f32)));
        let around = [0, 1, 2].map(|k| {
            let sum: f64 = (0..3).map(|j| given.axes[j][k].abs() * given.half_extents[j]).sum();
            f32x4::splat((sum + slack) as f32)
        });
        Self {
            center: [0, 1, 2].map(|k| f32x4::splat(given.center[k] as f32)),
            axes,
            reach: axes.map(|axis| axis.map(f32x4::abs)),
            half: given.half_extents.map(|h| f32x4::splat((h + slack) as f32)),
            around,
        }
    }

    /// Bits of the children whose boxes no face of either box separates from this one.
    #[inline]
    fn meets(&self, node: &Node) -> u32 {
        let t = [0, 1, 2].map(|k| node.center[k] - self.center[k]);
        let mut apart = (t[0].abs() - self.around[0]).simd_gt(node.half[0]);
        apart |= (t[1].abs() - self.around[1]).simd_gt(node.half[1]);
        apart |= (t[2].abs() - self.around[2]).simd_gt(node.half[2]);
        for k in 0..3 {
            let (axis, reach) = (&self.axes[k], &self.reach[k]);
            let distance = (t[0] * axis[0] + t[1] * axis[1] + t[2] * axis[2]).abs();
            let sum = node.half[0] * reach[0] + node.half[1] * reach[1] + node.half[2] * reach[2];
            apart |= distance.simd_gt(sum + self.half[k]);
        }
        !apart.to_bitmask() & 0b1111
    }
}

/// Append the subtree over `items`; return how to refer to it, and its box.
fn grow(bounds: &[Aabb], items: &mut [Item], nodes: &mut Vec<Node>) -> (u32, Aabb) {
    let place = nodes.len();
    nodes.push(Node::new(&[]));
    let mut children = [(0, Aabb::EMPTY); 4];
    let mut count = 0;
    let mut add = |child: (u32, Aabb)| {
        children[count] = child;
        count += 1;
    };
    if items.len() <= 4 {
        for item in items.iter() {
            add((PRIMITIVE | item.index, bounds[item.index as usize]));
        }
    } else {
        let (left, right) = halve(items);
        for side in [left, right] {
            if side.len() <= 4 {
                add(grow(bounds, side, nodes));
                continue;
            }
            let (first, second) = halve(side);
            add(grow(bounds, first, nodes));
            add(grow(bounds, second, nodes));
        }
    }
    let around = children[..count].iter().fold(Aabb::EMPTY, |sum, (_, b)| sum.union(b));
    nodes[place] = Node::new(&children[..count]);
    (place as u32, around)
}

/// Split at the median of the longest axis, rounded to fours so that the lowest nodes are full.
fn halve(items: &mut [Item]) -> (&mut [Item], &mut [Item]) {
    let (mut low, mut high) = ([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]);
    for item in items.iter() {
        for k in 0..3 {
            low[k] = low[k].min(item.center[k]);
            high[k] = high[k].max(item.center[k]);
        }
    }
    let mut axis = 0;
    for k in 1..3 {
        if high[k] - low[k] > high[axis] - low[axis] {
            axis = k;
        }
    }
    let middle = (items.len() / 2).next_multiple_of(4);
    items.select_nth_unstable_by(middle, |a, b| a.center[axis].total_cmp(&b.center[axis]).then(a.index.cmp(&b.index)));
    items.split_at_mut(middle)
}
