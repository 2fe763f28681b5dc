//! Speed of queries on a surface of 40,000 sub-plates: places in no order, one core.

use std::{hint::black_box, ops::ControlFlow};

use bevy_tectonics::prelude::*;
use bevy_tectonics::surface::Relief;
use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use glam::DVec3;

const SUB_PLATES: u32 = 40_000;
/// Places asked for in turn: more than caches remember the way to.
const PLACES: usize = 1 << 16;

/// Unit vectors all over the sphere, independent of each other.
fn places() -> Vec<DVec3> {
    let mut state = 1_u64;
    let mut noise = || {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1_u64 << 53) as f64
    };
    let mut place = || {
        let z = 2.0 * noise() - 1.0;
        let (sin, cos) = libm::sincos(std::f64::consts::TAU * noise());
        let ring = (1.0 - z * z).sqrt();
        DVec3::new(ring * cos, ring * sin, z)
    };
    (0..PLACES).map(|_| place()).collect()
}

fn surface() -> Surface {
    let mut history = History::new(Recipe::earth_like(1).with_sub_plates(SUB_PLATES)).unwrap();
    history
        .run_until(2.0, |_| ControlFlow::Continue(()))
        .unwrap();
    history.surface().unwrap()
}

fn queries(criterion: &mut Criterion) {
    let (surface, places) = (surface(), places());
    surface.prepare();
    let mut group = criterion.benchmark_group(format!("queries/{SUB_PLATES}"));
    group.throughput(Throughput::Elements(1)).sample_size(30);
    let mut round = places.iter().cycle().copied();
    let mut next = move || round.next().unwrap_or(DVec3::Z);

    group.bench_function("elevation", |bencher| {
        bencher.iter(|| surface.elevation(black_box(next())));
    });
    group.bench_function("at", |bencher| {
        bencher.iter(|| surface.at(black_box(next())));
    });
    group.bench_function("nearest_boundary", |bencher| {
        bencher.iter(|| surface.nearest_boundary(black_box(next())));
    });
    #[cfg(feature = "terrain")]
    {
        use bevy_tectonics::surface::Terrain;
        // Rows of 100 places, 100 m apart.
        let tile = |i: usize| {
            let corner = places[i / 10_000 % PLACES];
            let (east, north) = bevy_tectonics::surface::east_north(corner);
            let [x, y] = [i % 100, i / 100 % 100].map(|i| i as f64 * 0.1 / surface.radius_km);
            corner + east * x + north * y
        };
        let mut terrain = Terrain::new(&surface, 100.0).unwrap();
        let mut i = 0;
        group.bench_function("terrain of tiles", |bencher| {
            bencher.iter(|| {
                i += 1;
                terrain.elevation(black_box(tile(i)))
            });
        });
    }
    let drawn = Relief::exaggerated(20.0).with_sea();
    group.bench_function("ray", |bencher| {
        bencher.iter(|| {
            let origin = next() * 3.0;
            surface.ray(black_box(origin), next() - origin, drawn)
        });
    });
    group.bench_function("patch, per sample", |bencher| {
        bencher.iter_custom(|count| {
            let start = std::time::Instant::now();
            for _ in 0..count.div_ceil(65 * 65) {
                black_box(surface.patch(next(), 100.0, 65));
            }
            start
                .elapsed()
                .mul_f64(count as f64 / (count.div_ceil(65 * 65) * 65 * 65) as f64)
        });
    });
    group.bench_function("prepare", |bencher| {
        bencher.iter_batched(
            || surface.clone(),
            |surface| surface.prepare(),
            criterion::BatchSize::PerIteration,
        );
    });
    group.finish();
}

criterion_group!(benches, queries);
criterion_main!(benches);
