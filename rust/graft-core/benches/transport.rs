//! Batches of n x n pairs in lanes, in double and in single precision; one pair by the scalar solver.
#![allow(missing_docs, clippy::unwrap_used)]

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use graft_core::transport::batch::{Precision, Run, solve_batch};
use graft_core::transport::lanes::dispatch::instructions;
use graft_core::transport::{Entropy, Input, Loss, Options, solve};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

fn options(tol: f64) -> Options {
    Options {
        alpha: 0.5,
        tau_s: 1.0,
        tau_t: 1.0,
        eps: 0.05,
        loss: Loss::Square,
        entropy: Entropy::Relative,
        em_rate: Some(0.4),
        tol,
        max_outer: 200,
    }
}

/// Edge lengths of random points, as benches/transport.py has them.
fn lengths(random: &mut Pcg64, n: usize) -> Vec<f64> {
    let points: Vec<[f64; 3]> = (0..n).map(|_| [random.random(), random.random(), random.random()]).collect();
    let length = |a: &[f64; 3], b: &[f64; 3]| {
        let x = a.iter().zip(b).map(|(p, q): (&f64, &f64)| (p - q) * (p - q)).sum::<f64>().sqrt();
        x / (1.0 + x)
    };
    points.iter().flat_map(|a| points.iter().map(move |b| length(a, b))).collect()
}

fn masses(random: &mut Pcg64, n: usize) -> Vec<f64> {
    let x: Vec<f64> = (0..n).map(|_| 0.1 + random.random::<f64>()).collect();
    let total: f64 = x.iter().sum();
    x.iter().map(|x| x / total).collect()
}

fn transport(c: &mut Criterion) {
    for n in [3_usize, 6, 10, 20] {
        let mut random = Pcg64::seed_from_u64(n as u64);
        let data: Vec<[Vec<f64>; 5]> = (0..512)
            .map(|_| {
                let features: Vec<f64> = (0..n * n).map(|_| random.random()).collect();
                let (a, b) = (lengths(&mut random, n), lengths(&mut random, n));
                [features, a, b, masses(&mut random, n), masses(&mut random, n)]
            })
            .collect();
        let inputs: Vec<Input> = data
            .iter()
            .map(|[features, source, target, source_mass, target_mass]| Input {
                features,
                source,
                target,
                source_mass,
                target_mass,
                prior: None,
                start: None,
                start_potential: None,
            })
            .collect();
        let mut group = c.benchmark_group("ufgw");
        group.throughput(Throughput::Elements(inputs.len() as u64));
        for (name, precision, tol) in [("f64", Precision::F64, 1e-6), ("f32", Precision::F32, 1e-5)] {
            let run = Run { threads: 1, precision, history: false, instructions: instructions() };
            group.bench_function(BenchmarkId::new(name, n), |b| {
                b.iter(|| solve_batch(&inputs, &options(tol), &run).unwrap().len());
            });
        }
        group.throughput(Throughput::Elements(1));
        group.bench_function(BenchmarkId::new("scalar", n), |b| {
            b.iter(|| solve(&inputs[0], &options(1e-6)).unwrap().terms.objective());
        });
        group.finish();
    }
}

criterion_group!(benches, transport);
criterion_main!(benches);
