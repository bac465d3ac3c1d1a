//! The polyhedron that the search for the minimal box walks on: neighbours across edges, silhouettes, lower bounds.

use super::Vec3;
use super::corners::Corners;
use super::hull::{Hull, neighbours};
use super::rectangle::{Vec2, minimal_rectangle, planar_hull};

/// A face is seen when its normal leans towards the viewer by more than this; faces on edge count as unseen together,
/// rather than each as its rounding errors have it.
const SEEN: f64 = 1e-9;

/// A silhouette that misses an extreme corner by more than this share of the extent went around the wrong loop.
const LOOP_TOLERANCE: f64 = 1e-6;

/// A face lower than this share of its longest side has a normal made of rounding errors.
const SLIVER: f64 = 1e-7;

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
    /// The same, by coordinate.
    pub corners: Corners,
    /// Triangles.
    pub faces: Vec<[u32; 3]>,
    /// Outward unit normals; slivers have that of the face along their longest side.
    pub normals: Vec<Vec3>,
    /// Face areas.
    areas: Vec<f64>,
    /// Corner k's neighbours are `ring[ring_start[k]..ring_start[k + 1]]`, each a corner and the half-edge that leads to it.
    ring: Vec<(u32, u32)>,
    ring_start: Vec<u32>,
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
        let mut normals: Vec<Vec3> = area_vectors.iter().map(|a| a.try_normalize(1e-300).unwrap_or_default()).collect();
        let areas = area_vectors.iter().map(|a| a.norm() / 2.0).collect();
        let (across, closed) = neighbours(&faces);
        if closed {
            let sides =
                |f: usize| [0, 1, 2].map(|k| vertices[faces[f][(k + 1) % 3] as usize] - vertices[faces[f][k] as usize]);
            let longest = |f: usize| {
                let sides = sides(f).map(|s| s.norm_squared());
                (0..3).fold(0, |l, k| if sides[k] > sides[l] { k } else { l })
            };
            let sliver = |f: usize| area_vectors[f].norm() < SLIVER * sides(f)[longest(f)].norm_squared();
            for f in (0..faces.len()).filter(|&f| sliver(f)) {
                let mut wide = f;
                // Slivers may lie side by side; a ring of nothing else is not a solid.
                for _ in 0..faces.len() {
                    wide = across[3 * wide + longest(wide)] as usize / 3;
                    if !sliver(wide) {
                        normals[f] = normals[wide];
                        break;
                    }
                }
            }
        }
        let (ring, ring_start) = rings(&faces, vertices.len());
        let corners = Corners::new(&vertices);
        Self { vertices, corners, faces, normals, areas, ring, ring_start, across, closed }
    }

    /// Undirected edges as (corner, corner), each once.
    pub fn edges(&self) -> impl Iterator<Item = (usize, usize)> + '_ {
        self.faces
            .iter()
            .flat_map(|f| (0..3).map(move |k| (f[k] as usize, f[(k + 1) % 3] as usize)))
            .filter(|(a, b)| a < b)
    }

    /// Area of the shadow along a unit direction (Cauchy).
    #[must_use]
    fn shadow(&self, direction: &Vec3) -> f64 {
        self.normals.iter().zip(&self.areas).map(|(n, a)| a * n.dot(direction).abs()).sum::<f64>() / 2.0
    }

    /// A volume that no box with a unit vector `normal` as an axis is smaller than: height times shadow.
    #[must_use]
    pub fn least_volume(&self, normal: &Vec3) -> f64 {
        self.shadow(normal) * self.corners.extent(normal)
    }

    fn ring_of(&self, corner: usize) -> &[(u32, u32)] {
        &self.ring[self.ring_start[corner] as usize..self.ring_start[corner + 1] as usize]
    }

    /// The edges that start at a corner.
    pub fn edges_at(&self, corner: usize) -> impl Iterator<Item = Vec3> + '_ {
        self.ring_of(corner).iter().map(move |&(other, _)| self.vertices[other as usize] - self.vertices[corner])
    }

    /// The smallest box that has `normal` as an axis.
    pub fn best_about(&self, normal: &Vec3, work: &mut Workspace) -> Option<Candidate> {
        // An axis that is found from an axis, again and again, would drift away from unit length.
        let normal = &normal.normalize();
        let (u, v) = plane_axes(normal);
        let height = self.corners.extent(normal);
        if !(self.closed && self.walk_silhouette(normal, [&u, &v], work)) {
            work.outline.clear();
            work.outline.extend(self.vertices.iter().map(|p| Vec2::new(p.dot(&u), p.dot(&v))));
            planar_hull(&mut work.outline, &mut work.polygon);
        }
        let found = minimal_rectangle(&mut work.polygon)?;
        let x = u * found.side.x + v * found.side.y;
        let axes = [x, normal.cross(&x), *normal];
        // Where rounding led the calipers astray, their rectangle is too small; what the box needs decides.
        let volume = (found.area * height).max(self.corners.volume(&axes));
        Some(Candidate { volume, axes })
    }

    /// Project the closed loop between the faces that look along `normal` and those that do not.
    ///
    /// False when the loop through the extreme corner was not found or is not the outline.
    fn walk_silhouette(&self, normal: &Vec3, [u, v]: [&Vec3; 2], work: &mut Workspace) -> bool {
        let reach = [u, v].map(|direction| self.corners.reach(direction));
        let seen = |edge: usize| self.normals[edge / 3].dot(normal) > SEEN;
        let across = |edge: usize| self.across[edge] as usize;
        let right = self.corners.at(u, reach[0].1);
        let leaving = |&(_, edge): &(u32, u32)| seen(edge as usize) && !seen(across(edge as usize));
        let Some(&(_, start)) = self.ring_of(right).iter().find(|e| leaving(e)) else { return false };
        let start = start as usize;
        work.outline.clear();
        let mut edge = start;
        // Every half-edge is passed at most once on a sound polyhedron.
        for _ in 0..self.across.len() {
            let corner = &self.vertices[self.faces[edge / 3][edge % 3] as usize];
            work.outline.push(Vec2::new(corner.dot(u), corner.dot(v)));
            // Turn about the edge's end, through the faces that are seen, to the next edge with an unseen face behind.
            edge = next_in_face(edge);
            let mut turns = 0;
            while seen(across(edge)) {
                edge = next_in_face(across(edge));
                turns += 1;
                if turns > self.faces.len() {
                    return false;
                }
            }
            if edge == start {
                let whole = [0, 1].iter().all(|&k| {
                    let along = work.outline.iter().map(|p| p[k]);
                    let (low, high) = along.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), x| (l.min(x), h.max(x)));
                    high - low >= (reach[k].1 - reach[k].0) * (1.0 - LOOP_TOLERANCE)
                });
                return whole && convex_loop(&mut work.outline, &mut work.polygon);
            }
        }
        false
    }
}

/// List each corner's neighbours with the half-edges that lead to them.
fn rings(faces: &[[u32; 3]], corners: usize) -> (Vec<(u32, u32)>, Vec<u32>) {
    let mut start = vec![0u32; corners + 1];
    for i in faces.iter().flatten() {
        start[*i as usize + 1] += 1;
    }
    for k in 0..corners {
        start[k + 1] += start[k];
    }
    let mut next = start.clone();
    let mut ring = vec![(0, 0); 3 * faces.len()];
    for (f, face) in faces.iter().enumerate() {
        for k in 0..3 {
            let slot = &mut next[face[k] as usize];
            ring[*slot as usize] = (face[(k + 1) % 3], (3 * f + k) as u32);
            *slot += 1;
        }
    }
    (ring, start)
}

fn next_in_face(edge: usize) -> usize {
    if edge % 3 == 2 { edge - 2 } else { edge + 1 }
}

/// Copy an almost convex counter-clockwise loop without the corners at which it fails to turn left.
///
/// A loop that turns back on itself, as around slivers, has its hull taken instead.
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
    // A chain that turns left everywhere is convex if it goes right once and then left once.
    let rightmost = polygon.iter().enumerate().fold(0, |r, (i, p)| if p.x > polygon[r].x { i } else { r });
    let convex =
        polygon[..=rightmost].is_sorted_by(|a, b| a.x <= b.x) && polygon[rightmost..].is_sorted_by(|a, b| a.x >= b.x);
    if !convex {
        planar_hull(outline, polygon);
    }
    polygon.len() >= 3
}
