//! A hypsometric start shows the curve that its recipe asks for, and goes on as any other planet.

use bevy_tectonics::prelude::*;
use bevy_tectonics::simulation::{Hypsometry, Normals, Start};
use core::ops::ControlFlow;

const SUB_PLATES: u32 = 4_000;

fn recipe(seed: u64, hypsometry: Hypsometry) -> Recipe {
    Recipe {
        start: Start::Hypsometric(hypsometry),
        ..Recipe::earth_like(seed).with_sub_plates(SUB_PLATES)
    }
}

/// Elevations of the first moment with the share of the surface that lies lower, the lowest first.
fn shown(history: &mut History) -> Vec<(f64, f64)> {
    let surface = history.surface().unwrap();
    let cells = surface.mesh.cell_areas();
    let mut order: Vec<usize> = (0..cells.len()).collect();
    order.sort_by(|&a, &b| surface.elevation[a].total_cmp(&surface.elevation[b]));
    let sphere: f64 = cells.iter().sum();
    let mut lower = 0.0;
    order
        .into_iter()
        .map(|v| {
            let share = (lower + 0.5 * cells[v]) / sphere;
            lower += cells[v];
            (share, f64::from(surface.elevation[v]))
        })
        .collect()
}

fn normals(ocean_share: f64) -> Hypsometry {
    Hypsometry::Normals(Normals {
        ocean_share,
        ..Normals::default()
    })
}

/// Within the laws' reach nothing differs by more than metres; what lies deeper shows as deep floor. Without the
/// wedge of sediment off continents, on which no floor is that deep.
#[test]
fn the_drawn_curve_is_shown() {
    let bent = Hypsometry::Curve(vec![
        (0.0, -5500.0),
        (0.4, -4500.0),
        (0.55, -200.0),
        (0.9, 600.0),
        (1.0, 5000.0),
    ]);
    for (hypsometry, clipped) in [(normals(0.71), 0.05), (normals(0.3), 0.03), (bent, 0.0)] {
        let mut recipe = recipe(3, hypsometry.clone());
        recipe.constants.erosion.rise_thickest = 0.0;
        let mut history = History::new(recipe).unwrap();
        let mut outside = 0;
        for (share, elevation) in shown(&mut history) {
            let drawn = hypsometry.elevation(share);
            if (-5100.0..5300.0).contains(&drawn) {
                assert!(
                    (elevation - drawn).abs() < 25.0,
                    "{hypsometry:?}: {elevation} m in place of {drawn} m"
                );
            } else if (elevation - drawn).abs() > 25.0 {
                outside += 1;
                assert!(!(-5100.0..=5200.0).contains(&elevation));
            }
        }
        let outside = f64::from(outside) / f64::from(SUB_PLATES);
        assert!(outside <= clipped, "{hypsometry:?}: {outside} clipped");
    }
}

#[test]
fn the_ocean_has_the_wanted_share_to_one_cell() {
    for seed in 1..4 {
        for ocean in [0.1, 0.3, 0.5, 0.71, 0.95, 1.0] {
            let mut history = History::new(recipe(seed, normals(ocean))).unwrap();
            let cells = history.surface().unwrap().mesh.cell_areas();
            let largest = cells.iter().copied().fold(0.0, f64::max) / cells.iter().sum::<f64>();
            let land = history.statistics().unwrap().land_share;
            assert!(
                (1.0 - land - ocean).abs() <= largest,
                "{ocean} wanted, {land} is land"
            );
        }
    }
}

#[test]
fn earths_curve_gives_a_planet_like_earth() {
    let mut history = History::new(recipe(1, Hypsometry::default())).unwrap();
    history.check().unwrap();
    let start = history.statistics().unwrap();
    // Earth has 41 % of continental crust, 35 km thick.
    assert!((start.continental_share - 0.41).abs() < 0.02, "{start:?}");
    assert!((30.0..42.0).contains(&start.continental_thickness_km));
    assert!(start.ocean_age_oldest_my <= 140.0);
}

/// The first step derives every elevation from the crust: nothing may jump.
#[test]
fn the_first_step_changes_few_heights() {
    let mut recipe = recipe(2, Hypsometry::default());
    recipe.constants.step.geology = 0.1;
    let mut history = History::new(recipe).unwrap();
    let before = history.statistics().unwrap();
    history.step().unwrap();
    let after = history.statistics().unwrap();
    assert!((after.mean_ocean_m - before.mean_ocean_m).abs() < 80.0);
    assert!((after.mean_land_m - before.mean_land_m).abs() < 80.0);
    assert!((after.land_share - before.land_share).abs() < 0.02);
}

/// Random great circles: large continents, not noise. Most neighbours of land are land.
#[test]
fn continents_hang_together() {
    for seed in 1..4 {
        let mut history = History::new(recipe(seed, Hypsometry::default())).unwrap();
        let surface = history.surface().unwrap();
        let (mut land, mut same) = (0.0, 0.0);
        for v in 0..surface.elevation.len() as u32 {
            if surface.elevation[v as usize] > 0.0 {
                for w in surface.mesh.neighbours(v) {
                    land += 1.0;
                    same += f64::from(u8::from(surface.elevation[w as usize] > 0.0));
                }
            }
        }
        assert!(same / land > 0.75, "seed {seed}: {}", same / land);
        // Plates are blind to continents: most of the surface lies on plates with both kinds of crust.
        let mut kinds = std::collections::BTreeMap::<u16, [usize; 2]>::new();
        for (&plate, crust) in surface.plate.iter().zip(&surface.crust) {
            kinds.entry(plate).or_default()[usize::from(crust.is_continental())] += 1;
        }
        let mixed = kinds.values().filter(|[sea, land]| *sea > 0 && *land > 0);
        let mixed = mixed.flatten().sum::<usize>() as f64 / surface.plate.len() as f64;
        assert!(mixed > 0.6, "seed {seed}: {mixed} of the surface");
    }
}

#[test]
fn seeds_and_curves_grow_different_planets_and_the_same_one_again() {
    let mut hashes = Vec::new();
    for (seed, ocean) in [(1, 0.71), (2, 0.71), (1, 0.6)] {
        let small = recipe(seed, normals(ocean)).with_sub_plates(600);
        let hash = || History::new(small.clone()).unwrap().state_hash().unwrap();
        let (one, two) = (hash(), hash());
        assert_eq!(one, two);
        hashes.push(one);
    }
    hashes.sort_unstable();
    hashes.dedup();
    assert_eq!(hashes.len(), 3);
}

#[test]
fn its_history_keeps_every_promise() {
    for (ocean, end) in [(0.71, 60.0), (0.1, 20.0), (1.0, 20.0)] {
        let planet = recipe(5, normals(ocean)).with_sub_plates(1_000);
        let mut history = History::new(planet).unwrap();
        history.check().unwrap();
        while history.time_my() < end {
            let step = history.steps();
            history
                .run_until(end, |_| ControlFlow::Break(()))
                .and_then(|_| history.check())
                .unwrap_or_else(|error| panic!("{ocean}, step {step}: {error}"));
        }
        let figures = history.statistics().unwrap();
        assert!((2..=80).contains(&figures.plates), "{figures:?}");
        if ocean == 0.71 {
            assert!(
                (10.0..120.0).contains(&figures.speed_mean) && figures.land_share > 0.1,
                "{figures:?}"
            );
        }
    }
}
