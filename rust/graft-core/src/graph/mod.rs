//! Relations between parts: edge lengths, adjacency, saliency, masses.

pub mod adjacency;
pub mod structure;

pub use adjacency::{adjacency, hops};
pub use structure::{all_pairs, gaps, shortest_paths};
