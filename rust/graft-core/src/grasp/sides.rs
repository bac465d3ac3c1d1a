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

/// Spread the bits of a number (Steele, Lea and Flood 2014, `SplitMix`).
fn spread(x: u64) -> u64 {
    let mut x = x.wrapping_add(0x9E37_79B9_7F4A_7C15);
    x = (x ^ x >> 30).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    x = (x ^ x >> 27).wrapping_mul(0x94D0_49BB_1331_11EB);
    x ^ x >> 31
}

/// A number for a place: corners in the same place are the same corner, whichever their indices.
fn place(p: &Vec3) -> u64 {
    // Adding 0 makes the two zeros one.
    p.iter().fold(0, |sum, x| spread(sum ^ (x + 0.0).to_bits()))
}

/// Say it for each of `count` parts, in one pass.
///
/// A part is closed when its directed edges and their reverses are the same collection: sums of hashes compare these
/// without sorting. Parts that are open alone may be closed together, as pieces of one scan are. Which way they are
/// wound the signed volume tells.
#[must_use]
pub fn sides(vertices: &[Vec3], faces: &[[usize; 3]], face_parts: &[usize], count: usize) -> Vec<Side> {
    let places: Vec<u64> = vertices.iter().map(place).collect();
    let mut balance = vec![0_u64; count];
    let mut volume = vec![0.0; count];
    for (face, &part) in faces.iter().zip(face_parts) {
        for k in 0..3 {
            let (a, b) = (places[face[k]], places[face[(k + 1) % 3]]);
            let directed = |from: u64, to: u64| spread(from.rotate_left(32) ^ to);
            balance[part] = balance[part].wrapping_add(directed(a, b)).wrapping_sub(directed(b, a));
        }
        let [a, b, c] = face.map(|v| vertices[v]);
        volume[part] += a.dot(&b.cross(&c));
    }
    let is_open = |part: &usize| balance[*part] != 0;
    let together = (0..count).filter(is_open).fold(0_u64, |sum, part| sum.wrapping_add(balance[part]));
    let open_volume: f64 = (0..count).filter(is_open).map(|part| volume[part]).sum();
    (0..count)
        .map(|part| {
            let (edges, six) = if is_open(&part) { (together, open_volume) } else { (0, volume[part]) };
            match (edges, six) {
                (0, v) if v > 0.0 => Side::Out,
                (0, v) if v < 0.0 => Side::In,
                _ => Side::Both,
            }
        })
        .collect()
}
