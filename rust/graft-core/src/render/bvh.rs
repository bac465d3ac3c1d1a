//! A bounding volume hierarchy over triangles and spheres.
//!
//! Median splits over a total order of the centroids, so the tree, and with it every answer, is the same on every
//! machine and for any number of threads.

use nalgebra::Vector3;

use crate::geometry::crossing::crossing;

/// A leaf holds at most this many primitives; between 2 and 8 makes no difference that can be measured.
const LEAF_SIZE: usize = 4;

/// Deeper than any tree of median splits over 2^32 primitives.
const STACK_SIZE: usize = 64;

/// What a ray can hit.
#[derive(Debug, Clone, Copy)]
pub enum Primitive {
    /// Three corners.
    Triangle([Vector3<f64>; 3]),
    /// Centre and radius.
    Sphere(Vector3<f64>, f64),
}

/// A half-line; the direction need not be a unit vector.
#[derive(Debug, Clone, Copy)]
pub struct Ray {
    /// Where it begins.
    pub origin: Vector3<f64>,
    /// Where it goes; distances are in its lengths.
    pub direction: Vector3<f64>,
}

/// The nearest hit of a ray.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hit {
    /// Distance in lengths of the ray's direction.
    pub distance: f64,
    /// Index of the primitive.
    pub primitive: usize,
    /// Barycentric weights of a triangle's second and third corner; zero for spheres.
    pub weights: [f64; 2],
}

#[derive(Debug, Clone, Copy)]
struct Aabb {
    low: Vector3<f64>,
    high: Vector3<f64>,
}

impl Aabb {
    const EMPTY: Self = Self {
        low: Vector3::new(f64::INFINITY, f64::INFINITY, f64::INFINITY),
        high: Vector3::new(f64::NEG_INFINITY, f64::NEG_INFINITY, f64::NEG_INFINITY),
    };

    fn of(primitive: &Primitive) -> Self {
        match primitive {
            Primitive::Triangle([a, b, c]) => Self { low: a.inf(b).inf(c), high: a.sup(b).sup(c) },
            Primitive::Sphere(center, radius) => {
                Self { low: center.add_scalar(-radius), high: center.add_scalar(*radius) }
            }
        }
    }

    fn union(&self, other: &Self) -> Self {
        Self { low: self.low.inf(&other.low), high: self.high.sup(&other.high) }
    }

    /// Where the ray enters the box, if it does so before `limit`.
    fn entry(&self, ray: &Ray, inverse: &Vector3<f64>, limit: f64) -> Option<f64> {
        let (mut enter, mut leave) = (0.0_f64, limit);
        for k in 0..3 {
            if ray.direction[k] == 0.0 {
                // 0 / 0 would be NaN for a ray that runs in the plane of a side.
                if ray.origin[k] < self.low[k] || ray.origin[k] > self.high[k] {
                    return None;
                }
                continue;
            }
            let first = (self.low[k] - ray.origin[k]) * inverse[k];
            let second = (self.high[k] - ray.origin[k]) * inverse[k];
            enter = enter.max(first.min(second));
            leave = leave.min(first.max(second));
        }
        (enter <= leave).then_some(enter)
    }
}

#[derive(Debug, Clone, Copy)]
struct Node {
    bounds: Aabb,
    /// Leaf: first place in `order`. Inner node: index of the right child; the left one follows the node.
    start: usize,
    /// Number of primitives of a leaf; 0 for inner nodes.
    count: usize,
}

/// The hierarchy, with its primitives.
#[derive(Debug)]
pub struct Bvh {
    primitives: Vec<Primitive>,
    order: Vec<usize>,
    nodes: Vec<Node>,
}

impl Bvh {
    /// Build the tree over `primitives`, whose coordinates must be finite.
    #[must_use]
    pub fn new(primitives: Vec<Primitive>) -> Self {
        let bounds: Vec<Aabb> = primitives.iter().map(Aabb::of).collect();
        let centers: Vec<Vector3<f64>> = bounds.iter().map(|b| (b.low + b.high) * 0.5).collect();
        let mut order: Vec<usize> = (0..primitives.len()).collect();
        let mut nodes = Vec::with_capacity(primitives.len());
        if !order.is_empty() {
            split(&bounds, &centers, &mut order, 0, &mut nodes);
        }
        Self { primitives, order, nodes }
    }

    /// Return the nearest hit at a distance of at least 0; of equally near ones the primitive of lowest index.
    #[must_use]
    pub fn nearest(&self, ray: &Ray) -> Option<Hit> {
        let inverse = ray.direction.map(|x| 1.0 / x);
        let mut best: Option<Hit> = None;
        let mut stack = [(0_usize, 0.0_f64); STACK_SIZE];
        let mut depth = 0;
        if let Some(enter) = self.nodes.first().and_then(|n| n.bounds.entry(ray, &inverse, f64::INFINITY)) {
            stack[0] = (0, enter);
            depth = 1;
        }
        while depth > 0 {
            depth -= 1;
            let (index, enter) = stack[depth];
            let limit = best.map_or(f64::INFINITY, |b| b.distance);
            if enter > limit {
                continue;
            }
            let node = &self.nodes[index];
            if node.count > 0 {
                for &primitive in &self.order[node.start..node.start + node.count] {
                    self.test(primitive, ray, &mut best);
                }
                continue;
            }
            let (left, right) = (index + 1, node.start);
            let enter_left = self.nodes[left].bounds.entry(ray, &inverse, limit);
            let enter_right = self.nodes[right].bounds.entry(ray, &inverse, limit);
            match (enter_left, enter_right) {
                (Some(a), Some(b)) => {
                    let (near, far) = if a <= b { ((left, a), (right, b)) } else { ((right, b), (left, a)) };
                    stack[depth] = far;
                    stack[depth + 1] = near;
                    depth += 2;
                }
                (Some(a), None) => {
                    stack[depth] = (left, a);
                    depth += 1;
                }
                (None, Some(b)) => {
                    stack[depth] = (right, b);
                    depth += 1;
                }
                (None, None) => {}
            }
        }
        best
    }

    fn test(&self, primitive: usize, ray: &Ray, best: &mut Option<Hit>) {
        let found = match &self.primitives[primitive] {
            Primitive::Triangle(corners) => hit_triangle(corners, ray),
            Primitive::Sphere(center, radius) => hit_sphere(center, *radius, ray).map(|t| (t, [0.0; 2])),
        };
        if let Some((distance, weights)) = found {
            let nearer = best.is_none_or(|b| distance.total_cmp(&b.distance).then(primitive.cmp(&b.primitive)).is_lt());
            if nearer {
                *best = Some(Hit { distance, primitive, weights });
            }
        }
    }
}

/// Append the subtree over `order`, which begins at `offset` of the whole order.
fn split(bounds: &[Aabb], centers: &[Vector3<f64>], order: &mut [usize], offset: usize, nodes: &mut Vec<Node>) {
    let index = nodes.len();
    let around = order.iter().fold(Aabb::EMPTY, |sum, &i| sum.union(&bounds[i]));
    if order.len() <= LEAF_SIZE {
        nodes.push(Node { bounds: around, start: offset, count: order.len() });
        return;
    }
    let low = order.iter().fold(Aabb::EMPTY.low, |low, &i| low.inf(&centers[i]));
    let high = order.iter().fold(Aabb::EMPTY.high, |high, &i| high.sup(&centers[i]));
    let axis = (high - low).imax();
    let middle = order.len() / 2;
    order.select_nth_unstable_by(middle, |&a, &b| centers[a][axis].total_cmp(&centers[b][axis]).then(a.cmp(&b)));
    nodes.push(Node { bounds: around, start: 0, count: 0 });
    let (left, right) = order.split_at_mut(middle);
    split(bounds, centers, left, offset, nodes);
    nodes[index].start = nodes.len();
    split(bounds, centers, right, offset + middle, nodes);
}

/// Distance and weights of a hit, from either side.
fn hit_triangle(corners: &[Vector3<f64>; 3], ray: &Ray) -> Option<(f64, [f64; 2])> {
    crossing(corners, &ray.origin, &ray.direction).filter(|(distance, _)| *distance >= 0.0)
}

/// Distance of the first hit; from inside, of the exit.
fn hit_sphere(center: &Vector3<f64>, radius: f64, ray: &Ray) -> Option<f64> {
    let from = ray.origin - center;
    let a = ray.direction.norm_squared();
    let b = from.dot(&ray.direction);
    // The distance of the line from the centre, not b^2 - a c, which cancels for far origins.
    let closest = from - ray.direction * (b / a);
    let inside = radius * radius - closest.norm_squared();
    if inside < 0.0 {
        return None;
    }
    let half = (inside / a).sqrt();
    let middle = -b / a;
    [middle - half, middle + half].into_iter().find(|t| *t >= 0.0)
}
