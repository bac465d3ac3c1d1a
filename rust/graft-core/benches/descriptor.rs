//! The part descriptor, whole and by family.

#![allow(clippy::cast_possible_wrap)]

use std::hint::black_box;

use criterion::{Criterion, criterion_group, criterion_main};
use graft_core::descriptor::{Family, Options, Parts, describe};

/// A wavy tube of `rings` rings of 48 corners.
fn tube(rings: i64) -> (Vec<[f64; 3]>, Vec<[i64; 3]>) {
    let vertices = (0..rings * 48).map(|i| {
        let (s, c) = ((i % 48) as f64 * std::f64::consts::TAU / 48.0).sin_cos();
        let along = (i / 48) as f64 / rings as f64 * 3.0;
        let radius = 0.2 + 0.05 * (5.0 * along).sin();
        [radius * c, radius * s + along * along / 4.0, along]
    });
    let faces = (0..(rings - 1) * 48).flat_map(|i| {
        let beside = i / 48 * 48 + (i + 1) % 48;
        [[i, beside, beside + 48], [i, beside + 48, i + 48]]
    });
    (vertices.collect(), faces.collect())
}

fn descriptor(c: &mut Criterion) {
    let (vertices, faces) = tube(64);
    let parts = Parts {
        vertices: &vertices,
        faces: &faces,
        vertex_offsets: &[0, vertices.len() as i64],
        face_offsets: &[0, faces.len() as i64],
    };
    let mut run = |name: &str, families: Vec<Family>| {
        let options = Options { families, samples: 1024, seed: 0 };
        c.bench_function(&format!("describe/{name}"), |b| b.iter(|| describe(black_box(parts), &options)));
    };
    for family in Family::ALL {
        run(family.name(), vec![family]);
    }
    run("all", Family::ALL.to_vec());
}

criterion_group!(benches, descriptor);
criterion_main!(benches);
