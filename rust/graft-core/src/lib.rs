//! The mathematics of graft: part geometry, part graphs, descriptors and unbalanced fused Gromov-Wasserstein transport.
//!
//! Pure functions over plain slices: no Python, no files, no logging. Bad input is an [`Error`], never a panic.

pub mod descriptor;
pub mod error;
pub mod geometry;
pub mod graph;
pub mod grasp;
pub mod motion;
pub mod render;
pub mod retrieve;
pub mod segment;
pub mod transport;

pub use error::Error;
