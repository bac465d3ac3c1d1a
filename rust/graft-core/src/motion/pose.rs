//! Rigid poses and the way between them.

use nalgebra::{Matrix3, Quaternion, Rotation3, UnitQuaternion};
use rand::RngExt;
use rand_pcg::Pcg64;

use crate::geometry::Vec3;
use crate::grasp;

/// Below this angle, in radians of the quaternions' sphere, sines are proportional to their angles to the last bit.
const SMALL_ANGLE: f64 = 1e-8;

/// A rotation followed by a translation; the rotation as a quaternion, which interpolates (see [`grasp::Pose`]).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pose {
    /// Where the origin goes, metres.
    pub position: Vec3,
    /// How the axes turn.
    pub rotation: UnitQuaternion<f64>,
}

impl Pose {
    /// Read a row-major 4 x 4 matrix whose linear part is a rotation up to rounding.
    #[must_use]
    pub fn from_rows(m: &[f64; 16]) -> Self {
        let linear = Matrix3::new(m[0], m[1], m[2], m[4], m[5], m[6], m[8], m[9], m[10]);
        let rotation = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(linear));
        Self { position: Vec3::new(m[3], m[7], m[11]), rotation: UnitQuaternion::new_normalize(*rotation) }
    }

    /// Write a row-major 4 x 4 matrix.
    #[must_use]
    pub fn to_rows(&self) -> [f64; 16] {
        let (r, p) = (self.matrix(), self.position);
        [
            r[(0, 0)],
            r[(0, 1)],
            r[(0, 2)],
            p.x, //
            r[(1, 0)],
            r[(1, 1)],
            r[(1, 2)],
            p.y, //
            r[(2, 0)],
            r[(2, 1)],
            r[(2, 2)],
            p.z, //
            0.0,
            0.0,
            0.0,
            1.0,
        ]
    }

    /// The rotation as a matrix.
    #[must_use]
    pub fn matrix(&self) -> Matrix3<f64> {
        *self.rotation.to_rotation_matrix().matrix()
    }

    /// The same motion with its rotation as a matrix.
    #[must_use]
    pub fn rigid(&self) -> grasp::Pose {
        grasp::Pose { rotation: self.matrix(), translation: self.position }
    }

    /// Angle of the turn from one rotation to the other, in [0, pi].
    #[must_use]
    pub fn angle_to(&self, other: &Self) -> f64 {
        // A chord keeps the digits of a small angle, which a dot product loses.
        let (a, b) = (self.rotation.coords, other.rotation.coords);
        let chord = (a - b).norm_squared().min((a + b).norm_squared()).sqrt();
        4.0 * (0.5 * chord).min(1.0).asin()
    }

    /// The pose at `t` of the way: straight in position, at an even rate about one axis in rotation.
    #[must_use]
    pub fn between(&self, other: &Self, t: f64) -> Self {
        let position = self.position + (other.position - self.position) * t;
        let a = self.rotation.coords;
        let b = if a.dot(&other.rotation.coords) < 0.0 { -other.rotation.coords } else { other.rotation.coords };
        let angle = 2.0 * (0.5 * (a - b).norm()).min(1.0).asin();
        let (p, q) = if angle < SMALL_ANGLE {
            (1.0 - t, t)
        } else {
            (((1.0 - t) * angle).sin() / angle.sin(), (t * angle).sin() / angle.sin())
        };
        Self { position, rotation: UnitQuaternion::new_normalize(Quaternion::from(a * p + b * q)) }
    }
}

/// A rotation drawn evenly (Shoemake, "Uniform random rotations", Graphics Gems III, 1992).
pub fn random_rotation(random: &mut Pcg64) -> UnitQuaternion<f64> {
    let (u, v, w): (f64, f64, f64) = (random.random(), random.random(), random.random());
    let (first, second) = (std::f64::consts::TAU * v, std::f64::consts::TAU * w);
    let (a, b) = ((1.0 - u).sqrt(), u.sqrt());
    UnitQuaternion::new_normalize(Quaternion::new(b * second.cos(), a * first.sin(), a * first.cos(), b * second.sin()))
}
