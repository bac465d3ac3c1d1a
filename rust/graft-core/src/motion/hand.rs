//! A hand that flies freely: the space of its poses.

use rand::RngExt;
use rand_pcg::Pcg64;

use super::obstacles::Obstacles;
use super::pose::{Pose, random_rotation};
use super::space::Space;
use crate::geometry::{OrientedBox, Vec3};

/// Share of the samples whose rotation lies between those of start and goal; the others are drawn from all rotations.
const TOWARDS_GOAL: f64 = 0.5;

/// Rigid boxes among obstacles.
#[derive(Debug)]
pub struct Hand<'a> {
    /// In the hand's frame.
    pub boxes: &'a [OrientedBox],
    /// What it must not touch.
    pub obstacles: &'a Obstacles,
    /// Lowest and highest corner of where samples of its origin are drawn, metres.
    pub bounds: [Vec3; 2],
    /// The rotations of samples lie between those of these two in part.
    pub ends: [Pose; 2],
    /// Distance from its origin to its farthest corner, metres: the weight of a radian.
    pub radius: f64,
}

/// Distance from the origin to the farthest corner of boxes.
#[must_use]
pub fn reach(boxes: &[OrientedBox]) -> f64 {
    let corner = |b: &OrientedBox, k: usize| {
        (0..3)
            .fold(b.center, |p, i| p + b.axes[i] * if k >> i & 1 == 1 { b.half_extents[i] } else { -b.half_extents[i] })
    };
    boxes.iter().flat_map(|b| (0..8).map(move |k| corner(b, k).norm())).fold(0.0, f64::max)
}

impl Space for Hand<'_> {
    type State = Pose;

    /// Metres and radians weighted by the radius: a point of the hand is moved by the translation and, at most its
    /// distance from the origin times the angle, by the turn.
    fn distance(&self, a: &Pose, b: &Pose) -> f64 {
        (a.position - b.position).norm() + self.radius * a.angle_to(b)
    }

    fn between(&self, a: &Pose, b: &Pose, t: f64) -> Pose {
        a.between(b, t)
    }

    fn sample(&self, random: &mut Pcg64) -> Pose {
        let [low, high] = self.bounds;
        let position = Vec3::from_fn(|k, _| low[k] + (high[k] - low[k]) * random.random::<f64>());
        let rotation = if random.random_bool(TOWARDS_GOAL) {
            self.ends[0].between(&self.ends[1], random.random()).rotation
        } else {
            random_rotation(random)
        };
        Pose { position, rotation }
    }

    fn clear(&self, pose: &Pose, slack: f64) -> bool {
        !self.obstacles.touched_by(self.boxes, &pose.rigid(), slack)
    }
}
