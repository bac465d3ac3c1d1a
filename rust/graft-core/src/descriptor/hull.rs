//! Convex hull of a part in its own frame, to a fixed resolution.
//!
//! The hull is spanned by the support points of 192 directions, spread evenly after the part has been stretched to
//! equal deviations (hulls go with affine maps), so that it does not depend on the tessellation and costs the same
//! for every part. The directions come in mirrored octants: flipped axes give the same hull.

use super::surface::{FLOOR, Point, Surface};
use crate::geometry::convex_hull;
use nalgebra::Matrix3;

/// Directions per octant.
const DIRECTIONS: usize = 24;
/// Cells along an edge of the cube map that thins dense vertices out.
const CELLS: usize = 16;

/// Facets (outward) of a closed convex polyhedron.
pub struct Hull {
    /// Corners of every facet.
    pub facets: Vec<[Point; 3]>,
    /// Outward unit normal and offset of every facet.
    pub planes: Vec<(Point, f64)>,
    /// Enclosed volume.
    pub volume: f64,
    /// Surface area.
    pub area: f64,
    /// Centroid of the solid.
    pub centroid: Point,
    /// Covariance of the solid.
    pub covariance: Matrix3<f64>,
}

impl Hull {
    /// Hull of a part; flat and straight parts are thickened to the floor.
    pub fn new(surface: &Surface) -> Self {
        let stretch = Point::from(surface.deviations);
        let whitened: Vec<Point> = surface.vertices.iter().map(|v| v.component_div(&stretch)).collect();
        let mut points = support(&thin(&whitened));
        for axis in 0..3 {
            let low = points.iter().map(|p| p[axis]).fold(f64::INFINITY, f64::min);
            let high = points.iter().map(|p| p[axis]).fold(f64::NEG_INFINITY, f64::max);
            let floor = FLOOR * surface.deviations[0] / surface.deviations[axis];
            if high - low < floor {
                let copies: Vec<Point> = points.clone();
                for (point, side) in copies.iter().flat_map(|p| [(p, -0.5), (p, 0.5)]) {
                    let mut moved = *point;
                    moved[axis] += side * floor;
                    points.push(moved);
                }
            }
        }
        let hull = convex_hull(&points);
        let corner = |i: u32| hull.vertices[i as usize].component_mul(&stretch);
        Self::measured(hull.faces.iter().map(|f| f.map(corner)).collect())
    }

    /// Integrate volume, area, centroid and covariance over the facets.
    fn measured(facets: Vec<[Point; 3]>) -> Self {
        let (mut volume, mut area, mut first, mut second) = (0.0, 0.0, Point::zeros(), Matrix3::zeros());
        let mut planes = Vec::with_capacity(facets.len());
        for [a, b, c] in &facets {
            let normal = (b - a).cross(&(c - a));
            let tetrahedron = a.dot(&b.cross(c)) / 6.0;
            let sum = a + b + c;
            volume += tetrahedron;
            area += 0.5 * normal.norm();
            first += sum * (tetrahedron / 4.0);
            second += (a * a.transpose() + b * b.transpose() + c * c.transpose() + sum * sum.transpose())
                * (tetrahedron / 20.0);
            let unit = normal / normal.norm().max(f64::MIN_POSITIVE);
            planes.push((unit, unit.dot(a)));
        }
        let volume = volume.max(f64::MIN_POSITIVE);
        let centroid = first / volume;
        let covariance = second / volume - centroid * centroid.transpose();
        Self { facets, planes, volume, area, centroid, covariance }
    }

    /// How far a point lies below the hull's surface; 0 outside.
    pub fn depth(&self, point: &Point) -> f64 {
        self.planes.iter().map(|(normal, offset)| offset - normal.dot(point)).fold(f64::INFINITY, f64::min).max(0.0)
    }
}

/// Farthest point of each cell of a cube map around the origin.
fn thin(points: &[Point]) -> Vec<Point> {
    if points.len() <= 6 * CELLS * CELLS {
        return points.to_vec();
    }
    let mut farthest: Vec<Option<Point>> = vec![None; 6 * CELLS * CELLS];
    for point in points {
        let axis = point.iamax();
        let length = point[axis].abs();
        if length == 0.0 {
            continue;
        }
        let cell = |x: f64| (((x / length + 1.0) * 0.5 * CELLS as f64) as usize).min(CELLS - 1);
        let side = 2 * axis + usize::from(point[axis] < 0.0);
        let slot = &mut farthest[(side * CELLS + cell(point[(axis + 1) % 3])) * CELLS + cell(point[(axis + 2) % 3])];
        if slot.is_none_or(|kept| kept.norm_squared() < point.norm_squared()) {
            *slot = Some(*point);
        }
    }
    farthest.into_iter().flatten().collect()
}

/// Points that are farthest along one of the directions, each once, in order of their index.
fn support(points: &[Point]) -> Vec<Point> {
    let mut kept = vec![false; points.len()];
    for direction in directions() {
        let mut best = (f64::NEG_INFINITY, 0);
        for (i, point) in points.iter().enumerate() {
            let height = direction.dot(point);
            if height > best.0 {
                best = (height, i);
            }
        }
        kept[best.1] = true;
    }
    points.iter().zip(kept).filter(|&(_, keep)| keep).map(|(p, _)| *p).collect()
}

/// A golden spiral over one octant, mirrored into all eight.
fn directions() -> impl Iterator<Item = Point> {
    const GOLDEN: f64 = 0.618_033_988_749_894_9;
    (0..8 * DIRECTIONS).map(|k| {
        let i = (k / 8) as f64 + 0.5;
        let z = i / DIRECTIONS as f64;
        let azimuth = (i * GOLDEN).fract() * std::f64::consts::FRAC_PI_2;
        let radius = (1.0 - z * z).sqrt();
        let sign = |bit: usize| if k >> bit & 1 == 0 { 1.0 } else { -1.0 };
        Point::new(sign(0) * radius * azimuth.cos(), sign(1) * radius * azimuth.sin(), sign(2) * z)
    })
}
