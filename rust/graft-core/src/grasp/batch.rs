//! Many poses of one gripper against one object.

use rayon::prelude::*;

use super::boxes::{HalfSpace, Hand, Pose};
use super::collision::Collider;
use crate::error::Error;
use crate::geometry::{Vec3, points_of};

/// Poses that one task checks: some ten microseconds of work.
const TASK: usize = 16;

/// An object's surface as it comes: flat, unchecked.
#[derive(Debug, Clone, Copy)]
pub struct Surface<'a> {
    /// (v, 3) finite.
    pub vertices: &'a [f64],
    /// (f, 3) vertex indices.
    pub faces: &'a [i64],
    /// (p, 3) centres of balls, finite.
    pub points: &'a [f64],
    /// (p,) their radii.
    pub radii: &'a [f64],
}

impl Surface<'_> {
    /// Check indices and radii, and build the collider.
    ///
    /// # Errors
    /// A face has a vertex that is not there, or radii are too few, negative or not finite.
    pub fn collider(&self) -> Result<Collider, Error> {
        let vertices = points_of(self.vertices);
        if let Some(&bad) = self.faces.iter().find(|&&v| v < 0 || v as usize >= vertices.len()) {
            return Err(Error::value("faces", format!("indices of {} vertices", vertices.len()), bad));
        }
        if self.radii.len() != self.points.len() / 3 {
            return Err(Error::shape("radii", self.points.len() / 3, self.radii.len()));
        }
        if let Some(bad) = self.radii.iter().find(|r| !(r.is_finite() && **r >= 0.0)) {
            return Err(Error::value("radii", "finite numbers of at least 0", bad));
        }
        let faces: Vec<[usize; 3]> = self.faces.chunks_exact(3).map(|f| [0, 1, 2].map(|k| f[k] as usize)).collect();
        let balls: Vec<(Vec3, f64)> = points_of(self.points).into_iter().zip(self.radii.iter().copied()).collect();
        Ok(Collider::with_balls(&vertices, &faces, &balls))
    }
}

/// Say which of (q, 4, 4) row-major `poses`, each with its opening, touch the object or come within `margin` of it (every
/// face of every box moved out by it) or of the `support`.
///
/// # Errors
/// Poses and openings differ in number, or the margin is negative or not finite.
pub fn collisions(
    collider: &Collider,
    hand: &Hand,
    poses: &[f64],
    openings: &[f64],
    margin: f64,
    support: Option<&HalfSpace>,
) -> Result<Vec<bool>, Error> {
    let (matrices, rest) = poses.as_chunks::<16>();
    if !rest.is_empty() || matrices.len() != openings.len() {
        return Err(Error::shape("openings", matrices.len(), openings.len()));
    }
    if !(margin.is_finite() && margin >= 0.0) {
        return Err(Error::value("margin", "a finite number of at least 0", margin));
    }
    let check = |(matrix, opening): (&[f64; 16], &f64)| {
        let pose = Pose::of(matrix);
        let below =
            support.is_some_and(|plane| hand.boxes(*opening).any(|part| plane.clearance(&pose.place(&part)) < margin));
        below || collider.hand_collides(hand, *opening, &pose, margin)
    };
    Ok(matrices.par_iter().zip(openings).with_min_len(TASK).map(check).collect())
}
