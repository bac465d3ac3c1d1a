//! Axes of the minimal box about a solid.
//!
//! The minimal box has two adjacent faces that each lie against an edge of the hull (O'Rourke 1985); usually one lies
//! against a face. Starts are therefore face normals and the common normals of pairs of long edges, each with the minimal
//! rectangle about its axis, of the polyhedron between a few hundred extreme points: what it needs as a box, the hull
//! needs at least. The best of them are turned, then turned again among all points that can touch the box's sides. At last
//! every face of the whole hull is tried, so that no box flush with one is smaller.

use nalgebra::Matrix3;

use super::Vec3;
use super::corners::{Corners, spread_directions};
use super::flush::flush_box;
use super::hull::{Hull, convex_hull};
use super::moments::principal;
use super::search::{Candidate, Polyhedron, Workspace};
use super::turn::turned;

/// Volumes within this share of each other are equal; the earlier candidate wins.
const VOLUME_TIE: f64 = 1e-12;

/// Boxes whose axes all have cosines larger than this with each other's are one candidate.
const ALIKE: f64 = 0.9995;

/// Normals whose cross product is shorter than this are one candidate.
pub const SAME_NORMAL: f64 = 1e-9;

/// The common normals of this many longest edges are candidates.
const LONG_EDGES: usize = 16;

/// How many of the best candidates are turned to the nearest minimum.
const STARTS: usize = 8;

/// Boxes larger than the smallest by more than this after rough turning are given up.
const GIVEN_UP: f64 = 1.05;

/// Candidates larger than the smallest by more than this do not become it by turning: measured.
const SLACK: f64 = 1.1;

/// Directions whose extreme points make the polyhedron that bounds volumes to a few per cent from below.
const ROUGH_DIRECTIONS: usize = 24;

/// The same for the polyhedron whose boxes are sought first.
const INNER_DIRECTIONS: usize = 128;

/// Steps of the free turning, radians: the first, the last while there are many boxes to turn, the last.
const STEP: f64 = 0.2;
const ROUGH_STEP: f64 = 0.01;
const LAST_STEP: f64 = 1e-4;

/// Tilts of a box's axes, radians, for which the points that touch it are looked at together, in so many ways each:
/// around a box that will be turned, and around one that points were overlooked by.
const WIDE: [f64; 2] = [0.01, 0.05];
const CLOSE: [f64; 1] = [1e-3];
const WAYS: usize = 8;

/// Boxes get smaller by hardly more than this share once they have been turned roughly.
const ROUGHLY: f64 = 2e-3;

/// How often points that were overlooked are added and the box is turned again.
const ROUNDS: usize = 10;

/// A box that all points need larger by no more than this share overlooked none.
const WHOLE: f64 = 1e-9;

/// Skewness below this share of the deviation's cube does not choose a direction.
const SKEW_FLOOR: f64 = 1e-9;

/// Find the axes of the minimal box about a hull with faces; None where rounding leaves no solid of its extreme points.
///
/// The search is done in the frame of the corners' own moments: a rotated copy is searched in the same way.
#[must_use]
pub fn solid_axes(hull: &Hull) -> Option<[Vec3; 3]> {
    let pose = pose(&hull.vertices);
    let points: Vec<Vec3> = hull.vertices.iter().map(|p| pose.tr_mul(p)).collect();
    let inner = between_extremes(&points, INNER_DIRECTIONS)?;
    let rough = (inner.vertices.len() > 3 * ROUGH_DIRECTIONS)
        .then(|| between_extremes(&inner.vertices, ROUGH_DIRECTIONS))
        .flatten();
    let mut work = Workspace::default();
    let starts = starts(&inner, rough.as_ref(), &mut work);
    let near = roughly_turned(&inner, starts, &mut work);
    let whole = Corners::new(&points);
    let mut found = finished(&points, &whole, *near.first()?, f64::INFINITY, &mut work);
    for start in &near[1..] {
        // What the inner polyhedron's box needs, the box needs at least, but for what it still gets smaller by turning.
        if start.volume < found.volume * (1.0 + ROUGHLY) {
            let other = finished(&points, &whole, *start, found.volume, &mut work);
            found = if other.volume < found.volume { other } else { found };
        }
    }
    let insides: Vec<&Polyhedron> = rough.iter().chain([&inner]).collect();
    let whole_hull = Polyhedron::new(Hull { vertices: points, faces: hull.faces.clone() });
    if let Some(flush) = flush_box(&whole_hull, &insides, found.volume, &mut work) {
        found = finished(&whole_hull.vertices, &whole_hull.corners, flush, f64::INFINITY, &mut work);
    }
    Some(found.axes.map(|axis| pose * axis))
}

/// Principal axes of points as a rotation; the first two point to the side the points' skewness lies on.
fn pose(points: &[Vec3]) -> Matrix3<f64> {
    let share = 1.0 / points.len() as f64;
    let mean = points.iter().sum::<Vec3>() * share;
    let mut spread = Matrix3::zeros();
    for p in points {
        let d = p - mean;
        spread += d * d.transpose();
    }
    let (axes, variances) = principal(&(spread * share));
    let [x, y] = [0, 1].map(|k| {
        let axis = axes.column(k).into_owned();
        let skew = points.iter().map(|p| (p - mean).dot(&axis).powi(3)).sum::<f64>() * share;
        if skew < -SKEW_FLOOR * variances[k].powf(1.5) { -axis } else { axis }
    });
    Matrix3::from_columns(&[x, y, x.cross(&y)])
}

/// The polyhedron between the extreme points along some directions.
fn between_extremes(points: &[Vec3], directions: usize) -> Option<Polyhedron> {
    let chosen: Vec<Vec3> = if points.len() <= 2 * directions {
        points.to_vec()
    } else {
        let corners = Corners::new(points);
        let mut chosen: Vec<usize> = spread_directions(directions).flat_map(|d| corners.ends(&d)).collect();
        chosen.sort_unstable();
        chosen.dedup();
        chosen.into_iter().map(|k| points[k]).collect()
    };
    let hull = convex_hull(&chosen);
    (!hull.faces.is_empty()).then(|| Polyhedron::new(hull))
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
#[must_use]
pub fn face_normals(hull: &Polyhedron) -> Vec<Vec3> {
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
        // Candidates a few degrees apart turn to the same minimum: the smallest of them stands for all.
        let alike = |c: &Candidate| candidate.axes.iter().all(|a| c.axes.iter().any(|b| a.dot(b).abs() > ALIKE));
        if self.found.iter().any(|c| alike(c) && c.volume <= candidate.volume * (1.0 + VOLUME_TIE)) {
            return;
        }
        self.found.retain(|c| !alike(c));
        let place = self.found.partition_point(|c| c.volume <= candidate.volume * (1.0 + VOLUME_TIE));
        self.found.insert(place, candidate);
        self.found.truncate(self.capacity);
    }
}

/// The boxes that are near the smallest once all have been turned roughly, each once.
fn roughly_turned(hull: &Polyhedron, starts: Best, work: &mut Workspace) -> Vec<Candidate> {
    let mut best = Best { found: Vec::with_capacity(STARTS + 1), capacity: STARTS };
    for start in starts.found {
        best.insert(turned(hull, start, (STEP, ROUGH_STEP), work));
    }
    let bar = best.smallest() * GIVEN_UP;
    best.found.retain(|c| c.volume <= bar);
    best.found
}

/// The best boxes about the candidate normals.
fn starts(hull: &Polyhedron, rough: Option<&Polyhedron>, work: &mut Workspace) -> Best {
    let mut best = Best { found: Vec::with_capacity(STARTS + 1), capacity: STARTS };
    let bounding = rough.unwrap_or(hull);
    let mut queue: Vec<(f64, Vec3)> =
        candidate_normals(hull).into_iter().map(|n| (bounding.least_volume(&n), n)).collect();
    queue.sort_by(|a, b| a.0.total_cmp(&b.0));
    for (bound, normal) in queue {
        if bound >= best.bar() {
            break;
        }
        if rough.is_some_and(|r| r.best_about(&normal, work).is_some_and(|c| c.volume >= best.bar())) {
            continue;
        }
        if let Some(candidate) = hull.best_about(&normal, work) {
            best.insert(candidate);
        }
    }
    best
}

/// Turn a box among the points that can touch its sides, until all others lie inside.
///
/// Given up as soon as it will not become smaller than `bar`.
fn finished(points: &[Vec3], whole: &Corners, start: Candidate, bar: f64, work: &mut Workspace) -> Candidate {
    let mut best = Candidate { volume: whole.volume(&start.axes), ..start };
    let mut chosen = Vec::new();
    touching(whole, &best.axes, &WIDE, &mut chosen);
    for _ in 0..ROUNDS {
        let local: Vec<Vec3> = chosen.iter().map(|&k| points[k]).collect();
        let polyhedron = Polyhedron::new(convex_hull(&local));
        let turned = turned(&polyhedron, best, (2.0 * ROUGH_STEP, LAST_STEP), work);
        let volume = whole.volume(&turned.axes);
        if volume < best.volume {
            best = Candidate { volume, ..turned };
        }
        if volume <= turned.volume * (1.0 + WHOLE) || turned.volume >= bar * (1.0 - WHOLE) {
            break;
        }
        touching(whole, &turned.axes, &CLOSE, &mut chosen);
    }
    best
}

/// Add the points that touch a box or would do so if its axes were tilted.
fn touching(whole: &Corners, axes: &[Vec3; 3], tilts: &[f64], chosen: &mut Vec<usize>) {
    for k in 0..3 {
        chosen.extend(whole.ends(&axes[k]));
        for tilt in tilts {
            for i in 0..WAYS {
                let (s, c) = (std::f64::consts::TAU * i as f64 / WAYS as f64).sin_cos();
                chosen.extend(whole.ends(&(axes[k] + (axes[(k + 1) % 3] * c + axes[(k + 2) % 3] * s) * *tilt)));
            }
        }
    }
    chosen.sort_unstable();
    chosen.dedup();
}
