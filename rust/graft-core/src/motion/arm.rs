//! An arm among obstacles: the space of its joint values.

use rand::RngExt;
use rand_pcg::Pcg64;

use super::chain::Chain;
use super::obstacles::Obstacles;
use super::space::Space;
use crate::geometry::boxes_overlap;
use crate::grasp::Pose;

/// A chain, what it must not touch, and which of its boxes must not touch each other.
#[derive(Debug)]
pub struct Arm<'a> {
    /// The arm.
    pub chain: &'a Chain,
    /// The object and what it stands on.
    pub obstacles: &'a Obstacles,
    /// Indices of boxes that keep away from the obstacles: all but those of the base, which stands on the support.
    pub movers: &'a [usize],
    /// Pairs of boxes that keep away from each other.
    pub pairs: &'a [(usize, usize)],
}

impl Space for Arm<'_> {
    type State = Vec<f64>;

    /// Radians and metres weighted by how far each joint moves a point of the arm at most.
    fn distance(&self, a: &Vec<f64>, b: &Vec<f64>) -> f64 {
        a.iter().zip(b).zip(self.chain.reaches()).map(|((p, q), reach)| reach * (p - q).abs()).sum()
    }

    fn between(&self, a: &Vec<f64>, b: &Vec<f64>, t: f64) -> Vec<f64> {
        a.iter().zip(b).map(|(p, q)| p + (q - p) * t).collect()
    }

    fn sample(&self, random: &mut Pcg64) -> Vec<f64> {
        self.chain.limits().iter().map(|(low, high)| low + (high - low) * random.random::<f64>()).collect()
    }

    fn clear(&self, q: &Vec<f64>, slack: f64) -> bool {
        let boxes = self.chain.placed(q, slack);
        let still = Pose::identity();
        self.movers.iter().all(|&i| !self.obstacles.touched_by(&boxes[i..=i], &still, 0.0))
            && self.pairs.iter().all(|&(i, j)| !boxes_overlap(&boxes[i], &boxes[j]))
    }
}
