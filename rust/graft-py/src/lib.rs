//! The Python border of graft-core: declares, converts, calls. No computing here.

mod convert;
mod render;

/// The compiled core of graft.
#[pyo3::pymodule]
mod _core {
    /// The version of the compiled core.
    #[pymodule_export]
    #[allow(non_upper_case_globals)]
    const __version__: &str = env!("CARGO_PKG_VERSION");

    #[pymodule_export]
    use super::render::{cast_rays, render_scene};
}
