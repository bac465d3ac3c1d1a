//! Known solids, measured and cut.

#![allow(clippy::unwrap_used)]

use super::elements::{Elements, Repairs};
use super::voxels::Voxels;
use super::{Levels, segment_mesh};
use crate::geometry::{Vec3, minimal_box, points_of};

/// Vertices and faces of a box, each side cut into `cells` by `cells` squares; without the top when `open`.
fn crate_mesh(low: [f64; 3], high: [f64; 3], cells: usize, open: bool) -> (Vec<f64>, Vec<i64>) {
    let (mut vertices, mut faces) = (Vec::new(), Vec::new());
    for side in 0..6 {
        let (axis, top) = (side / 2, side % 2 == 1);
        if open && axis == 2 && top {
            continue;
        }
        let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
        let start = vertices.len() as i64 / 3;
        for i in 0..=cells {
            for j in 0..=cells {
                let mut p = [0.0; 3];
                p[axis] = if top { high[axis] } else { low[axis] };
                p[u] = low[u] + (high[u] - low[u]) * i as f64 / cells as f64;
                p[v] = low[v] + (high[v] - low[v]) * j as f64 / cells as f64;
                vertices.extend(p);
            }
        }
        let row = cells as i64 + 1;
        for i in 0..cells as i64 {
            for j in 0..cells as i64 {
                let (a, b, c, d) = (i * row + j, (i + 1) * row + j, (i + 1) * row + j + 1, i * row + j + 1);
                let two = if top { [a, b, c, a, c, d] } else { [a, c, b, a, d, c] };
                faces.extend(two.map(|n| start + n));
            }
        }
    }
    (vertices, faces)
}

fn gridded(vertices: &[f64], faces: &[i64]) -> (Elements, Voxels) {
    let points = points_of(vertices);
    let triangles: Vec<[usize; 3]> = faces.chunks_exact(3).map(|f| [f[0], f[1], f[2]].map(|v| v as usize)).collect();
    let bounds = minimal_box(&points);
    let elements = Elements::of_mesh(&points, &triangles, bounds.diagonal(), &mut Repairs::default());
    let grid = Voxels::of(&elements, &bounds, 0.0);
    (elements, grid)
}

#[test]
fn the_inside_of_a_closed_box_is_filled_and_its_outside_is_not() {
    let (vertices, faces) = crate_mesh([0.0; 3], [1.0, 2.0, 3.0], 4, false);
    let (_, grid) = gridded(&vertices, &faces);
    let middle = Vec3::new(0.5, 1.0, 1.5);
    assert!(grid.filled(&middle) && !grid.in_cavity(&middle));
    assert!(!grid.filled(&Vec3::new(1.1, 1.0, 1.5)));
}

#[test]
fn an_open_box_is_a_cavity_but_the_hole_of_a_frame_is_not() {
    let (vertices, faces) = crate_mesh([0.0; 3], [1.0, 1.0, 1.0], 4, true);
    let (_, grid) = gridded(&vertices, &faces);
    assert!(grid.in_cavity(&Vec3::new(0.5, 0.5, 0.4)));
    assert!(!grid.filled(&Vec3::new(0.5, 0.5, 1.1)));

    // Four beams around a square hole.
    let (mut vertices, mut faces) = (Vec::new(), Vec::new());
    for (low, high) in [
        ([0.0, 0.0, 0.0], [1.0, 0.1, 0.1]),
        ([0.0, 0.9, 0.0], [1.0, 1.0, 0.1]),
        ([0.0, 0.0, 0.0], [0.1, 1.0, 0.1]),
        ([0.9, 0.0, 0.0], [1.0, 1.0, 0.1]),
    ] {
        let (more, triangles) = crate_mesh(low, high, 4, false);
        let start = vertices.len() as i64 / 3;
        vertices.extend(more);
        faces.extend(triangles.iter().map(|n| n + start));
    }
    let (_, grid) = gridded(&vertices, &faces);
    assert!(!grid.filled(&Vec3::new(0.5, 0.5, 0.05)));
}

#[test]
fn a_plate_is_as_thick_as_it_is() {
    let (vertices, faces) = crate_mesh([0.0; 3], [1.0, 1.0, 0.2], 8, false);
    let (elements, grid) = gridded(&vertices, &faces);
    let middle = (0..elements.len())
        .filter(|&i| elements.normals[i].z > 0.9 && (elements.centers[i] - Vec3::new(0.5, 0.5, 0.2)).norm() < 0.3);
    for i in middle {
        let found = super::measure::thickness(&elements, i, &grid);
        // Rays of a cone of 50 degrees are 1 to 1.56 times as long; trimmed, 1.08 to 1.35.
        assert!((0.2 * 1.0..0.2 * 1.45).contains(&found), "{found}");
    }
}

#[test]
fn normals_that_point_inwards_are_turned() {
    let (vertices, mut faces) = crate_mesh([0.0; 3], [1.0; 3], 4, false);
    for face in faces.chunks_exact_mut(3) {
        face.swap(0, 1);
    }
    let (mut elements, grid) = gridded(&vertices, &faces);
    assert_eq!(grid.turn_outward(&mut elements), elements.len());
    assert!((0..elements.len()).all(|i| elements.normals[i].dot(&(elements.centers[i] - Vec3::repeat(0.5))) > 0.0));
}

#[test]
fn a_box_is_one_part_and_as_many_as_asked() {
    let (vertices, faces) = crate_mesh([0.0; 3], [1.0, 1.2, 1.1], 8, false);
    let found = segment_mesh(&vertices, &faces, Levels::Chosen, 0).unwrap();
    assert!(found.levels[0].iter().all(|&l| l == 0));
    let three = segment_mesh(&vertices, &faces, Levels::Count(3), 0).unwrap();
    assert_eq!(three.levels[0].iter().max(), Some(&2));
}

#[test]
fn what_cannot_be_cut_is_an_error() {
    let (vertices, faces) = crate_mesh([0.0; 3], [1.0; 3], 4, false);
    assert!(segment_mesh(&vertices, &[], Levels::Chosen, 0).is_err());
    assert!(segment_mesh(&vertices, &faces, Levels::Count(0), 0).is_err());
    assert!(segment_mesh(&vertices, &[0, 1, 9999], Levels::Chosen, 0).is_err());
    assert!(segment_mesh(&[1.0; 9], &[0, 1, 2], Levels::Chosen, 0).is_err());
}
