//! Quickhull (Barber, Dobkin, Huhdanpaa 1996) with a check of its result.
//!
//! parry's quickhull, measured on meshes of pliers, returned faces with points 20 % of the size outside them, spends time
//! quadratic in the points, and asserts. This one decides with exact predicates (Shewchuk 1997) where rounding could
//! decide, and returns a closed, locally convex surface or nothing.

use robust::{Coord3D, orient3d};

use super::Vec3;

/// Rounding of a height above a well-shaped face, points filling about the unit cube: 72 roundings, some twenty of which
/// can happen. It grows with the product of two sides over the face's doubled area.
const HEIGHT_ERROR: f64 = 8e-15;

/// Faces whose heights are known to better than this count as seen by a point in their plane: joined to its side, they
/// leave no face between three corners on a line.
const IN_PLANE: f64 = 1e-12;

/// What a corner may rise above a neighbouring face.
const CONVEX: f64 = 1e-9;

/// Volume below which the first tetrahedron is flat.
const FLAT: f64 = 1e-13;

/// A point less than this above every face, points filling about the unit cube, is no corner: rounding leaves the points
/// of a flat side that much apart, and a hull that has them all as corners has slivers for faces.
const ON_FACE: f64 = 1e-10;

const NONE: u32 = u32::MAX;

struct Face {
    corners: [u32; 3],
    /// The face across the edge from corner k to corner k + 1.
    across: [u32; 3],
    normal: Vec3,
    offset: f64,
    /// Heights below this are rounding, or, where it is large, decided exactly.
    doubt: f64,
    /// Points above this face and no earlier one, the farthest last.
    above: Vec<u32>,
    farthest: f64,
    alive: bool,
    /// Number of the step that last saw it.
    visited: u32,
}

impl Face {
    fn height(&self, p: &Vec3) -> f64 {
        self.normal.dot(p) - self.offset
    }

    /// Whether a point is above the face or, where that counts, in its plane.
    fn seen_from(&self, points: &[Vec3], p: &Vec3, coplanar: bool) -> bool {
        let height = self.height(p);
        if height.abs() > self.doubt {
            return height > 0.0;
        }
        if coplanar { self.doubt <= IN_PLANE || self.side(points, p) >= 0.0 } else { self.side(points, p) > 0.0 }
    }

    /// Positive above the face, negative below, 0 in its plane, exactly.
    fn side(&self, points: &[Vec3], p: &Vec3) -> f64 {
        let coord = |p: &Vec3| Coord3D { x: p.x, y: p.y, z: p.z };
        let [a, b, c] = self.corners.map(|i| coord(&points[i as usize]));
        -orient3d(a, b, c, coord(p))
    }

    fn take(&mut self, point: u32, height: f64) {
        self.above.push(point);
        if height > self.farthest {
            self.farthest = height;
        } else {
            let last = self.above.len() - 1;
            self.above.swap(last - 1, last);
        }
    }
}

fn face(points: &[Vec3], corners: [u32; 3]) -> Face {
    let [a, b, c] = corners.map(|i| points[i as usize]);
    let (ab, ac) = (b - a, c - a);
    let cross = ab.cross(&ac);
    let size = cross.norm();
    let normal = if size > 0.0 { cross / size } else { Vec3::zeros() };
    let offset = normal.dot(&(a + b + c)) / 3.0;
    let doubt =
        if size > 0.0 { (HEIGHT_ERROR * (1.0 + ab.norm() * ac.norm() / size)).max(IN_PLANE) } else { f64::INFINITY };
    Face {
        corners,
        across: [NONE; 3],
        normal,
        offset,
        doubt,
        above: Vec::new(),
        farthest: f64::NEG_INFINITY,
        alive: true,
        visited: NONE,
    }
}

/// Return the outward triangles of the hull, starting from the tetrahedron of four of the points.
///
/// With `coplanar`, a point sees the faces in whose planes it lies, which leaves fewer and better faces but can give a
/// horizon that touches itself. None when the surface is not closed or not convex.
#[must_use]
pub fn quickhull(points: &[Vec3], tetrahedron: [usize; 4], coplanar: bool) -> Option<Vec<[u32; 3]>> {
    let mut faces = first_faces(points, tetrahedron)?;
    for (i, p) in points.iter().enumerate() {
        assign(points, &mut faces, 0, i as u32, p);
    }
    let mut pending: Vec<u32> = (0..4).collect();
    // The new face that starts at a corner of the horizon.
    let mut starting: Vec<u32> = vec![NONE; points.len()];
    let (mut visible, mut horizon) = (Vec::new(), Vec::new());
    let mut step = 0;
    while let Some(index) = pending.pop() {
        if !faces[index as usize].alive {
            continue;
        }
        let Some(&eye) = faces[index as usize].above.last() else { continue };
        let place = points[eye as usize];

        // Flood from the face over its neighbours, as far as the eye is above them.
        visible.clear();
        horizon.clear();
        visible.push(index);
        faces[index as usize].visited = step;
        let mut next = 0;
        while next < visible.len() {
            let here = visible[next];
            next += 1;
            for k in 0..3 {
                let other = faces[here as usize].across[k];
                let beyond = &mut faces[other as usize];
                if beyond.visited != step && beyond.seen_from(points, &place, coplanar) {
                    beyond.visited = step;
                    visible.push(other);
                }
            }
        }
        for &here in &visible {
            let seen = &faces[here as usize];
            for k in 0..3 {
                if faces[seen.across[k] as usize].visited != step {
                    horizon.push((seen.corners[k], seen.corners[(k + 1) % 3], seen.across[k]));
                }
            }
        }
        step += 1;

        let first = faces.len() as u32;
        for &(a, b, other) in &horizon {
            // A corner that is passed twice belongs to a horizon that is not one loop.
            if starting[a as usize] != NONE {
                return None;
            }
            let index = faces.len() as u32;
            starting[a as usize] = index;
            let mut new = face(points, [a, b, eye]);
            new.across[0] = other;
            faces.push(new);
            let edge = faces[other as usize].corners.iter().position(|&c| c == b)?;
            faces[other as usize].across[edge] = index;
        }
        for (i, &(_, b, _)) in horizon.iter().enumerate() {
            let after = starting[b as usize];
            if after == NONE {
                return None;
            }
            faces[first as usize + i].across[1] = after;
            faces[after as usize].across[2] = first + i as u32;
        }
        for &(a, _, _) in &horizon {
            starting[a as usize] = NONE;
        }
        for &here in &visible {
            faces[here as usize].alive = false;
            for point in std::mem::take(&mut faces[here as usize].above) {
                if point != eye {
                    assign(points, &mut faces, first as usize, point, &points[point as usize]);
                }
            }
        }
        pending.extend(first..faces.len() as u32);
    }
    convex_faces(points, &faces)
}

fn first_faces(points: &[Vec3], [a, b, c, d]: [usize; 4]) -> Option<Vec<Face>> {
    let volume = (points[b] - points[a]).cross(&(points[c] - points[a])).dot(&(points[d] - points[a]));
    if volume.abs() < FLAT {
        return None;
    }
    // The fourth corner below the first face.
    let (b, c) = if volume > 0.0 { (c, b) } else { (b, c) };
    let [a, b, c, d] = [a, b, c, d].map(|i| i as u32);
    let mut faces: Vec<Face> =
        [[a, b, c], [b, a, d], [c, b, d], [a, c, d]].into_iter().map(|k| face(points, k)).collect();
    for (f, across) in faces.iter_mut().zip([[1, 2, 3], [0, 3, 2], [0, 1, 3], [0, 2, 1]]) {
        f.across = across;
    }
    Some(faces)
}

/// Give a point to the first face from `first` on that it is above, by more than what flat sides vary by.
fn assign(points: &[Vec3], faces: &mut [Face], first: usize, point: u32, place: &Vec3) {
    for f in &mut faces[first..] {
        let height = f.height(place);
        // Heights above slivers are doubtful, however large.
        if height > ON_FACE.max(f.doubt) || (f.doubt > ON_FACE && height > -f.doubt && f.side(points, place) > 0.0) {
            f.take(point, height.max(0.0));
            return;
        }
    }
}

/// Return the faces that are left, if none of their neighbours rises above them.
fn convex_faces(points: &[Vec3], faces: &[Face]) -> Option<Vec<[u32; 3]>> {
    let mut found = Vec::new();
    for f in faces.iter().filter(|f| f.alive) {
        for other in f.across {
            let beyond = faces.get(other as usize).filter(|o| o.alive)?;
            let rises = |c: &u32| !f.corners.contains(c) && f.height(&points[*c as usize]) > CONVEX.max(f.doubt);
            if beyond.corners.iter().any(rises) {
                return None;
            }
        }
        found.push(f.corners);
    }
    Some(found)
}
