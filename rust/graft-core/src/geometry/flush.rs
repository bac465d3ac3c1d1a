//! The smallest box that lies flush with a face of the hull.
//!
//! Most minimal boxes do (O'Rourke 1985 lets them lie against two edges instead), and it is what other programs look for.
//! The search for the minimal box works on the extreme points of a few hundred directions, between which a face of the
//! hull can be overlooked; here every face gets its turn, and lower bounds refute nearly all of them.

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
