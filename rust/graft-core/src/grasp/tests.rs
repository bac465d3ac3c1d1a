//! Collisions against slower, plainer ways of asking the same.

#![allow(clippy::unwrap_used)]

use nalgebra::{Matrix3, Rotation3};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

use super::{Collider, HalfSpace, Hand, Pose, meets_ball, meets_triangle, swept};
use crate::geometry::{OrientedBox, Vec3};

fn cube(center: Vec3, half: f64) -> OrientedBox {
    OrientedBox { center, axes: [Vec3::x(), Vec3::y(), Vec3::z()], half_extents: [half; 3] }
}

fn vector(rng: &mut Pcg64, reach: f64) -> Vec3 {
    Vec3::new(rng.random_range(-reach..reach), rng.random_range(-reach..reach), rng.random_range(-reach..reach))
}

fn rotation(rng: &mut Pcg64) -> Matrix3<f64> {
    Rotation3::new(vector(rng, 3.0)).into_inner()
}

fn any_box(rng: &mut Pcg64, reach: f64) -> OrientedBox {
    let turn = rotation(rng);
    OrientedBox {
        center: vector(rng, reach),
        axes: [0, 1, 2].map(|k| turn.column(k).into_owned()),
        half_extents: [0, 1, 2].map(|_| rng.random_range(0.01..0.4)),
    }
}

/// Clip the triangle by the box's six planes; something left means that they meet.
fn clipped_is_left(given: &OrientedBox, corners: &[Vec3; 3]) -> bool {
    let mut polygon: Vec<Vec3> = corners.to_vec();
    for k in 0..3 {
        for side in [1.0, -1.0] {
            let height = |p: &Vec3| given.half_extents[k] - side * given.axes[k].dot(&(p - given.center));
            let mut kept = Vec::new();
            for i in 0..polygon.len() {
                let (p, q) = (polygon[i], polygon[(i + 1) % polygon.len()]);
                let (a, b) = (height(&p), height(&q));
                if a >= 0.0 {
                    kept.push(p);
                }
                if (a > 0.0 && b < 0.0) || (a < 0.0 && b > 0.0) {
                    kept.push(p + (q - p) * (a / (a - b)));
                }
            }
            polygon = kept;
        }
    }
    !polygon.is_empty()
}

#[test]
fn separating_axes_agree_with_clipping() {
    let mut rng = Pcg64::seed_from_u64(1);
    let mut met = 0;
    for _ in 0..20_000 {
        let given = any_box(&mut rng, 0.3);
        let corners = [0, 1, 2].map(|_| vector(&mut rng, 1.0));
        let expected = clipped_is_left(&given, &corners);
        assert_eq!(meets_triangle(&given, &corners), expected, "{given:?} {corners:?}");
        met += usize::from(expected);
    }
    assert!((4_000..16_000).contains(&met), "{met} of 20,000 meet: the sample tells nothing");
}

#[test]
fn degenerate_triangles_are_segments_and_points() {
    let given = cube(Vec3::zeros(), 1.0);
    let (through, beside) = (Vec3::new(3.0, 0.9, 0.0), Vec3::new(3.0, 1.1, 0.0));
    let back = |p: Vec3| Vec3::new(-3.0, p.y, p.z);
    assert!(meets_triangle(&given, &[through, back(through), through]));
    assert!(!meets_triangle(&given, &[beside, back(beside), beside]));
    assert!(meets_triangle(&given, &[Vec3::new(1.0, 1.0, 1.0); 3]), "touching at a corner");
    assert!(!meets_triangle(&given, &[Vec3::new(1.0, 1.0, 1.0 + 1e-12); 3]));
    // A diagonal segment past an edge of the box, which only a product of edges separates.
    assert!(!meets_triangle(
        &given,
        &[Vec3::new(0.0, 2.01, 0.0), Vec3::new(2.01, 0.0, 0.0), Vec3::new(2.01, 0.0, 0.0)]
    ));
}

#[test]
fn balls_meet_corners_by_distance() {
    let given = cube(Vec3::zeros(), 1.0);
    let beyond = Vec3::new(2.0, 2.0, 2.0);
    assert!(meets_ball(&given, &beyond, 3.0_f64.sqrt() + 1e-12));
    assert!(!meets_ball(&given, &beyond, 3.0_f64.sqrt() - 1e-12));
    assert!(meets_ball(&given, &Vec3::zeros(), 0.0));
}

#[test]
fn the_tree_loses_nothing() {
    let mut rng = Pcg64::seed_from_u64(2);
    for count in [0, 1, 3, 4, 5, 9, 17, 250, 1_001] {
        // Far from the origin, where single precision is coarse.
        let away = vector(&mut rng, 50.0);
        let vertices: Vec<Vec3> = (0..count)
            .flat_map(|_| {
                let near = vector(&mut rng, 1.0) + away;
                [near, near + vector(&mut rng, 0.05), near + vector(&mut rng, 0.05)]
            })
            .collect();
        let faces: Vec<[usize; 3]> = (0..count).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
        let balls: Vec<(Vec3, f64)> = (0..count / 3).map(|_| (vector(&mut rng, 1.0) + away, 0.02)).collect();
        let collider = Collider::with_balls(&vertices, &faces, &balls);
        let pose = Pose { rotation: rotation(&mut rng), translation: away };
        for _ in 0..300 {
            let given = any_box(&mut rng, 1.0);
            let placed = pose.place(&given);
            let expected = faces.iter().any(|face| meets_triangle(&placed, &face.map(|v| vertices[v])))
                || balls.iter().any(|(center, radius)| meets_ball(&placed, center, *radius));
            assert_eq!(collider.collides(&[given], &pose), expected);
        }
    }
}

/// A closed cube, wound outward.
fn shell(half: f64) -> (Vec<Vec3>, Vec<[usize; 3]>) {
    let corner = |i: usize| Vec3::new((i & 1) as f64, (i >> 1 & 1) as f64, (i >> 2) as f64) * 2.0 - Vec3::repeat(1.0);
    let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let faces = quads.iter().flat_map(|q| [[q[0], q[1], q[2]], [q[0], q[2], q[3]]]).collect();
    ((0..8).map(|i| corner(i) * half).collect(), faces)
}

#[test]
fn inside_counts_only_where_asked() {
    let (vertices, faces) = shell(1.0);
    let surface = Collider::new(&vertices, &faces);
    let small = [cube(Vec3::zeros(), 0.1)];
    assert!(!surface.collides(&small, &Pose::identity()));
    assert!(surface.collides_within(&small, &Pose::identity(), 0.9));
    assert!(!surface.collides_within(&small, &Pose::identity(), 0.89));
    let solid = surface.solid();
    assert!(solid.collides(&small, &Pose::identity()));
    let away = Pose { rotation: Matrix3::identity(), translation: Vec3::new(0.0, 1.5, 0.0) };
    assert!(!solid.collides(&small, &away));
}

#[test]
fn overlapping_closed_parts_stay_solid() {
    let (mut vertices, mut faces) = shell(1.0);
    let moved: Vec<Vec3> = vertices.iter().map(|v| v + Vec3::new(0.5, 0.3, 0.2)).collect();
    faces.extend(faces.clone().iter().map(|face| face.map(|v| v + 8)));
    vertices.extend(moved);
    let solid = Collider::new(&vertices, &faces);
    assert!(solid.contains(&Vec3::new(0.25, 0.1, 0.1)), "inside both");
    assert!(solid.contains(&Vec3::new(1.3, 0.1, 0.1)), "inside one");
    assert!(!solid.contains(&Vec3::new(1.3, -0.9, 0.1)));
}

#[test]
fn lines_cross_every_wall_in_order() {
    let (vertices, faces) = shell(1.0);
    let collider = Collider::new(&vertices, &faces);
    let mut hits = Vec::new();
    let from = Vec3::new(-3.0, 0.3, 0.2);
    collider.crossings(&from, &Vec3::x(), 10.0, &mut hits);
    let distances: Vec<f64> = hits.iter().map(|hit| hit.0).collect();
    assert_eq!(distances, [2.0, 4.0]);
    collider.crossings(&from, &Vec3::x(), 3.0, &mut hits);
    assert_eq!(hits.len(), 1);
    collider.crossings(&from, &-Vec3::x(), 10.0, &mut hits);
    assert!(hits.is_empty());
}

#[test]
fn fingers_mirror_and_open() {
    let part = OrientedBox { center: Vec3::new(0.0, 0.1, 0.5), ..any_box(&mut Pcg64::seed_from_u64(3), 0.1) };
    let hand = Hand { palm: vec![cube(-Vec3::z(), 0.2)], finger: vec![part] };
    let boxes: Vec<OrientedBox> = hand.boxes(0.6).collect();
    assert_eq!(boxes.len(), hand.len());
    assert!((boxes[0].center.y - 0.4).abs() < 1e-12 && (boxes[1].center.y + 0.4).abs() < 1e-12);
    let signs = [-1.0, 1.0];
    let corners = |b: &OrientedBox| -> Vec<Vec3> {
        (0..8)
            .map(|i| (0..3).fold(b.center, |sum, k| sum + b.axes[k] * (b.half_extents[k] * signs[i >> k & 1])))
            .collect()
    };
    for corner in corners(&boxes[0]) {
        let reflected = Vec3::new(corner.x, -corner.y, corner.z);
        assert!(corners(&boxes[1]).iter().any(|other| (other - reflected).norm() < 1e-12));
    }
    let turn = Matrix3::from_columns(&boxes[1].axes);
    assert!((turn.determinant() - 1.0).abs() < 1e-12, "right-handed");
}

#[test]
fn sweeps_hold_every_place_on_the_way() {
    let mut rng = Pcg64::seed_from_u64(4);
    for _ in 0..50 {
        let (moving, by) = (any_box(&mut rng, 0.5), vector(&mut rng, 1.0));
        let whole = swept(&moving, &by);
        for step in 0..=10 {
            let center = moving.center + by * (f64::from(step) / 10.0);
            for k in 0..3 {
                let offset = (center - whole.center).dot(&whole.axes[k]).abs();
                assert!(offset + moving.half_extents[k] <= whole.half_extents[k] + 1e-12);
            }
        }
    }
}

#[test]
fn the_lowest_corner_decides_above_a_plane() {
    let plane = HalfSpace { normal: Vec3::z(), offset: 0.5 };
    let turned = Pose {
        rotation: Rotation3::from_axis_angle(&Vec3::x_axis(), std::f64::consts::FRAC_PI_4).into_inner(),
        translation: Vec3::new(0.0, 0.0, 2.0),
    };
    let clearance = plane.clearance(&turned.place(&cube(Vec3::zeros(), 1.0)));
    assert!((clearance - (1.5 - 2.0_f64.sqrt())).abs() < 1e-12);
}
