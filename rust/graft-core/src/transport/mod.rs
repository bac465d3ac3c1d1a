//! Unbalanced fused Gromov-Wasserstein transport between two small weighted graphs, with EM on the target masses.
//!
//! The objective over plans T (n x m), with KL(p|q) = sum p log(p/q) - p + q:
//!
//! ```text
//! F(T) = (1-alpha) 1/2 sum loss(A_ii', B_jj') T_ij T_i'j' + alpha <M, T>
//!        + tau_s KL(T1 | mu) + tau_t KL(T'1 | nu) + eps KL(T | R),      R = mu nu' by default
//! ```
//!
//! alpha weighs features and 1 - alpha structure, as in the paper; POT's alpha is the opposite.
//!
//! [`problem`] checks the data, [`cost`] linearises the structure term, [`sinkhorn`] solves the linear problem,
//! [`objective`] evaluates F, [`ufgw`] loops. [`lanes`] does the same for many small pairs at once, [`batch`] sends every
//! pair where it belongs, [`starts`] tries several starts, [`wide`] has the inner loops, [`feature`] makes M from
//! part graphs.

// C_GW, T_ij and A_ii' are mathematics, not code.
#![allow(clippy::doc_markdown)]

pub mod batch;
pub mod cost;
pub mod feature;
pub mod lanes;
pub mod objective;
pub mod problem;
pub mod sinkhorn;
pub mod starts;
pub mod ufgw;
pub mod wide;

pub use problem::{Entropy, Input, Loss, Options, Problem};
pub use ufgw::{Solution, solve};
