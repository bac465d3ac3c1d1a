//! Motions without collisions: RRT-Connect for a hand that flies freely and for arms.
//!
//! [`rrt::plan`] plans in any [`Space`]; [`Hand`] and [`Arm`] are two. Metres and radians throughout.

pub mod arm;
pub mod batch;
pub mod chain;
pub mod edges;
pub mod hand;
pub mod obstacles;
pub mod pose;
pub mod rrt;
pub mod shortcut;
pub mod space;

pub use arm::Arm;
pub use batch::{Contacts, clear_arms, plan_arms, plan_hands};
pub use chain::{Chain, Link, LinkBox, Motion};
pub use hand::{Hand, reach};
pub use obstacles::Obstacles;
pub use pose::Pose;
pub use rrt::{Options, Outcome, Plan, plan};
pub use space::Space;

#[cfg(test)]
mod tests;
