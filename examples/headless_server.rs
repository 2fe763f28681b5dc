//! A game server without a renderer: grows a planet and prints where people would settle.
//!
//! `cargo run --release --no-default-features --example headless_server -- [SEED]`

use bevy::app::ScheduleRunnerPlugin;
use bevy::math::DVec3;
use bevy::prelude::*;
use bevy_tectonics::{prelude::*, surface::lat_lon};
use core::time::Duration;

/// Settlements to found.
const SETTLEMENTS: usize = 12;
/// Settlements keep at least this distance, in km.
const APART_KM: f64 = 900.0;

fn main() -> AppExit {
    let seed = match std::env::args().nth(1).map(|seed| seed.parse()) {
        None => 7,
        Some(Ok(seed)) => seed,
        Some(Err(error)) => {
            eprintln!("error: the seed must be a whole number: {error}");
            return AppExit::from_code(2);
        }
    };
    // A server ticks at its own rate, whatever the planet costs.
    let ticks = ScheduleRunnerPlugin::run_loop(Duration::from_secs_f64(1.0 / 30.0));
    App::new()
        .add_plugins((MinimalPlugins.set(ticks), PlanetPlugin::default()))
        .add_systems(Startup, move |mut commands: Commands| {
            commands.spawn(Planet::new(Recipe::earth_like(seed)));
        })
        .add_observer(report)
        .add_observer(settle)
        .add_observer(
            |failed: On<GrowthFailed>, mut exit: MessageWriter<AppExit>| {
                eprintln!("error: {}", failed.failure);
                exit.write(AppExit::error());
            },
        )
        .run()
}

/// Tells every 50 My how far the history has come.
fn report(progressed: On<GrowthProgressed>, mut told: Local<f64>) {
    let time_my = progressed.progress.time_my;
    if time_my >= *told {
        println!(
            "{time_my:6.0} My, {:3.0} %",
            100.0 * progressed.progress.fraction
        );
        *told = (time_my / 50.0).floor() * 50.0 + 50.0;
    }
}

/// Founds settlements on the best coasts.
fn settle(
    grown: On<GrowthFinished>,
    surfaces: Query<&PlanetSurface>,
    mut exit: MessageWriter<AppExit>,
) -> Result {
    let surface = surfaces.get(grown.entity)?;
    println!(
        "\n{:>2}  {:>18}  {:>6}  {:>5}  setting",
        "", "place", "height", "plate"
    );
    let apart = APART_KM / surface.radius_km;
    let mut founded: Vec<DVec3> = Vec::new();
    for site in best_sites(surface) {
        if founded.iter().any(|other| other.distance(site) < apart) {
            continue;
        }
        founded.push(site);
        let place = surface.at(site);
        let (latitude, longitude) = lat_lon(site);
        let quakes = surface
            .nearest_boundary(site)
            .filter(|boundary| boundary.distance_km < 400.0)
            .map_or("quiet coast".to_owned(), |boundary| {
                format!(
                    "{:.0} km from a {:?} boundary",
                    boundary.distance_km, boundary.segment.kind
                )
            });
        println!(
            "{:>2}  {latitude:7.1}° {longitude:8.1}°  {:4.0} m  {:>5}  {quakes}",
            founded.len(),
            place.elevation,
            place.plate,
        );
        if founded.len() == SETTLEMENTS {
            break;
        }
    }
    exit.write(AppExit::Success);
    Ok(())
}

/// Coasts in the order in which people would choose them: mild and low.
fn best_sites(surface: &Surface) -> Vec<DVec3> {
    let mut sites: Vec<(f64, DVec3)> = surface
        .coasts()
        .map(|sub_plate| {
            let site = surface.mesh.site(sub_plate);
            let (latitude, _) = lat_lon(site);
            let mild = 1.0 - (latitude.abs() - 35.0).abs().max(15.0) / 55.0;
            let height = f64::from(surface.elevation[sub_plate as usize]);
            (mild - height / 2000.0, site)
        })
        .collect();
    sites.sort_by(|a, b| b.0.total_cmp(&a.0));
    sites.into_iter().map(|(_, site)| site).collect()
}
