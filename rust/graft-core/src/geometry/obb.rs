//! Oriented bounding box of minimal volume.
//!
//! The minimal box has two adjacent faces that each lie against an edge of the hull (O'Rourke 1985); usually one lies
//! against a face. Starts are therefore face normals and the common normals of pairs of long edges, each with the minimal
//! rectangle about its axis; lower bounds from a coarse inner polyhedron order them. The best of them are turned: about one
//! axis at a time by calipers, freely in shrinking steps, and along the ridges on which edges stay flush with the box. At
//! last every face normal (near the box's axes, for hulls of many corners) that the bounds leave is tried. The boxes of
//! 533 parts and point sets were never larger than the best of those over all face normals.

use std::collections::HashSet;

use super::Vec3;
use super::affine::{Span, any_normal, span};
use super::hull::{Hull, hull_in};
use super::moments;
use super::rectangle::{Vec2, minimal_rectangle, planar_hull};
use super::search::{Candidate, Coarse, Polyhedron, Workspace, extent};

/// Volumes within this share of each other are equal; the earlier candidate wins.
const VOLUME_TIE: f64 = 1e-12;

/// Normals whose cross product is shorter than this are one candidate.
const SAME_NORMAL: f64 = 1e-9;

/// The common normals of this many longest edges are candidates.
const LONG_EDGES: usize = 16;

/// How many of the best candidates are turned to the nearest minimum.
const STARTS: usize = 6;

/// Boxes larger than the smallest by more than this after rough turning are given up.
const GIVEN_UP: f64 = 1.02;

/// Candidates larger than the smallest by more than this do not become it by turning: measured.
const SLACK: f64 = 1.1;

/// A turn counts when it makes the box smaller by more than this share; less is rounding.
const SMALLER: f64 = 1e-10;

/// Directions whose extreme points make the polyhedron that bounds volumes to a few per cent from below.
const ROUGH_DIRECTIONS: usize = 32;

/// The same for the polyhedron whose boxes are sought first in place of those of a large hull, of more corners than this.
const INNER_DIRECTIONS: usize = 128;
const LARGE: usize = 400;

/// Up to this many candidates are all tried; of more, one in every cell first.
const ALL_CANDIDATES: usize = 400;

/// Size of a cell of directions, radians. The free turning reaches farther.
const CELL: f64 = 0.1;

/// Around the axes of the best box, all face normals of a large hull within this many radians are tried.
const NEAR: f64 = 0.03;

/// Steps of the free turning, radians: the first, the last while there are many boxes to turn, the last.
const STEP: f64 = 0.2;
const ROUGH_STEP: f64 = 0.01;
const LAST_STEP: f64 = 1e-4;

/// Edges within this many steps of being flush with the box are brought there, the nearest of them.
const KINK_REACH: f64 = 3.0;
const KINKS: usize = 5;

/// Sines below this belong to parallel kinks.
const PARALLEL: f64 = 1e-3;

/// What a step that finds nothing is shortened by.
const SHRINK: f64 = 0.1;

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

/// Find the minimal box about non-empty `points`.
///
/// Points on a plane get the plane's normal and their minimal rectangle, points on a line that line, coinciding
/// points the frame of the coordinates.
#[must_use]
pub fn minimal_box(points: &[Vec3]) -> OrientedBox {
    let found = span(points);
    minimal_box_of(&hull_in(points, &found), &found)
}

/// Like [`minimal_box`], for a caller that has the hull of the points and their span.
#[must_use]
pub fn minimal_box_of(hull: &Hull, found: &Span) -> OrientedBox {
    let axes = match found.dimension {
        0 => [Vec3::x(), Vec3::y(), Vec3::z()],
        1 => {
            let y = any_normal(&found.axes[0]);
            [found.axes[0], y, found.axes[0].cross(&y)]
        }
        3 if !hull.faces.is_empty() => posed_axes(hull),
        // A plane, or a solid so thin that quickhull gave up.
        _ => planar_axes(&hull.vertices, found.axes),
    };
    OrientedBox::about(&hull.vertices, axes)
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
    let mut normals = face_normals(hull);
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

/// The normals of the faces, up to their signs.
fn face_normals(hull: &Polyhedron) -> Vec<Vec3> {
    hull.normals.iter().filter(|n| n.norm_squared() > 0.5).map(upper).collect()
}

/// Of a direction and its opposite, the one in the upper half space.
fn upper(n: &Vec3) -> Vec3 {
    if (n.z, n.y, n.x) < (0.0, 0.0, 0.0) { -n } else { *n }
}

/// The best few boxes found so far, each once, in the order of their volumes.
struct Best {
    found: Vec<Candidate>,
    capacity: usize,
}

impl Best {
    fn smallest(&self) -> f64 {
        self.found.first().map_or(f64::INFINITY, |c| c.volume)
    }

    /// What a candidate must be smaller than to get in.
    fn bar(&self) -> f64 {
        if self.found.len() < self.capacity { f64::INFINITY } else { self.found[self.capacity - 1].volume }
            .min(self.smallest() * SLACK)
    }

    fn insert(&mut self, candidate: Candidate) {
        let place = self.found.partition_point(|c| c.volume <= candidate.volume * (1.0 + VOLUME_TIE));
        // A box is found again by way of each of its axes; equal volumes are taken for equal boxes.
        let known = place > 0 && self.found[place - 1].volume >= candidate.volume * (1.0 - VOLUME_TIE);
        if place < self.capacity && !known {
            self.found.insert(place, candidate);
            self.found.truncate(self.capacity);
        }
    }
}

/// Search in the frame of the hull's own moments: a rotated copy is searched in the same way.
fn posed_axes(hull: &Hull) -> [Vec3; 3] {
    let pose = moments::pose(&hull.vertices, &hull.faces);
    let vertices = hull.vertices.iter().map(|v| pose.tr_mul(v)).collect();
    let posed = Polyhedron::new(Hull { vertices, faces: hull.faces.clone() });
    solid_axes(&posed).map_or([Vec3::x(), Vec3::y(), Vec3::z()], |w| w.axes).map(|axis| pose * axis)
}

fn solid_axes(hull: &Polyhedron) -> Option<Candidate> {
    let mut work = Workspace::default();
    let inner = if hull.vertices.len() > LARGE { Coarse::new(hull, INNER_DIRECTIONS) } else { None };
    let mut best = Best { found: Vec::new(), capacity: STARTS };
    let Some(inner) = inner else {
        let rough = Coarse::new(hull, ROUGH_DIRECTIONS);
        let (starts, rest) = starts(hull, rough.as_ref());
        for start in roughly_turned(hull, starts, &mut work) {
            best.insert(turned(hull, start, ROUGH_STEP, LAST_STEP, &mut work));
        }
        descend(hull, rough.as_ref(), rest, &mut best);
        return smallest(hull, &best);
    };
    // The inner polyhedron's boxes are near the hull's.
    let rough = Coarse::new(inner.shape(), ROUGH_DIRECTIONS);
    let (starts, _) = starts(inner.shape(), rough.as_ref());
    let near = roughly_turned(inner.shape(), starts, &mut work);
    work = Workspace::default();
    for start in near {
        let volume = hull.box_volume(&start.axes, &mut work);
        best.insert(turned(hull, Candidate { volume, ..start }, 2.0 * ROUGH_STEP, LAST_STEP, &mut work));
    }
    let found = *best.found.first()?;
    let mut faces = face_normals(hull);
    faces.retain(|n| found.axes.iter().any(|a| a.dot(n).abs() > 1.0 - NEAR * NEAR / 2.0));
    descend(hull, Some(&inner), faces, &mut best);
    smallest(hull, &best)
}

/// The smallest box once all corners have been looked at: on sides that are flat but for rounding, walking uphill can end
/// before the top and make a box look smaller than it is.
fn smallest(hull: &Polyhedron, best: &Best) -> Option<Candidate> {
    let whole = |c: &Candidate| c.axes.iter().map(|axis| extent(&hull.vertices, axis)).product::<f64>();
    best.found.iter().copied().min_by(|a, b| whole(a).total_cmp(&whole(b)))
}

/// The boxes that are near the smallest once all have been turned roughly, each once.
fn roughly_turned(hull: &Polyhedron, starts: Best, work: &mut Workspace) -> Vec<Candidate> {
    let mut best = Best { found: Vec::with_capacity(STARTS + 1), capacity: STARTS };
    for start in starts.found {
        best.insert(turned(hull, start, STEP, ROUGH_STEP, work));
    }
    let bar = best.smallest() * GIVEN_UP;
    best.found.retain(|c| c.volume <= bar);
    best.found
}

/// The best boxes about one candidate normal of every cell of directions, and the candidates that were not tried.
fn starts(hull: &Polyhedron, rough: Option<&Coarse>) -> (Best, Vec<Vec3>) {
    let normals = candidate_normals(hull);
    let thin = normals.len() > ALL_CANDIDATES;
    let mut taken = HashSet::new();
    let (first, rest): (Vec<Vec3>, Vec<Vec3>) =
        normals.into_iter().partition(|n| !thin || taken.insert(n.map(|c| (c / CELL).round() as i32)));
    let mut best = Best { found: Vec::with_capacity(STARTS + 1), capacity: STARTS };
    let (mut work, mut rough_work) = (Workspace::default(), Workspace::default());
    for (bound, normal) in queue(rough, first) {
        if bound >= best.bar() {
            break;
        }
        if rough.is_some_and(|c| c.bound(&normal, &mut rough_work) >= best.bar()) {
            continue;
        }
        if let Some(candidate) = hull.best_about(&normal, &mut work) {
            best.insert(candidate);
        }
    }
    (best, rest)
}

/// Try all normals that can still give a smaller box; turn each box that is.
fn descend(hull: &Polyhedron, rough: Option<&Coarse>, normals: Vec<Vec3>, best: &mut Best) {
    let (mut work, mut rough_work) = (Workspace::default(), Workspace::default());
    for (bound, normal) in queue(rough, normals) {
        let bar = best.smallest() * (1.0 - SMALLER);
        if bound >= bar {
            break;
        }
        if rough.is_some_and(|c| c.bound(&normal, &mut rough_work) >= bar) {
            continue;
        }
        if let Some(candidate) = hull.best_about(&normal, &mut work)
            && candidate.volume < bar
        {
            best.insert(turned(hull, candidate, ROUGH_STEP, LAST_STEP, &mut work));
        }
    }
}

/// Order normals by a lower bound of their boxes' volumes.
fn queue(rough: Option<&Coarse>, normals: Vec<Vec3>) -> Vec<(f64, Vec3)> {
    let mut queue: Vec<(f64, Vec3)> =
        normals.into_iter().map(|n| (rough.map_or(0.0, |c| c.quick_bound(&n)), n)).collect();
    queue.sort_by(|a, b| a.0.total_cmp(&b.0));
    queue
}

/// Turn a box to the nearest local minimum, to within `last` radians.
fn turned(hull: &Polyhedron, start: Candidate, first: f64, last: f64, work: &mut Workspace) -> Candidate {
    turn_freely(hull, turn_about_axes(hull, start, work), (first, last), work)
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

/// Turn a box by rotation vectors with components in {-1, 0, 1} steps, at most two of them turning, and along the
/// ridges of the volume; the best of them is taken, the step is shortened when none is better.
fn turn_freely(
    hull: &Polyhedron,
    mut current: Candidate,
    (first, last): (f64, f64),
    work: &mut Workspace,
) -> Candidate {
    let mut step = first;
    let mut moved = false;
    while step > last {
        let mut improved = current;
        let mut attempt = |turn: Vec3, work: &mut Workspace| {
            let rotation = nalgebra::Rotation3::new(turn);
            let axes = current.axes.map(|a| rotation * a);
            let volume = hull.box_volume(&axes, work);
            if volume < improved.volume * (1.0 - SMALLER) {
                improved = Candidate { volume, axes };
            }
        };
        for code in 0..27 {
            let parts = [code % 3, code / 3 % 3, code / 9].map(|c| f64::from(c) - 1.0);
            if (1..=2).contains(&parts.iter().filter(|p| **p != 0.0).count()) {
                let [x, y, z] = parts.map(|p| p * step);
                attempt(current.axes[0] * x + current.axes[1] * y + current.axes[2] * z, work);
            }
        }
        for turn in ridges(hull, &current, step, work) {
            attempt(turn, work);
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

/// Rotation vectors that bring two or three edges of the hull flush with the box, and on along the ridge.
///
/// The volume has a kink where an edge e lies in a box face with normal n, and its minima lie where kinks meet. A small
/// turn w makes the edge flush when w . (n x e) = -n . e.
fn ridges(hull: &Polyhedron, current: &Candidate, step: f64, work: &mut Workspace) -> Vec<Vec3> {
    hull.box_volume(&current.axes, work);
    let mut kinks: Vec<(f64, Vec3)> = Vec::new();
    for (foot, k) in work.feet().into_iter().zip([0, 0, 1, 1, 2, 2]) {
        let normal = current.axes[k];
        for edge in hull.edges_at(foot) {
            let edge = edge.normalize();
            let rise = normal.dot(&edge);
            if rise.abs() < KINK_REACH * step {
                kinks.push((-rise, normal.cross(&edge)));
            }
        }
    }
    kinks.sort_by(|a, b| a.0.abs().total_cmp(&b.0.abs()));
    kinks.truncate(KINKS);
    let mut turns = Vec::new();
    for (i, (rise, row)) in kinks.iter().enumerate() {
        for (j, (other_rise, other)) in kinks[..i].iter().enumerate() {
            let along = row.cross(other);
            let square = along.norm_squared();
            if square < PARALLEL * PARALLEL {
                continue;
            }
            // The shortest turn that makes both flush (Cramer's rule with `along` as the third row).
            let both = (other.cross(&along) * *rise + along.cross(row) * *other_rise) / square;
            let onward = along * (step / square.sqrt());
            turns.extend([both, both + onward, both - onward]);
            for (third_rise, third) in &kinks[..j] {
                let slope = along.dot(third);
                if slope.abs() > PARALLEL {
                    let meet = both + along * ((third_rise - both.dot(third)) / slope);
                    turns.push(meet);
                }
            }
        }
    }
    turns.retain(|turn| turn.norm() < 2.0 * KINK_REACH * step);
    turns
}
