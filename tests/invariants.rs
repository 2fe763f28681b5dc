//! Everything a planet promises holds after every step of long histories, and the planet stays alive.

use bevy_tectonics::prelude::*;
use bevy_tectonics::simulation::laws::{CollisionLaw, ErosionLaw, Laws, SeaFloorLaw, UpliftLaw};
use bevy_tectonics::simulation::{Drive, Start};

/// Grows a planet to its end with a check after every step, then looks whether it still lives.
fn grow(recipe: Recipe) {
    let what = format!(
        "seed {}, {} sub-plates, {:?}, {:?}, contrast {}",
        recipe.seed,
        recipe.sub_plates,
        recipe.start,
        recipe.drive,
        recipe.constants.refine.contrast
    );
    let end = recipe.duration_my;
    let even = recipe.constants.refine.contrast == 1.0;
    let nominal = f64::from(recipe.sub_plates);
    let mut history = History::new(recipe).unwrap();
    history.check().unwrap();
    let start = history.statistics().unwrap();
    while history.time_my() < end {
        let step = history.steps() + 1;
        history
            .step()
            .unwrap_or_else(|error| panic!("{what}: step {step}: {error}"));
        history
            .check()
            .unwrap_or_else(|error| panic!("{what}: after step {step}: {error}"));
    }

    let now = history.statistics().unwrap();
    let ledger = history.ledger();
    let what = format!("{what}: {now:?} {ledger:?}");
    assert!((10.0..100.0).contains(&now.speed_mean), "{what}");
    assert!((4..=80).contains(&now.plates), "{what}");
    // Shelves and fore-arcs are narrower than a cell of 500 km, and a crushed cell is a small continent:
    // there land drifts further.
    let drift = if nominal < 2_000.0 { 0.5 } else { 1.0 / 3.0 };
    assert!(
        (now.land_share / start.land_share - 1.0).abs() < drift,
        "{what}"
    );
    // 70 km of crust stand 5.5 km high, and the sea may have fallen.
    assert!((2.0..7.0).contains(&(now.highest_m / 1e3)), "{what}");
    assert!(
        (now.hypsometry_500_m.iter().sum::<f64>() - 1.0).abs() < 1e-9,
        "{what}"
    );
    assert!(
        (now.boundary_shares.iter().sum::<f64>() - 1.0).abs() < 1e-9,
        "{what}"
    );

    let (created, consumed) = (ledger.area_created_km2, ledger.area_consumed_km2);
    let sphere = 4.0 * core::f64::consts::PI * 6371.0 * 6371.0;
    assert!(created > 1e-3 * sphere * end / 2.0, "crust is made: {what}");
    if even {
        let made = created + ledger.area_stretched_km2;
        assert!(
            (made / consumed - 1.0).abs() < 0.08,
            "made {made}, consumed {consumed}: {what}"
        );
        let sub_plates = history.surface().unwrap().elevation.len() as f64;
        assert!(
            (sub_plates / nominal - 1.0).abs() < 0.05,
            "{sub_plates} sub-plates: {what}"
        );
    }
}

#[test]
fn a_new_planet_is_as_dry_as_its_recipe_asks() {
    for (seed, land_share) in [(1, 0.3), (2, 0.2), (3, 0.35)] {
        let mut recipe = Recipe::earth_like(seed).with_sub_plates(2_500);
        recipe.land_share = land_share;
        let found = History::new(recipe)
            .unwrap()
            .statistics()
            .unwrap()
            .land_share;
        assert!(
            (found - land_share).abs() < 0.01,
            "{found} instead of {land_share}"
        );
    }
}

#[test]
fn flood_fill_with_soft_margins() {
    for seed in [1, 2, 3] {
        grow(
            Recipe::earth_like(seed)
                .with_sub_plates(1_000)
                .with_duration(200.0),
        );
    }
    grow(
        Recipe::earth_like(4)
            .with_sub_plates(2_500)
            .with_duration(200.0),
    );
}

#[test]
fn voronoi_with_soft_margins() {
    for (seed, sub_plates, duration_my) in [(5, 1_000, 200.0), (6, 2_500, 100.0)] {
        grow(Recipe {
            start: Start::Voronoi,
            ..Recipe::earth_like(seed)
                .with_sub_plates(sub_plates)
                .with_duration(duration_my)
        });
    }
}

#[test]
fn rigid_plates() {
    for (seed, start) in [(7, Start::FloodFill), (8, Start::Voronoi)] {
        grow(Recipe {
            start,
            drive: Drive::Rigid,
            ..Recipe::earth_like(seed)
                .with_sub_plates(1_500)
                .with_duration(150.0)
        });
    }
}

#[test]
fn foundering_sea_floor() {
    for (seed, sub_plates) in [(1, 1_500), (2, 2_500)] {
        grow(Recipe {
            drive: Drive::Foundering,
            ..Recipe::earth_like(seed)
                .with_sub_plates(sub_plates)
                .with_duration(200.0)
        });
    }
}

#[test]
fn prescribed_rotations() {
    for (seed, start) in [(1, Start::FloodFill), (2, Start::Voronoi)] {
        grow(Recipe {
            start,
            drive: Drive::Prescribed,
            ..Recipe::earth_like(seed)
                .with_sub_plates(1_500)
                .with_duration(200.0)
        });
    }
}

/// Published laws bring other heights than Earth's, but break no promise.
#[test]
fn published_laws() {
    for (sea_floor, uplift, collision, erosion) in [
        (
            SeaFloorLaw::ParsonsSclater,
            UpliftLaw::Magma,
            CollisionLaw::Crush,
            ErosionLaw::Rain,
        ),
        (
            SeaFloorLaw::Cortial,
            UpliftLaw::Cortial,
            CollisionLaw::Cortial,
            ErosionLaw::Cortial,
        ),
        (
            SeaFloorLaw::Yggdrasill,
            UpliftLaw::Magma,
            CollisionLaw::Cortial,
            ErosionLaw::Cortial,
        ),
    ] {
        let mut recipe = Recipe::earth_like(3)
            .with_sub_plates(1_000)
            .with_duration(100.0);
        recipe.laws = Laws {
            sea_floor,
            uplift,
            collision,
            erosion,
        };
        let mut history = History::new(recipe).unwrap();
        while history.time_my() < 100.0 {
            history.step().unwrap();
            history.check().unwrap();
        }
        let now = history.statistics().unwrap();
        assert!(
            (0.05..0.6).contains(&now.land_share),
            "{sea_floor:?}: {now:?}"
        );
        assert!(
            (0.5..15.0).contains(&(now.highest_m / 1e3)),
            "{sea_floor:?}: {now:?}"
        );
    }
}

#[test]
fn uneven_meshes() {
    for (seed, drive) in [(9, Drive::Soft), (10, Drive::Rigid)] {
        let mut recipe = Recipe::earth_like(seed)
            .with_sub_plates(2_000)
            .with_duration(120.0);
        recipe.drive = drive;
        recipe.constants.refine.contrast = 4.0;
        grow(recipe);
    }
}
