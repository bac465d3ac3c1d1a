//! Boxes, hulls, sampling: everything about one mesh or point set.

pub mod affine;
pub mod chamfer;
pub mod corners;
pub mod crossing;
pub mod flush;
pub mod frame;
pub mod gap;
pub mod hull;
pub mod moments;
pub mod obb;
pub mod part;
mod quickhull;
pub mod rectangle;
pub mod search;
pub mod solid;
pub mod surface;
pub mod ties;
pub mod turn;

pub use chamfer::chamfer;
pub use frame::Frame;
pub use gap::{box_gap, boxes_overlap};
pub use hull::{Hull, convex_hull};
pub use obb::{OrientedBox, minimal_box};
pub use part::{PartGeometry, PartShape, object_geometry};

/// A point or a direction in space.
pub type Vec3 = nalgebra::Vector3<f64>;

/// Read (n, 3) row-major coordinates.
#[must_use]
pub fn points_of(flat: &[f64]) -> Vec<Vec3> {
    flat.chunks_exact(3).map(|p| Vec3::new(p[0], p[1], p[2])).collect()
}
