//! From flat arrays to grasps: checks a request, works out what the object is, asks the sampler.

use super::boxes::{HalfSpace, Hand};
use super::collision::Collider;
use super::pairs::Sheet;
use super::sampler::{Answer, Place, Scene, Settings, sample_grasps};
use super::samples::SPREAD;
use super::score::{Judge, TERMS};
use super::sides::{Side, sides};
use crate::error::Error;
use crate::geometry::{Vec3, points_of};

/// What is asked for. Arrays are flat and finite, lengths in metres.
#[derive(Debug, Clone)]
pub struct Request<'a> {
    /// (v, 3).
    pub vertices: &'a [f64],
    /// (f, 3) vertex indices.
    pub faces: &'a [i64],
    /// (f,) the part of each face.
    pub face_parts: &'a [i64],
    /// What closes.
    pub hand: Hand,
    /// Its largest opening.
    pub stroke: f64,
    /// Where: a point on the surface.
    pub contact: Option<Vec3>,
    /// How far around it pads may press.
    pub radius: f64,
    /// The demonstrated approach, a unit vector.
    pub approach: Option<Vec3>,
    /// The part on which a pad must press.
    pub part: Option<usize>,
    /// What the object stands on.
    pub support: Option<HalfSpace>,
    /// Up, a unit vector; the support's normal where there is one.
    pub up: Option<Vec3>,
    /// Weights of the score's terms.
    pub weights: [f64; TERMS],
    /// The rest.
    pub settings: Settings,
}

/// Find grasps.
///
/// # Errors
/// A face has a vertex that is not there or no part, the surface has no area, or a parameter is out of its range.
pub fn plan(request: &Request<'_>) -> Result<Answer, Error> {
    let vertices = points_of(request.vertices);
    let faces = faces_of(request.faces, vertices.len())?;
    let face_parts: Vec<usize> = request.face_parts.iter().map(|&p| p as usize).collect();
    if face_parts.len() != faces.len() {
        return Err(Error::shape("face_parts", faces.len(), face_parts.len()));
    }
    if let Some(bad) = request.face_parts.iter().find(|p| !(0..=faces.len() as i64).contains(*p)) {
        return Err(Error::value("face_parts", format!("numbers from 0 to {}", faces.len()), bad));
    }
    check(request)?;
    let count = face_parts.iter().max().map_or(0, |p| p + 1);
    let sides = sides(&vertices, &faces, &face_parts, count);
    let center = center_of_mass(&vertices, &faces, &face_parts, &sides)?;
    let collider = Collider::new(&vertices, &faces);
    let settings = &request.settings;
    let scene = Scene {
        sheet: Sheet { vertices: &vertices, faces: &faces, face_parts: &face_parts, sides: &sides },
        collider: &collider,
        hand: &request.hand,
        support: request.support,
        judge: Judge {
            contact: request.contact,
            spread: SPREAD * request.radius,
            approach: request.approach,
            up: request.support.map(|s| s.normal).or(request.up),
            is_supported: request.support.is_some(),
            center,
            stroke: request.stroke,
            cone: settings.cone,
            weights: request.weights,
        },
    };
    let place = Place { part: request.part, near: request.contact.map(|point| (point, request.radius)) };
    Ok(sample_grasps(&scene, &place, settings))
}

fn faces_of(flat: &[i64], count: usize) -> Result<Vec<[usize; 3]>, Error> {
    if let Some(&bad) = flat.iter().find(|&&v| v < 0 || v as usize >= count) {
        return Err(Error::value("faces", format!("indices of {count} vertices"), bad));
    }
    Ok(flat.chunks_exact(3).map(|f| [0, 1, 2].map(|k| f[k] as usize)).collect())
}

fn check(request: &Request<'_>) -> Result<(), Error> {
    let settings = &request.settings;
    let positive = [
        ("stroke", request.stroke),
        ("radius", request.radius),
        ("cone", settings.cone),
        ("spacing", settings.nearness.distance),
        ("turn", settings.nearness.angle),
    ];
    for (name, value) in positive {
        if !(value.is_finite() && value > 0.0) {
            return Err(Error::value(name, "a positive number", value));
        }
    }
    if settings.cone >= std::f64::consts::FRAC_PI_2 {
        return Err(Error::value("cone", "less than a right angle", settings.cone));
    }
    for (name, value) in [("clearance", settings.clearance), ("margin", settings.margin), ("travel", settings.travel)] {
        if !(value.is_finite() && value >= 0.0) {
            return Err(Error::value(name, "a number of at least 0", value));
        }
    }
    for (name, value) in [("samples", settings.samples), ("rays", settings.rays), ("approaches", settings.approaches)] {
        if value == 0 {
            return Err(Error::value(name, "at least 1", value));
        }
    }
    let is_weight = |w: &f64| w.is_finite() && *w >= 0.0;
    if !(request.weights.iter().all(is_weight) && request.weights.iter().any(|w| *w > 0.0)) {
        let got = format!("{:?}", request.weights);
        return Err(Error::value("weights", "numbers of at least 0, not all of them 0", got));
    }
    if request.hand.finger.is_empty() {
        return Err(Error::value("fingers", "at least one box, the pad", 0));
    }
    Ok(())
}

/// Of a body of even density where every part is closed, else of a shell of even thickness.
fn center_of_mass(
    vertices: &[Vec3],
    faces: &[[usize; 3]],
    face_parts: &[usize],
    sides: &[Side],
) -> Result<Vec3, Error> {
    let is_body = face_parts.iter().all(|&part| sides[part] != Side::Both);
    // Shares are taken about a point of the object, so that they do not cancel far from the origin.
    let about = faces.first().map_or_else(Vec3::zeros, |face| vertices[face[0]]);
    let (mut total, mut area, mut body, mut shell) = (0.0, 0.0, Vec3::zeros(), Vec3::zeros());
    for (face, &part) in faces.iter().zip(face_parts) {
        let [a, b, c] = face.map(|v| vertices[v] - about);
        let size = (b - a).cross(&(c - a)).norm();
        area += size;
        shell += (a + b + c) * (size / 3.0);
        let volume = a.dot(&b.cross(&c)) * if sides[part] == Side::In { -1.0 } else { 1.0 };
        total += volume;
        body += (a + b + c) * (volume / 4.0);
    }
    if area <= 0.0 {
        return Err(Error::value("faces", "a surface of some area", area));
    }
    Ok(about + if is_body && total > 0.0 { body / total } else { shell / area })
}
