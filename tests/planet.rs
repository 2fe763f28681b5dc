//! Planets in a game: what the components and events promise, without a window.

mod game;

use bevy::prelude::*;
use bevy_tectonics::{
    planet::{GrowthFailure, PlanetThreads},
    prelude::*,
    simulation::StatisticsPlugin,
};
use core::time::Duration;
use game::*;
use std::ops::ControlFlow;

fn recipe(seed: u64) -> Recipe {
    Recipe::earth_like(seed)
        .with_sub_plates(400)
        .with_duration(12.0)
}

/// The surface that the recipe has at its end when no game is around.
fn alone(recipe: &Recipe) -> Surface {
    let mut history = History::new(recipe.clone()).unwrap();
    history
        .run_until(recipe.duration_my, |_| ControlFlow::Continue(()))
        .unwrap();
    history.surface().unwrap()
}

fn assert_same(one: &Surface, other: &Surface) {
    assert_eq!(one.time_my.to_bits(), other.time_my.to_bits());
    assert_eq!(one.mesh.sites(), other.mesh.sites());
    let bits =
        |surface: &Surface| -> Vec<u32> { surface.elevation.iter().map(|z| z.to_bits()).collect() };
    assert_eq!(bits(one), bits(other));
    assert_eq!(one.plate, other.plate);
}

#[test]
fn a_planet_grows_to_its_end_and_says_so() {
    let mut game = Game::new(PlanetPlugin::default().with_threads(1));
    let planet = game.spawn(Planet::new(recipe(1)));
    game.until(|game| game.log.finished == 1);
    assert!(game.log.surfaces.len() >= 2, "first and last at least");
    assert_eq!(game.log.firsts, 1);
    assert!(game.log.surfaces.is_sorted(), "time runs forwards");
    assert!(game.log.progress > 0);
    assert!(game.log.failures.is_empty());
    assert_eq!(game.growth(planet).state, GrowthState::Finished);
    assert_eq!(game.growth(planet).progress.fraction, 1.0);
    assert_eq!(game.surface(planet).time_my, 12.0);
    let statistics = game
        .app
        .world()
        .get::<PlanetSurface>(planet)
        .unwrap()
        .statistics();
    assert!(statistics.land_share > 0.1);
    let component = game.app.world().get::<PlanetStatistics>(planet).unwrap();
    assert_eq!(&component.now, statistics);
    assert_eq!(component.now.time_my, 12.0);
    assert!(
        component.history.moments().is_empty(),
        "nobody asked for it"
    );
    // Nothing more happens, and nothing is said twice.
    let surfaces = game.log.surfaces.len();
    for _ in 0..20 {
        game.frame();
    }
    assert_eq!(game.log.finished, 1);
    assert_eq!(game.log.surfaces.len(), surfaces);
}

#[test]
fn a_planet_keeps_its_figures_over_time_if_told_to() {
    let plugin = PlanetPlugin::default().with_threads(1).with_simulation(|| {
        let interval_my = 5.0;
        SimulationPlugins
            .build()
            .set(StatisticsPlugin { interval_my })
    });
    let mut game = Game::new(plugin);
    let planet = game.spawn(Planet::new(recipe(1)));
    game.until(|game| game.log.finished == 1);
    let statistics = game.app.world().get::<PlanetStatistics>(planet).unwrap();
    let moments = statistics.history.moments();
    let reached: Vec<f64> = moments.iter().map(|m| (m.time_my / 5.0).floor()).collect();
    assert_eq!(reached, [0.0, 1.0, 2.0]);
    assert_eq!(statistics.now.interval_my, 12.0 - moments[2].time_my);
}

/// On threads or in slices, at any pace, with pauses: bit for bit the history that runs alone.
#[test]
fn a_game_changes_nothing_in_a_history() {
    let recipe = recipe(2);
    let expected = alone(&recipe);
    for threads in [0, 1, 3] {
        let mut game = Game::new(PlanetPlugin::default().with_threads(threads));
        let planet = game.spawn(Planet::new(recipe.clone()));
        game.until(|game| game.log.finished == 1);
        assert_same(&game.surface(planet), &expected);
    }
    let mut game = Game::new(PlanetPlugin::default().with_threads(1));
    let planet = game.spawn(Planet::new(recipe).with_pace(Pace::MyPerSecond(120.0)));
    for frame in 0.. {
        game.frame();
        if game.log.finished == 1 {
            break;
        }
        // A step that is asked for runs beyond the end too.
        let early = game.growth(planet).progress.time_my < 6.0;
        let mut planet = game.planet(planet);
        match frame % 7 {
            2 => planet.pause(),
            4 if early => planet.step(),
            5 => planet.resume(),
            _ => {}
        }
    }
    assert_same(&game.surface(planet), &expected);
}

#[test]
fn time_stands_still_runs_by_steps_and_up_to_a_moment() {
    let mut game = Game::new(PlanetPlugin::default().with_threads(1));
    let mut paused = Planet::new(recipe(3));
    paused.pause();
    let planet = game.spawn(paused);
    game.until(|game| game.log.firsts == 1);
    game.until(|game| game.growth(planet).state == GrowthState::Resting);
    assert_eq!(
        game.surface(planet).time_my,
        0.0,
        "the first moment is shown"
    );
    for _ in 0..3 {
        game.planet(planet).step();
    }
    game.until(|game| game.growth(planet).progress.steps == 3);
    // The surface of the last step comes when the history rests, not when the step is reported.
    game.until(|game| game.growth(planet).state == GrowthState::Resting);
    for _ in 0..20 {
        game.frame();
    }
    assert_eq!(game.growth(planet).progress.steps, 3);
    let after_steps = game.growth(planet).progress.time_my;
    assert_eq!(game.surface(planet).time_my, after_steps);

    game.planet(planet).run_to(5.0);
    game.until(|game| game.log.finished == 1);
    let time_my = game.growth(planet).progress.time_my;
    assert!((5.0..12.0).contains(&time_my), "{time_my}");
    assert_eq!(game.surface(planet).time_my, time_my);
    // An earlier moment has passed: the history rests where it is.
    game.planet(planet).run_to(1.0);
    for _ in 0..20 {
        game.frame();
    }
    assert_eq!(game.growth(planet).progress.time_my, time_my);
    // Beyond the recipe's duration the history goes on.
    game.planet(planet).run_to(14.0);
    game.until(|game| game.growth(planet).progress.time_my >= 14.0);
}

#[test]
fn pace_follows_the_time_of_the_game() {
    let mut game = Game::new(PlanetPlugin::default().with_threads(1));
    let recipe = recipe(4).with_duration(1000.0);
    let planet = game.spawn(Planet::new(recipe).with_pace(Pace::MyPerSecond(50.0)));
    game.until(|game| game.log.firsts == 1);
    let start = game.elapsed();
    game.until(|game| game.growth(planet).progress.time_my > 20.0);
    // Never ahead of the game's time by more than the step that was due.
    let most = 50.0 * (game.elapsed() + Game::FRAME).as_secs_f64();
    let time_my = game.growth(planet).progress.time_my;
    assert!(
        time_my <= most + 12.0,
        "{time_my} My after {:?}",
        game.elapsed() - start
    );
    game.planet(planet).pace = Pace::MyPerSecond(0.0);
    game.until(|game| game.growth(planet).state == GrowthState::Resting);
    let time_my = game.growth(planet).progress.time_my;
    for _ in 0..20 {
        game.frame();
    }
    assert_eq!(game.growth(planet).progress.time_my, time_my);
}

#[test]
fn another_recipe_grows_in_secret_or_in_sight() {
    let mut game = Game::new(PlanetPlugin::default().with_threads(1));
    let planet = game.spawn(Planet::new(recipe(5)));
    game.until(|game| game.log.finished == 1);
    game.planet(planet).recipe = recipe(6);
    game.until(|game| game.growth(planet).hidden && game.growth(planet).progress.time_my > 0.0);
    let mut hidden = 0;
    while game.log.finished == 1 {
        if game.growth(planet).hidden {
            hidden += 1;
            assert_eq!(game.surface(planet).seed, 5, "the old surface stays");
        }
        game.frame();
    }
    assert!(hidden > 0);
    assert_eq!(game.log.firsts, 2);
    assert!(!game.growth(planet).hidden);
    assert_same(&game.surface(planet), &alone(&recipe(6)));

    game.planet(planet).regrowth = Regrowth::Shown;
    game.planet(planet).recipe = recipe(7).with_duration(9_000.0);
    game.until(|game| game.surface(planet).seed == 7);
    assert_eq!(game.log.finished, 2, "seen long before it is finished");
}

#[test]
fn a_change_that_is_none_starts_nothing() {
    let mut game = Game::new(PlanetPlugin::default().with_threads(1));
    let planet = game.spawn(Planet::new(recipe(8)));
    game.until(|game| game.log.finished == 1);
    game.planet(planet).recipe = recipe(8);
    game.planet(planet).radius = 3.0;
    for _ in 0..20 {
        game.frame();
    }
    assert_eq!(game.growth(planet).state, GrowthState::Finished);
    assert_eq!(game.log.firsts, 1);
}

#[test]
fn a_bad_recipe_is_refused_with_a_sentence_and_a_good_one_heals() {
    let mut game = Game::new(PlanetPlugin::default().with_threads(1));
    let mut bad = recipe(9);
    bad.land_share = 3.0;
    let planet = game.spawn(Planet::new(bad));
    game.until(|game| !game.log.failures.is_empty());
    let sentence = "land_share is 3, but must be between 0 and 0.9";
    assert_eq!(game.log.failures, [sentence]);
    assert!(matches!(
        game.growth(planet).state,
        GrowthState::Failed(GrowthFailure::Tectonic(TectonicError::Recipe { .. }))
    ));
    assert!(game.app.world().get::<PlanetSurface>(planet).is_none());
    for _ in 0..20 {
        game.frame();
    }
    assert_eq!(game.log.failures.len(), 1, "said once");
    game.planet(planet).recipe = recipe(9);
    game.until(|game| game.log.finished == 1);
    assert_eq!(game.surface(planet).seed, 9);
}

#[test]
fn a_stage_that_panics_ends_its_planet_alone() {
    fn fragile(clock: Res<bevy_tectonics::simulation::Clock>, recipe: Res<Recipe>) {
        assert!(
            recipe.seed != 13 || clock.steps < 3,
            "a defect, made to be found"
        );
    }
    let mut game = Game::new(PlanetPlugin::default().with_threads(1).with_simulation(|| {
        SimulationPlugins.build().add(|app: &mut App| {
            app.add_systems(TectonicStep, fragile.in_set(TectonicSystems::Last));
        })
    }));
    let doomed = game.spawn(Planet::new(recipe(13)));
    let other = game.spawn(Planet::new(recipe(14)));
    game.until(|game| !game.log.failures.is_empty() && game.log.finished == 1);
    assert!(matches!(
        game.growth(doomed).state,
        GrowthState::Failed(GrowthFailure::Panicked)
    ));
    assert_eq!(game.growth(other).state, GrowthState::Finished);
}

#[test]
fn planets_share_a_thread_fairly() {
    let mut game = Game::new(PlanetPlugin::default().with_threads(1));
    let planets: Vec<Entity> = (20..24)
        .map(|seed| game.spawn(Planet::new(recipe(seed).with_duration(5_000.0))))
        .collect();
    game.until(|game| {
        planets
            .iter()
            .any(|&planet| game.growth(planet).progress.steps >= 40)
    });
    for &planet in &planets {
        let steps = game.growth(planet).progress.steps;
        assert!(steps >= 20, "{steps} steps while another had 40");
    }
}

#[test]
fn despawning_stops_a_history_within_a_step() {
    for threads in [0, 1] {
        let probe = Probe::default();
        let mut game = Game::new(probe.watch(PlanetPlugin::default().with_threads(threads)));
        let planet = game.spawn(Planet::new(recipe(30).with_duration(10_000.0)));
        game.until(|_| probe.steps() > 5);
        game.app.world_mut().despawn(planet);
        let steps = probe.steps();
        game.until(|_| probe.worlds() == 0);
        assert!(
            probe.steps() <= steps + 1,
            "{} after {steps}",
            probe.steps()
        );
    }
}

#[test]
fn a_game_that_ends_leaves_no_history_behind() {
    let probe = Probe::default();
    let mut game = Game::new(probe.watch(PlanetPlugin::default().with_threads(1)));
    game.spawn(Planet::new(recipe(31).with_duration(10_000.0)));
    game.until(|_| probe.steps() > 5);
    let threads = game.app.world().resource::<PlanetThreads>().clone();
    drop(game);
    probe.wait_for_worlds(0);
    drop(threads);
}

/// Random recipes, valid or not, and despawns at random moments, many times in a row.
#[test]
fn regenerating_for_ever_leaks_nothing() {
    let probe = Probe::default();
    let mut game = Game::new(probe.watch(PlanetPlugin::default().with_threads(2)));
    let mut dice = Dice(7);
    let mut resident = Vec::new();
    for _ in 0..5 {
        let mut planet = game.spawn(Planet::new(random_recipe(&mut dice)));
        for _ in 0..40 {
            for _ in 0..dice.below(6) {
                game.frame();
            }
            match dice.below(5) {
                0 => {
                    game.app.world_mut().despawn(planet);
                    planet = game.spawn(Planet::new(random_recipe(&mut dice)));
                }
                1 => game.planet(planet).step(),
                2 => game.planet(planet).regrowth = Regrowth::Shown,
                _ => {}
            }
            game.planet(planet).recipe = random_recipe(&mut dice);
        }
        game.app.world_mut().despawn(planet);
        game.until(|_| probe.worlds() == 0);
        resident.push(resident_bytes());
    }
    let (first, last) = (resident[1], resident[4]);
    assert!(last <= first + 16_000_000, "{resident:?}");
}

fn random_recipe(dice: &mut Dice) -> Recipe {
    let mut recipe = Recipe::earth_like(dice.below(1000))
        .with_sub_plates(200 + dice.below(1500) as u32)
        .with_duration(dice.below(30) as f64);
    recipe.land_share = dice.below(11) as f64 / 10.0;
    recipe
}

#[test]
fn frames_go_on_while_a_large_planet_is_laid_out() {
    let mut game = Game::new(PlanetPlugin::default().with_threads(1));
    game.spawn(Planet::new(Recipe::earth_like(40).with_sub_plates(60_000)));
    let mut frames = 0;
    while game.log.firsts == 0 {
        game.frame();
        frames += 1;
        std::thread::sleep(Duration::from_millis(1));
    }
    assert!(
        frames > 20,
        "{frames} frames while 60,000 points were triangulated"
    );
}
