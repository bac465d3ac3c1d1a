//! Edges without gaps: a configuration whose neighbourhood is free vouches for all of it.
//!
//! If what moves, grown by h, touches nothing at the middle of a motion on which no point travels further than 2 h, then
//! it touches nothing anywhere on that motion. So one query with a large h settles an edge through open space, and only
//! near obstacles is the edge halved (after Schwarzer, Saha and Latombe, "Adaptive dynamic collision checking for single
//! and multiple articulated robots in complex environments", 2005, with grown boxes in the place of distances).

use std::collections::VecDeque;

use super::space::Space;

/// Whether the whole motion from `a` to `b` is free; both ends must be clear by `clearance` already.
///
/// A motion that comes nearer than `clearance` (positive) to an obstacle is refused, which ends the halving: nothing is
/// jumped over, however thin. `checks` counts the queries.
pub fn edge_free<S: Space>(space: &S, a: &S::State, b: &S::State, clearance: f64, checks: &mut usize) -> bool {
    let length = space.distance(a, b);
    let mut intervals = VecDeque::from([(0.0_f64, 1.0_f64)]);
    // Breadth first, so that an obstacle anywhere on the edge is met after few queries.
    while let Some((from, to)) = intervals.pop_front() {
        let half = 0.5 * (to - from) * length;
        let middle = 0.5 * (from + to);
        let state = space.between(a, b, middle);
        *checks += 1;
        if space.clear(&state, half) {
            continue;
        }
        if half <= clearance {
            return false;
        }
        *checks += 1;
        if !space.clear(&state, clearance) {
            return false;
        }
        intervals.push_back((from, middle));
        intervals.push_back((middle, to));
    }
    true
}
