//! What stands in the way: an object's triangles and the plane it stands on.

use std::cmp::Ordering;

use crate::Error;
use crate::geometry::{OrientedBox, Vec3, points_of};

/// A leaf holds at most this many triangles.
const LEAF_SIZE: usize = 4;

/// Deeper than any tree of median splits over 2^32 triangles.
const STACK_SIZE: usize = 64;

/// An object and its support.
#[derive(Debug)]
pub struct Obstacles {
    /// In the order of the leaves.
    triangles: Vec<[Vec3; 3]>,
    nodes: Vec<Node>,
    support: Option<(Vec3, f64)>,
}

/// An axis-aligned box. Leaf: `count` triangles from `at` on. Inner node: count 0, `at` is the right child, the left one
/// follows the node.
#[derive(Debug, Clone, Copy)]
struct Node {
    center: Vec3,
    half: Vec3,
    at: usize,
    count: usize,
}

impl Obstacles {
    /// Take an object's triangles; nothing may come to where normal . p < offset of the support.
    ///
    /// # Errors
    /// A face names a vertex that is not there.
    pub fn new(vertices: &[f64], faces: &[i64], support: Option<(Vec3, f64)>) -> Result<Self, Error> {
        let points = points_of(vertices);
        let corner = |&i: &i64| {
            let found = usize::try_from(i).ok().and_then(|i| points.get(i)).copied();
            found.ok_or_else(|| Error::value("faces", format!("indices of {} vertices", points.len()), i))
        };
        let (rows, _) = faces.as_chunks::<3>();
        let triangles = rows.iter().map(|[a, b, c]| Ok([corner(a)?, corner(b)?, corner(c)?]));
        let mut leaves: Vec<Leaf> = triangles.map(|t| t.map(Leaf::of)).collect::<Result<_, Error>>()?;
        let mut nodes = Vec::with_capacity(leaves.len());
        if !leaves.is_empty() {
            split(&mut leaves, 0, &mut nodes);
        }
        Ok(Self { triangles: leaves.into_iter().map(|leaf| leaf.corners).collect(), nodes, support })
    }

    /// Whether a box touches the object or reaches below the support.
    #[must_use]
    pub fn touches(&self, b: &OrientedBox) -> bool {
        let half = Vec3::from(b.half_extents);
        let below = self.support.is_some_and(|(normal, offset)| {
            let reach: f64 = (0..3).map(|k| half[k] * b.axes[k].dot(&normal).abs()).sum();
            b.center.dot(&normal) - offset < reach
        });
        below || self.touches_object(b, &half)
    }

    fn touches_object(&self, b: &OrientedBox, half: &Vec3) -> bool {
        if self.nodes.is_empty() {
            return false;
        }
        let sizes = b.axes.map(|axis| axis.abs());
        let width = sizes[0] * half.x + sizes[1] * half.y + sizes[2] * half.z;
        // Six of the fifteen separating axes: the others cost more than the nodes that they would spare.
        let apart = |node: &Node| {
            let offset = node.center - b.center;
            (0..3).any(|k| offset[k].abs() > node.half[k] + width[k])
                || (0..3).any(|k| offset.dot(&b.axes[k]).abs() > half[k] + node.half.dot(&sizes[k]))
        };
        let mut stack = [0_usize; STACK_SIZE];
        let mut depth = 1;
        while depth > 0 {
            depth -= 1;
            let index = stack[depth];
            let node = &self.nodes[index];
            if apart(node) {
                continue;
            }
            if node.count == 0 {
                stack[depth] = node.at;
                stack[depth + 1] = index + 1;
                depth += 2;
            } else if self.triangles[node.at..node.at + node.count].iter().any(|t| overlaps(b, half, t)) {
                return true;
            }
        }
        false
    }
}

struct Leaf {
    corners: [Vec3; 3],
    low: Vec3,
    high: Vec3,
}

impl Leaf {
    fn of(corners: [Vec3; 3]) -> Self {
        let [a, b, c] = &corners;
        Self { low: a.inf(b).inf(c), high: a.sup(b).sup(c), corners }
    }
}

/// Median splits along the longest side of the box of centres; triangles are put in the order of the leaves, the first
/// of which is the `first` of all.
fn split(leaves: &mut [Leaf], first: usize, nodes: &mut Vec<Node>) {
    let (mut low, mut high) = (leaves[0].low, leaves[0].high);
    let middle = |leaf: &Leaf| leaf.low + leaf.high;
    let (mut least, mut most) = (middle(&leaves[0]), middle(&leaves[0]));
    for leaf in &leaves[1..] {
        (low, high) = (low.inf(&leaf.low), high.sup(&leaf.high));
        (least, most) = (least.inf(&middle(leaf)), most.sup(&middle(leaf)));
    }
    let node = nodes.len();
    nodes.push(Node { center: (low + high) * 0.5, half: (high - low) * 0.5, at: first, count: leaves.len() });
    if leaves.len() <= LEAF_SIZE {
        return;
    }
    let axis = (most - least).imax();
    let half = leaves.len() / 2;
    let key = |leaf: &Leaf| leaf.low[axis] + leaf.high[axis];
    leaves.select_nth_unstable_by(half, |a, b| key(a).partial_cmp(&key(b)).unwrap_or(Ordering::Equal));
    let (left, right) = leaves.split_at_mut(half);
    split(left, first, nodes);
    nodes[node].at = nodes.len();
    nodes[node].count = 0;
    split(right, first + half, nodes);
}

/// Whether box and triangle share a point, by the 13 separating axes (Akenine-Moller, "Fast 3D triangle-box overlap
/// testing", 2001).
fn overlaps(b: &OrientedBox, half: &Vec3, triangle: &[Vec3; 3]) -> bool {
    let [p, q, r] = triangle.map(|corner| {
        let offset = corner - b.center;
        Vec3::new(offset.dot(&b.axes[0]), offset.dot(&b.axes[1]), offset.dot(&b.axes[2]))
    });
    let (low, high) = (p.inf(&q).inf(&r), p.sup(&q).sup(&r));
    if (0..3).any(|k| low[k] > half[k] || high[k] < -half[k]) {
        return false;
    }
    let edges = [q - p, r - q, p - r];
    let normal = edges[0].cross(&edges[1]);
    if normal.dot(&p).abs() > normal.abs().dot(half) {
        return false;
    }
    // An edge's two ends project alike: its start and the corner across span the triangle.
    let across = [(p, r), (q, p), (r, q)];
    for (edge, (on, off)) in edges.iter().zip(&across) {
        for k in 0..3 {
            let (i, j) = ((k + 1) % 3, (k + 2) % 3);
            let along = |v: &Vec3| edge[i] * v[j] - edge[j] * v[i];
            let reach = half[i] * edge[j].abs() + half[j] * edge[i].abs();
            let (s, t) = (along(on), along(off));
            if s.min(t) > reach || s.max(t) < -reach {
                return false;
            }
        }
    }
    true
}
