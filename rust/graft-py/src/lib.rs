//! The Python border of graft-core: declares, converts, calls. No computing here.

// pyo3 hands arguments over by value.
#![allow(clippy::needless_pass_by_value)]

mod convert;
mod descriptor;
mod geometry;
mod graph;
mod grasp;
mod motion;
mod render;
mod retrieve;
mod segment;
mod transport;

/// The compiled core of graft.
#[pyo3::pymodule]
mod _core {
    /// The version of the compiled core.
    #[pymodule_export]
    #[allow(non_upper_case_globals)]
    const __version__: &str = env!("CARGO_PKG_VERSION");

    #[pymodule_export]
    use super::descriptor::{describe_parts, descriptor_dim};
    #[pymodule_export]
    use super::grasp::{antipodal_grasps, gripper_collisions};
    #[pymodule_export]
    use super::motion::{arm_poses, clear_arms, plan_arms, plan_hands};
    #[pymodule_export]
    use super::render::{cast_rays, render_scene};
    #[pymodule_export]
    use super::retrieve::rank_graphs;
    #[pymodule_export]
    use super::segment::{segment_cloud, segment_mesh};
    #[pymodule_export]
    use super::transport::{feature_costs, ufgw_batch, ufgw_pair};
    #[pymodule_export]
    use crate::geometry::{chamfer_distances, convex_hull, oriented_box, part_geometry};
    #[pymodule_export]
    use crate::graph::{box_gaps, edge_lengths, part_adjacency, part_hops, part_relations};
}
