//! Kernels compiled for several instruction sets, and the choice among them at run time.
//!
//! The one place of the crate with `unsafe`: a function compiled for instructions that the build does not assume may
//! be called only where the processor has them.

use std::sync::OnceLock;

/// Instruction sets the kernel is compiled for. On aarch64 the baseline has NEON.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Instructions {
    /// What every processor of the target has.
    Baseline,
    /// AVX2.
    Avx2,
    /// AVX-512 F, DQ, BW, VL.
    Avx512,
}

/// The best set this processor has; found once.
pub fn instructions() -> Instructions {
    static FOUND: OnceLock<Instructions> = OnceLock::new();
    *FOUND.get_or_init(detect)
}

#[cfg(target_arch = "x86_64")]
fn detect() -> Instructions {
    let avx512 = is_x86_feature_detected!("avx512f")
        && is_x86_feature_detected!("avx512dq")
        && is_x86_feature_detected!("avx512bw")
        && is_x86_feature_detected!("avx512vl");
    if avx512 {
        Instructions::Avx512
    } else if is_x86_feature_detected!("avx2") {
        Instructions::Avx2
    } else {
        Instructions::Baseline
    }
}

#[cfg(not(target_arch = "x86_64"))]
fn detect() -> Instructions {
    Instructions::Baseline
}

/// Work that is worth compiling for several instruction sets; its `run` and all that it calls must be
/// `#[inline(always)]`, or it is compiled for the baseline only.
pub trait Kernel {
    /// Do the work.
    fn run(self);
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx512f,avx512dq,avx512bw,avx512vl")]
fn run_avx512(kernel: impl Kernel) {
    kernel.run();
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2")]
fn run_avx2(kernel: impl Kernel) {
    kernel.run();
}

/// Run a kernel with the instructions given, or with the best that the processor has if it lacks them.
#[allow(unsafe_code)]
pub fn run(kernel: impl Kernel, with: Instructions) {
    match with.min(instructions()) {
        // SAFETY: the processor has these instructions, `instructions` found them.
        #[cfg(target_arch = "x86_64")]
        Instructions::Avx512 => unsafe { run_avx512(kernel) },
        // SAFETY: as above.
        #[cfg(target_arch = "x86_64")]
        Instructions::Avx2 => unsafe { run_avx2(kernel) },
        _ => kernel.run(),
    }
}
