//! Grasps: what a gripper of boxes touches, and where it can close.

mod batch;
mod boxes;
mod collision;
mod separating;
mod tree;

pub use batch::{Surface, collisions};
pub use boxes::{HalfSpace, Hand, Pose, swept};
pub use collision::Collider;
pub use separating::{meets_ball, meets_triangle};

#[cfg(test)]
mod tests;
