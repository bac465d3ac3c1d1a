//! Whether the hand gets to a pose: past the object and above the support, straight along its approach.

use super::boxes::{HalfSpace, Hand, Pose, swept};
use super::collision::Collider;
use crate::geometry::{OrientedBox, Vec3};

/// Why a candidate falls.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Reason {
    /// No opposite wall in the friction cone.
    NoAntipode,
    /// The opposite wall is farther than the stroke.
    TooWide,
    /// A finger would be in the object.
    Fingers,
    /// The palm would be in the object.
    Palm,
    /// Something would go below the support, now or on the way.
    Support,
    /// The straight way there is blocked.
    Approach,
    /// A finger meets something beside its pad while closing.
    Closing,
    /// The pads miss the surface, or press where the line between them leaves the friction cone.
    Pads,
}

impl Reason {
    /// All, in the order of [`name`](Self::name)'s table.
    pub const ALL: [Self; 8] = [
        Self::NoAntipode,
        Self::TooWide,
        Self::Fingers,
        Self::Palm,
        Self::Support,
        Self::Approach,
        Self::Closing,
        Self::Pads,
    ];

    /// For people.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::NoAntipode => "no antipode",
            Self::TooWide => "too wide",
            Self::Fingers => "finger collision",
            Self::Palm => "palm collision",
            Self::Support => "support",
            Self::Approach => "approach blocked",
            Self::Closing => "closing blocked",
            Self::Pads => "pads miss",
        }
    }
}

/// A hand at one opening, and what it passes on its straight way in: gripper frame.
#[derive(Debug, Clone)]
pub struct Comer {
    fingers: Vec<OrientedBox>,
    palm: Vec<OrientedBox>,
    way: Vec<OrientedBox>,
}

impl Comer {
    /// A hand `opening` wide that comes in over the last `travel` metres.
    #[must_use]
    pub fn new(hand: &Hand, opening: f64, travel: f64) -> Self {
        let back = Vec3::new(0.0, 0.0, -travel);
        Self {
            fingers: hand.fingers(opening).collect(),
            palm: hand.palm.clone(),
            way: hand.boxes(opening).map(|part| swept(&part, &back)).collect(),
        }
    }

    /// Whether it gets to `pose` with every box grown by `margin`; if not, why.
    ///
    /// # Errors
    /// What it meets first: the support, then fingers and palm where they end, then anything on the way.
    pub fn arrives(
        &self,
        collider: &Collider,
        support: Option<&HalfSpace>,
        pose: &Pose,
        margin: f64,
    ) -> Result<(), Reason> {
        if support.is_some_and(|plane| self.way.iter().any(|part| plane.clearance(&pose.place(part)) < margin)) {
            return Err(Reason::Support);
        }
        if !collider.collides_within(&self.way, pose, margin) {
            return Ok(());
        }
        if collider.collides_within(&self.fingers, pose, margin) {
            return Err(Reason::Fingers);
        }
        if collider.collides_within(&self.palm, pose, margin) {
            return Err(Reason::Palm);
        }
        Err(Reason::Approach)
    }
}

/// Whether the fingers close at `pose` from one opening to another without meeting anything.
#[must_use]
pub fn closes(collider: &Collider, hand: &Hand, from: f64, to: f64, pose: &Pose) -> bool {
    let way = hand.fingers(to).zip(hand.fingers(from)).map(|(near, far)| swept(&near, &(far.center - near.center)));
    !collider.meets_any(way, pose, 0.0)
}
