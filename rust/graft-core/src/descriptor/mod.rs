//! Rotation-invariant geometric descriptors of parts.
