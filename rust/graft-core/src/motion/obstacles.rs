//! What stands in the way: an object's surface and the plane it stands on.

use crate::geometry::OrientedBox;
use crate::grasp::{Collider, HalfSpace, Pose};

/// An object and its support.
#[derive(Debug)]
pub struct Obstacles {
    /// The object.
    pub object: Collider,
    /// Nothing may go below it.
    pub support: Option<HalfSpace>,
}

impl Obstacles {
    /// Whether boxes, moved by `pose` and grown by `slack` on every side, touch the object or reach below the support.
    #[must_use]
    pub fn touched_by(&self, boxes: &[OrientedBox], pose: &Pose, slack: f64) -> bool {
        let below = |plane: &HalfSpace| boxes.iter().any(|b| lowest(plane, &pose.place(b), slack) < 0.0);
        self.support.as_ref().is_some_and(below) || self.object.collides_within(boxes, pose, slack)
    }
}

/// Height of the lowest corner of a box grown by `slack`.
fn lowest(plane: &HalfSpace, placed: &OrientedBox, slack: f64) -> f64 {
    plane.clearance(&OrientedBox { half_extents: placed.half_extents.map(|h| h + slack), ..*placed })
}
