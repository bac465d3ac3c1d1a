//! Oriented bounding box of minimal volume.
//!
//! The minimal box has two adjacent faces that each lie against an edge of the hull (O'Rourke 1985); usually one lies
//! against a face. Candidates are therefore every face's normal and the common normals of pairs of long edges, each
//! with the minimal rectangle about its axis. Lower bounds from a coarse inner polyhedron order the candidates and end
//! the search. The best of them are then turned, first about one axis at a time by calipers, then freely in shrinking
//! steps, which reaches the boxes that only touch edges.

use std::collections::HashSet;

use super::Vec3;
use super::affine::{any_normal, span};
use super::hull::{Hull, hull_in};
use super::moments;
use super::rectangle::{Vec2, minimal_rectangle, planar_hull};
use super::search::{Candidate, Coarse, Polyhedron, Workspace};

/// Volumes within this share of each other are equal; the earlier candidate wins.
const VOLUME_TIE: f64 = 1e-12;

/// Normals whose cross product is shorter than this are one candidate.
const SAME_NORMAL: f64 = 1e-9;

/// The common normals of this many longest edges are candidates.
const LONG_EDGES: usize = 32;

/// How many of the best candidates are turned further.
const REFINED: usize = 8;

/// Candidates larger than the smallest by more than this do not become it by turning: measured.
const SLACK: f64 = 1.1;

/// A turn counts when it makes the box smaller by more than this share; less is rounding.
const SMALLER: f64 = 1e-10;

/// Directions whose extreme points make the coarse polyhedron, which bounds volumes to a few per cent from below; more of
/// them for hulls whose boxes take longer.
const COARSE_DIRECTIONS: [usize; 2] = [32, 128];

/// Corners of a large hull.
const LARGE: usize = 400;

/// Up to this many candidates are all tried; of more, one in every cell first.
const ALL_CANDIDATES: usize = 400;

/// Size of a cell of directions, radians. The free turning reaches farther.
const CELL: f64 = 0.1;

/// Around the axes of the best box that the cells gave, all candidates of a large hull within this many radians are tried.
const NEAR: f64 = 0.03;

/// First and last step of the free turning, radians.
const STEPS: (f64, f64) = (0.2, 1e-6);

/// What a step that finds nothing is shortened by.
const SHRINK: f64 = 0.35;

/// A box.
#[derive(Debug, Clone, Copy)]
pub struct OrientedBox {
    /// Centre.
    pub center: Vec3,
    /// Orthonormal axes, right-handed.
    pub axes: [Vec3; 3],
    /// Half of the box's size along each axis; zero along the thin axes of flat sets.
    pub half_extents: [f64; 3],
}

impl OrientedBox {
    /// The box with given axes about non-empty `points`.
    #[must_use]
    pub fn about(points: &[Vec3], axes: [Vec3; 3]) -> Self {
        let mut center = Vec3::zeros();
        let mut half_extents = [0.0; 3];
        for k in 0..3 {
            let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
            for p in points {
                let s = p.dot(&axes[k]);
                low = low.min(s);
                high = high.max(s);
            }
            center += axes[k] * f64::midpoint(low, high);
            half_extents[k] = (high - low) / 2.0;
        }
        Self { center, axes, half_extents }
    }

    /// Volume.
    #[must_use]
    pub fn volume(&self) -> f64 {
        8.0 * self.half_extents.iter().product::<f64>()
    }

    /// Length of the diagonal.
    #[must_use]
    pub fn diagonal(&self) -> f64 {
        2.0 * Vec3::from(self.half_extents).norm()
    }
}

/// A box with what was found on the way to it.
#[derive(Debug, Clone)]
pub struct Boxed {
    /// The minimal box.
    pub bounds: OrientedBox,
    /// Corners of the convex hull (all points, when they do not span a solid).
    pub corners: Vec<Vec3>,
    /// Volume of the convex hull.
    pub hull_volume: f64,
    /// 3 for a solid, 2 for points on a plane, 1 on a line, 0 when they coincide.
    pub dimension: usize,
}

/// Find the minimal box about non-empty `points`.
///
/// Points on a plane get the plane's normal and their minimal rectangle, points on a line that line, coinciding
/// points the frame of the coordinates.
#[must_use]
pub fn minimal_box(points: &[Vec3]) -> Boxed {
    let found = span(points);
    let hull = hull_in(points, &found);
    let hull_volume = hull.volume();
    let corners = hull.vertices.clone();
    let axes = match found.dimension {
        0 => [Vec3::x(), Vec3::y(), Vec3::z()],
        1 => {
            let y = any_normal(&found.axes[0]);
            [found.axes[0], y, found.axes[0].cross(&y)]
        }
        3 if !hull.faces.is_empty() => posed_axes(hull),
        // A plane, or a solid so thin that quickhull gave up.
        _ => planar_axes(points, found.axes),
    };
    Boxed { bounds: OrientedBox::about(points, axes), corners, hull_volume, dimension: found.dimension }
}

fn planar_axes(points: &[Vec3], [u, v, normal]: [Vec3; 3]) -> [Vec3; 3] {
    let mut flat: Vec<Vec2> = points.iter().map(|p| Vec2::new(p.dot(&u), p.dot(&v))).collect();
    let mut polygon = Vec::new();
    planar_hull(&mut flat, &mut polygon);
    let side = minimal_rectangle(&mut polygon).map_or(Vec2::x(), |r| r.side);
    let x = u * side.x + v * side.y;
    [x, normal.cross(&x), normal]
}

/// Directions that can be an axis of the minimal box, each once up to its sign.
fn candidate_normals(hull: &Polyhedron) -> Vec<Vec3> {
    let mut normals: Vec<Vec3> = hull.normals.iter().filter(|n| n.norm_squared() > 0.5).map(upper).collect();
    let mut edges: Vec<Vec3> = hull.edges().map(|(a, b)| hull.vertices[b] - hull.vertices[a]).collect();
    edges.sort_by(|a, b| b.norm_squared().total_cmp(&a.norm_squared()));
    edges.truncate(LONG_EDGES);
    for (i, a) in edges.iter().enumerate() {
        for b in &edges[..i] {
            let normal = a.cross(b);
            if normal.norm() > 1e-6 * a.norm() * b.norm() {
                normals.push(upper(&normal.normalize()));
            }
        }
    }
    normals.sort_unstable_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)).then(a.z.total_cmp(&b.z)));
    normals.dedup_by(|a, b| (*a - *b).norm() < SAME_NORMAL);
    normals
}

/// Of a direction and its opposite, the one in the upper half space.
fn upper(n: &Vec3) -> Vec3 {
    if (n.z, n.y, n.x) < (0.0, 0.0, 0.0) { -n } else { *n }
}

/// The best few boxes found so far, each once, in the order of their volumes.
struct Best(Vec<Candidate>);

impl Best {
    fn smallest(&self) -> f64 {
        self.0.first().map_or(f64::INFINITY, |c| c.volume)
    }

    /// What a candidate must be smaller than to get in.
    fn bar(&self) -> f64 {
        if self.0.len() < REFINED { f64::INFINITY } else { self.0[REFINED - 1].volume.min(self.smallest() * SLACK) }
    }

    fn insert(&mut self, candidate: Candidate) {
        let place = self.0.partition_point(|c| c.volume <= candidate.volume * (1.0 + VOLUME_TIE));
        // A box is found again by way of each of its axes; equal volumes are taken for equal boxes.
        let known = place > 0 && self.0[place - 1].volume >= candidate.volume * (1.0 - VOLUME_TIE);
        if place < REFINED && !known {
            self.0.insert(place, candidate);
            self.0.truncate(REFINED);
        }
    }
}

/// Search in the frame of the hull's own moments: a rotated copy is searched in the same way.
fn posed_axes(hull: Hull) -> [Vec3; 3] {
    let pose = moments::pose(&hull.vertices, &hull.faces);
    let vertices = hull.vertices.iter().map(|v| pose.tr_mul(v)).collect();
    solid_axes(&Polyhedron::new(Hull { vertices, faces: hull.faces })).map(|axis| pose * axis)
}

fn solid_axes(hull: &Polyhedron) -> [Vec3; 3] {
    let mut work = Workspace::default();
    let mut rough_work = Workspace::default();
    let large = hull.vertices.len() > LARGE;
    let rough = Coarse::new(hull, COARSE_DIRECTIONS[usize::from(large)]);
    let mut best = Best(Vec::with_capacity(REFINED + 1));
    let mut evaluate = |normals: Vec<Vec3>, best: &mut Best| {
        let bound = |n: &Vec3| rough.as_ref().map_or(0.0, |c| c.quick_bound(n));
        let mut queue: Vec<(f64, Vec3)> = normals.iter().map(|n| (bound(n), *n)).collect();
        queue.sort_by(|a, b| a.0.total_cmp(&b.0));
        for (bound, normal) in queue {
            if bound >= best.bar() {
                break;
            }
            if rough.as_ref().is_some_and(|c| c.bound(&normal, &mut rough_work) >= best.bar()) {
                continue;
            }
            if let Some(candidate) = hull.best_about(&normal, &mut work) {
                best.insert(candidate);
            }
        }
    };
    // First one normal of every cell, then the others: of a large hull those in the neighbourhood of the best box's
    // axes, of any other hull all that the bounds leave.
    let normals = candidate_normals(hull);
    let thin = normals.len() > ALL_CANDIDATES;
    let mut taken = HashSet::new();
    let (first, mut rest): (Vec<Vec3>, Vec<Vec3>) =
        normals.into_iter().partition(|n| !thin || taken.insert(n.map(|c| (c / CELL).round() as i32)));
    evaluate(first, &mut best);
    if let Some(found) = best.0.first().copied() {
        if large {
            rest.retain(|n| found.axes.iter().any(|a| a.dot(n).abs() > 1.0 - NEAR * NEAR / 2.0));
        } else {
            // Turned as far as it goes, the best box rules out most of the rest.
            let mut turning = Workspace::default();
            best.insert(turn_freely(hull, turn_about_axes(hull, found, &mut turning), &mut turning));
        }
        evaluate(rest, &mut best);
    }
    let mut winner: Option<Candidate> = None;
    for candidate in best.0 {
        let turned = turn_freely(hull, turn_about_axes(hull, candidate, &mut work), &mut work);
        if winner.is_none_or(|w| turned.volume < w.volume * (1.0 - VOLUME_TIE)) {
            winner = Some(turned);
        }
    }
    winner.map_or([Vec3::x(), Vec3::y(), Vec3::z()], |w| w.axes)
}

/// Turn a box about one of its axes at a time, as long as it gets smaller.
fn turn_about_axes(hull: &Polyhedron, mut current: Candidate, work: &mut Workspace) -> Candidate {
    loop {
        let mut improved = current;
        for axis in current.axes {
            if let Some(found) = hull.best_about(&axis, work)
                && found.volume < improved.volume * (1.0 - SMALLER)
            {
                improved = found;
            }
        }
        if improved.volume >= current.volume {
            return current;
        }
        current = improved;
    }
}

/// Turn a box by rotation vectors with components in {-1, 0, 1} steps, at most two of them turning; the best of them
/// is taken, the step is shortened when none is better. The set is the same for every choice of the axes' signs and order.
fn turn_freely(hull: &Polyhedron, mut current: Candidate, work: &mut Workspace) -> Candidate {
    let mut step = STEPS.0;
    let mut moved = false;
    while step > STEPS.1 {
        let mut improved = current;
        for code in 0..27 {
            let parts = [code % 3, code / 3 % 3, code / 9].map(|c| f64::from(c) - 1.0);
            if !(1..=2).contains(&parts.iter().filter(|p| **p != 0.0).count()) {
                continue;
            }
            let [x, y, z] = parts.map(|p| p * step);
            let turn = current.axes[0] * x + current.axes[1] * y + current.axes[2] * z;
            let rotation = nalgebra::Rotation3::new(turn);
            let axes = current.axes.map(|a| rotation * a);
            let volume = hull.box_volume(&axes, work);
            if volume < improved.volume * (1.0 - SMALLER) {
                improved = Candidate { volume, axes };
            }
        }
        if improved.volume < current.volume {
            current = improved;
            moved = true;
        } else if std::mem::take(&mut moved) {
            current = turn_about_axes(hull, current, work);
        } else {
            step *= SHRINK;
        }
    }
    current
}
