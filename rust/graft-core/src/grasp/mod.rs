//! Grasps: what a gripper of boxes touches, and where it can close.

mod batch;
mod boxes;
mod collision;
mod pads;
mod pairs;
mod plan;
mod reach;
mod sampler;
mod samples;
mod score;
mod separating;
mod sides;
mod thin;
mod tree;

pub use batch::{Surface, collisions};
pub use boxes::{HalfSpace, Hand, Pose, swept};
pub use collision::Collider;
pub use plan::{Request, plan};
pub use reach::Reason;
pub use sampler::{Answer, Proposal, Settings};
pub use score::{NAMES, TERMS};
pub use separating::{meets_ball, meets_triangle};
pub use thin::Nearness;

#[cfg(test)]
mod tests;
