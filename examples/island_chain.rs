//! A plate glides over a hot spot, turns, and glides on: a chain of islands with an elbow, as Hawaii and
//! the Emperor seamounts are.
//!
//! `cargo run --release --no-default-features --features export --example island_chain -- [FOLDER]`
//!
//! Prints the chain with its ages and writes maps to FOLDER (`target/island_chain` by default).

use bevy_tectonics::{
    export::Maps,
    prelude::*,
    simulation::{NewCrust, PlateChoice},
};
use core::ops::ControlFlow;
use std::{error::Error, path::Path};

/// Where the hot spot lies.
const HAWAII: LatLon = LatLon::new(19.0, -60.0);
/// When the plate changes its course, and the end, in My.
const ELBOW_MY: f64 = 40.0;
const END_MY: f64 = 80.0;

fn main() -> Result<(), Box<dyn Error>> {
    let folder = std::env::args().nth(1);
    let folder = Path::new(folder.as_deref().unwrap_or("target/island_chain"));
    let mut history = History::new(recipe())?;
    history.run_until(END_MY, |_| ControlFlow::Continue(()))?;
    history.check()?;

    let surface = history.surface()?;
    println!("lava before     from the hot spot    height");
    let hot_spot = HAWAII.direction();
    let mut links: Vec<(f32, f64, f32)> = (0..surface.elevation.len())
        .filter_map(|v| {
            let away = hot_spot.angle_between(surface.mesh.site(v as u32)) * surface.radius_km;
            Some((surface.volcanism_age[v]?, away, surface.elevation[v]))
        })
        .collect();
    links.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
    for (age, away, elevation) in links {
        let kind = if elevation > 0.0 {
            "island"
        } else {
            "seamount"
        };
        println!("{age:8.1} My  {away:16.0} km  {elevation:8.0} m  {kind}");
    }
    for path in Maps::new(2048).write(&surface, folder)? {
        println!("{}", path.display());
    }
    Ok(())
}

/// An ocean of two plates that move as one, westwards at first, then to the north-west.
fn recipe() -> Recipe {
    let mut recipe = Recipe {
        plates: 2,
        hot_spots: 0,
        // The sea is as deep as beside a few continents.
        continental_share: 0.06,
        land_share: 0.04,
        ..Recipe::earth_like(1).with_duration(END_MY)
    };
    recipe.constants.plates.rift_rate = 0.0;
    recipe.constants.plates.founder_age = 500.0;
    let ocean = Intervention::SetCrust {
        centre: HAWAII,
        radius_km: 30_000.0,
        crust: NewCrust::Oceanic { age_my: 10.0 },
    };
    let hot_spot = Intervention::StartHotSpot {
        place: HAWAII,
        strength: 1.0,
    };
    let mut recipe = recipe.with_event(0.0, ocean).with_event(0.0, hot_spot);
    for (at_my, pole) in [(0.0, [-10.0, 30.0]), (ELBOW_MY, [-71.0, 60.0])] {
        for plate in [1, 2] {
            let what = Intervention::SetMotion {
                plate: PlateChoice::Id(plate),
                pole: pole.into(),
                deg_per_my: 0.7,
                hold_my: END_MY,
            };
            recipe = recipe.with_event(at_my, what);
        }
    }
    recipe
}
