//! Terrain from a compute shader is that of the CPU, to 0.1 m.
//!
//! It is raised on whatever adapter there is. Where there is none, the tests say so and pass, unless
//! `BEVY_TECTONICS_REQUIRE_GPU` is set.
#![cfg(all(feature = "window", feature = "terrain"))]

#[expect(dead_code, reason = "each uses a part of it")]
mod studio;

use bevy::render::renderer::{RenderDevice, RenderQueue};
use bevy_tectonics::{
    prelude::*,
    render::{GpuTerrain, GpuTerrainError},
    simulation::{Crust, Surface},
    surface::{Exemplar, Exemplars, Landform, Terrain, east_north},
};
use core::ops::ControlFlow;
use glam::DVec3;
use std::{
    env,
    sync::{Arc, LazyLock},
    time::Instant,
};

/// What the two may differ by, in m.
const APART_M: f32 = 0.1;

fn grow(recipe: Recipe) -> Surface {
    let end = recipe.duration_my;
    let mut history = History::with_threads(recipe, 2).unwrap();
    let outcome = history.run_until(end, |_| ControlFlow::Continue(()));
    outcome.unwrap();
    history.surface().unwrap()
}

static PLANET: LazyLock<Surface> = LazyLock::new(|| {
    grow(
        Recipe::earth_like(11)
            .with_sub_plates(5000)
            .with_duration(150.0),
    )
});

static DEVICE: LazyLock<Option<(RenderDevice, RenderQueue)>> = LazyLock::new(find_device);

fn find_device() -> Option<(RenderDevice, RenderQueue)> {
    let app = studio::open()?;
    let world = app.world();
    let device = world.get_resource::<RenderDevice>()?.clone();
    Some((device, world.get_resource::<RenderQueue>()?.clone()))
}

fn gpu() -> Option<GpuTerrain> {
    if let Some((device, queue)) = &*DEVICE {
        return Some(GpuTerrain::new(device, queue));
    }
    assert!(
        env::var_os("BEVY_TECTONICS_REQUIRE_GPU").is_none(),
        "there is no adapter to compute with"
    );
    println!("skipped: there is no adapter to compute with");
    None
}

/// Places of every kind, as directions.
fn places(surface: &Surface) -> Vec<(&'static str, DVec3)> {
    let sites = surface.mesh.sites();
    let height = |v: usize| surface.elevation[v];
    let all = 0..sites.len();
    let by_height = |a: &usize, b: &usize| height(*a).total_cmp(&height(*b));
    let highest = all.clone().max_by(by_height).unwrap();
    let lowest = all.clone().min_by(by_height).unwrap();
    let nearest_to = |wanted: f32, crust: Crust| {
        let kind = all.clone().filter(|&v| surface.crust[v] == crust);
        let apart = |v: &usize| (height(*v) - wanted).abs();
        kind.min_by(|a, b| apart(a).total_cmp(&apart(b))).unwrap()
    };
    let youngest = all.clone().filter(|&v| surface.crust[v] == Crust::Oceanic);
    let youngest = youngest
        .min_by(|&a, &b| surface.age[a].total_cmp(&surface.age[b]))
        .unwrap();
    // Where land and sea floor meet, in the mesh as in the sampler.
    let mut terrain = Terrain::new(surface, 1000.0).unwrap();
    let mut coasts = Vec::new();
    for i in 0..100_000_u32 {
        let z = 1.0 - (2.0 * f64::from(i) + 1.0) / 100_000.0;
        let (sin, cos) = libm::sincos(f64::from(i) * 2.399_963_229_728_653);
        let place = DVec3::new((1.0 - z * z).sqrt() * cos, (1.0 - z * z).sqrt() * sin, z);
        if terrain.elevation(place).abs() < 2.0 {
            coasts.push(place);
        }
    }
    let coast = |i: usize| coasts[i * (coasts.len() - 1) / 4];
    vec![
        ("highest", sites[highest]),
        ("plain", sites[nearest_to(250.0, Crust::Continental)]),
        ("hills", sites[nearest_to(1200.0, Crust::Continental)]),
        ("shelf", sites[nearest_to(-120.0, Crust::Continental)]),
        ("coast", coast(0)),
        ("coast", coast(1)),
        ("coast", coast(2)),
        ("slope", sites[nearest_to(-1500.0, Crust::Continental)]),
        ("deep", sites[nearest_to(-5000.0, Crust::Oceanic)]),
        ("ridge", sites[youngest]),
        ("trench", sites[lowest]),
        ("north pole", DVec3::Z),
        ("south pole", DVec3::NEG_Z),
        ("equator", DVec3::X),
        ("antimeridian", DVec3::new(-1.0, 0.0, 0.3)),
    ]
}

/// A square of samples as far apart as the detail, as long as it fits, and places far and wide, at odd distances.
fn batches(surface: &Surface, centre: DVec3, detail_m: f64) -> [Vec<DVec3>; 2] {
    let (east, north) = east_north(centre);
    let radius_m = 1000.0 * surface.radius_km;
    let centre = centre.normalize();
    let at = |x: f64, y: f64| (centre + (east * x + north * y) / radius_m).normalize();
    let close = (0..33 * 33).map(|i| {
        let [x, y] =
            [i % 33, i / 33].map(|i| (f64::from(i) - 16.3) * detail_m.min(radius_m / 1400.0));
        at(x, y)
    });
    let reach_m = 195_000.0_f64.min(radius_m / 33.0);
    let wide = (0..900).map(|i| {
        let far = reach_m * (f64::from(i) / 900.0).sqrt();
        let (sin, cos) = libm::sincos(f64::from(i) * 2.399_963_229_728_653);
        at(far * cos, far * sin)
    });
    [close.collect(), wide.collect()]
}

/// Largest and mean difference in m.
fn compare(gpu: &mut GpuTerrain, terrain: &mut Terrain, batch: &[DVec3]) -> (f32, f32) {
    let raised = gpu.elevations(terrain, batch).unwrap();
    assert_eq!(raised.len(), batch.len());
    let (mut largest, mut sum) = (0.0_f32, 0.0);
    for (&place, &height) in batch.iter().zip(&raised) {
        let expected = terrain.elevation(place);
        let apart = (height - expected).abs();
        assert!(height.is_finite(), "{height} in place of {expected} m");
        sum += apart;
        largest = largest.max(apart);
    }
    (largest, sum / batch.len() as f32)
}

fn check(surface: &Surface, details_m: &[f64]) {
    let Some(mut gpu) = gpu() else {
        return;
    };
    let mut complaints = Vec::new();
    let (mut most, mut means, mut count) = (0.0_f32, 0.0, 0);
    for (name, centre) in places(surface) {
        for &detail_m in details_m {
            let mut terrain = Terrain::new(surface, detail_m).unwrap();
            for (batch, width) in batches(surface, centre, detail_m)
                .iter()
                .zip(["close", "wide"])
            {
                let (largest, mean) = compare(&mut gpu, &mut terrain, batch);
                println!("{name}, {detail_m} m, {width}: {largest:.4} m, {mean:.5} m in the mean");
                if largest > APART_M {
                    complaints.push(format!("{largest} m at {detail_m} m, {name}, {width}"));
                }
                most = most.max(largest);
                means += mean * batch.len() as f32;
                count += batch.len();
            }
        }
    }
    println!(
        "{count} places: {most} m at most, {} m in the mean",
        means / count as f32
    );
    assert!(complaints.is_empty(), "{}", complaints.join("\n"));
}

#[test]
fn heights_from_the_gpu_are_those_of_the_cpu() {
    check(&PLANET, &[20_000.0, 1000.0, 100.0, 10.0, 2.0]);
}

/// Steeper ground between closer sub-plates; pieces and noise of another size in radii.
#[test]
fn heights_agree_on_finer_and_on_smaller_planets() {
    let fine = Recipe::earth_like(5)
        .with_sub_plates(30_000)
        .with_duration(3.0);
    check(&grow(fine), &[300.0, 3.0]);
    let small = Recipe {
        radius_km: 1500.0,
        ..Recipe::earth_like(3).with_sub_plates(2000)
    };
    check(&grow(small.with_duration(60.0)), &[300.0, 3.0]);
}

#[test]
fn ground_of_ones_own_and_patches_are_raised_too() {
    let Some(mut gpu) = gpu() else {
        return;
    };
    let heights: Vec<f32> = (0..65_536)
        .map(|i| libm::sinf(i as f32 * 0.37) * 80.0)
        .collect();
    let own = Exemplar::new(&heights).unwrap();
    let mut exemplars = (*Exemplars::shipped()).clone();
    for landform in Landform::ALL {
        exemplars = exemplars.with(landform, own.clone());
    }
    let place = places(&PLANET)[0].1;
    let mut theirs = Terrain::with_exemplars(&PLANET, 30.0, Arc::new(exemplars)).unwrap();
    let mut ours = Terrain::new(&PLANET, 30.0).unwrap();
    let mut found = Vec::new();
    for terrain in [&mut ours, &mut theirs] {
        let patch = gpu.patch(terrain, place, 2.0, 65).unwrap();
        let expected = terrain.patch(place, 2.0, 65);
        assert_eq!(
            (patch.samples, patch.size_m, patch.centre),
            (expected.samples, expected.size_m, expected.centre)
        );
        for (height, expected) in patch.heights.iter().zip(&expected.heights) {
            assert!((height - expected).abs() < APART_M, "{height} {expected}");
        }
        found.push(patch.heights);
    }
    assert_ne!(found[0], found[1]);
    // More than are worked on at once.
    let (patch, expected) = (
        gpu.patch(&ours, place, 16.0, 520).unwrap(),
        ours.patch(place, 16.0, 520),
    );
    assert_eq!(patch.heights.len(), 270_400);
    for (height, expected) in patch.heights.iter().zip(&expected.heights) {
        assert!((height - expected).abs() < APART_M, "{height} {expected}");
    }
}

#[test]
fn odd_batches_are_answered_or_refused() {
    let Some(mut gpu) = gpu() else {
        return;
    };
    let mut terrain = Terrain::new(&PLANET, 50.0).unwrap();
    assert_eq!(gpu.elevations(&terrain, &[]), Ok(Vec::new()));
    let odd = [
        DVec3::ZERO,
        DVec3::NAN,
        DVec3::INFINITY,
        DVec3::Z * 1e-200,
        DVec3::Z * 1e9,
        DVec3::new(0.0, 0.001, 1.0),
    ];
    let (largest, _) = compare(&mut gpu, &mut terrain, &odd);
    assert!(largest < APART_M, "{largest}");
    for detail_m in [f64::NAN, f64::INFINITY, -5.0, 0.0, 1e9] {
        let mut terrain = Terrain::new(&PLANET, detail_m).unwrap();
        let (largest, _) = compare(&mut gpu, &mut terrain, &odd);
        assert!(largest < APART_M, "{largest} at {detail_m}");
    }
    for wide in [
        vec![DVec3::Z, DVec3::NEG_Z],
        vec![DVec3::X, DVec3::Y, DVec3::Z],
        vec![DVec3::NAN, DVec3::X],
    ] {
        let error = gpu.elevations(&terrain, &wide).unwrap_err();
        assert!(matches!(error, GpuTerrainError::TooWide { .. }), "{error}");
    }
    // 201 km to either side.
    let aside = DVec3::Y * (201.0 / PLANET.radius_km);
    let error = gpu.elevations(&terrain, &[DVec3::X + aside, DVec3::X - aside, DVec3::X]);
    let text = error.unwrap_err().to_string();
    assert!(text.contains("of the batch lies 200.9 km"), "{text}");
    assert!(text.contains("from 0 to 199.1 km are possible"), "{text}");
}

#[test]
#[ignore = "a measurement"]
fn how_long_a_height_takes() {
    let Some(mut gpu) = gpu() else {
        return;
    };
    for (name, place) in places(&PLANET) {
        if !["highest", "plain", "coast", "ridge"].contains(&name) {
            continue;
        }
        for detail_m in [1e9, 1000.0, 100.0, 10.0, 2.0] {
            let spacing_m = f64::min(detail_m, 100.0);
            let mut terrain = Terrain::new(&PLANET, detail_m).unwrap();
            for samples in [2, 65, 513] {
                let size_km = 0.001 * spacing_m * (samples - 1) as f64;
                let start = Instant::now();
                let expected = terrain.patch(place, size_km, samples);
                let cpu = start.elapsed();
                // The first call of all compiles.
                let _ = gpu.patch(&terrain, place, size_km, samples).unwrap();
                let start = Instant::now();
                let found = gpu.patch(&terrain, place, size_km, samples).unwrap();
                let ours = start.elapsed();
                assert_eq!(found.heights.len(), expected.heights.len());
                let each = |time: core::time::Duration| {
                    time.as_nanos() as f64 / expected.heights.len() as f64
                };
                println!(
                    "{name}, {detail_m} m, {samples}²: CPU {:.0} ns, GPU {:.0} ns a height",
                    each(cpu),
                    each(ours)
                );
            }
        }
    }
}
