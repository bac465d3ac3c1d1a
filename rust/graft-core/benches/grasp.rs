//! Colliders and grasps on a ring of 11,000 faces, as thick as a mug's handle.

use std::hint::black_box;

use criterion::{BatchSize, Criterion, criterion_group, criterion_main};
use graft_core::geometry::{OrientedBox, Vec3};
use graft_core::grasp::{Collider, Hand, Nearness, Pose, Request, Settings, TERMS, plan};
use nalgebra::Rotation3;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

const TUBE: f64 = 0.008;
const RING: f64 = 0.05;

/// A torus about z, wound outward.
fn ring(around: usize, across: usize) -> (Vec<Vec3>, Vec<[usize; 3]>) {
    let turn = |i: usize, n: usize| (i as f64 / n as f64 * std::f64::consts::TAU).sin_cos();
    let vertices = (0..around * across)
        .map(|i| {
            let ((s, c), (t, d)) = (turn(i / across, around), turn(i % across, across));
            Vec3::new((RING + TUBE * d) * c, (RING + TUBE * d) * s, TUBE * t)
        })
        .collect();
    let at = |i: usize, j: usize| (i % around) * across + j % across;
    let faces = (0..around * across)
        .flat_map(|k| {
            let (i, j) = (k / across, k % across);
            [[at(i, j), at(i + 1, j), at(i + 1, j + 1)], [at(i, j), at(i + 1, j + 1), at(i, j + 1)]]
        })
        .collect();
    (vertices, faces)
}

fn part(center: [f64; 3], half_extents: [f64; 3]) -> OrientedBox {
    OrientedBox { center: center.into(), axes: [Vec3::x(), Vec3::y(), Vec3::z()], half_extents }
}

/// The size of Franka's hand.
fn hand() -> Hand {
    Hand {
        palm: vec![part([0.0, 0.0, -0.0704], [0.0315, 0.1025, 0.033])],
        finger: vec![
            part([0.0, 0.0075, 0.0], [0.0088, 0.0075, 0.009]),
            part([0.0, 0.0105, -0.0232], [0.0105, 0.0075, 0.0142]),
        ],
    }
}

fn grasp(c: &mut Criterion) {
    let (vertices, faces) = ring(220, 25);
    let collider = Collider::new(&vertices, &faces);
    let hand = hand();
    let mut rng = Pcg64::seed_from_u64(0);
    let mut number = |reach: f64| rng.random_range(-reach..reach);
    let poses: Vec<Pose> = (0..1000)
        .map(|_| {
            let turn = Rotation3::new(Vec3::new(number(3.0), number(3.0), number(3.0)));
            let on = vertices[(number(1.0).abs() * vertices.len() as f64) as usize];
            let off = Vec3::new(number(0.04), number(0.04), number(0.04));
            Pose { rotation: turn.into_inner(), translation: on + off }
        })
        .collect();
    let hits = poses.iter().filter(|pose| collider.hand_collides(&hand, 0.04, pose, 0.0)).count();
    c.bench_function(&format!("collider/1000_poses_{hits}_hits"), |b| {
        b.iter(|| poses.iter().filter(|pose| collider.hand_collides(&hand, 0.04, black_box(pose), 0.0)).count());
    });
    c.bench_function("collider/build", |b| b.iter(|| Collider::new(black_box(&vertices), black_box(&faces))));
    let flat: Vec<f64> = vertices.iter().flat_map(|v| [v.x, v.y, v.z]).collect();
    let indices: Vec<i64> = faces.iter().flatten().map(|&v| v as i64).collect();
    let parts = vec![0_i64; faces.len()];
    let request = Request {
        vertices: &flat,
        faces: &indices,
        face_parts: &parts,
        hand,
        stroke: 0.08,
        contact: Some(Vec3::new(RING, 0.0, TUBE)),
        tolerance: 0.01,
        radius: 0.03,
        approach: None,
        part: None,
        support: None,
        up: None,
        weights: [1.0; TERMS],
        settings: Settings {
            samples: 192,
            rays: 4,
            pairs: 48,
            approaches: 12,
            depths: vec![0.0, -0.006, 0.006],
            cone: 0.5_f64.atan(),
            clearance: 0.005,
            margin: 0.001,
            travel: 0.08,
            nearness: Nearness { distance: 0.01, angle: 0.35 },
            count: 20,
            seed: 0,
        },
    };
    c.bench_function("plan/top_20_near_contact", |b| {
        b.iter_batched(|| request.clone(), |request| plan(black_box(&request)), BatchSize::SmallInput);
    });
}

criterion_group!(benches, grasp);
criterion_main!(benches);
