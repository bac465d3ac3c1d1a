//! Oriented bounding box of minimal volume.
//!
//! The minimal box has two adjacent faces that each lie against an edge of the hull (O'Rourke 1985); usually one lies
//! against a face. Candidates are therefore every face's normal and the common normals of pairs of long edges, each
//! with the minimal rectangle about its axis. Lower bounds from a coarse inner polyhedron order the candidates and end
//! the search. The best of them are then turned, first about one axis at a time by calipers, then freely in shrinking
//! steps, which reaches the boxes that only touch edges.

use super::Vec3;
use super::affine::{any_normal, span};
use super::hull::hull_in;
use super::rectangle::{Vec2, minimal_rectangle, planar_hull};
use super::search::{Candidate, Coarse, Polyhedron, Workspace, extent};

/// Volumes within this share of each other are equal; the earlier candidate wins.
const VOLUME_TIE: f64 = 1e-12;

/// Normals whose cross product is shorter than this are one candidate.
const SAME_NORMAL: f64 = 1e-9;

/// The common normals of this many longest edges are candidates.
const LONG_EDGES: usize = 32;

/// How many of the best candidates are turned further.
const REFINED: usize = 6;

/// First and last step of the free turning, radians.
const STEPS: (f64, f64) = (0.2, 1e-8);

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
            center += axes[k] * ((low + high) / 2.0);
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
        3 if !hull.faces.is_empty() => solid_axes(Polyhedron::new(hull)),
        // A plane, or a solid so thin that quickhull gave up.
        _ => planar_axes(points, found.axes),
    };
    Boxed { bounds: OrientedBox::about(points, axes), corners, hull_volume, dimension: found.dimension }
}

fn planar_axes(points: &[Vec3], [u, v, normal]: [Vec3; 3]) -> [Vec3; 3] {
    let mut flat: Vec<Vec2> = points.iter().map(|p| Vec2::new(p.dot(&u), p.dot(&v))).collect();
    let mut polygon = Vec::new();
    planar_hull(&mut flat, &mut polygon);
    let side = minimal_rectangle(&polygon).map_or(Vec2::x(), |r| r.side);
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

fn solid_axes(hull: Polyhedron) -> [Vec3; 3] {
    let coarse = Coarse::new(&hull);
    let mut work = Workspace::default();
    let mut queue: Vec<(f64, Vec3)> =
        candidate_normals(&hull).into_iter().map(|n| (coarse.quick_bound(&n), n)).collect();
    queue.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut best: Vec<Candidate> = Vec::with_capacity(REFINED + 1);
    let mut smallest = f64::INFINITY;
    for (bound, normal) in queue {
        if bound >= smallest {
            break;
        }
        if coarse.bound(&normal, &mut work) >= smallest {
            continue;
        }
        let Some(candidate) = hull.best_about(&normal, &mut work) else { continue };
        smallest = smallest.min(candidate.volume);
        let place = best.partition_point(|c| c.volume <= candidate.volume * (1.0 + VOLUME_TIE));
        if place < REFINED {
            best.insert(place, candidate);
            best.truncate(REFINED);
        }
    }
    let mut winner: Option<Candidate> = None;
    for candidate in best {
        let turned = turn_freely(&hull, &coarse, turn_about_axes(&hull, candidate, &mut work), &mut work);
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
                && found.volume < improved.volume * (1.0 - 1e-10)
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

/// Turn a box by rotation vectors with components in {-1, 0, 1} steps; the best of them is taken, the step is halved
/// when none is better. The set is the same for every choice of the axes' signs and order.
fn turn_freely(hull: &Polyhedron, coarse: &Coarse, mut current: Candidate, work: &mut Workspace) -> Candidate {
    let mut step = STEPS.0;
    while step > STEPS.1 {
        let near = reachable(hull, &current.axes, step);
        let mut improved = current;
        for code in 0..27 {
            if code == 13 {
                continue;
            }
            let [x, y, z] = [code % 3, code / 3 % 3, code / 9].map(|c| (f64::from(c) - 1.0) * step);
            let turn = current.axes[0] * x + current.axes[1] * y + current.axes[2] * z;
            let rotation = nalgebra::Rotation3::new(turn);
            let axes = current.axes.map(|a| rotation * a);
            if step > 0.02 && coarse.box_bound(&axes) >= improved.volume {
                continue;
            }
            let volume = axes.iter().zip(&near).map(|(a, points)| extent(points, a)).product::<f64>();
            if volume < improved.volume * (1.0 - 1e-10) {
                improved = Candidate { volume, axes };
            }
        }
        if improved.volume < current.volume {
            current = turn_about_axes(hull, improved, work);
        } else {
            step /= 2.0;
        }
    }
    current
}

/// The corners that can come to touch each pair of box faces when the box turns by up to sqrt(3) `step` radians.
fn reachable(hull: &Polyhedron, axes: &[Vec3; 3], step: f64) -> [Vec<Vec3>; 3] {
    let size = extent(&hull.vertices, &axes[0]).hypot(extent(&hull.vertices, &axes[1])).hypot(extent(&hull.vertices, &axes[2]));
    let slack = 2.0 * 3.0f64.sqrt() * step * size;
    axes.map(|a| {
        let heights: Vec<f64> = hull.vertices.iter().map(|p| p.dot(&a)).collect();
        let low = heights.iter().copied().fold(f64::INFINITY, f64::min);
        let high = heights.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let touches = |h: f64| h <= low + slack || h >= high - slack;
        hull.vertices.iter().zip(&heights).filter(|(_, h)| touches(**h)).map(|(p, _)| *p).collect()
    })
}
