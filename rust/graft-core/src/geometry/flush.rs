//! The smallest box that lies flush with a face of the hull.
//!
//! Usually it is the minimal box or near it. The search for the minimal box begins with the extreme points of a few
//! hundred directions, between which a face of the hull can be overlooked; here every face gets its turn, and lower bounds
//! refute nearly all of them.

use super::search::{Candidate, Polyhedron, Workspace};
use super::solid::{SAME_NORMAL, face_normals};

/// A box counts as smaller when it is by more than this share; less is rounding.
const SMALLER: f64 = 1e-10;

/// Find the smallest box about `hull` that has a face normal as an axis and is smaller than `bar`, if there is one.
///
/// `insides` are polyhedra within the hull, from rough to fine: what they need as a box, the hull needs at least.
pub fn flush_box(hull: &Polyhedron, insides: &[&Polyhedron], bar: f64, work: &mut Workspace) -> Option<Candidate> {
    let mut normals = face_normals(hull);
    normals.sort_unstable_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)).then(a.z.total_cmp(&b.z)));
    normals.dedup_by(|a, b| (*a - *b).norm() < SAME_NORMAL);
    let mut best: Option<Candidate> = None;
    for normal in normals {
        let bar = best.map_or(bar, |b| b.volume) * (1.0 - SMALLER);
        if insides.iter().any(|p| p.least_volume(&normal) >= bar) {
            continue;
        }
        let height = hull.corners.extent(&normal);
        let refuted = insides.iter().any(|p| {
            let needs = p.best_about(&normal, work).map_or(0.0, |c| c.volume);
            // The rectangle's area is what the inner box needs; the height is the hull's own.
            needs / p.corners.extent(&normal) * height >= bar
        });
        if refuted {
            continue;
        }
        if let Some(found) = hull.best_about(&normal, work)
            && found.volume < bar
        {
            best = Some(found);
        }
    }
    best
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::super::Vec3;
    use super::super::corners::spread_directions;
    use super::super::hull::convex_hull;
    use super::*;

    #[test]
    fn bounds_refute_no_face_whose_box_is_the_smallest() {
        let shape = Vec3::new(1.0, 0.9, 1.2);
        let directions = spread_directions(400).flat_map(|d| [d, -d]);
        let points: Vec<Vec3> = directions.map(|d| d.component_mul(&shape)).collect();
        let few: Vec<Vec3> = points.iter().step_by(5).copied().collect();
        let hull = Polyhedron::new(convex_hull(&points));
        let inside = Polyhedron::new(convex_hull(&few));
        let mut work = Workspace::default();
        let boxes = hull.normals.iter().map(|n| hull.best_about(n, &mut work).unwrap().volume);
        let smallest = boxes.fold(f64::INFINITY, f64::min);
        let found = flush_box(&hull, &[&inside], f64::INFINITY, &mut work).unwrap();
        assert!((found.volume / smallest - 1.0).abs() < 1e-9);
        assert!(flush_box(&hull, &[&inside], smallest * (1.0 - 1e-6), &mut work).is_none());
    }
}
