//! A mesh or a point cloud as a graph of small elements: faces that share an edge, or points that are neighbours.

use std::collections::{BinaryHeap, HashMap};

use super::Vec3;
use super::merge::Reach;

/// Corners closer than this share of the diagonal are one: single precision keeps no finer distance.
const WELD: f64 = 1e-6;

/// The share of the distance to a cloud's farthest neighbour that one link stands for along a seam: a line of length
/// s, the spacing, crosses about 3.5 links of 8 neighbours, the farthest of which lies 1.7 s away.
const LINK_WIDTH: f64 = 0.17;

/// Two elements that touch.
#[derive(Debug, Clone, Copy)]
pub struct Edge {
    /// The other element.
    pub to: u32,
    /// Length of the edge that they share.
    pub length: f64,
    /// Distance between their centres.
    pub distance: f64,
}

/// What was met on the way; all counts.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Repairs {
    /// Edges of a single face.
    pub open_edges: usize,
    /// Edges of more than two faces.
    pub crowded_edges: usize,
    /// Faces that were wound inside out.
    pub flipped: usize,
    /// Connected components.
    pub components: usize,
    /// Components so small or so many that they were joined to what lies nearest.
    pub joined: usize,
    /// Elements of the coarser copy that was segmented; 0 when the surface itself was.
    pub coarse: usize,
}

/// Elements and which of them touch.
#[derive(Debug, Clone)]
pub struct Elements {
    /// Centres.
    pub centers: Vec<Vec3>,
    /// Unit normals.
    pub normals: Vec<Vec3>,
    /// Areas.
    pub areas: Vec<f64>,
    /// Corners of each face; empty for clouds.
    pub corners: Vec<[Vec3; 3]>,
    /// Where the edges of each element begin in `edges`.
    pub starts: Vec<usize>,
    /// Edges, from either side.
    pub edges: Vec<Edge>,
    /// Connected component of each, numbered in the order of first elements.
    pub component: Vec<u32>,
}

impl Elements {
    /// Edges of an element.
    #[must_use]
    pub fn edges_of(&self, element: usize) -> &[Edge] {
        &self.edges[self.starts[element]..self.starts[element + 1]]
    }

    /// Number of elements.
    #[must_use]
    pub fn len(&self) -> usize {
        self.centers.len()
    }

    /// Whether there is none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.centers.is_empty()
    }

    /// Build the graph of a mesh: `faces` index `vertices`. Edges of more than two faces join them all in a row.
    #[must_use]
    pub fn of_mesh(vertices: &[Vec3], faces: &[[usize; 3]], diagonal: f64, repairs: &mut Repairs) -> Self {
        let welded = weld(vertices, WELD * diagonal);
        let corners: Vec<[Vec3; 3]> = faces.iter().map(|f| f.map(|v| vertices[v])).collect();
        let centers = corners.iter().map(|[a, b, c]| (a + b + c) / 3.0).collect::<Vec<_>>();
        let crosses: Vec<Vec3> = corners.iter().map(|[a, b, c]| (b - a).cross(&(c - a))).collect();
        let mut sides: Vec<(u32, u32, u32)> = Vec::with_capacity(3 * faces.len());
        for (i, face) in faces.iter().enumerate() {
            for k in 0..3 {
                let (a, b) = (welded[face[k]], welded[face[(k + 1) % 3]]);
                if a != b {
                    sides.push((a.min(b), a.max(b), i as u32));
                }
            }
        }
        sides.sort_unstable();
        let mut pairs: Vec<(u32, u32, f64)> = Vec::with_capacity(sides.len());
        for run in sides.chunk_by(|x, y| (x.0, x.1) == (y.0, y.1)) {
            repairs.open_edges += usize::from(run.len() == 1);
            repairs.crowded_edges += usize::from(run.len() > 2);
            let length = (vertices[run[0].0 as usize] - vertices[run[0].1 as usize]).norm();
            for two in run.windows(2) {
                if two[0].2 != two[1].2 {
                    pairs.push((two[0].2, two[1].2, length));
                }
            }
        }
        let normals = crosses.iter().map(|n| n.try_normalize(0.0).unwrap_or_else(Vec3::z)).collect();
        let areas = crosses.iter().map(|n| n.norm() / 2.0).collect();
        Self::linked(centers, normals, areas, corners, &pairs)
    }

    /// Build the graph of a cloud: each point stands for a disc as large as its neighbours are far.
    #[must_use]
    pub fn of_cloud(points: &[Vec3], normals: Vec<Vec3>, neighbours: &[Vec<u32>]) -> Self {
        let mut pairs = Vec::new();
        let mut areas = Vec::with_capacity(points.len());
        for (i, near) in neighbours.iter().enumerate() {
            let far = near.iter().map(|&j| (points[i] - points[j as usize]).norm()).fold(0.0, f64::max);
            areas.push((std::f64::consts::PI * far * far / (near.len() + 1) as f64).max(f64::MIN_POSITIVE));
            for &j in near {
                // Kept once; the other one may not count this one among its nearest.
                if i < j as usize || !neighbours[j as usize].contains(&(i as u32)) {
                    pairs.push((i as u32, j, far * LINK_WIDTH));
                }
            }
        }
        Self::linked(points.to_vec(), normals, areas, Vec::new(), &pairs)
    }

    fn linked(
        centers: Vec<Vec3>,
        normals: Vec<Vec3>,
        areas: Vec<f64>,
        corners: Vec<[Vec3; 3]>,
        pairs: &[(u32, u32, f64)],
    ) -> Self {
        let mut built = Self {
            starts: Vec::new(),
            edges: Vec::new(),
            component: vec![0; centers.len()],
            centers,
            normals,
            areas,
            corners,
        };
        built.link(pairs);
        built.component = built.components();
        built
    }

    /// Add edges (element, element, length).
    pub fn link(&mut self, pairs: &[(u32, u32, f64)]) {
        let count = self.len();
        let mut degree = vec![0_usize; count + 1];
        for element in 0..count {
            degree[element + 1] = if self.starts.is_empty() { 0 } else { self.edges_of(element).len() };
        }
        for &(a, b, _) in pairs {
            degree[a as usize + 1] += 1;
            degree[b as usize + 1] += 1;
        }
        for i in 0..count {
            degree[i + 1] += degree[i];
        }
        let mut place = degree.clone();
        let mut edges = vec![Edge { to: 0, length: 0.0, distance: 0.0 }; degree[count]];
        if !self.starts.is_empty() {
            for element in 0..count {
                for &edge in self.edges_of(element) {
                    edges[place[element]] = edge;
                    place[element] += 1;
                }
            }
        }
        for &(a, b, length) in pairs {
            let distance = (self.centers[a as usize] - self.centers[b as usize]).norm();
            for (from, to) in [(a, b), (b, a)] {
                edges[place[from as usize]] = Edge { to, length, distance };
                place[from as usize] += 1;
            }
        }
        self.starts = degree;
        self.edges = edges;
    }

    /// Give normals of which the side is not known the side of their neighbours, the best aligned first
    /// (Hoppe et al. 1992); where nothing is known they agree among themselves.
    pub fn align_normals(&mut self, mut known: Vec<bool>) {
        let mut heap = BinaryHeap::new();
        for start in 0..=self.len() {
            let seeds = if start == 0 { 0..self.len() } else { start - 1..start };
            for i in seeds {
                if start > 0 && !known[i] {
                    known[i] = true;
                } else if start > 0 || !known[i] {
                    continue;
                }
                self.offer(i, &known, &mut heap);
            }
            while let Some((Reach { place, .. }, from)) = heap.pop() {
                if known[place] {
                    continue;
                }
                known[place] = true;
                if self.normals[place].dot(&self.normals[from]) < 0.0 {
                    self.normals[place] = -self.normals[place];
                }
                self.offer(place, &known, &mut heap);
            }
        }
    }

    fn offer(&self, i: usize, known: &[bool], heap: &mut BinaryHeap<(Reach, usize)>) {
        for edge in self.edges_of(i) {
            let j = edge.to as usize;
            if !known[j] {
                heap.push((Reach { cost: 1.0 - self.normals[i].dot(&self.normals[j]).abs(), place: j }, i));
            }
        }
    }

    fn components(&self) -> Vec<u32> {
        let mut found = vec![u32::MAX; self.len()];
        let mut next = 0;
        let mut stack = Vec::new();
        for seed in 0..self.len() {
            if found[seed] != u32::MAX {
                continue;
            }
            found[seed] = next;
            stack.push(seed);
            while let Some(i) = stack.pop() {
                for edge in self.edges_of(i) {
                    if found[edge.to as usize] == u32::MAX {
                        found[edge.to as usize] = next;
                        stack.push(edge.to as usize);
                    }
                }
            }
            next += 1;
        }
        found
    }

    /// Normals averaged over a geodesic neighbourhood of about `radius`, by area.
    #[must_use]
    pub fn smoothed_normals(&self, radius: f64) -> Vec<Vec3> {
        let mean = self.edges.iter().map(|e| e.distance).sum::<f64>() / self.edges.len().max(1) as f64;
        // A random walk of n steps of length h spreads to h sqrt(n).
        let steps = if mean > 0.0 { ((radius / mean).powi(2).ceil() as usize).clamp(1, MOST_STEPS) } else { 1 };
        let mut normals = self.normals.clone();
        for _ in 0..steps {
            normals = (0..self.len())
                .map(|i| {
                    let own = normals[i] * self.areas[i];
                    let sum = self.edges_of(i).iter().fold(own, |sum, e| {
                        let j = e.to as usize;
                        sum + normals[j] * self.areas[j]
                    });
                    sum.try_normalize(0.0).unwrap_or(normals[i])
                })
                .collect();
        }
        normals
    }
}

/// Smoothing steps at most: beyond them a mesh is so fine that the walk costs more than it tells.
const MOST_STEPS: usize = 64;

/// Give corners at one place one number: that of the first of them.
fn weld(vertices: &[Vec3], size: f64) -> Vec<u32> {
    let mut first: HashMap<[i64; 3], u32> = HashMap::with_capacity(vertices.len());
    let cell = size.max(f64::MIN_POSITIVE);
    vertices
        .iter()
        .enumerate()
        .map(|(i, v)| {
            let key = [0, 1, 2].map(|k| (v[k] / cell).round() as i64);
            *first.entry(key).or_insert(i as u32)
        })
        .collect()
}
