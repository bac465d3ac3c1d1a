//! Rectangle of minimal area about planar points, by rotating calipers (Toussaint 1983).

/// Corners within this share of the polygon's size of each other are one, such as the ends of an edge seen end-on: the
/// direction from one to the other is made of rounding errors.
const SHORT_EDGE: f64 = 1e-9;

/// A foot of the calipers moves on over a fall below this share of the size, which rounding makes of a level edge.
const LEVEL: f64 = 1e-14;

/// A point of the plane.
pub type Vec2 = nalgebra::Vector2<f64>;

/// The rectangle's area and the unit direction of one of its sides.
#[derive(Debug, Clone, Copy)]
pub struct Rectangle {
    /// Area.
    pub area: f64,
    /// Direction of a side.
    pub side: Vec2,
}

/// Return the convex hull, counter-clockwise, of `points`, which are sorted in place (Andrew's monotone chain).
pub fn planar_hull(points: &mut [Vec2], hull: &mut Vec<Vec2>) {
    hull.clear();
    points.sort_unstable_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
    let turn = |o: &Vec2, a: &Vec2, b: &Vec2| (a - o).perp(&(b - o));
    for &p in points.iter() {
        while hull.len() >= 2 && turn(&hull[hull.len() - 2], &hull[hull.len() - 1], &p) <= 0.0 {
            hull.pop();
        }
        hull.push(p);
    }
    let lower = hull.len() + 1;
    for &p in points.iter().rev().skip(1) {
        while hull.len() >= lower && turn(&hull[hull.len() - 2], &hull[hull.len() - 1], &p) <= 0.0 {
            hull.pop();
        }
        hull.push(p);
    }
    if hull.len() > 1 {
        hull.pop();
    }
}

/// Return the minimal rectangle of a convex counter-clockwise polygon: one of its sides lies on an edge.
///
/// A polygon without an edge (one point) has none. Corners that lie on the one before them are removed.
#[must_use]
pub fn minimal_rectangle(polygon: &mut Vec<Vec2>) -> Option<Rectangle> {
    let mut best: Option<Rectangle> = None;
    each_rectangle(polygon, |found| {
        if best.is_none_or(|b| found.area < b.area) {
            best = Some(found);
        }
    });
    best
}

/// Visit the rectangles that have a side on an edge of a convex counter-clockwise polygon, in the order of the edges.
pub fn each_rectangle(polygon: &mut Vec<Vec2>, mut visit: impl FnMut(Rectangle)) {
    let Some(&start) = polygon.first() else { return };
    let size = polygon.iter().map(|p| (p - start).amax()).fold(0.0, f64::max);
    let same = |a: &Vec2, b: &Vec2| (a - b).amax() <= SHORT_EDGE * size;
    polygon.dedup_by(|next, kept| same(next, kept));
    if polygon.len() > 1 && same(&polygon[polygon.len() - 1], &start) {
        polygon.pop();
    }
    let polygon = &*polygon;
    let n = polygon.len();
    let next = |i: usize| if i + 1 == n { 0 } else { i + 1 };
    let mut placed = false;
    // Feet of the calipers: farthest along the edge, away from it, and against it.
    let (mut right, mut top, mut left) = (0, 0, 0);
    for i in 0..n {
        let edge = polygon[next(i)] - polygon[i];
        let length = edge.norm();
        if length <= 0.0 {
            continue;
        }
        let u = edge / length;
        let v = Vec2::new(-u.y, u.x);
        if !std::mem::replace(&mut placed, true) {
            for (k, p) in polygon.iter().enumerate() {
                right = if p.dot(&u) > polygon[right].dot(&u) { k } else { right };
                top = if p.dot(&v) > polygon[top].dot(&v) { k } else { top };
                left = if p.dot(&u) < polygon[left].dot(&u) { k } else { left };
            }
        }
        let climb = |mut k: usize, d: Vec2| {
            for _ in 0..n {
                if polygon[next(k)].dot(&d) < polygon[k].dot(&d) - LEVEL * size {
                    break;
                }
                k = next(k);
            }
            k
        };
        right = climb(right, u);
        top = climb(top, v);
        left = climb(left, -u);
        let width = (polygon[right] - polygon[left]).dot(&u);
        let height = (polygon[top] - polygon[i]).dot(&v);
        let area = width * height;
        visit(Rectangle { area, side: u });
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    fn hull_of(points: &[(f64, f64)]) -> Vec<Vec2> {
        let mut points: Vec<Vec2> = points.iter().map(|&(x, y)| Vec2::new(x, y)).collect();
        let mut hull = Vec::new();
        planar_hull(&mut points, &mut hull);
        hull
    }

    #[test]
    fn a_turned_square_with_points_inside_is_its_own_rectangle() {
        let mut hull = hull_of(&[(1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0), (0.1, 0.2), (0.5, 0.5)]);
        assert_eq!(hull.len(), 4);
        let found = minimal_rectangle(&mut hull).unwrap();
        assert!((found.area - 2.0).abs() < 1e-12);
        assert!((found.side.x.abs() - 0.5f64.sqrt()).abs() < 1e-12);
    }

    #[test]
    fn an_equilateral_triangle_fills_half_of_it() {
        let mut hull = hull_of(&[(0.0, 0.0), (1.0, 0.0), (0.5, 0.75f64.sqrt())]);
        assert!((minimal_rectangle(&mut hull).unwrap().area - 0.75f64.sqrt()).abs() < 1e-12);
    }

    #[test]
    fn a_segment_has_area_zero_and_a_point_none() {
        assert!(minimal_rectangle(&mut hull_of(&[(0.0, 0.0), (1.0, 1.0), (0.5, 0.5)])).unwrap().area.abs() < 1e-15);
        assert!(minimal_rectangle(&mut hull_of(&[(1.0, 1.0), (1.0, 1.0)])).is_none());
    }
}
