//! Hulls and minimal boxes of point sets of different roundness.

use std::hint::black_box;

use criterion::{Criterion, criterion_group, criterion_main};
use graft_core::geometry::{Vec3, convex_hull, minimal_box};

/// Points spread evenly over an ellipsoid, every one a corner of its hull.
fn ellipsoid(count: usize) -> Vec<Vec3> {
    (0..count)
        .map(|i| {
            let z = 1.0 - 2.0 * (i as f64 + 0.5) / count as f64;
            let (s, c) = (2.399_963 * i as f64).sin_cos();
            let r = (1.0 - z * z).sqrt();
            Vec3::new(r * c, 0.6 * r * s, 0.3 * z)
        })
        .collect()
}

/// A tube's wall: rings of points, few of them corners.
fn tube(rings: usize) -> Vec<Vec3> {
    (0..rings * 48)
        .map(|i| {
            let (s, c) = ((i % 48) as f64 * std::f64::consts::TAU / 48.0).sin_cos();
            let bend = (i / 48) as f64 / rings as f64 * 2.0;
            let r = 1.0 + 0.1 * c;
            Vec3::new(r * bend.cos(), r * bend.sin(), 0.1 * s)
        })
        .collect()
}

fn geometry(c: &mut Criterion) {
    for (name, points) in [("ellipsoid_500", ellipsoid(500)), ("ellipsoid_3000", ellipsoid(3000)), ("tube", tube(60))] {
        c.bench_function(&format!("convex_hull/{name}"), |b| b.iter(|| convex_hull(black_box(&points))));
        c.bench_function(&format!("minimal_box/{name}"), |b| b.iter(|| minimal_box(black_box(&points))));
    }
}

criterion_group!(benches, geometry);
criterion_main!(benches);
