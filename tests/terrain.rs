//! Terrain between sub-plates: the same for everyone, true to the history, without seams.
#![cfg(feature = "terrain")]

use bevy_tectonics::prelude::*;
use bevy_tectonics::simulation::{Crust, Surface};
use bevy_tectonics::surface::{
    Exemplar, ExemplarError, Exemplars, Landform, Raster, Terrain, east_north,
};
use core::ops::ControlFlow;
use glam::DVec3;
use std::sync::{Arc, LazyLock};

static PLANET: LazyLock<Surface> = LazyLock::new(|| {
    let recipe = Recipe::earth_like(11)
        .with_sub_plates(5000)
        .with_duration(150.0);
    let mut history = History::with_threads(recipe, 2).unwrap();
    let outcome = history.run_until(150.0, |_| ControlFlow::Continue(()));
    outcome.unwrap();
    history.surface().unwrap()
});

/// Directions spread evenly over the sphere.
fn directions(count: u32) -> impl Iterator<Item = DVec3> {
    (0..count).map(move |i| {
        let z = 1.0 - (2.0 * f64::from(i) + 1.0) / f64::from(count);
        let (sin, cos) = libm::sincos(f64::from(i) * 2.399_963_229_728_653);
        DVec3::new((1.0 - z * z).sqrt() * cos, (1.0 - z * z).sqrt() * sin, z)
    })
}

fn terrain(detail_m: f64) -> Terrain<'static> {
    Terrain::new(&PLANET, detail_m).unwrap()
}

#[test]
fn a_place_is_the_same_in_any_order_and_on_any_thread() {
    let places: Vec<DVec3> = directions(3000).collect();
    let mut one = terrain(30.0);
    let forward: Vec<f32> = places.iter().map(|&place| one.elevation(place)).collect();
    let mut other = terrain(30.0);
    let mut backward: Vec<f32> = places
        .iter()
        .rev()
        .map(|&place| other.elevation(place))
        .collect();
    backward.reverse();
    assert_eq!(forward, backward);
    let halves: Vec<f32> = std::thread::scope(|scope| {
        let threads: Vec<_> = places
            .chunks(1500)
            .map(|part| {
                scope.spawn(move || {
                    let mut terrain = terrain(30.0);
                    part.iter()
                        .map(|&place| terrain.sample(place).elevation)
                        .collect::<Vec<f32>>()
                })
            })
            .collect();
        threads
            .into_iter()
            .flat_map(|thread| thread.join().unwrap())
            .collect()
    });
    assert_eq!(forward, halves);
    for (&place, &height) in places.iter().zip(&forward).step_by(100) {
        assert_eq!(PLANET.sample(place, 30.0).unwrap().elevation, height);
    }
}

/// Neighbours share pieces and hints, whoever comes first.
#[test]
fn a_walk_finds_the_same_ground_there_and_back() {
    let metre = 1.0 / (1000.0 * PLANET.radius_km);
    let walk = |start: DVec3| {
        let (east, north) = east_north(start);
        let step =
            move |i: u32| (start + (east + 0.3 * north) * metre * 70.0 * f64::from(i)).normalize();
        (0..600).map(step)
    };
    let places: Vec<DVec3> = directions(12).flat_map(walk).collect();
    let heights = |order: &[usize]| -> Vec<f32> {
        let mut terrain = terrain(20.0);
        let mut heights = vec![f32::NAN; places.len()];
        for &i in order {
            heights[i] = terrain.elevation(places[i]);
        }
        heights
    };
    let there: Vec<usize> = (0..places.len()).collect();
    let back: Vec<usize> = there.iter().rev().copied().collect();
    // 1,607 and the number of places have no divisor in common.
    let about: Vec<usize> = there.iter().map(|i| i * 1607 % places.len()).collect();
    let found = heights(&there);
    assert_eq!(found, heights(&back));
    assert_eq!(found, heights(&about));
}

#[test]
fn nothing_happens_at_the_equator() {
    let highest =
        (0..PLANET.elevation.len()).filter(|&v| PLANET.mesh.site(v as u32).z.abs() < 0.02);
    let highest = highest
        .max_by(|&a, &b| PLANET.elevation[a].total_cmp(&PLANET.elevation[b]))
        .unwrap();
    let above = PLANET.mesh.site(highest as u32).with_z(0.0).normalize();
    let mut terrain = terrain(1.0);
    let millimetre = 1e-6 / PLANET.radius_km;
    for i in -500..500 {
        let place = above + DVec3::Z.cross(above) * (f64::from(i) * 2e-5);
        let [south, north] = [-1.0, 1.0]
            .map(|side| terrain.elevation((place + DVec3::Z * (side * millimetre)).normalize()));
        assert!((south - north).abs() < 0.03, "{south} and {north} m");
    }
}

#[test]
fn land_stays_land_at_every_level_of_detail_but_at_coasts() {
    let raster = Raster::new(&PLANET).unwrap();
    for detail_m in [20_000.0, 2000.0, 200.0, 5.0] {
        let mut terrain = terrain(detail_m);
        let mut changed = 0;
        for place in directions(100_000) {
            let before = raster.sample(place).elevation;
            if (before > 0.0) != (terrain.elevation(place) > 0.0) {
                changed += 1;
                assert!(
                    before.abs() < 250.0,
                    "{before} m changes sides at {detail_m} m"
                );
            }
        }
        assert!(
            changed < 1000,
            "{changed} of 100,000 places at {detail_m} m"
        );
    }
}

#[test]
fn the_mean_over_the_width_of_a_range_is_that_of_the_history() {
    let raster = Raster::new(&PLANET).unwrap();
    let mut terrain = terrain(1000.0);
    let (mut means, mut all, mut discs) = (0.0, 0.0, 0);
    for middle in directions(4000) {
        let height = raster.sample(middle).elevation;
        if height.abs() < 600.0 {
            continue;
        }
        let (east, north) = east_north(middle);
        // 80 km across, in steps of 4 km.
        let (mut sum, mut count) = (0.0, 0.0);
        for i in -10..=10 {
            for j in -10..=10_i32 {
                if i * i + j * j <= 100 {
                    let offset = (east * f64::from(i) + north * f64::from(j)) * (4.0 / 6371.0);
                    let place = (middle + offset).normalize();
                    let added =
                        f64::from(terrain.elevation(place) - raster.sample(place).elevation);
                    sum += added;
                    count += 1.0;
                    all += added * added / 317.0;
                }
            }
        }
        means += (sum / count) * (sum / count);
        discs += 1;
        if discs == 60 {
            break;
        }
    }
    let (mean, deviation) = ((means / 60.0).sqrt(), (all / 60.0).sqrt());
    assert!(deviation > 30.0, "{deviation} m of terrain");
    assert!(
        mean < 0.15 * deviation,
        "means of {mean} m where terrain deviates by {deviation} m"
    );
}

/// A spectrum that falls with the power β of the wave number has second differences whose squares grow with the
/// power β − 1 of their distance.
#[test]
fn the_spectrum_goes_on_where_the_history_ends() {
    let mut terrain = terrain(100.0);
    let mut squares = [0.0; 9];
    for (i, place) in directions(8000).enumerate() {
        let (east, north) = east_north(place);
        let axis = east * libm::cos(i as f64) + north * libm::sin(i as f64);
        for (k, square) in squares.iter_mut().enumerate() {
            let far = axis * (libm::exp2(k as f64 - 1.0) / PLANET.radius_km);
            let mut at = |offset: DVec3| f64::from(terrain.elevation((place + offset).normalize()));
            let bend = at(far) - 2.0 * at(DVec3::ZERO) + at(-far);
            *square += bend * bend;
        }
    }
    // From 0.5 to 128 km: about 2 as on Earth, and no octave without its share.
    let slopes: Vec<f64> = squares
        .windows(2)
        .map(|pair| 1.0 + libm::log2(pair[1] / pair[0]))
        .collect();
    let mean = slopes.iter().sum::<f64>() / slopes.len() as f64;
    assert!((1.8..2.6).contains(&mean), "{slopes:?}");
    assert!(
        slopes.iter().all(|slope| (1.1..3.3).contains(slope)),
        "{slopes:?}"
    );
}

#[test]
fn finer_detail_stays_within_the_error_that_is_told() {
    let mut finest = terrain(1.0);
    for detail_m in [9000.0, 1500.0, 300.0, 40.0] {
        let mut coarse = terrain(detail_m);
        let (mut largest, mut told) = (0.0_f32, 0.0_f32);
        for place in directions(15_000) {
            let sample = coarse.sample(place);
            // Near coasts it is the shore that moves.
            if sample.elevation.abs() < 400.0 {
                continue;
            }
            let change = (finest.elevation(place) - sample.elevation).abs();
            assert!(
                change <= sample.error + 0.01,
                "{change} m in place of at most {} at {detail_m} m",
                sample.error
            );
            (largest, told) = (largest.max(change), told.max(sample.error));
        }
        // Not just any bound.
        assert!(
            told < 12.0 * largest + 1.0,
            "{told} m for {largest} m at {detail_m} m"
        );
    }
    assert_eq!(
        terrain(20_000.0).shore_error_m(),
        terrain(40_000.0).shore_error_m()
    );
    assert_eq!(terrain(50.0).shore_error_m(), 0.0);
    assert!((100.0..2000.0).contains(&terrain(1000.0).shore_error_m()));
}

#[test]
fn the_ground_has_no_steps_and_its_normals_are_those_of_its_slopes() {
    let highest = (0..PLANET.elevation.len())
        .max_by(|&a, &b| PLANET.elevation[a].total_cmp(&PLANET.elevation[b]))
        .unwrap();
    let starts = directions(12).chain([PLANET.mesh.site(highest as u32)]);
    let (mut apart, mut count) = (0.0, 0.0);
    for start in starts {
        let (east, north) = east_north(start);
        let metre = 1.0 / (1000.0 * PLANET.radius_km);
        let mut terrain = terrain(1.0);
        let mut before = terrain.elevation(start);
        for i in 1..3000 {
            // Strides through many pieces, and one metre each.
            let stride = start + (east + 0.37 * north) * metre * f64::from(i / 60 * 900 + i % 60);
            let here = terrain.elevation(stride);
            if i % 60 != 0 {
                assert!(
                    (here - before).abs() < 6.0,
                    "{before} to {here} m within a metre"
                );
            }
            before = here;
        }
        let mut terrain = self::terrain(50.0);
        for i in 0..200 {
            let place = (start + east * metre * 700.0 * f64::from(i)).normalize();
            let (east, north) = east_north(place);
            let mut slope = |axis: DVec3| {
                let mut at = |side: f64| {
                    f64::from(terrain.elevation((place + axis * (side * 25.0 * metre)).normalize()))
                };
                (at(1.0) - at(-1.0)) / 50.0
            };
            let up = place - east * slope(east) - north * slope(north);
            apart += terrain.sample(place).normal.angle_between(up).to_degrees();
            count += 1.0;
        }
    }
    assert!(apart / count < 2.0, "normals are {}° off", apart / count);
}

#[test]
fn young_sea_floor_is_rough_across_the_ridge_that_made_it() {
    let mut terrain = terrain(300.0);
    let km = 1.0 / PLANET.radius_km;
    let (mut along, mut across, mut count) = (0.0, 0.0, 0);
    for v in 0..PLANET.mesh.vertex_count() {
        let (site, ridge) = (PLANET.mesh.site(v as u32), PLANET.ridge[v].as_dvec3());
        let neighbours_agree = PLANET.mesh.neighbours(v as u32).all(|w| {
            PLANET.crust[w as usize] == Crust::Oceanic
                && PLANET.ridge[w as usize].as_dvec3().dot(ridge).abs() > 0.97
        });
        if PLANET.crust[v] != Crust::Oceanic || PLANET.age[v] > 40.0 || !neighbours_agree {
            continue;
        }
        let mut curvature = |axis: DVec3| {
            let mut at =
                |side: f64| f64::from(terrain.elevation((site + axis * (side * km)).normalize()));
            let bend = at(1.0) - 2.0 * at(0.0) + at(-1.0);
            bend * bend
        };
        along += curvature(ridge);
        across += curvature(site.cross(ridge));
        count += 1;
    }
    assert!(count > 20, "{count} places");
    assert!(
        across > 5.0 * along,
        "{across} across, {along} along the ridges"
    );
}

#[test]
fn odd_places_and_details_have_a_ground_too() {
    for detail_m in [f64::NAN, f64::INFINITY, -5.0, 0.0, 1e9] {
        let mut terrain = terrain(detail_m);
        for place in [
            DVec3::ZERO,
            DVec3::NAN,
            DVec3::X * 1e-200,
            DVec3::NEG_Z * 1e9,
        ] {
            let sample = terrain.sample(place);
            assert!(
                sample.elevation.is_finite() && sample.error.is_finite(),
                "{place} {detail_m}"
            );
            assert!((sample.normal.length() - 1.0).abs() < 1e-9);
        }
    }
    let mut short = PLANET.clone();
    short.fold.pop();
    assert!(Terrain::new(&short, 10.0).is_err());
}

#[test]
fn patches_have_the_ground_of_their_places() {
    let centre = DVec3::new(0.3, -0.8, 0.5);
    let patch = terrain(50.0).patch(centre, 2.0, 41);
    assert_eq!((patch.samples, patch.heights.len()), (41, 41 * 41));
    assert!((patch.spacing_m() - 50.0).abs() < 1e-9);
    let mut other = terrain(50.0);
    for (direction, &height) in patch.directions().zip(&patch.heights) {
        assert_eq!(other.elevation(direction), height);
    }
    // Nonsense counts as something.
    let odd = terrain(50.0).patch(DVec3::ZERO, f64::NAN, 0);
    assert_eq!((odd.samples, odd.size_m), (2, 1000.0));
}

#[test]
fn exemplars_are_refused_that_are_none() {
    assert!(matches!(
        Exemplar::new(&[1.0; 100]),
        Err(ExemplarError::Size { found: 100, .. })
    ));
    assert_eq!(Exemplar::new(&[1.0; 65_536]), Err(ExemplarError::Flat));
    let mut heights: Vec<f32> = (0..65_536).map(|i| (i % 777) as f32).collect();
    for void in [f32::NAN, f32::INFINITY, -32_768.0] {
        heights[300] = void;
        assert_eq!(Exemplar::new(&heights), Err(ExemplarError::Void(300)));
    }
    heights[300] = 5.0;
    let ramp = Exemplar::new(&heights).unwrap();
    assert!(matches!(
        Exemplar::from_png(b"PNG"),
        Err(ExemplarError::Unreadable(_))
    ));
    // One's own ground is what is shown.
    let shipped = Exemplars::shipped();
    let mut own = (*shipped).clone();
    for landform in Landform::ALL {
        own = own.with(landform, ramp.clone());
    }
    let mut theirs = Terrain::with_exemplars(&PLANET, 100.0, Arc::new(own)).unwrap();
    let mut ours = terrain(100.0);
    let differ = directions(500).filter(|&place| theirs.elevation(place) != ours.elevation(place));
    assert!(differ.count() > 100);
}
