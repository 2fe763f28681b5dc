//! Saves: the same bits, whatever the planet, the moment, the threads; errors for everything else.
#![cfg(feature = "save")]

#[expect(dead_code, reason = "what the tests of planets need besides")]
mod game;

use bevy_tectonics::prelude::*;
use bevy_tectonics::save::{self, SaveError, SavedComponent, SavedComponentPlugin};
use bevy_tectonics::simulation::laws::{CollisionLaw, ErosionLaw, SeaFloorLaw, UpliftLaw};
use bevy_tectonics::simulation::{
    Drive, HeightMap, Hypsometry, ImageStart, ImportedWorld, PlateChoice, PlateId, Start, SubPlate,
    Workers,
};
use std::{
    env, fs,
    path::{Path, PathBuf},
    process::{Command, Stdio},
    thread,
    time::{Duration, Instant},
};

/// Twenty recipes that have little in common, by number.
fn recipe(number: u64) -> Recipe {
    let starts = [
        Start::FloodFill,
        Start::Voronoi,
        Start::Hypsometric(Hypsometry::default()),
    ];
    let drives = [
        Drive::Soft,
        Drive::Rigid,
        Drive::Foundering,
        Drive::Prescribed,
    ];
    let sizes = [300, 800, 1_500, 5_000];
    let mut recipe = Recipe {
        start: starts[number as usize % 3].clone(),
        drive: drives[number as usize % 4],
        ..Recipe::earth_like(100 + number)
    }
    .with_sub_plates(sizes[number as usize / 5])
    .with_duration(300.0);
    let at = LatLon {
        lat: 10.0,
        lon: 20.0 * number as f64 % 180.0,
    };
    if number % 2 == 1 {
        recipe = recipe
            .with_event(
                4.0,
                Intervention::StartHotSpot {
                    place: at,
                    strength: 2.0,
                },
            )
            .with_event(
                6.5,
                Intervention::SetMotion {
                    plate: PlateChoice::At(at),
                    pole: LatLon {
                        lat: 80.0,
                        lon: 0.0,
                    },
                    deg_per_my: 0.7,
                    hold_my: 60.0,
                },
            )
            .with_event(
                9.0,
                Intervention::BreakUp {
                    plate: PlateChoice::Id(3),
                    pieces: 3,
                },
            );
    }
    if number % 5 == 2 {
        recipe.laws.sea_floor = SeaFloorLaw::Cortial;
        recipe.laws.uplift = UpliftLaw::Cortial;
        recipe.laws.collision = CollisionLaw::Cortial;
        recipe.laws.erosion = ErosionLaw::Cortial;
    }
    if number % 7 == 3 {
        recipe.radius_km = 3_390.0;
        recipe.hot_spots = 0;
    }
    recipe
}

fn advance(history: &mut History, steps: u64) {
    for _ in 0..steps {
        history.step().unwrap();
    }
}

#[test]
fn a_loaded_planet_goes_on_to_the_same_bits() {
    let folder = tempfile::tempdir().unwrap();
    for number in 0..20 {
        // Before and after rows have been sorted, at the very start, in the middle of everything.
        let stop = number * 37 % 211;
        let mut whole = History::with_threads(recipe(number), 1).unwrap();
        advance(&mut whole, stop);
        let path = folder.path().join(format!("{number}.save"));
        save::write(&mut whole, &path).unwrap();
        let kept = whole.checkpoint().unwrap();
        advance(&mut whole, 40);
        for threads in [1, 2] {
            let mut loaded = save::read(&path, SimulationPlugins).unwrap();
            loaded.world_mut().insert_resource(Workers::new(threads));
            assert_eq!(loaded.checkpoint().unwrap(), kept, "recipe {number}");
            advance(&mut loaded, 40);
            assert_eq!(
                loaded.state_hash(),
                whole.state_hash(),
                "recipe {number} from step {stop} on {threads} threads"
            );
            assert_eq!(loaded.event_log(), whole.event_log());
            assert_eq!(loaded.ledger(), whole.ledger());
        }
    }
}

#[test]
fn statistics_come_along() {
    let mut history = History::new(recipe(1)).unwrap();
    for _ in 0..5 {
        advance(&mut history, 3);
        history.record_statistics().unwrap();
    }
    let bytes = save::to_bytes(&mut history).unwrap();
    let loaded = save::from_bytes(&bytes, SimulationPlugins).unwrap();
    assert_eq!(loaded.statistics_history(), history.statistics_history());
    assert_eq!(loaded.statistics_history().moments().len(), 5);
}

#[test]
fn an_imported_world_needs_its_files_no_more() {
    let mut recipe = Recipe::earth_like(3).with_sub_plates(400);
    recipe.start = Start::Image(ImageStart {
        heights: "somewhere/else.png".into(),
        ..ImageStart::default()
    });
    let row = |y: usize| (0..64).map(move |x| if x < 24 && y > 8 { 300.0 } else { -4000.0 });
    let world = ImportedWorld {
        heights: HeightMap::new(64, (0..32).flat_map(row).collect()).unwrap(),
        plates: Vec::new(),
    };
    let mut history = History::imported(recipe, world, SimulationPlugins).unwrap();
    advance(&mut history, 5);
    let bytes = save::to_bytes(&mut history).unwrap();
    let mut loaded = save::from_bytes(&bytes, SimulationPlugins).unwrap();
    advance(&mut history, 5);
    advance(&mut loaded, 5);
    assert_eq!(loaded.state_hash(), history.state_hash());
}

/// After 500 My, at the moment of a cycle of sortings at which saves are largest.
#[test]
fn a_sub_plate_takes_forty_bytes() {
    let recipe = Recipe::earth_like(11)
        .with_sub_plates(10_000)
        .with_duration(500.0);
    let mut history = History::with_threads(recipe, 2).unwrap();
    let going_on = |_: &Progress| core::ops::ControlFlow::Continue(());
    history.run_until(500.0, going_on).unwrap();
    while history.steps() % 32 != 31 {
        history.step().unwrap();
    }
    let bytes = save::to_bytes(&mut history).unwrap();
    let each = bytes.len() as f64 / history.checkpoint().unwrap().sub_plates() as f64;
    assert!(each < 40.0, "{each:.1} bytes");
}

/// Files of every version that was ever released, with the state that is in them.
#[test]
fn saves_of_all_versions_load() {
    let frozen = [Frozen {
        bytes: include_bytes!("save/version_1.save"),
        steps: 120,
        state: 0x32f6_bc3f_8db4_0676,
    }];
    for version in &frozen {
        let mut loaded = save::from_bytes(version.bytes, SimulationPlugins).unwrap();
        assert_eq!(loaded.steps(), version.steps);
        assert_eq!(loaded.state_hash(), Ok(version.state));
        assert_eq!(loaded.statistics_history().moments().len(), 3);
        assert_eq!(loaded.event_log().len(), 1);
        advance(&mut loaded, 3);
        loaded.check().unwrap();
    }
}

struct Frozen {
    bytes: &'static [u8],
    steps: u64,
    state: u64,
}

fn small() -> (History, Vec<u8>) {
    let mut history = History::new(recipe(1).with_sub_plates(300)).unwrap();
    advance(&mut history, 12);
    let bytes = save::to_bytes(&mut history).unwrap();
    (history, bytes)
}

#[test]
fn files_that_are_cut_short_say_so() {
    let (_, bytes) = small();
    for length in (0..bytes.len()).step_by(97) {
        match save::from_bytes(&bytes[..length], SimulationPlugins) {
            Err(SaveError::Truncated { found, .. }) => assert_eq!(found, length as u64),
            Err(SaveError::Foreign { .. }) if length == 0 => {}
            other => panic!("{length} bytes: {:?}", other.err()),
        }
    }
}

#[test]
fn no_changed_byte_goes_unnoticed() {
    let (_, bytes) = small();
    for at in (0..bytes.len()).step_by(53) {
        let mut bad = bytes.clone();
        bad[at] ^= 0x40;
        let error = save::from_bytes(&bad, SimulationPlugins).err();
        let error = error.unwrap_or_else(|| panic!("byte {at}")).to_string();
        assert!(!error.is_empty() && !error.contains('\n'), "{error}");
    }
}

#[test]
fn files_of_other_kinds_are_refused_in_a_sentence() {
    let folder = tempfile::tempdir().unwrap();
    let missing = save::read(&folder.path().join("none"), SimulationPlugins);
    let message = missing.err().unwrap().to_string();
    assert!(message.contains("none"), "{message}");
    let path = folder.path().join("text");
    fs::write(&path, "a planet, honestly").unwrap();
    let message = save::read(&path, SimulationPlugins)
        .err()
        .unwrap()
        .to_string();
    assert!(message.contains("no saved planet"), "{message}");
    let folder_itself = save::read(folder.path(), SimulationPlugins).err().unwrap();
    assert!(
        matches!(folder_itself, SaveError::Io { .. }),
        "{folder_itself}"
    );
}

#[derive(
    bevy::prelude::Component, Debug, Default, Clone, PartialEq, serde::Serialize, serde::Deserialize,
)]
struct Tribe {
    name: String,
    people: Option<u32>,
}

impl SavedComponent for Tribe {
    const NAME: &'static str = "tribe";
}

fn with_tribes() -> bevy::app::PluginGroupBuilder {
    use bevy::app::PluginGroup;
    SimulationPlugins
        .build()
        .add(SavedComponentPlugin::<Tribe>::default())
}

#[test]
fn components_of_a_game_come_along_or_are_left_behind() {
    let recipe = Recipe::earth_like(4).with_sub_plates(400);
    let mut history = History::with_plugins(recipe, with_tribes()).unwrap();
    advance(&mut history, 3);
    let world = history.world_mut();
    let mut tribes = world.query::<(&PlateId, &mut Tribe)>();
    for (plate, mut tribe) in tribes.iter_mut(world) {
        tribe.name = format!("of plate {}", plate.0);
        tribe.people = (plate.0 % 2 == 0).then_some(7);
    }
    let bytes = save::to_bytes(&mut history).unwrap();
    let rows = |history: &mut History| {
        let world = history.world_mut();
        let mut query = world.query::<&Tribe>();
        query.iter(world).cloned().collect::<Vec<Tribe>>()
    };
    let before = rows(&mut history);
    assert!(before.iter().any(|tribe| tribe.people == Some(7)));
    let mut loaded = save::from_bytes(&bytes, with_tribes()).unwrap();
    assert_eq!(rows(&mut loaded), before);
    advance(&mut loaded, 5);
    loaded.check().unwrap();
    // A game that has no tribes any more.
    let mut without = save::from_bytes(&bytes, SimulationPlugins).unwrap();
    without.step().unwrap();
    // And one that had none yet.
    let old = save::to_bytes(&mut without).unwrap();
    let mut loaded = save::from_bytes(&old, with_tribes()).unwrap();
    assert!(
        rows(&mut loaded)
            .iter()
            .all(|tribe| *tribe == Tribe::default())
    );
    let world = loaded.world_mut();
    let count = world
        .query_filtered::<(), bevy::prelude::With<SubPlate>>()
        .iter(world)
        .count();
    assert_eq!(rows(&mut loaded).len(), count);
}

/// What saves have answered.
#[derive(bevy::prelude::Resource, Default, Debug)]
struct Answers {
    saved: Vec<f64>,
    loaded: Vec<f64>,
    failures: Vec<String>,
}

fn game_that_saves() -> game::Game {
    use bevy::prelude::*;
    let mut game = game::Game::new(PlanetPlugin::default().with_threads(1));
    game.app
        .init_resource::<Answers>()
        .add_observer(|saved: On<PlanetSaved>, mut answers: ResMut<Answers>| {
            answers.saved.push(saved.time_my);
        })
        .add_observer(|loaded: On<PlanetLoaded>, mut answers: ResMut<Answers>| {
            answers.loaded.push(loaded.time_my);
        })
        .add_observer(|failed: On<SaveFailed>, mut answers: ResMut<Answers>| {
            answers.failures.push(failed.error.to_string());
        })
        .add_observer(|failed: On<LoadFailed>, mut answers: ResMut<Answers>| {
            answers.failures.push(failed.error.to_string());
        });
    game
}

#[test]
fn a_game_saves_a_planet_and_another_goes_on_with_it() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("world.save");
    let recipe = recipe(1).with_duration(20.0);
    let mut game = game_that_saves();
    let entity = game.spawn(Planet::new(recipe.clone()).with_end(8.0));
    let ask = |game: &mut game::Game, path: &Path| {
        let path = path.to_owned();
        game.app.world_mut().trigger(SavePlanet { entity, path });
    };
    // Asked for in the middle of growth, and again at rest; the later file replaces the first.
    ask(&mut game, &path);
    game.until(|game| game.app.world().resource::<Answers>().saved.len() == 1);
    game.until(|game| game.log.finished == 1);
    ask(&mut game, &path);
    game.until(|game| game.app.world().resource::<Answers>().saved.len() == 2);
    assert!(game.app.world().resource::<Answers>().saved[1] >= 8.0);

    let mut other = game_that_saves();
    let entity = other.spawn(Planet::new(Recipe::earth_like(77).with_sub_plates(480)));
    other.until(|game| game.app.world().get::<PlanetSurface>(entity).is_some());
    let load = path.clone();
    other
        .app
        .world_mut()
        .trigger(LoadPlanet { entity, path: load });
    other.until(|game| !game.app.world().resource::<Answers>().loaded.is_empty());
    assert_eq!(other.planet(entity).recipe.seed, recipe.seed);
    other.until(|game| game.growth(entity).state == GrowthState::Finished);
    assert_eq!(other.surface(entity).time_my, 20.0);
    let mut alone = History::new(recipe).unwrap();
    alone
        .run_until(20.0, |_| core::ops::ControlFlow::Continue(()))
        .unwrap();
    let expected = alone.surface().unwrap();
    assert_eq!(other.surface(entity).elevation, expected.elevation);
    assert_eq!(other.surface(entity).mesh.sites(), expected.mesh.sites());
}

#[test]
fn a_planet_that_is_loaded_at_its_end_or_with_a_pace_says_where_it_stands() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("world.save");
    let mut history = History::new(recipe(1).with_duration(9.0)).unwrap();
    let going_on = |_: &Progress| core::ops::ControlFlow::Continue(());
    history.run_until(9.0, going_on).unwrap();
    save::write(&mut history, &path).unwrap();

    let mut game = game_that_saves();
    let mut planet = Planet::new(Recipe::earth_like(77).with_sub_plates(480));
    planet.paused = true;
    let entity = game.spawn(planet);
    let load = |game: &mut game::Game, count: usize| {
        let path = path.clone();
        game.app.world_mut().trigger(LoadPlanet { entity, path });
        game.until(|game| game.app.world().resource::<Answers>().loaded.len() == count);
    };
    load(&mut game, 1);
    game.until(|game| game.log.finished == 1);
    assert_eq!(game.growth(entity).progress.time_my, 9.0);
    // Further, at a pace that is a fraction of what the save has behind it.
    game.planet(entity).resume();
    game.planet(entity).pace = Pace::MyPerSecond(5.0);
    load(&mut game, 2);
    game.planet(entity).until_my = Some(12.0);
    game.until(|game| game.growth(entity).progress.time_my >= 12.0);
    game.until(|game| game.growth(entity).state == GrowthState::Finished);
}

#[test]
fn a_save_before_a_load_is_of_the_planet_before() {
    let folder = tempfile::tempdir().unwrap();
    let (old, new) = (folder.path().join("old"), folder.path().join("new"));
    let mut history = History::new(recipe(1)).unwrap();
    save::write(&mut history, &new).unwrap();
    let mut game = game_that_saves();
    let entity = game.spawn(Planet::new(Recipe::earth_like(77).with_sub_plates(480)));
    game.until(|game| game.app.world().get::<PlanetSurface>(entity).is_some());
    let world = game.app.world_mut();
    world.trigger(SavePlanet {
        entity,
        path: old.clone(),
    });
    world.trigger(LoadPlanet { entity, path: new });
    game.until(|game| !game.app.world().resource::<Answers>().loaded.is_empty());
    assert_eq!(game.app.world().resource::<Answers>().saved.len(), 1);
    let kept = save::read(&old, SimulationPlugins).unwrap();
    assert_eq!(kept.recipe().seed, 77);
    // What nobody will save any more is said, too.
    let world = game.app.world_mut();
    world.trigger(SavePlanet { entity, path: old });
    game.planet(entity).recipe.seed += 1;
    game.until(|game| {
        let answers = game.app.world().resource::<Answers>();
        answers.saved.len() + answers.failures.len() == 2
    });
}

#[test]
fn a_planet_goes_on_when_a_file_cannot_be_read_or_written() {
    let folder = tempfile::tempdir().unwrap();
    let mut game = game_that_saves();
    let recipe = Recipe::earth_like(7)
        .with_sub_plates(480)
        .with_duration(10.0);
    let entity = game.spawn(Planet::new(recipe.clone()));
    game.until(|game| game.app.world().get::<PlanetSurface>(entity).is_some());
    let path = folder.path().join("no such folder").join("world.save");
    let world = game.app.world_mut();
    world.trigger(LoadPlanet {
        entity,
        path: path.clone(),
    });
    world.trigger(SavePlanet { entity, path });
    game.until(|game| game.app.world().resource::<Answers>().failures.len() == 2);
    game.until(|game| game.log.finished == 1);
    let failures = &game.app.world().resource::<Answers>().failures;
    assert!(
        failures
            .iter()
            .all(|error| error.contains("no such folder")),
        "{failures:?}"
    );
    assert!(game.log.failures.is_empty());
    assert_eq!(game.planet(entity).recipe, recipe);
    assert_eq!(game.log.firsts, 1);
}

/// Path of the file that a child of this test writes over and over, if this is that child.
const CHILD: &str = "BEVY_TECTONICS_TEST_SAVES_TO";

/// No test of its own: what [`killing_a_save_never_loses_the_one_before`] starts and kills.
#[test]
fn child_that_saves_for_ever() {
    let Some(path) = env::var_os(CHILD) else {
        return;
    };
    let (mut history, _) = small();
    let started = Instant::now();
    // Its parent may have been killed itself.
    while started.elapsed() < Duration::from_secs(60) {
        save::write(&mut history, Path::new(&path)).unwrap();
        println!("saved");
    }
}

#[test]
fn killing_a_save_never_loses_the_one_before() {
    let folder = tempfile::tempdir().unwrap();
    let path: PathBuf = folder.path().join("world.save");
    let (mut history, _) = small();
    save::write(&mut history, &path).unwrap();
    let expected = history.state_hash().unwrap();
    for kill in 0..200_u64 {
        let mut child = Command::new(env::current_exe().unwrap())
            .args(["--exact", "child_that_saves_for_ever", "--nocapture"])
            .env(CHILD, &path)
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        // From before its first save to after many.
        thread::sleep(Duration::from_micros(20_000 + 7_919 * kill % 60_000));
        child.kill().unwrap();
        child.wait().unwrap();
        let mut loaded = save::read(&path, SimulationPlugins).unwrap();
        assert_eq!(loaded.state_hash().unwrap(), expected, "kill {kill}");
    }
    // Nor is there a half-written file of another name, where the system can do without.
    if cfg!(target_os = "linux") {
        for file in fs::read_dir(folder.path()).unwrap() {
            save::read(&file.unwrap().path(), SimulationPlugins).unwrap();
        }
    }
}

#[test]
#[cfg(target_os = "linux")]
fn a_full_disk_leaves_the_save_before() {
    let folder = tempfile::tempdir().unwrap();
    let mount = |args: &[&str]| {
        Command::new(args[0])
            .args(&args[1..])
            .output()
            .is_ok_and(|done| done.status.success())
    };
    let disk = folder.path().to_str().unwrap();
    if !mount(&["mount", "-t", "tmpfs", "-o", "size=128k", "tmpfs", disk]) {
        eprintln!("only root may mount a small disk: nothing was tested");
        return;
    }
    let (mut history, bytes) = small();
    let path = folder.path().join("world.save");
    save::write(&mut history, &path).unwrap();
    let whole = fs::read(&path).unwrap();
    assert_eq!(whole, bytes);
    let rest = 128 * 1024 - bytes.len() - bytes.len() / 2;
    fs::write(folder.path().join("ballast"), vec![1; rest]).unwrap();
    advance(&mut history, 1);
    let error = save::write(&mut history, &path).unwrap_err();
    let after = fs::read(&path).unwrap();
    let files = fs::read_dir(folder.path()).unwrap().count();
    assert!(mount(&["umount", disk]));
    assert!(matches!(error, SaveError::Io { .. }), "{error}");
    assert_eq!(after, whole);
    assert_eq!(files, 2);
}
