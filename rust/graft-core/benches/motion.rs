//! RRT-Connect for a hand of boxes around a tube, and for the tree it plans with.
#![allow(missing_docs)]

use std::f64::consts::TAU;
use std::hint::black_box;

use criterion::{Criterion, criterion_group, criterion_main};
use graft_core::geometry::{OrientedBox, Vec3};
use graft_core::grasp::{Collider, HalfSpace};
use graft_core::motion::{Hand, Obstacles, Options, Pose, plan, reach};
use nalgebra::UnitQuaternion;

/// An upright tube, 8 cm wide and 10 cm high, of `rings` rings of 96 corners.
fn tube(rings: usize) -> (Vec<Vec3>, Vec<[usize; 3]>) {
    let corner = |i: usize| {
        let (s, c) = ((i % 96) as f64 * TAU / 96.0).sin_cos();
        Vec3::new(0.04 * c, 0.04 * s, 0.1 * (i / 96) as f64 / rings as f64)
    };
    let faces = (0..(rings - 1) * 96).flat_map(|i| {
        let beside = i / 96 * 96 + (i + 1) % 96;
        [[i, beside, beside + 96], [i, beside + 96, i + 96]]
    });
    ((0..rings * 96).map(corner).collect(), faces.collect())
}

/// A palm and two fingers of about a Panda's size.
fn hand() -> Vec<OrientedBox> {
    let part = |center: [f64; 3], half_extents: [f64; 3]| OrientedBox {
        center: Vec3::from(center),
        axes: [Vec3::x(), Vec3::y(), Vec3::z()],
        half_extents,
    };
    vec![
        part([0.0, 0.0, -0.07], [0.032, 0.103, 0.033]),
        part([0.0, 0.048, -0.015], [0.01, 0.008, 0.024]),
        part([0.0, -0.048, -0.015], [0.01, 0.008, 0.024]),
    ]
}

fn motion(c: &mut Criterion) {
    let (vertices, faces) = tube(60);
    c.bench_function("obstacles/11k_faces", |b| b.iter(|| Collider::new(black_box(&vertices), &faces)));
    let support = Some(HalfSpace { normal: Vec3::z(), offset: 0.0 });
    let obstacles = Obstacles { object: Collider::new(&vertices, &faces), support };
    let boxes = hand();
    let down = UnitQuaternion::from_euler_angles(std::f64::consts::PI, 0.0, 0.0);
    let [start, goal] = [-0.15, 0.15].map(|y| Pose { position: Vec3::new(0.0, y, 0.05), rotation: down });
    let bounds = [Vec3::new(-0.3, -0.4, 0.0), Vec3::new(0.3, 0.4, 0.5)];
    let space = Hand { boxes: &boxes, obstacles: &obstacles, bounds, ends: [start, goal], radius: reach(&boxes) };
    let mut seed = 0;
    c.bench_function("plan/around_a_tube", |b| {
        b.iter(|| {
            seed += 1;
            let options = Options {
                clearance: 0.001,
                step: 0.2,
                goal_bias: 0.05,
                max_iterations: 5000,
                time_limit: None,
                shortcuts: 30,
                seed,
            };
            plan(&space, black_box(&start), &goal, &options)
        });
    });
}

criterion_group!(benches, motion);
criterion_main!(benches);
