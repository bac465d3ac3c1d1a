//! Turning a box to the nearest local minimum of its volume.
//!
//! About one axis at a time by calipers, freely in shrinking steps, and along the ridges on which edges stay flush with
//! the box.

use super::Vec3;
use super::corners::Corners;
use super::search::{Candidate, Polyhedron, Workspace};

/// A turn counts when it makes the box smaller by more than this share; less is rounding.
const SMALLER: f64 = 1e-10;

/// Edges within this many steps of being flush with the box are brought there, the nearest of them.
const KINK_REACH: f64 = 3.0;
const KINKS: usize = 5;

/// Boxes that get smaller by next to nothing for longer than this are small enough.
const MOVES: usize = 40;

/// Sines below this belong to parallel kinks.
const PARALLEL: f64 = 1e-3;

/// What a step that finds nothing is shortened by.
const SHRINK: f64 = 0.1;

/// Turn a box to the nearest local minimum, to within `last` radians.
pub fn turned(hull: &Polyhedron, start: Candidate, (first, last): (f64, f64), work: &mut Workspace) -> Candidate {
    turn_freely(hull, turn_about_axes(hull, start, work), (first, last), work)
}

/// Turn a box about one of its axes at a time, as long as it gets smaller.
fn turn_about_axes(hull: &Polyhedron, mut current: Candidate, work: &mut Workspace) -> Candidate {
    for _ in 0..MOVES {
        let mut improved = current;
        for axis in current.axes {
            if let Some(found) = hull.best_about(&axis, work)
                && found.volume < improved.volume * (1.0 - SMALLER)
            {
                improved = found;
            }
        }
        if improved.volume >= current.volume {
            break;
        }
        current = improved;
    }
    current
}

/// Turn a box by rotation vectors with components in {-1, 0, 1} steps, at most two of them turning, and along the
/// ridges of the volume; the best of them is taken, the step is shortened when none is better.
fn turn_freely(
    hull: &Polyhedron,
    mut current: Candidate,
    (first, last): (f64, f64),
    work: &mut Workspace,
) -> Candidate {
    let mut step = first;
    let mut moved = false;
    // The corners that boxes were seen to stand on: most turns are refuted by them alone.
    let mut met = Corners::default();
    let meet = |met: &mut Corners, axes: &[Vec3; 3]| {
        for axis in axes {
            let (known, all) = (met.reach(axis), hull.corners.reach(axis));
            if all.0 < known.0 {
                met.push(&hull.vertices[hull.corners.at(axis, all.0)]);
            }
            if all.1 > known.1 {
                met.push(&hull.vertices[hull.corners.at(axis, all.1)]);
            }
        }
    };
    meet(&mut met, &current.axes);
    for _ in 0..MOVES {
        if step <= last {
            break;
        }
        let mut improved = current;
        let mut attempt = |turn: Vec3| {
            let axes = turned_axes(&current.axes, &turn);
            let bar = improved.volume * (1.0 - SMALLER);
            if met.volume(&axes) >= bar {
                return;
            }
            let volume = hull.corners.volume(&axes);
            if volume < bar {
                improved = Candidate { volume, axes };
            } else {
                meet(&mut met, &axes);
            }
        };
        for code in 0..27 {
            let parts = [code % 3, code / 3 % 3, code / 9].map(|c| f64::from(c) - 1.0);
            if (1..=2).contains(&parts.iter().filter(|p| **p != 0.0).count()) {
                let [x, y, z] = parts.map(|p| p * step);
                attempt(current.axes[0] * x + current.axes[1] * y + current.axes[2] * z);
            }
        }
        for turn in ridges(hull, &current, step) {
            attempt(turn);
        }
        if improved.volume < current.volume {
            current = improved;
            moved = true;
        } else if std::mem::take(&mut moved) {
            current = turn_about_axes(hull, current, work);
        } else {
            step *= SHRINK;
        }
    }
    current
}

/// Rotation vectors that bring two or three edges of the hull flush with the box, and on along the ridge.
///
/// The volume has a kink where an edge e lies in a box face with normal n, and its minima lie where kinks meet. A small
/// turn w makes the edge flush when w . (n x e) = -n . e.
fn ridges(hull: &Polyhedron, current: &Candidate, step: f64) -> Vec<Vec3> {
    let mut kinks: Vec<(f64, Vec3)> = Vec::new();
    for (normal, foot) in current.axes.iter().flat_map(|axis| hull.corners.ends(axis).map(|foot| (axis, foot))) {
        for edge in hull.edges_at(foot) {
            let edge = edge.normalize();
            let rise = normal.dot(&edge);
            if rise.abs() < KINK_REACH * step {
                kinks.push((-rise, normal.cross(&edge)));
            }
        }
    }
    kinks.sort_by(|a, b| a.0.abs().total_cmp(&b.0.abs()));
    kinks.truncate(KINKS);
    let mut turns = Vec::new();
    for (i, (rise, row)) in kinks.iter().enumerate() {
        for (j, (other_rise, other)) in kinks[..i].iter().enumerate() {
            let along = row.cross(other);
            let square = along.norm_squared();
            if square < PARALLEL * PARALLEL {
                continue;
            }
            // The shortest turn that makes both flush (Cramer's rule with `along` as the third row).
            let both = (other.cross(&along) * *rise + along.cross(row) * *other_rise) / square;
            let onward = along * (step / square.sqrt());
            turns.extend([both, both + onward, both - onward]);
            for (third_rise, third) in &kinks[..j] {
                let slope = along.dot(third);
                if slope.abs() > PARALLEL {
                    let meet = both + along * ((third_rise - both.dot(third)) / slope);
                    turns.push(meet);
                }
            }
        }
    }
    turns.retain(|turn| turn.norm() < 2.0 * KINK_REACH * step);
    turns
}

/// Turn axes about a vector by its length; larger angles come out smaller (Cayley's transform), which no step depends on.
fn turned_axes(axes: &[Vec3; 3], turn: &Vec3) -> [Vec3; 3] {
    let half = turn / 2.0;
    let scale = 2.0 / (1.0 + half.norm_squared());
    axes.map(|a| {
        let across = half.cross(&a);
        a + (across + half.cross(&across)) * scale
    })
}
