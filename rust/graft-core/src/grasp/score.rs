//! How good a grasp is: named terms in [0, 1], and their weighted geometric mean.

use super::boxes::Pose;
use crate::geometry::Vec3;

/// How many terms there are.
pub const TERMS: usize = 8;

/// Their names, in the order of weights and values.
pub const NAMES: [&str; TERMS] = ["cone", "distance", "lever", "approach", "above", "width", "pads", "part"];

/// A term of nothing still leaves an order among grasps: one that fails in two things is worse than in one.
const FLOOR: f64 = 1e-3;

/// Horizontal distance from the centre of mass, in metres, that halves the term: at 4 N it twists the pads by .2 Nm,
/// some twice of what two of Panda's pads at 15 N and friction .5 hold by friction alone.
const LEVER: f64 = 0.05;

/// A pad of which this share touches is as good as one that touches all over.
const ENOUGH: f64 = 0.5;

/// Share of the term that is left where only one of the pads presses on the part that was asked for.
const OTHER_PART: f64 = 0.3;

/// What grasps are judged by, beside themselves.
#[derive(Debug, Clone)]
pub struct Judge {
    /// Where it was asked for.
    pub contact: Option<Vec3>,
    /// Distance from there at which the term is e^(-1/2), metres.
    pub spread: f64,
    /// The demonstrated approach, a unit vector.
    pub approach: Option<Vec3>,
    /// Up, a unit vector.
    pub up: Option<Vec3>,
    /// Whether coming from above is better: something is below.
    pub is_supported: bool,
    /// Centre of mass.
    pub center: Vec3,
    /// Largest opening.
    pub stroke: f64,
    /// Friction cone's half angle.
    pub cone: f64,
    /// Weights of the terms.
    pub weights: [f64; TERMS],
}

/// What is known of one grasp.
#[derive(Debug, Clone, Copy)]
pub struct Facts {
    /// Where the gripper is.
    pub pose: Pose,
    /// Where the pads press: at +y, at -y; object frame.
    pub contacts: [Vec3; 2],
    /// Between the pads, metres.
    pub width: f64,
    /// The worst angle between the line of the contacts, the normals and the closing axis, radians.
    pub angle: f64,
    /// Share of the worse pad that touches; None before it is known.
    pub share: Option<f64>,
    /// Whether both pads press on the part that was asked for.
    pub is_on_part: bool,
}

/// Distance of a point from a segment.
#[must_use]
pub fn segment_distance(point: &Vec3, ends: &[Vec3; 2]) -> f64 {
    let along = ends[1] - ends[0];
    let length = along.norm_squared();
    let t = if length > 0.0 { ((point - ends[0]).dot(&along) / length).clamp(0.0, 1.0) } else { 0.0 };
    (point - ends[0] - along * t).norm()
}

impl Judge {
    /// Distance from the contact to the nearest place between the pads; 0 where none was asked for.
    #[must_use]
    pub fn distance(&self, contacts: &[Vec3; 2]) -> f64 {
        self.contact.map_or(0.0, |point| segment_distance(&point, contacts))
    }

    /// The terms, in the order of [`NAMES`].
    ///
    /// * cone: how far inside the friction cone the worst angle stays.
    /// * distance: a Gaussian of the distance from the contact.
    /// * lever: the centre of mass's distance from the pads, horizontal where up is known.
    /// * approach: agreement with the demonstrated approach.
    /// * above: coming from above, where there is a support.
    /// * width: what is left of the stroke.
    /// * pads: the share of the worse pad that touches.
    /// * part: both pads on the part that was asked for.
    #[must_use]
    pub fn terms(&self, facts: &Facts) -> [f64; TERMS] {
        let come = facts.pose.rotation.column(2);
        let far = self.distance(&facts.contacts) / self.spread;
        let mut arm = self.center - (facts.contacts[0] + facts.contacts[1]) / 2.0;
        if let Some(up) = &self.up {
            arm -= up * arm.dot(up);
        }
        let above = self.up.filter(|_| self.is_supported).map_or(1.0, |up| (1.0 - come.dot(&up)) / 2.0);
        [
            (1.0 - facts.angle / self.cone).max(0.0),
            (-far * far / 2.0).exp(),
            1.0 / (1.0 + arm.norm() / LEVER),
            self.approach.map_or(1.0, |a| f64::midpoint(1.0, come.dot(&a))),
            above,
            1.0 - facts.width / self.stroke,
            facts.share.map_or(1.0, |share| (share / ENOUGH).min(1.0)),
            if facts.is_on_part { 1.0 } else { OTHER_PART },
        ]
    }

    /// Weighted geometric mean of terms, in [0, 1].
    #[must_use]
    pub fn score(&self, terms: &[f64; TERMS]) -> f64 {
        let total: f64 = self.weights.iter().sum();
        let sum: f64 = self.weights.iter().zip(terms).map(|(w, t)| w * t.max(FLOOR).ln()).sum();
        (sum / total).exp()
    }
}
