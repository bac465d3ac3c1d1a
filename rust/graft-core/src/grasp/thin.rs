//! Non-maximum suppression: of grasps that are nearly the same, the best.

use super::boxes::Pose;
use crate::geometry::Vec3;

/// How near is nearly the same.
#[derive(Debug, Clone, Copy)]
pub struct Nearness {
    /// Metres.
    pub distance: f64,
    /// Radians.
    pub angle: f64,
}

/// Keep up to `limit` of the poses, which come best first: each that is farther than `near` in place or in turn from
/// every one kept before. Half a turn about z, which exchanges the fingers, is no turn. Returns indices.
#[must_use]
pub fn thin(poses: impl Iterator<Item = Pose>, near: Nearness, limit: usize) -> Vec<usize> {
    let mut kept: Vec<(usize, Pose)> = Vec::new();
    // Comparing traces is comparing angles, without the arc cosine.
    let least_trace = 1.0 + 2.0 * near.angle.cos();
    for (index, pose) in poses.enumerate() {
        if kept.len() == limit {
            break;
        }
        let is_same = |other: &Pose| {
            let offset: Vec3 = other.translation - pose.translation;
            if offset.norm_squared() > near.distance * near.distance {
                return false;
            }
            // Traces of A^T B, and of A^T B turned by half a turn, which reverses x and y.
            let [x, y, z] = [0, 1, 2].map(|k| other.rotation.column(k).dot(&pose.rotation.column(k)));
            (x + y + z).max(z - x - y) >= least_trace
        };
        if !kept.iter().any(|(_, other)| is_same(other)) {
            kept.push((index, pose));
        }
    }
    kept.into_iter().map(|(index, _)| index).collect()
}
