//! The polyhedron that the search for the minimal box walks on: neighbours across edges, silhouettes, lower bounds.

use super::Vec3;
use super::hull::{Hull, convex_hull};
use super::rectangle::{Vec2, minimal_rectangle, planar_hull};

/// Directions whose extreme points make the coarse polyhedron; 96 of them bound the volume to a few per cent from below.
const COARSE_DIRECTIONS: usize = 48;

/// A candidate: the volume of a box and its axes, right-handed.
#[derive(Debug, Clone, Copy)]
pub struct Candidate {
    /// Volume.
    pub volume: f64,
    /// Orthonormal axes.
    pub axes: [Vec3; 3],
}

/// A hull with everything the search asks for again and again.
pub struct Polyhedron {
    /// Corners.
    pub vertices: Vec<Vec3>,
    /// Triangles.
    pub faces: Vec<[u32; 3]>,
    /// Outward unit normals, those of slivers being zero.
    pub normals: Vec<Vec3>,
    /// Twice the area vectors, positive multiples of the normals.
    area_vectors: Vec<Vec3>,
    /// Across edge k (corner k to k + 1) of each face: the other face and its edge, 3 * face + edge.
    across: Vec<u32>,
    /// Whether every edge has exactly two faces; without it there is no silhouette to walk along.
    closed: bool,
}

/// Buffers that survive from one candidate to the next.
#[derive(Default)]
pub struct Workspace {
    outline: Vec<Vec2>,
    polygon: Vec<Vec2>,
}

/// Return how far `points` reach along a direction.
#[must_use]
pub fn extent(points: &[Vec3], direction: &Vec3) -> f64 {
    let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
    for p in points {
        let s = p.dot(direction);
        low = low.min(s);
        high = high.max(s);
    }
    high - low
}

/// Return two unit vectors that complete a unit `normal` to a right-handed frame (u, v, normal).
///
/// Duff et al. 2017, "Building an orthonormal basis, revisited".
#[must_use]
pub fn plane_axes(n: &Vec3) -> (Vec3, Vec3) {
    let sign = 1.0f64.copysign(n.z);
    let a = -1.0 / (sign + n.z);
    let b = n.x * n.y * a;
    (Vec3::new(1.0 + sign * n.x * n.x * a, sign * b, -sign * n.x), Vec3::new(b, sign + n.y * n.y * a, -n.y))
}

impl Polyhedron {
    /// Prepare a hull with faces.
    #[must_use]
    pub fn new(hull: Hull) -> Self {
        let Hull { vertices, faces } = hull;
        let area_vectors: Vec<Vec3> = faces
            .iter()
            .map(|f| {
                let [a, b, c] = f.map(|i| vertices[i as usize]);
                (b - a).cross(&(c - a))
            })
            .collect();
        let normals = area_vectors.iter().map(|a| a.try_normalize(1e-300).unwrap_or_default()).collect();
        let (across, closed) = neighbours(&faces);
        Self { vertices, faces, normals, area_vectors, across, closed }
    }

    /// Undirected edges as (corner, corner), each once.
    pub fn edges(&self) -> impl Iterator<Item = (usize, usize)> + '_ {
        self.faces.iter().flat_map(|f| (0..3).map(move |k| (f[k] as usize, f[(k + 1) % 3] as usize))).filter(|(a, b)| a < b)
    }

    /// Area of the shadow along a unit direction (Cauchy).
    #[must_use]
    pub fn shadow(&self, direction: &Vec3) -> f64 {
        self.area_vectors.iter().map(|a| a.dot(direction).abs()).sum::<f64>() / 4.0
    }

    /// The smallest box that has `normal` as an axis.
    pub fn best_about(&self, normal: &Vec3, work: &mut Workspace) -> Option<Candidate> {
        let (u, v) = plane_axes(normal);
        if !(self.closed && self.walk_silhouette(normal, &u, &v, work)) {
            work.outline.clear();
            work.outline.extend(self.vertices.iter().map(|p| Vec2::new(p.dot(&u), p.dot(&v))));
            planar_hull(&mut work.outline, &mut work.polygon);
        }
        let found = minimal_rectangle(&work.polygon)?;
        let x = u * found.side.x + v * found.side.y;
        Some(Candidate { volume: found.area * extent(&self.vertices, normal), axes: [x, normal.cross(&x), *normal] })
    }

    /// Project the closed loop between the faces that look along `normal` and those that do not.
    ///
    /// False when no single loop was found, which rounding at slivers can cause.
    fn walk_silhouette(&self, normal: &Vec3, u: &Vec3, v: &Vec3, work: &mut Workspace) -> bool {
        let seen = |face: usize| self.area_vectors[face].dot(normal) > 0.0;
        let Some(start) = self.silhouette_edge(normal) else { return false };
        work.outline.clear();
        let mut edge = start;
        // Every half-edge is passed at most once on a sound polyhedron.
        for _ in 0..self.across.len() {
            let corner = &self.vertices[self.faces[edge / 3][edge % 3] as usize];
            work.outline.push(Vec2::new(corner.dot(u), corner.dot(v)));
            // Turn about the edge's end, through the faces that are seen, to the next edge with an unseen face behind.
            edge = next_in_face(edge);
            let mut turns = 0;
            while seen(self.across[edge] as usize / 3) {
                edge = next_in_face(self.across[edge] as usize);
                turns += 1;
                if turns > self.faces.len() {
                    return false;
                }
            }
            if edge == start {
                return convex_loop(&mut work.outline, &mut work.polygon);
            }
        }
        false
    }

    /// A half-edge whose face is seen along `normal` while the face across is not.
    fn silhouette_edge(&self, normal: &Vec3) -> Option<usize> {
        // Go downhill on the normals from the face that is seen best of a few; gives up at flat spots.
        let score = |face: usize| self.normals[face].dot(normal);
        let stride = self.faces.len() / 8 + 1;
        let mut face = (0..self.faces.len()).step_by(stride).find(|&f| score(f) > 0.0).unwrap_or(0);
        let mut height = score(face);
        while height > 0.0 {
            let mut lowest = (height, None);
            for k in 0..3 {
                let other = self.across[3 * face + k] as usize / 3;
                let s = score(other);
                if s <= 0.0 && self.area_vectors[other].dot(normal) <= 0.0 {
                    return Some(3 * face + k);
                }
                if s < lowest.0 {
                    lowest = (s, Some(other));
                }
            }
            match lowest {
                (s, Some(other)) => (face, height) = (other, s),
                (_, None) => break,
            }
        }
        let seen: Vec<bool> = self.area_vectors.iter().map(|a| a.dot(normal) > 0.0).collect();
        (0..self.across.len()).find(|&e| seen[e / 3] && !seen[self.across[e] as usize / 3])
    }
}

fn next_in_face(edge: usize) -> usize {
    if edge % 3 == 2 { edge - 2 } else { edge + 1 }
}

/// Pair the half-edges of a triangle mesh.
fn neighbours(faces: &[[u32; 3]]) -> (Vec<u32>, bool) {
    let mut keyed: Vec<(u64, u32)> = faces
        .iter()
        .enumerate()
        .flat_map(|(f, c)| {
            (0..3).map(move |k| {
                let (a, b) = (u64::from(c[k]), u64::from(c[(k + 1) % 3]));
                ((a.min(b) << 32) | a.max(b), (3 * f + k) as u32)
            })
        })
        .collect();
    keyed.sort_unstable();
    let mut across = vec![0; keyed.len()];
    let mut closed = !faces.is_empty() && keyed.len() % 2 == 0;
    for pair in keyed.chunks_exact(2) {
        closed &= pair[0].0 == pair[1].0;
        across[pair[0].1 as usize] = pair[1].1;
        across[pair[1].1 as usize] = pair[0].1;
    }
    (across, closed)
}

/// Copy an almost convex counter-clockwise loop without the corners at which it fails to turn left.
fn convex_loop(outline: &mut [Vec2], polygon: &mut Vec<Vec2>) -> bool {
    polygon.clear();
    if outline.len() < 3 {
        return false;
    }
    let mut lowest = 0;
    for (i, p) in outline.iter().enumerate() {
        if p.x < outline[lowest].x || (p.x <= outline[lowest].x && p.y < outline[lowest].y) {
            lowest = i;
        }
    }
    outline.rotate_left(lowest);
    let turn = |o: &Vec2, a: &Vec2, b: &Vec2| (a - o).perp(&(b - o));
    for &p in outline.iter().chain(std::iter::once(&outline[0])) {
        while polygon.len() >= 2 && turn(&polygon[polygon.len() - 2], &polygon[polygon.len() - 1], &p) <= 0.0 {
            polygon.pop();
        }
        polygon.push(p);
    }
    polygon.pop();
    polygon.len() >= 3
}

/// A polyhedron inside the hull, with few corners: what it needs as a box, the hull needs at least.
pub struct Coarse {
    /// Its corners, corners of the hull too.
    pub points: Vec<Vec3>,
    shape: Option<Polyhedron>,
}

impl Coarse {
    /// Take the extreme points of a hull along directions spread evenly over the sphere.
    #[must_use]
    pub fn new(hull: &Polyhedron) -> Self {
        if hull.vertices.len() <= 2 * COARSE_DIRECTIONS {
            return Self { points: hull.vertices.clone(), shape: None };
        }
        let golden = std::f64::consts::PI * (3.0 - 5.0f64.sqrt());
        let mut chosen = Vec::with_capacity(2 * COARSE_DIRECTIONS);
        for i in 0..COARSE_DIRECTIONS {
            let z = 1.0 - (i as f64 + 0.5) / COARSE_DIRECTIONS as f64;
            let (s, c) = (golden * i as f64).sin_cos();
            let r = (1.0 - z * z).sqrt();
            let d = Vec3::new(r * c, r * s, z);
            let (mut low, mut high) = ((f64::INFINITY, 0), (f64::NEG_INFINITY, 0));
            for (k, p) in hull.vertices.iter().enumerate() {
                let t = p.dot(&d);
                low = if t < low.0 { (t, k) } else { low };
                high = if t > high.0 { (t, k) } else { high };
            }
            chosen.extend([low.1, high.1]);
        }
        chosen.sort_unstable();
        chosen.dedup();
        let points: Vec<Vec3> = chosen.iter().map(|&k| hull.vertices[k]).collect();
        let inner = convex_hull(&points);
        let shape = (!inner.faces.is_empty()).then(|| Polyhedron::new(inner));
        Self { points, shape }
    }

    /// A number that no box about the hull with `normal` as an axis is smaller than: height times shadow.
    #[must_use]
    pub fn quick_bound(&self, normal: &Vec3) -> f64 {
        self.shape.as_ref().map_or(0.0, |s| s.shadow(normal) * extent(&self.points, normal))
    }

    /// Like [`Self::quick_bound`], closer: height times the smallest rectangle.
    pub fn bound(&self, normal: &Vec3, work: &mut Workspace) -> f64 {
        let Some(shape) = &self.shape else { return 0.0 };
        shape.best_about(normal, work).map_or(0.0, |c| c.volume)
    }

    /// A number that the box with these axes is not smaller than.
    #[must_use]
    pub fn box_bound(&self, axes: &[Vec3; 3]) -> f64 {
        axes.iter().map(|a| extent(&self.points, a)).product()
    }
}
