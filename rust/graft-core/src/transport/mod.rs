//! Unbalanced fused Gromov-Wasserstein transport.
