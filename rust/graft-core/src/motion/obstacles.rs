//! What stands in the way: an object's triangles and the plane it stands on.

use crate::Error;
use crate::geometry::{OrientedBox, Vec3, points_of};

/// A leaf holds at most this many triangles.
const LEAF_SIZE: usize = 4;

/// Bits of a cell's index along each axis of the curve: cells of a thousandth of the object.
const CURVE_BITS: u32 = 10;

/// Deeper than any tree of halves over 2^32 triangles.
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
        let triangles = along_curve(&triangles.collect::<Result<Vec<_>, Error>>()?);
        let mut nodes = Vec::with_capacity(triangles.len());
        if !triangles.is_empty() {
            split(&triangles, 0, &mut nodes);
        }
        Ok(Self { triangles, nodes, support })
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

/// The triangles along a Morton curve through their centres (Lauterbach and others, "Fast BVH construction on GPUs",
/// 2009): one sort makes neighbours of what is near, an order of magnitude sooner than a sort at every split. Of equal
/// codes the triangle of lower index comes first.
fn along_curve(triangles: &[[Vec3; 3]]) -> Vec<[Vec3; 3]> {
    let center = |t: &[Vec3; 3]| t[0] + t[1] + t[2];
    let first = triangles.first().map_or_else(Vec3::zeros, center);
    let (low, high) =
        triangles.iter().fold((first, first), |(low, high), t| (low.inf(&center(t)), high.sup(&center(t))));
    let cells = f64::from(1_u32 << CURVE_BITS) - 1.0;
    let scale = (high - low).map(|width| if width > 0.0 { cells / width } else { 0.0 });
    let code = |t: &[Vec3; 3]| {
        let cell = (center(t) - low).component_mul(&scale);
        spread(cell.x as u64) | spread(cell.y as u64) << 1 | spread(cell.z as u64) << 2
    };
    let mut order: Vec<u64> = triangles.iter().enumerate().map(|(i, t)| code(t) << 32 | i as u64).collect();
    order.sort_unstable();
    order.into_iter().map(|key| triangles[(key & 0xFFFF_FFFF) as usize]).collect()
}

/// Put two zeros between the ten lowest bits.
fn spread(cell: u64) -> u64 {
    let mut x = cell & 0x3FF;
    x = (x | x << 16) & 0x0300_00FF;
    x = (x | x << 8) & 0x0300_F00F;
    x = (x | x << 4) & 0x030C_30C3;
    (x | x << 2) & 0x0924_9249
}

/// Halve the triangles, the first of which is the `first` of all, down to leaves; return the corners of their box.
fn split(triangles: &[[Vec3; 3]], first: usize, nodes: &mut Vec<Node>) -> (Vec3, Vec3) {
    let node = nodes.len();
    nodes.push(Node { center: Vec3::zeros(), half: Vec3::zeros(), at: first, count: triangles.len() });
    let (low, high) = if triangles.len() <= LEAF_SIZE {
        let corners = triangles.iter().flatten();
        corners.fold((triangles[0][0], triangles[0][0]), |(low, high), p| (low.inf(p), high.sup(p)))
    } else {
        let (left, right) = triangles.split_at(triangles.len() / 2);
        let (low, high) = split(left, first, nodes);
        nodes[node].at = nodes.len();
        nodes[node].count = 0;
        let (other_low, other_high) = split(right, first + left.len(), nodes);
        (low.inf(&other_low), high.sup(&other_high))
    };
    // Rounding of centre and half must not shrink the box.
    let half = (high - low) * 0.5;
    nodes[node].center = low + half;
    nodes[node].half = half + (low.abs() + high.abs()) * f64::EPSILON;
    (low, high)
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
