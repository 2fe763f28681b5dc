//! Speed of the mesh: construction, the sweep of every simulation step, verification.

use std::{hint::black_box, time::Duration};

use bevy_tectonics::mesh::{SphereMesh, hilbert_order};
use criterion::{BatchSize, Criterion, Throughput, criterion_group, criterion_main};
use glam::DVec3;

const SIZES: [usize; 3] = [10_000, 100_000, 500_000];

/// A Fibonacci spiral along the Hilbert curve, jittered so that no two runs of sites are alike.
fn sites(count: usize) -> Vec<DVec3> {
    const GOLDEN_ANGLE: f64 = 2.399_963_229_728_653;
    let mut state = 1_u64;
    let mut noise = || {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
    };
    let spacing = (4.0 * std::f64::consts::PI / count as f64).sqrt();
    let points: Vec<DVec3> = (0..count)
        .map(|i| {
            let z = 1.0 - (2 * i + 1) as f64 / count as f64;
            let (sin, cos) = libm::sincos(GOLDEN_ANGLE * i as f64);
            let ring = (1.0 - z * z).sqrt();
            let jitter = 0.5 * spacing * DVec3::new(noise(), noise(), noise());
            (DVec3::new(ring * cos, ring * sin, z) + jitter).normalize()
        })
        .collect();
    hilbert_order(&points)
        .into_iter()
        .map(|i| points[i as usize])
        .collect()
}

fn mesh(criterion: &mut Criterion) {
    for count in SIZES {
        let sites = sites(count);
        let mut group = criterion.benchmark_group(format!("mesh/{count}"));
        group
            .sample_size(10)
            .measurement_time(Duration::from_secs(3));

        group.throughput(Throughput::Elements(count as u64));
        group.bench_function("build", |bencher| {
            bencher.iter_batched(
                || sites.clone(),
                |sites| SphereMesh::<()>::build(sites).unwrap(),
                BatchSize::PerIteration,
            );
        });

        // Per edge from here on.
        let mut mesh = SphereMesh::<()>::build(sites).unwrap();
        group.throughput(Throughput::Elements(mesh.edge_count() as u64));
        group.bench_function("repair_delaunay", |bencher| {
            bencher.iter(|| black_box(&mut mesh).repair_delaunay().unwrap());
        });
        group.bench_function("slivers", |bencher| {
            bencher.iter(|| black_box(&mesh).slivers(0.04))
        });
        group.bench_function("check", |bencher| {
            bencher.iter(|| black_box(&mesh).check().unwrap())
        });
        group.finish();
    }
}

criterion_group!(benches, mesh);
criterion_main!(benches);
