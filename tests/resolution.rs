//! Sub-plates are a resolution, not a planet: more of them show the same kind of planet in more detail.

use bevy_tectonics::prelude::*;
use core::ops::ControlFlow;

const SEEDS: [u64; 3] = [11, 12, 13];

/// Figures of a planet, averaged over seeds and over time.
#[derive(Debug, Default, Clone, Copy)]
struct Mean {
    land: f64,
    continents: f64,
    speed: f64,
    plates: f64,
    age: f64,
    thickness: f64,
    made: f64,
}

fn measure(sub_plates: u32) -> Mean {
    let mut mean = Mean::default();
    let mut samples = 0.0;
    for seed in SEEDS {
        let mut history = History::new(
            Recipe::earth_like(seed)
                .with_sub_plates(sub_plates)
                .with_duration(100.0),
        )
        .unwrap();
        for time_my in [60.0, 80.0, 100.0] {
            history
                .run_until(time_my, |_| ControlFlow::Continue(()))
                .unwrap();
            let now = history.statistics().unwrap();
            mean.land += now.land_share;
            mean.continents += now.continental_share;
            mean.speed += now.speed_mean;
            mean.plates += now.plates as f64;
            mean.age += now.ocean_age_mean_my;
            mean.thickness += now.continental_thickness_km;
            mean.made += history.ledger().area_created_km2 / time_my * 1e-6;
            samples += 1.0;
        }
    }
    for figure in [
        &mut mean.land,
        &mut mean.continents,
        &mut mean.speed,
        &mut mean.plates,
        &mut mean.age,
        &mut mean.thickness,
        &mut mean.made,
    ] {
        *figure /= samples;
    }
    mean
}

#[test]
fn four_times_the_sub_plates_grow_the_same_kind_of_planet() {
    let (coarse, fine) = (measure(2_500), measure(10_000));
    for (name, coarse_value, fine_value, factor) in [
        ("land", coarse.land, fine.land, 1.25),
        ("continents", coarse.continents, fine.continents, 1.15),
        ("speed", coarse.speed, fine.speed, 1.5),
        ("plates", coarse.plates, fine.plates, 1.6),
        ("age of the sea floor", coarse.age, fine.age, 1.4),
        (
            "thickness of continents",
            coarse.thickness,
            fine.thickness,
            1.1,
        ),
        ("crust made", coarse.made, fine.made, 1.4),
    ] {
        let ratio = fine_value / coarse_value;
        assert!(
            ratio < factor && ratio > 1.0 / factor,
            "{name}: {coarse_value} becomes {fine_value}: {coarse:?} {fine:?}"
        );
    }
}
