//! What the pads of a closing gripper meet: the height of the surface over each pad's rectangle.

use super::boxes::Pose;
use super::collision::Collider;
use crate::geometry::{OrientedBox, Vec3};

/// Heights are taken at this many places along each side of a pad.
const GRID: usize = 6;

/// Rubber gives way by this much, in metres: what lies no lower touches.
pub const GIVE: f64 = 5e-4;

/// How far below the expected place a pad's first touch is looked for, in metres.
const WINDOW: f64 = 4e-3;

/// What one pad meets.
#[derive(Debug, Clone, Copy)]
pub struct Touch {
    /// y of the highest place, by magnitude, gripper frame.
    pub height: f64,
    /// Share of the pad's rectangle that touches.
    pub share: f64,
    /// Middle of what touches, gripper frame.
    pub middle: Vec3,
}

/// The rectangle of a pad: its middle and half extents along the gripper's x and z, given that the pad's box is aligned
/// with the gripper; of a turned box, the rectangle around it.
#[derive(Debug, Clone, Copy)]
pub struct Pad {
    /// x and z of the middle.
    pub middle: [f64; 2],
    /// Half extents along x and z.
    pub half: [f64; 2],
}

impl Pad {
    /// Of the pad's box in the finger's frame.
    #[must_use]
    pub fn of(pad: &OrientedBox) -> Self {
        let along = |k: usize| (0..3).map(|j| pad.axes[j][k].abs() * pad.half_extents[j]).sum();
        Self { middle: [pad.center.x, pad.center.z], half: [along(0), along(2)] }
    }

    /// What the pad that comes from `side` (+1 or -1) of y meets first when it closes from `from` (a magnitude of y)
    /// to [`WINDOW`] below `expected`; None when it meets nothing.
    #[must_use]
    pub fn touch(&self, collider: &Collider, pose: &Pose, side: f64, from: f64, expected: f64) -> Option<Touch> {
        let lowest = expected - WINDOW;
        let window = OrientedBox {
            center: Vec3::new(self.middle[0], side * f64::midpoint(from, lowest), self.middle[1]),
            axes: [Vec3::x(), Vec3::y(), Vec3::z()],
            half_extents: [self.half[0], (from - lowest) / 2.0, self.half[1]],
        };
        let step = self.half.map(|h| 2.0 * h / GRID as f64);
        let first = [0, 1].map(|k| self.middle[k] - self.half[k] + step[k] / 2.0);
        let mut heights = [f64::NEG_INFINITY; GRID * GRID];
        collider.triangles_near(&window, pose, |corners| {
            let local = corners.map(|p| {
                let q = pose.rotation.tr_mul(&(p - pose.translation));
                [q.x, q.z, q.y * side]
            });
            raise(&mut heights, &local, first, step, from);
        });
        let height = heights.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        if height < lowest {
            return None;
        }
        let (mut count, mut sum) = (0.0, [0.0; 2]);
        for (place, _) in heights.iter().enumerate().filter(|(_, h)| **h >= height - GIVE) {
            count += 1.0;
            sum[0] += first[0] + (place % GRID) as f64 * step[0];
            sum[1] += first[1] + (place / GRID) as f64 * step[1];
        }
        let middle = Vec3::new(sum[0] / count, side * height, sum[1] / count);
        Some(Touch { height, share: count / (GRID * GRID) as f64, middle })
    }
}

/// Raise the heights at the places of the grid that a triangle (x, z, height) covers, where it is not above `ceiling`.
fn raise(heights: &mut [f64; GRID * GRID], corners: &[[f64; 3]; 3], first: [f64; 2], step: [f64; 2], ceiling: f64) {
    let [a, b, c] = corners;
    let twice = (b[0] - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (b[1] - a[1]);
    if twice == 0.0 {
        return;
    }
    let range = |k: usize| {
        let (low, high) = (a[k].min(b[k]).min(c[k]), a[k].max(b[k]).max(c[k]));
        let start = ((low - first[k]) / step[k]).ceil().max(0.0) as usize;
        let end = ((high - first[k]) / step[k]).floor();
        (start, if end < 0.0 { 0 } else { (end as usize + 1).min(GRID) })
    };
    let (columns, rows) = (range(0), range(1));
    for row in rows.0..rows.1 {
        for column in columns.0..columns.1 {
            let (x, z) = (first[0] + column as f64 * step[0], first[1] + row as f64 * step[1]);
            let u = ((x - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (z - a[1])) / twice;
            let v = ((b[0] - a[0]) * (z - a[1]) - (x - a[0]) * (b[1] - a[1])) / twice;
            if u < 0.0 || v < 0.0 || u + v > 1.0 {
                continue;
            }
            let height = a[2] + u * (b[2] - a[2]) + v * (c[2] - a[2]);
            let cell = &mut heights[row * GRID + column];
            if height <= ceiling && height > *cell {
                *cell = height;
            }
        }
    }
}
