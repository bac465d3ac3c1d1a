//! Whether a gripper made of boxes touches an object made of triangles and balls.

use super::boxes::{Hand, Pose};
use super::separating::{meets_ball, meets_triangle};
use super::tree::{Aabb, Tree};
use crate::geometry::crossing::crossing;
use crate::geometry::{OrientedBox, Vec3};

/// The direction in which [`Collider::contains`] looks: along no axis, plane or diagonal that people build with.
const LOOK: [f64; 3] = [0.480_384_46, 0.754_877_67, 0.446_642_31];

/// An object to be collided with: built once, asked from any number of threads.
///
/// The surface alone counts, as in FCL: a box that lies wholly inside a closed mesh and touches none of its triangles
/// does not collide, unless the object was said to be [`solid`](Self::solid).
#[derive(Debug)]
pub struct Collider {
    /// Everything is stored about this point, where floats are densest.
    origin: Vec3,
    triangles: Vec<[Vec3; 3]>,
    balls: Vec<(Vec3, f64)>,
    tree: Tree,
    solid: bool,
}

impl Collider {
    /// Take the triangles of a mesh with finite vertices and valid indices.
    #[must_use]
    pub fn new(vertices: &[Vec3], faces: &[[usize; 3]]) -> Self {
        Self::with_balls(vertices, faces, &[])
    }

    /// Take triangles, and balls (centre, radius), as which the points of clouds count.
    #[must_use]
    pub fn with_balls(vertices: &[Vec3], faces: &[[usize; 3]], balls: &[(Vec3, f64)]) -> Self {
        let mut around = Aabb::EMPTY;
        for p in faces.iter().flatten().map(|&v| &vertices[v]).chain(balls.iter().map(|(center, _)| center)) {
            around = Aabb { low: around.low.inf(p), high: around.high.sup(p) };
        }
        let is_empty = faces.is_empty() && balls.is_empty();
        let origin = if is_empty { Vec3::zeros() } else { (around.low + around.high) * 0.5 };
        let triangles: Vec<[Vec3; 3]> = faces.iter().map(|face| face.map(|v| vertices[v] - origin)).collect();
        let balls: Vec<(Vec3, f64)> = balls.iter().map(|(center, radius)| (center - origin, *radius)).collect();
        let of_triangles = triangles.iter().map(|[a, b, c]| Aabb { low: a.inf(b).inf(c), high: a.sup(b).sup(c) });
        let of_balls = balls.iter().map(|(center, r)| Aabb { low: center.add_scalar(-r), high: center.add_scalar(*r) });
        let bounds: Vec<Aabb> = of_triangles.chain(of_balls).collect();
        Self { origin, tree: Tree::new(&bounds), triangles, balls, solid: false }
    }

    /// Let boxes wholly inside count as well; the triangles must be wound outward and their parts be closed.
    #[must_use]
    pub fn solid(self) -> Self {
        Self { solid: true, ..self }
    }

    /// Whether any of the boxes, moved by `pose` into the object's frame, touches the object.
    ///
    /// They are tried in their order: those likelier to touch go first. Nothing is allocated.
    #[must_use]
    pub fn collides(&self, boxes: &[OrientedBox], pose: &Pose) -> bool {
        self.collides_within(boxes, pose, 0.0)
    }

    /// Like [`collides`](Self::collides), with every face of every box moved out by `margin`.
    #[must_use]
    pub fn collides_within(&self, boxes: &[OrientedBox], pose: &Pose, margin: f64) -> bool {
        self.meets_any(boxes.iter().copied(), pose, margin)
    }

    /// Whether a hand at `pose`, its pads `opening` apart, touches the object.
    #[must_use]
    pub fn hand_collides(&self, hand: &Hand, opening: f64, pose: &Pose, margin: f64) -> bool {
        self.meets_any(hand.boxes(opening), pose, margin)
    }

    /// Whether any box, moved by `pose` and grown by `margin`, touches the object.
    pub fn meets_any(&self, boxes: impl Iterator<Item = OrientedBox> + Clone, pose: &Pose, margin: f64) -> bool {
        let place = |given: &OrientedBox| {
            let mut placed = pose.place(given);
            placed.center -= self.origin;
            placed.half_extents = placed.half_extents.map(|h| h + margin);
            placed
        };
        boxes.clone().any(|given| self.meets(&place(&given)))
            || (self.solid && boxes.map(|given| place(&given).center).any(|center| self.encloses(&center)))
    }

    /// Whether a box about the origin of storage touches a triangle or a ball.
    fn meets(&self, placed: &OrientedBox) -> bool {
        self.tree.any(placed, |index| {
            if let Some(corners) = self.triangles.get(index) {
                return meets_triangle(placed, corners);
            }
            let (center, radius) = &self.balls[index - self.triangles.len()];
            meets_ball(placed, center, *radius)
        })
    }

    /// Whether a point lies inside the triangles: they wind around it. Balls do not count.
    #[must_use]
    pub fn contains(&self, point: &Vec3) -> bool {
        self.encloses(&(point - self.origin))
    }

    /// Signed crossings of a half-line do not add up to zero; parity would fail where closed parts overlap.
    fn encloses(&self, point: &Vec3) -> bool {
        let look = Vec3::from(LOOK);
        let mut winding = 0_i64;
        self.tree.along(point, &look, f64::from(f32::MAX), |index| {
            if let Some(corners) = self.triangles.get(index)
                && crossing(corners, point, &look).is_some_and(|(t, _)| t >= 0.0)
            {
                let normal = (corners[1] - corners[0]).cross(&(corners[2] - corners[0]));
                winding += if normal.dot(&look) > 0.0 { 1 } else { -1 };
            }
        });
        winding != 0
    }

    /// Where a line from `origin` along the unit `direction` crosses triangles, `0 <= t <= longest`: fills `hits` with
    /// (t, triangle) in the order of t, ties in that of the triangles.
    pub fn crossings(&self, origin: &Vec3, direction: &Vec3, longest: f64, hits: &mut Vec<(f64, usize)>) {
        hits.clear();
        let from = origin - self.origin;
        self.tree.along(&from, direction, longest, |index| {
            if let Some(corners) = self.triangles.get(index)
                && let Some((t, _)) = crossing(corners, &from, direction)
                && (0.0..=longest).contains(&t)
            {
                hits.push((t, index));
            }
        });
        hits.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    }

    /// Visit the corners of every triangle whose bounds may meet a box moved by `pose`.
    pub fn triangles_near(&self, given: &OrientedBox, pose: &Pose, mut visit: impl FnMut([Vec3; 3])) {
        let mut placed = pose.place(given);
        placed.center -= self.origin;
        self.tree.any(&placed, |index| {
            if let Some(corners) = self.triangles.get(index) {
                visit(corners.map(|p| p + self.origin));
            }
            false
        });
    }
}
