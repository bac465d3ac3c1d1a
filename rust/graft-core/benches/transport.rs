//! One pair of n x n graphs, solved to the default tolerance with EM.
#![allow(missing_docs, clippy::unwrap_used)]

use criterion::{BenchmarkId, Criterion, criterion_group, criterion_main};
use graft_core::transport::{Entropy, Input, Loss, Options, solve};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

fn transport(c: &mut Criterion) {
    let options = Options {
        alpha: 0.5,
        tau_s: 1.0,
        tau_t: 1.0,
        eps: 0.05,
        loss: Loss::Square,
        entropy: Entropy::Relative,
        em_rate: Some(0.4),
        tol: 1e-6,
        max_outer: 200,
    };
    let mut group = c.benchmark_group("ufgw");
    for n in [3_usize, 6, 10, 20, 50] {
        let mut random = Pcg64::seed_from_u64(n as u64);
        let mut numbers = |len: usize| -> Vec<f64> { (0..len).map(|_| random.random()).collect() };
        let (features, source, target) = (numbers(n * n), numbers(n * n), numbers(n * n));
        let mass = vec![1.0 / n as f64; n];
        let input = Input {
            features: &features,
            source: &source,
            target: &target,
            source_mass: &mass,
            target_mass: &mass,
            prior: None,
            start: None,
        };
        group.bench_function(BenchmarkId::from_parameter(n), |b| {
            b.iter(|| solve(&input, &options).unwrap().terms.objective());
        });
    }
    group.finish();
}

criterion_group!(benches, transport);
criterion_main!(benches);
