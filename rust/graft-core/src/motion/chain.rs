//! An arm: a tree of links with one hinge or slide each at most, and boxes on them.

use nalgebra::UnitQuaternion;

use super::pose::Pose;
use crate::Error;
use crate::geometry::{OrientedBox, Vec3};

/// What moves a link on its parent.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Motion {
    /// Nothing: it is welded on.
    Fixed,
    /// Turns by q radians about `axis` through `anchor`, both in the link's frame.
    Hinge {
        /// Unit vector.
        axis: Vec3,
        /// A point on the axis, metres.
        anchor: Vec3,
    },
    /// Moves by q metres along `axis`, in the link's frame.
    Slide {
        /// Unit vector.
        axis: Vec3,
    },
}

/// A rigid piece of an arm.
#[derive(Debug, Clone)]
pub struct Link {
    /// Index of the link that carries it, lower than its own; None for one that stands in the world.
    pub parent: Option<usize>,
    /// Its frame in the parent's (or the world's) where its joint is at 0.
    pub rest: Pose,
    /// How it moves on its parent. Joints are numbered in the order of their links.
    pub motion: Motion,
}

/// A box on a link.
#[derive(Debug, Clone)]
pub struct LinkBox {
    /// Index of the link.
    pub link: usize,
    /// In the link's frame, metres.
    pub shape: OrientedBox,
}

/// Links, boxes, limits.
#[derive(Debug, Clone)]
pub struct Chain {
    links: Vec<Link>,
    boxes: Vec<LinkBox>,
    /// Lowest and highest value of each joint, radians or metres.
    limits: Vec<(f64, f64)>,
    /// How far a point of the arm travels at most while a joint moves by one radian or metre, metres.
    reaches: Vec<f64>,
}

impl Chain {
    /// Put an arm together.
    ///
    /// # Errors
    /// A parent after its child, a box on no link, or limits that are not those of the joints.
    pub fn new(links: Vec<Link>, boxes: Vec<LinkBox>, limits: Vec<(f64, f64)>) -> Result<Self, Error> {
        if let Some(i) = (0..links.len()).find(|&i| links[i].parent.is_some_and(|p| p >= i)) {
            return Err(Error::value(
                "link_parents",
                "parents before their children",
                format!("link {i} before its own"),
            ));
        }
        if let Some(b) = boxes.iter().find(|b| b.link >= links.len()) {
            return Err(Error::value("box_links", format!("indices of {} links", links.len()), b.link));
        }
        let joints = links.iter().filter(|link| link.motion != Motion::Fixed).count();
        if limits.len() != joints {
            return Err(Error::shape("limits", format!("{joints} joints"), limits.len()));
        }
        if let Some((low, high)) = limits.iter().find(|(low, high)| low > high) {
            return Err(Error::value("limits", "low <= high", format!("{low} > {high}")));
        }
        let mut chain = Self { links, boxes, limits, reaches: Vec::new() };
        chain.reaches = chain.measured_reaches();
        Ok(chain)
    }

    /// Lowest and highest value of each joint.
    #[must_use]
    pub fn limits(&self) -> &[(f64, f64)] {
        &self.limits
    }

    /// How far a point of the arm travels at most per radian or metre of each joint.
    #[must_use]
    pub fn reaches(&self) -> &[f64] {
        &self.reaches
    }

    /// Where each link is at the joint values `q`.
    #[must_use]
    pub fn poses(&self, q: &[f64]) -> Vec<Pose> {
        let mut poses: Vec<Pose> = Vec::with_capacity(self.links.len());
        let mut joint = 0;
        for link in &self.links {
            let base = match link.parent {
                None => link.rest,
                Some(parent) => compose(&poses[parent], &link.rest),
            };
            let moved = match link.motion {
                Motion::Fixed => base,
                Motion::Hinge { axis, anchor } => {
                    let turn = UnitQuaternion::from_scaled_axis(axis * q[joint]);
                    compose(&base, &Pose { position: anchor - turn * anchor, rotation: turn })
                }
                Motion::Slide { axis } => {
                    compose(&base, &Pose { position: axis * q[joint], rotation: UnitQuaternion::identity() })
                }
            };
            joint += usize::from(link.motion != Motion::Fixed);
            poses.push(moved);
        }
        poses
    }

    /// The boxes, on their links.
    #[must_use]
    pub fn boxes(&self) -> &[LinkBox] {
        &self.boxes
    }

    /// Where each box is at the joint values `q`, grown by `slack` metres on every side.
    #[must_use]
    pub fn placed(&self, q: &[f64], slack: f64) -> Vec<OrientedBox> {
        let frames: Vec<_> = self.poses(q).iter().map(Pose::rigid).collect();
        let place = |b: &LinkBox| {
            let placed = frames[b.link].place(&b.shape);
            OrientedBox { half_extents: placed.half_extents.map(|h| h + slack), ..placed }
        };
        self.boxes.iter().map(place).collect()
    }

    /// Per joint: the longest way along the arm from its axis to a corner of a box that it moves. Straight lines between
    /// joints are no longer than that in any configuration.
    fn measured_reaches(&self) -> Vec<f64> {
        // `beyond[i]`: from the origin of link i to the farthest corner that hangs on it.
        let mut beyond = vec![None; self.links.len()];
        let mut joints = Vec::new();
        let mut joint = self.limits.len();
        for i in (0..self.links.len()).rev() {
            let mine = self.boxes.iter().filter(|b| b.link == i);
            let corners = mine.map(|b| b.shape.center.norm() + Vec3::from(b.shape.half_extents).norm());
            let mut reach: Option<f64> = corners.fold(beyond[i], |best, r| Some(best.map_or(r, |b: f64| b.max(r))));
            match self.links[i].motion {
                Motion::Fixed => {}
                Motion::Hinge { anchor, .. } => {
                    joint -= 1;
                    joints.push(reach.map_or(0.0, |r| r + anchor.norm()));
                    // The origin itself circles the anchor.
                    reach = reach.map(|r| r + 2.0 * anchor.norm());
                }
                Motion::Slide { .. } => {
                    joint -= 1;
                    joints.push(reach.map_or(0.0, |_| 1.0));
                    let (low, high) = self.limits[joint];
                    reach = reach.map(|r| r + low.abs().max(high.abs()));
                }
            }
            if let (Some(parent), Some(r)) = (self.links[i].parent, reach) {
                let r = r + self.links[i].rest.position.norm();
                beyond[parent] = Some(beyond[parent].map_or(r, |b: f64| b.max(r)));
            }
        }
        joints.reverse();
        joints
    }
}

fn compose(a: &Pose, b: &Pose) -> Pose {
    Pose { position: a.position + a.rotation * b.position, rotation: a.rotation * b.rotation }
}
