//! Two scripted histories: what a designer wants to happen, happens.
//!
//! `cargo run --release --no-default-features --features export --example scenario -- [FOLDER]`
//!
//! They follow Figures 15 and 16 of Cortial et al. 2019, *Procedural Tectonic Planets*: an island arc that
//! grows off a coast and is welded onto it, and a planet whose continents are led together and torn apart
//! again. Maps of each moment are written to FOLDER (`target/scenario` by default).

use bevy::prelude::*;
use bevy_tectonics::{
    export::Maps,
    prelude::*,
    simulation::{NewCrust, PlateChoice, PlateId, Splits, SubPlate, Topology},
};
use core::ops::ControlFlow;
use std::{error::Error, path::Path};

/// Width of the maps in pixels.
const WIDTH: u32 = 1024;

fn main() -> Result<(), Box<dyn Error>> {
    let folder = std::env::args().nth(1);
    let folder = Path::new(folder.as_deref().unwrap_or("target/scenario"));
    accretion().play(&folder.join("accretion"))?;
    supercontinent().play(&folder.join("supercontinent"))
}

/// A script: the stage, what happens on it, and the moments worth a picture.
struct Scenario {
    title: &'static str,
    recipe: Recipe,
    /// Middles of the plates 1, 2, …, each of which gets the ground nearest to it.
    plates: Vec<LatLon>,
    /// Times in My, with what is to be seen.
    moments: Vec<(f64, &'static str)>,
}

impl Scenario {
    fn play(self, folder: &Path) -> Result<(), Box<dyn Error>> {
        println!("{}", self.title);
        let mut history = History::new(self.recipe)?;
        lay_out(&mut history, &self.plates);
        let mut told = 0;
        for (time_my, sight) in self.moments {
            history.run_until(time_my, |_| ControlFlow::Continue(()))?;
            for record in &history.event_log()[told..] {
                match &record.failure {
                    None => println!("  {:5.1} My  {}", record.time_my, record.event.what.name()),
                    Some(failure) => println!("  {:5.1} My  {failure}", record.time_my),
                }
            }
            told = history.event_log().len();
            history.check()?;
            let moment = folder.join(format!("{time_my:03.0}-my"));
            Maps::new(WIDTH).write(&history.surface()?, &moment)?;
            println!(
                "  {time_my:5.1} My  {sight}: {}",
                moment.join("map.png").display()
            );
        }
        Ok(())
    }
}

/// Gives every sub-plate to the plate whose middle is nearest.
fn lay_out(history: &mut History, plates: &[LatLon]) {
    let world = history.world_mut();
    let sites = world.resource::<Topology>().0.sites().to_vec();
    let mut rows = world.query_filtered::<&mut PlateId, With<SubPlate>>();
    for (site, mut plate) in sites.into_iter().zip(rows.iter_mut(world)) {
        let distance = |place: &LatLon| place.direction().distance(site);
        let nearest = (0..plates.len())
            .min_by(|&a, &b| distance(&plates[a]).total_cmp(&distance(&plates[b])));
        plate.0 = nearest.map_or(1, |nearest| nearest as u16 + 1);
    }
    let mut splits = world.resource_mut::<Splits>();
    splits.suspected = true;
    splits.regrouped = true;
}

/// A planet on which nothing happens by itself, all of it sea floor of this age.
fn stage(plates: usize, age_my: f64) -> Recipe {
    let mut recipe = Recipe {
        plates: plates as u32,
        hot_spots: 0,
        // The sea is as deep as beside a few continents.
        continental_share: 0.1,
        land_share: 0.08,
        ..Recipe::earth_like(3)
            .with_sub_plates(8_000)
            .with_duration(260.0)
    };
    recipe.constants.plates.rift_rate = 0.0;
    recipe.constants.plates.founder_age = 500.0;
    recipe.constants.plates.basin = 0.0;
    recipe.with_event(0.0, sea_floor([0.0, 0.0], 30_000.0, age_my))
}

fn sea_floor(centre: [f64; 2], radius_km: f64, age_my: f64) -> Intervention {
    Intervention::SetCrust {
        centre: centre.into(),
        radius_km,
        crust: NewCrust::Oceanic { age_my },
    }
}

fn continent(centre: [f64; 2], radius_km: f64) -> Intervention {
    Intervention::SetCrust {
        centre: centre.into(),
        radius_km,
        crust: NewCrust::Continental { thickness_km: 37.5 },
    }
}

/// Holds a plate to a motion until another one is asked for.
fn drift(plate: u16, pole: [f64; 2], deg_per_my: f64) -> Intervention {
    Intervention::SetMotion {
        plate: PlateChoice::Id(plate),
        pole: pole.into(),
        deg_per_my,
        hold_my: 1_000.0,
    }
}

const NORTH: [f64; 2] = [90.0, 0.0];

/// Figure 15: sea floor sinks before a coast, an arc grows beyond it, and is welded onto the coast.
fn accretion() -> Scenario {
    let mut recipe = stage(6, 100.0);
    // The paper's arcs grow within 10 My.
    recipe.constants.uplift.arc_flux = 500.0;
    recipe.constants.uplift.arc_oceanic = 1.0;
    recipe.constants.uplift.arc_feedback = 0.0;
    let recipe = recipe
        .with_event(0.0, continent([0.0, -36.0], 2_000.0))
        .with_event(0.0, continent([18.0, -44.0], 1_300.0))
        // The younger floor of the eastern plate overrides.
        .with_event(0.0, sea_floor([0.0, 32.0], 3_200.0, 40.0))
        .with_event(0.0, drift(1, NORTH, -0.35))
        // A pole to the south-east turns it to the north-west.
        .with_event(32.0, drift(1, [-60.0, 90.0], 0.7));
    let recipe = (2..=6).fold(recipe, |recipe, other| {
        recipe.with_event(0.0, drift(other, NORTH, 0.0))
    });
    Scenario {
        title: "An island arc is welded onto a continent (Cortial et al. 2019, Figure 15)",
        recipe,
        plates: [
            [0.0, 35.0],
            [0.0, -30.0],
            [36.0, 35.0],
            [-36.0, 35.0],
            [0.0, 140.0],
            [0.0, -130.0],
        ]
        .map(LatLon::from)
        .into(),
        moments: vec![
            (14.0, "sea floor goes under, the arc rises from the sea"),
            (26.0, "the arc is an island along its trench"),
            (32.0, "the eastern plate is turned to the north-west"),
            (62.0, "the island is a part of the continent"),
        ],
    }
}

/// Figure 16: an island collides, a continent follows, and the supercontinent is torn apart.
fn supercontinent() -> Scenario {
    let recipe = stage(4, 60.0)
        .with_event(0.0, continent([-5.0, -5.0], 2_000.0))
        .with_event(0.0, continent([-16.0, 6.0], 1_300.0))
        .with_event(0.0, continent([0.0, 50.0], 650.0))
        .with_event(0.0, continent([57.0, 0.0], 1_500.0))
        .with_event(0.0, drift(1, NORTH, 0.0))
        .with_event(0.0, drift(2, [0.0, -40.0], 0.05))
        .with_event(0.0, drift(3, NORTH, 0.05))
        .with_event(0.0, drift(4, NORTH, 0.0))
        .with_event(36.0, drift(2, NORTH, -0.65))
        // The island has arrived: its plate comes to rest.
        .with_event(90.0, drift(2, NORTH, 0.0))
        .with_event(108.0, drift(3, [0.0, 90.0], 0.36))
        .with_event(200.0, drift(3, NORTH, 0.0))
        // A rift from coast to coast, and the land beyond it leaves to the south-east.
        .with_event(
            212.0,
            Intervention::Rift {
                line: [[22.0, 14.0], [2.0, 2.0], [-6.0, -8.0], [-22.0, -14.0]]
                    .map(LatLon::from)
                    .into(),
            },
        )
        .with_event(
            212.0,
            Intervention::SetMotion {
                plate: PlateChoice::At(LatLon::new(-14.0, 8.0)),
                pole: LatLon::new(45.0, -70.0),
                deg_per_my: 0.4,
                hold_my: 50.0,
            },
        );
    Scenario {
        title: "Continents gather and part (Cortial et al. 2019, Figure 16)",
        recipe,
        plates: vec![
            LatLon::new(-10.0, -15.0),
            LatLon::new(0.0, 75.0),
            LatLon::new(62.0, 0.0),
            LatLon::new(-20.0, 180.0),
        ],
        moments: vec![
            (
                36.0,
                "the plate of the eastern island is sent towards the continent",
            ),
            (77.0, "the island collides"),
            (108.0, "the northern continent is sent to the centre"),
            (182.0, "sea floor goes under between the continents"),
            (205.0, "the continents have collided"),
            (245.0, "a new sea divides the supercontinent"),
        ],
    }
}
