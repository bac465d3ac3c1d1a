//! Grippers as boxes: poses, palms and fingers, the volumes they sweep, the table they must stay above.

use nalgebra::Matrix3;

use crate::geometry::{OrientedBox, Vec3};

/// A rigid motion: p -> rotation p + translation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pose {
    /// Orthonormal, right-handed.
    pub rotation: Matrix3<f64>,
    /// Metres.
    pub translation: Vec3,
}

impl Pose {
    /// The motion that leaves everything where it is.
    #[must_use]
    pub fn identity() -> Self {
        Self { rotation: Matrix3::identity(), translation: Vec3::zeros() }
    }

    /// Read a row-major (4, 4) matrix.
    #[must_use]
    pub fn of(matrix: &[f64; 16]) -> Self {
        let m = matrix;
        Self {
            rotation: Matrix3::new(m[0], m[1], m[2], m[4], m[5], m[6], m[8], m[9], m[10]),
            translation: Vec3::new(m[3], m[7], m[11]),
        }
    }

    /// Write it as a row-major (4, 4) matrix.
    #[must_use]
    pub fn matrix(&self) -> [f64; 16] {
        let (r, t) = (&self.rotation, &self.translation);
        [
            r[(0, 0)],
            r[(0, 1)],
            r[(0, 2)],
            t.x, //
            r[(1, 0)],
            r[(1, 1)],
            r[(1, 2)],
            t.y, //
            r[(2, 0)],
            r[(2, 1)],
            r[(2, 2)],
            t.z, //
            0.0,
            0.0,
            0.0,
            1.0,
        ]
    }

    /// Move a point.
    #[must_use]
    pub fn apply(&self, point: &Vec3) -> Vec3 {
        self.rotation * point + self.translation
    }

    /// Move a box.
    #[must_use]
    pub fn place(&self, given: &OrientedBox) -> OrientedBox {
        OrientedBox {
            center: self.apply(&given.center),
            axes: given.axes.map(|axis| self.rotation * axis),
            half_extents: given.half_extents,
        }
    }
}

/// A plane below which no gripper may go.
#[derive(Debug, Clone, Copy)]
pub struct HalfSpace {
    /// Unit vector into the free half.
    pub normal: Vec3,
    /// normal . p of its points p.
    pub offset: f64,
}

impl HalfSpace {
    /// How far the lowest corner of a box lies above the plane; negative below.
    #[must_use]
    pub fn clearance(&self, placed: &OrientedBox) -> f64 {
        let reach: f64 = (0..3).map(|k| placed.half_extents[k] * self.normal.dot(&placed.axes[k]).abs()).sum();
        self.normal.dot(&placed.center) - self.offset - reach
    }
}

/// The box that holds everything a box passes when it moves by `by`: exact along its own axes, else a little more.
#[must_use]
pub fn swept(moving: &OrientedBox, by: &Vec3) -> OrientedBox {
    let mut half_extents = moving.half_extents;
    for k in 0..3 {
        half_extents[k] += by.dot(&moving.axes[k]).abs() / 2.0;
    }
    OrientedBox { center: moving.center + by / 2.0, axes: moving.axes, half_extents }
}

/// A parallel gripper: boxes that stay, and a finger at +y whose mirror image is the other one.
#[derive(Debug, Clone)]
pub struct Hand {
    /// Boxes of the palm, gripper frame.
    pub palm: Vec<OrientedBox>,
    /// Boxes of the finger at +y, in its own frame, whose origin lies at y = opening / 2 in the gripper's; the pad
    /// first, its inner surface at y = 0.
    pub finger: Vec<OrientedBox>,
}

/// Reflect a box in the plane y = 0. A box has no handedness, so its axes stay right-handed by reversing the second.
fn mirrored(given: &OrientedBox) -> OrientedBox {
    let mirror = |v: &Vec3| Vec3::new(v.x, -v.y, v.z);
    let [a, b, c] = &given.axes;
    OrientedBox {
        center: mirror(&given.center),
        axes: [mirror(a), -mirror(b), mirror(c)],
        half_extents: given.half_extents,
    }
}

impl Hand {
    /// How many boxes it has.
    #[must_use]
    pub fn len(&self) -> usize {
        self.palm.len() + 2 * self.finger.len()
    }

    /// Whether it has no box at all.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Both fingers' boxes in the gripper frame, `opening` between the pads.
    pub fn fingers(&self, opening: f64) -> impl Iterator<Item = OrientedBox> + Clone + '_ {
        let away = Vec3::new(0.0, opening / 2.0, 0.0);
        self.finger.iter().flat_map(move |part| {
            let right = OrientedBox { center: part.center + away, ..*part };
            [right, mirrored(&right)]
        })
    }

    /// All boxes in the gripper frame: fingers first, which are the likelier to touch, then the palm.
    pub fn boxes(&self, opening: f64) -> impl Iterator<Item = OrientedBox> + Clone + '_ {
        self.fingers(opening).chain(self.palm.iter().copied())
    }
}
