//! Which side of a part's faces is outside.

use crate::geometry::Vec3;

/// What is known of the faces of a part.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Side {
    /// The part is closed and wound outward.
    Out,
    /// The part is closed and wound inward.
    In,
    /// The part is a sheet: both sides are outside.
    Both,
}

impl Side {
    /// The outward one of a face's two unit normals, given the one of its winding; of a sheet, that one.
    #[must_use]
    pub fn outward(self, normal: Vec3) -> Vec3 {
        if self == Self::In { -normal } else { normal }
    }
}

/// Spread the bits of a directed edge (Steele, Lea and Flood 2014, `SplitMix`).
fn spread(from: usize, to: usize) -> u64 {
    let mut x = ((from as u64) << 32 | to as u64).wrapping_add(0x9E37_79B9_7F4A_7C15);
    x = (x ^ x >> 30).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    x = (x ^ x >> 27).wrapping_mul(0x94D0_49BB_1331_11EB);
    x ^ x >> 31
}

/// Say it for each of `count` parts, in one pass.
///
/// A part is closed when its directed edges and their reverses are the same collection: sums of hashes compare these
/// without sorting. Which way it is wound its signed volume tells.
#[must_use]
pub fn sides(vertices: &[Vec3], faces: &[[usize; 3]], face_parts: &[usize], count: usize) -> Vec<Side> {
    let mut balance = vec![0_u64; count];
    let mut volume = vec![0.0; count];
    for (face, &part) in faces.iter().zip(face_parts) {
        for k in 0..3 {
            let (a, b) = (face[k], face[(k + 1) % 3]);
            balance[part] = balance[part].wrapping_add(spread(a, b)).wrapping_sub(spread(b, a));
        }
        let [a, b, c] = face.map(|v| vertices[v]);
        volume[part] += a.dot(&b.cross(&c));
    }
    balance
        .iter()
        .zip(&volume)
        .map(|(&edges, &six)| match (edges, six) {
            (0, v) if v > 0.0 => Side::Out,
            (0, v) if v < 0.0 => Side::In,
            _ => Side::Both,
        })
        .collect()
}
