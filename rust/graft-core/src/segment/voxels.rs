//! The closed solid of a surface on a grid: what lies inside it, and in its cavities.
//!
//! A cavity is where most directions meet the surface: the inside of a cup, however thin its wall, and of a pan,
//! but not the hole of a handle, which most directions leave.

use super::Vec3;
use super::elements::Elements;
use crate::geometry::OrientedBox;

/// Voxels along the longest side of the box.
pub const RESOLUTION: usize = 128;

/// Empty voxels around the box, so that the outside is connected.
const MARGIN: usize = 2;

/// How far from the surface its sides are told apart, in voxels: beyond the voxels of the surface itself.
const PROBE: f64 = 1.8;

const EMPTY: u8 = 0;
const WALL: u8 = 1;
const INSIDE: u8 = 2;
const CAVITY: u8 = 3;

/// Of the 26 directions of a grid, how many must meet the surface in a cavity. Over a flat pan's bottom 17 do:
/// nine below and eight along it; in the hole of a handle about 14 do.
pub const CAVITY_DIRECTIONS: u32 = 17;

/// A grid over an object, in the frame of its box.
#[derive(Debug, Clone)]
pub struct Voxels {
    origin: Vec3,
    axes: [Vec3; 3],
    /// Side of a voxel.
    pub size: f64,
    shape: [usize; 3],
    state: Vec<u8>,
}

impl Voxels {
    /// Fill the solid of `elements` within their minimal box; points of a cloud are balls of `radius`.
    #[must_use]
    pub fn of(elements: &Elements, bounds: &OrientedBox, radius: f64) -> Self {
        let OrientedBox { center, axes, half_extents } = *bounds;
        let longest = half_extents.iter().fold(0.0_f64, |a, &b| a.max(b));
        let size = 2.0 * longest / RESOLUTION as f64;
        let shape = half_extents.map(|h| (2.0 * h / size).ceil() as usize + 2 * MARGIN + 1);
        let corner = [0, 1, 2].map(|k| shape[k] as f64 * size / 2.0);
        let origin = center - axes[0] * corner[0] - axes[1] * corner[1] - axes[2] * corner[2];
        let mut grid = Self { origin, axes, size, shape, state: vec![EMPTY; shape.iter().product()] };
        if elements.corners.is_empty() {
            elements.centers.iter().for_each(|p| grid.splat(p, radius));
        } else {
            elements.corners.iter().for_each(|t| grid.draw(t));
        }
        grid.fill_inside();
        grid.fill_cavities();
        grid
    }

    fn local(&self, p: &Vec3) -> [f64; 3] {
        let d = p - self.origin;
        [0, 1, 2].map(|k| d.dot(&self.axes[k]) / self.size)
    }

    fn index(&self, cell: [usize; 3]) -> usize {
        (cell[0] * self.shape[1] + cell[1]) * self.shape[2] + cell[2]
    }

    fn cell(&self, p: &Vec3) -> Option<usize> {
        let at = self.local(p);
        for k in 0..3 {
            if !(at[k] >= 0.0 && at[k] < self.shape[k] as f64) {
                return None;
            }
        }
        Some(self.index(at.map(|x| x as usize)))
    }

    /// Whether a place is in the closed solid: surface, inside or cavity.
    #[must_use]
    pub fn filled(&self, p: &Vec3) -> bool {
        self.cell(p).is_some_and(|c| self.state[c] != EMPTY)
    }

    /// Whether a place is in a cavity.
    #[must_use]
    pub fn in_cavity(&self, p: &Vec3) -> bool {
        self.cell(p).is_some_and(|c| self.state[c] == CAVITY)
    }

    /// Turn normals that point into the solid, where the other side is out of it; returns how many. Those of a cloud
    /// of which that cannot be told follow their neighbours.
    pub fn turn_outward(&self, elements: &mut Elements) -> usize {
        let mut turned = 0;
        let mut known = vec![false; elements.len()];
        for i in 0..elements.len() {
            let (center, off) = (elements.centers[i], elements.normals[i] * (PROBE * self.size));
            let (ahead, behind) = (self.filled(&(center + off)), self.filled(&(center - off)));
            known[i] = ahead != behind;
            if ahead && !behind {
                elements.normals[i] = -elements.normals[i];
                turned += 1;
            }
        }
        if elements.corners.is_empty() {
            elements.align_normals(known);
        }
        turned
    }

    /// Mark the voxels of a triangle by points on it that lie less than half a voxel apart.
    fn draw(&mut self, [a, b, c]: &[Vec3; 3]) {
        let longest = (b - a).norm().max((c - a).norm()).max((c - b).norm());
        let steps = ((longest / (0.5 * self.size)).ceil() as usize).max(1);
        for i in 0..=steps {
            for j in 0..=(steps - i) {
                let (u, v) = (i as f64 / steps as f64, j as f64 / steps as f64);
                let p = a + (b - a) * u + (c - a) * v;
                if let Some(cell) = self.cell(&p) {
                    self.state[cell] = WALL;
                }
            }
        }
    }

    /// Mark the voxels within `radius` of a point.
    fn splat(&mut self, p: &Vec3, radius: f64) {
        let steps = (radius / self.size).ceil() as i64;
        for x in -steps..=steps {
            for y in -steps..=steps {
                for z in -steps..=steps {
                    let d = (self.axes[0] * x as f64 + self.axes[1] * y as f64 + self.axes[2] * z as f64) * self.size;
                    if d.norm() <= radius.max(self.size * 0.1)
                        && let Some(cell) = self.cell(&(p + d))
                    {
                        self.state[cell] = WALL;
                    }
                }
            }
        }
    }

    /// Everything that the outside does not reach through the faces of voxels is inside.
    fn fill_inside(&mut self) {
        let mut outside = vec![false; self.state.len()];
        let mut stack = vec![[0_usize; 3]];
        outside[0] = true;
        while let Some(cell) = stack.pop() {
            for axis in 0..3 {
                for forward in [false, true] {
                    let mut next = cell;
                    if forward {
                        next[axis] += 1;
                        if next[axis] == self.shape[axis] {
                            continue;
                        }
                    } else if next[axis] == 0 {
                        continue;
                    } else {
                        next[axis] -= 1;
                    }
                    let i = self.index(next);
                    if !outside[i] && self.state[i] == EMPTY {
                        outside[i] = true;
                        stack.push(next);
                    }
                }
            }
        }
        for (state, out) in self.state.iter_mut().zip(outside) {
            if *state == EMPTY && !out {
                *state = INSIDE;
            }
        }
    }

    /// Count for every empty voxel the directions that meet the surface; where most do is a cavity.
    fn fill_cavities(&mut self) {
        let mut met = vec![0_u8; self.state.len()];
        let mut blocked = vec![false; self.state.len()];
        for direction in 0..27_usize {
            if direction == 13 {
                continue;
            }
            let step = [direction / 9, direction / 3 % 3, direction % 3].map(|s| s as i64 - 1);
            // Cells are visited so that the one the direction leads to has been visited before.
            for x in Sweep::new(self.shape[0], step[0]) {
                for y in Sweep::new(self.shape[1], step[1]) {
                    for z in Sweep::new(self.shape[2], step[2]) {
                        let i = self.index([x, y, z]);
                        if self.state[i] == WALL || self.state[i] == INSIDE {
                            blocked[i] = true;
                            continue;
                        }
                        let next = [x as i64 + step[0], y as i64 + step[1], z as i64 + step[2]];
                        let within = (0..3).all(|k| next[k] >= 0 && next[k] < self.shape[k] as i64);
                        blocked[i] = within && blocked[self.index(next.map(|n| n as usize))];
                        met[i] += u8::from(blocked[i]);
                    }
                }
            }
        }
        for (state, met) in self.state.iter_mut().zip(met) {
            if *state == EMPTY && u32::from(met) >= CAVITY_DIRECTIONS {
                *state = CAVITY;
            }
        }
    }

    /// How far one goes from `p` along the unit `direction` before leaving the closed solid.
    #[must_use]
    pub fn depth(&self, p: &Vec3, direction: &Vec3) -> f64 {
        let step = direction * (0.5 * self.size);
        let mut at = *p;
        let mut steps = 0;
        loop {
            at += step;
            // The wall's own voxels may be missed by half a voxel at the start.
            if !self.filled(&at) && steps >= 2 {
                return f64::from(steps) * 0.5 * self.size;
            }
            steps += 1;
        }
    }

    /// Whether at most a share `most` of the segment between two places lies outside of the closed solid.
    #[must_use]
    pub fn sees(&self, p: &Vec3, q: &Vec3, most: f64) -> bool {
        let (a, b) = (self.local(p), self.local(q));
        let length = (0..3).map(|k| (b[k] - a[k]).powi(2)).sum::<f64>().sqrt();
        let steps = (length.ceil() as usize).max(1);
        let allowed = most * steps as f64;
        let mut out = 0.0;
        for s in 1..steps {
            let t = s as f64 / steps as f64;
            let cell = [0, 1, 2].map(|k| (a[k] + (b[k] - a[k]) * t) as usize);
            if self.state[self.index(cell)] == EMPTY {
                out += 1.0;
                if out > allowed {
                    return false;
                }
            }
        }
        true
    }
}

/// Places along one axis in the order in which a sweep along `step` visits them.
struct Sweep {
    at: usize,
    count: usize,
    backward: bool,
}

impl Sweep {
    fn new(count: usize, step: i64) -> Self {
        Self { at: 0, count, backward: step > 0 }
    }
}

impl Iterator for Sweep {
    type Item = usize;

    fn next(&mut self) -> Option<usize> {
        (self.at < self.count).then(|| {
            self.at += 1;
            if self.backward { self.count - self.at } else { self.at - 1 }
        })
    }
}
