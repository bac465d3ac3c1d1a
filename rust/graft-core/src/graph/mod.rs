//! Relations between parts: edge lengths, adjacency, saliency, masses.

pub mod adjacency;
mod nearest;
pub mod relations;
pub mod structure;

pub use adjacency::{adjacency, hops};
pub use relations::{PartSurface, raw_relations, relations};
pub use structure::{all_pairs, gaps, shortest_paths};
