//! Places on the surface where a pad might go: by area, more of them near a contact.

use rand::RngExt;
use rand_pcg::Pcg64;

use crate::geometry::Vec3;

/// Near a contact, triangles are cut until their edges are this share of the radius: the weight within one is then even.
const CUT: f64 = 0.5;

/// Standard deviation of the preference for the contact, as a share of the radius.
pub const SPREAD: f64 = 0.5;

/// A place on the surface.
#[derive(Debug, Clone, Copy)]
pub struct Sample {
    /// Where.
    pub point: Vec3,
    /// On which face.
    pub face: usize,
}

/// A piece of a face, and how likely it is.
struct Piece {
    corners: [Vec3; 3],
    face: usize,
    weight: f64,
}

fn area(corners: &[Vec3; 3]) -> f64 {
    (corners[1] - corners[0]).cross(&(corners[2] - corners[0])).norm() / 2.0
}

/// Add the pieces of a triangle within `radius` of `center`, weighted by area and nearness.
fn cut(corners: [Vec3; 3], face: usize, center: &Vec3, radius: f64, pieces: &mut Vec<Piece>) {
    let mut waiting = vec![corners];
    while let Some(corners) = waiting.pop() {
        let middle = (corners[0] + corners[1] + corners[2]) / 3.0;
        let reach = corners.iter().map(|c| (c - middle).norm_squared()).fold(0.0, f64::max).sqrt();
        let distance = (middle - center).norm();
        if distance > radius + reach {
            continue;
        }
        if reach > CUT * radius {
            let [a, b, c] = corners;
            let [ab, bc, ca] = [(a + b) / 2.0, (b + c) / 2.0, (c + a) / 2.0];
            waiting.extend([[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]);
        } else if distance <= radius {
            let far = distance / (SPREAD * radius);
            pieces.push(Piece { corners, face, weight: area(&corners) * (-far * far / 2.0).exp() });
        }
    }
}

/// Draw `count` places on the faces that are `allowed`, stratified; none where these have no area.
pub fn draw(
    vertices: &[Vec3],
    faces: &[[usize; 3]],
    allowed: impl Fn(usize) -> bool,
    near: Option<(Vec3, f64)>,
    count: usize,
    rng: &mut Pcg64,
) -> Vec<Sample> {
    let mut pieces = Vec::new();
    for (face, indices) in faces.iter().enumerate().filter(|(face, _)| allowed(*face)) {
        let corners = indices.map(|v| vertices[v]);
        match &near {
            Some((center, radius)) => cut(corners, face, center, *radius, &mut pieces),
            None => pieces.push(Piece { corners, face, weight: area(&corners) }),
        }
    }
    let total: f64 = pieces.iter().map(|p| p.weight).sum();
    if total <= 0.0 {
        return Vec::new();
    }
    let (mut at, mut below) = (0, 0.0);
    (0..count)
        .map(|k| {
            let goal = (k as f64 + rng.random::<f64>()) / count as f64 * total;
            while below + pieces[at].weight < goal && at + 1 < pieces.len() {
                below += pieces[at].weight;
                at += 1;
            }
            let (mut u, mut v): (f64, f64) = (rng.random(), rng.random());
            if u + v > 1.0 {
                (u, v) = (1.0 - u, 1.0 - v);
            }
            let Piece { corners: [a, b, c], face, .. } = &pieces[at];
            Sample { point: a + (b - a) * u + (c - a) * v, face: *face }
        })
        .collect()
}
