//! The step as a schedule: order, plugins, components and systems of one's own, errors, stops.

use crate::scenario::{column, run};
use bevy::app::{PluginGroup, PluginGroupBuilder};
use bevy::prelude::*;
use bevy_tectonics::mesh::SphereMesh;
use bevy_tectonics::prelude::*;
use bevy_tectonics::simulation::*;
use core::ops::ControlFlow;
use glam::DVec3;
use std::sync::{Mutex, mpsc};

fn small(seed: u64) -> Recipe {
    Recipe::earth_like(seed).with_sub_plates(1_000)
}

/// Runs to a time and leaves the rest of the recipe's duration open.
fn run_to(history: &mut History, time_my: f64) -> Outcome {
    history
        .run_until(time_my, |_| ControlFlow::Continue(()))
        .unwrap()
}

/// A history with one more plugin, made of a function.
fn with<F: Fn(&mut App) + Send + Sync + 'static>(recipe: Recipe, build: F) -> History {
    History::with_plugins(recipe, SimulationPlugins.build().add(Extra(build))).unwrap()
}

struct Extra<F>(F);

impl<F: Fn(&mut App) + Send + Sync + 'static> Plugin for Extra<F> {
    fn build(&self, app: &mut App) {
        self.0(app);
    }
}

#[derive(Resource, Default)]
struct Seen(Vec<&'static str>);

#[test]
fn stages_run_in_their_order_once_a_step() {
    let mut history = with(small(1), |app| {
        app.init_resource::<Seen>();
        for stage in TectonicSystems::ALL {
            let note = move |mut seen: ResMut<Seen>| seen.0.push(stage.name());
            app.add_systems(TectonicStep, note.in_set(stage));
        }
    });
    for _ in 0..3 {
        history.step().unwrap();
    }
    let names: Vec<_> = TectonicSystems::ALL.map(TectonicSystems::name).to_vec();
    assert_eq!(history.world().resource::<Seen>().0, names.repeat(3));
    let timed: Vec<_> = history
        .stage_seconds()
        .iter()
        .map(|(name, _)| *name)
        .collect();
    assert_eq!(timed, names);
}

/// What systems of one's own saw at the edges of a step.
#[derive(Resource, Default)]
struct Edges {
    first: Vec<DVec3>,
    steps: u32,
    moved: u32,
}

#[test]
fn systems_of_ones_own_see_whole_planets() {
    // Positions are the sites, rounded.
    fn sites(mesh: &SphereMesh<EdgeState>, position: &[Position]) -> Vec<DVec3> {
        for (site, position) in mesh.sites().iter().zip(position) {
            assert_eq!(site.as_vec3(), position.0);
        }
        mesh.sites().to_vec()
    }
    fn first(
        clock: Res<Clock>,
        topology: Res<Topology>,
        mut edges: ResMut<Edges>,
        mut rows: Query<&Position, With<SubPlate>>,
    ) -> Result<(), TectonicError> {
        edges.steps += 1;
        assert_eq!(clock.steps, u64::from(edges.steps));
        assert!(clock.step_my > 0.0 && clock.time_my >= clock.step_my);
        edges.first = sites(&topology.0, rows.columns(topology.0.vertex_count())?);
        Ok(())
    }
    fn between(
        clock: Res<Clock>,
        topology: Res<Topology>,
        mut rows: Query<(&Position, &Velocity), With<SubPlate>>,
    ) -> Result<(), TectonicError> {
        // The vertices already lie where the sub-plates have moved.
        let (position, velocity) = rows.columns(topology.0.vertex_count())?;
        sites(&topology.0, position);
        let fastest = velocity
            .iter()
            .map(|velocity| velocity.0.length())
            .fold(0.0, f32::max);
        assert!((f64::from(fastest) - clock.fastest).abs() < 1e-3);
        Ok(())
    }
    fn last(
        topology: Res<Topology>,
        mut edges: ResMut<Edges>,
        mut rows: Query<(&Position, &PlateId), With<SubPlate>>,
        plates: Query<&Plate>,
    ) -> Result<(), TectonicError> {
        let mesh = &topology.0;
        mesh.check().unwrap();
        let (position, plate) = rows.columns(mesh.vertex_count())?;
        let now = sites(mesh, position);
        edges.moved += u32::from(now != edges.first);
        let carried = |id: &PlateId| plates.iter().any(|plate| plate.id == *id);
        assert!(
            plate.iter().all(carried),
            "a sub-plate names a plate that is gone"
        );
        Ok(())
    }
    let mut history = with(small(2), |app| {
        app.init_resource::<Edges>().add_systems(
            TectonicStep,
            (
                first.pipe(record_failure).in_set(TectonicSystems::First),
                between
                    .pipe(record_failure)
                    .after(TectonicSystems::Move)
                    .before(TectonicSystems::Uplift),
                last.pipe(record_failure).in_set(TectonicSystems::Last),
            ),
        );
    });
    run_to(&mut history, 30.0);
    let edges = history.world().resource::<Edges>();
    assert_eq!(u64::from(edges.steps), history.steps());
    assert_eq!(edges.moved, edges.steps);
}

/// A component of one's own. Its value never changes after the start.
#[derive(Component, Debug, Clone, Copy, Default, PartialEq)]
struct Mine(u32);

#[test]
fn components_of_ones_own_stay_on_every_sub_plate() {
    let mut recipe = small(3);
    recipe.constants.refine.contrast = 2.0;
    let mut history = with(recipe, |app| {
        app.register_required_components::<SubPlate, Mine>();
    });
    let world = history.world_mut();
    let mut first = std::collections::BTreeMap::new();
    let mut rows = world.query_filtered::<(Entity, &mut Mine), With<SubPlate>>();
    for (number, (entity, mut mine)) in rows.iter_mut(world).enumerate() {
        mine.0 = number as u32 + 1;
        first.insert(entity, *mine);
    }
    assert_eq!(first.len(), 1_000);
    run(&mut history, 50.0);
    let world = history.world_mut();
    let count = world.resource::<Topology>().0.vertex_count();
    let mut rows = world.query_filtered::<(Entity, &Mine), With<SubPlate>>();
    let now: Vec<_> = rows
        .iter(world)
        .map(|(entity, mine)| (entity, *mine))
        .collect();
    assert_eq!(now.len(), count);
    let (mut old, mut new) = (0, 0);
    for (entity, mine) in now {
        if let Some(given) = first.get(&entity) {
            assert_eq!(mine, *given);
            old += 1;
        } else {
            assert_eq!(mine, Mine::default());
            new += 1;
        }
    }
    assert!(old > 100 && new > 100, "{old} old and {new} new sub-plates");
}

#[test]
fn a_component_of_ones_own_changes_nothing_else() {
    let mut plain = History::new(small(3)).unwrap();
    let mut own = with(small(3), |app| {
        app.register_required_components::<SubPlate, Mine>();
    });
    run_to(&mut plain, 20.0);
    run_to(&mut own, 20.0);
    assert_eq!(plain.state_hash(), own.state_hash());
}

#[test]
fn a_component_inserted_later_is_an_error() {
    let mut history = History::new(small(4)).unwrap();
    run_to(&mut history, 3.0);
    let world = history.world_mut();
    let mut rows = world.query_filtered::<Entity, With<SubPlate>>();
    let entity = rows.iter(world).nth(500).unwrap();
    world.entity_mut(entity).insert(Mine(1));
    let is_told = |error: TectonicError| {
        assert!(matches!(error, TectonicError::Archetype { expected, .. } if expected > 900));
        assert!(error.to_string().contains("registered as required"));
    };
    is_told(history.step().unwrap_err());
    is_told(history.check().unwrap_err());
    is_told(history.statistics().unwrap_err());
    is_told(history.surface().map(|_| ()).unwrap_err());
    is_told(history.state_hash().unwrap_err());
}

#[test]
fn a_sub_plate_too_many_is_an_error() {
    let mut history = History::new(small(4)).unwrap();
    history.world_mut().spawn(SubPlate);
    assert_eq!(
        history.step(),
        Err(TectonicError::Archetype {
            found: 1_001,
            expected: 1_000
        })
    );
}

/// Grows a planet without one stage. Its promises hold all the same.
fn without(leave_out: impl FnOnce(PluginGroupBuilder) -> PluginGroupBuilder) -> (History, History) {
    let plugins = leave_out(SimulationPlugins.build());
    let start = History::new(small(5)).unwrap();
    let mut history = History::with_plugins(small(5), plugins).unwrap();
    run(&mut history, 20.0);
    (start, history)
}

#[test]
fn stages_can_be_left_out() {
    without(|plugins| plugins.disable::<RefinePlugin>());

    let (_, history) = without(|plugins| plugins.disable::<CreateCrustPlugin>());
    assert_eq!(history.ledger().area_created_km2, 0.0);
    assert!(history.ledger().area_consumed_km2 > 0.0);

    let (_, mut history) = without(|plugins| plugins.disable::<ClassifyBoundariesPlugin>());
    assert!(history.world().resource::<Boundaries>().fronts.is_empty());
    let trenches = column::<Trench>(&mut history);
    assert!(trenches.iter().all(|trench| trench.0 == 0.0));

    let (mut start, mut history) = without(|plugins| plugins.disable::<ApplyForcesPlugin>());
    let rotations = |history: &mut History| {
        let world = history.world_mut();
        let mut rows: Vec<_> = world
            .query::<(&Plate, &Rotation)>()
            .iter(world)
            .map(|(plate, rotation)| (plate.id, rotation.0))
            .collect();
        rows.sort_by_key(|row| row.0);
        rows
    };
    let (first, now) = (rotations(&mut start), rotations(&mut history));
    let kept = first.iter().filter(|row| now.contains(row)).count();
    // A suture every 4 My may change two of them; no other plate changes its motion.
    assert!(
        2 * kept >= first.len(),
        "{kept} of {} rotations kept",
        first.len()
    );

    let (_, history) = without(|plugins| plugins.disable::<UpliftPlugin>());
    assert_eq!(history.ledger().arc_magma_km3, 0.0);
    assert_eq!(history.ledger().scraped_km3, 0.0);

    let (_, history) = without(|plugins| plugins.disable::<ErodePlugin>());
    assert_eq!(history.ledger().eroded_km3, 0.0);
}

#[test]
fn without_reorganisation_no_plate_is_born() {
    let plugins = SimulationPlugins
        .build()
        .disable::<ReorganizePlatesPlugin>();
    let mut history = History::with_plugins(small(6), plugins).unwrap();
    run_to(&mut history, 40.0);
    let world = history.world_mut();
    assert_eq!(world.resource::<NextPlateId>().0, 25);
    assert_eq!(world.query::<&Plate>().iter(world).count(), 24);
    world.resource::<Topology>().0.check().unwrap();
}

#[test]
fn a_stage_can_be_replaced() {
    #[derive(Resource, Default)]
    struct Replaced(u32);
    let plugins = SimulationPlugins
        .build()
        .disable::<ErodePlugin>()
        .add(Extra(|app: &mut App| {
            let stage = |mut replaced: ResMut<Replaced>,
                         mut rows: Query<&mut Elevation, With<SubPlate>>| {
                replaced.0 += 1;
                rows.iter_mut()
                    .for_each(|mut elevation| elevation.0 = 123.0);
            };
            app.init_resource::<Replaced>()
                .add_systems(TectonicStep, stage.in_set(TectonicSystems::Erode));
        }));
    let mut history = History::with_plugins(small(7), plugins).unwrap();
    run(&mut history, 5.0);
    assert_eq!(
        u64::from(history.world().resource::<Replaced>().0),
        history.steps()
    );
    assert!(
        column::<Elevation>(&mut history)
            .iter()
            .all(|elevation| elevation.0 == 123.0)
    );
    assert!((history.statistics().unwrap().mean_land_m - 123.0).abs() < 1e-6);
}

#[test]
fn an_error_of_ones_own_ends_the_step() {
    let error = TectonicError::Build("no reason".into());
    let mut history = with(small(8), |app| {
        let fail = |clock: Res<Clock>| match clock.steps {
            2 => Err(TectonicError::Build("no reason".into())),
            _ => Ok(()),
        };
        let note = |mut seen: ResMut<Seen>| seen.0.push("moved");
        app.init_resource::<Seen>().add_systems(
            TectonicStep,
            (
                fail.pipe(record_failure).in_set(TectonicSystems::First),
                note.in_set(TectonicSystems::Move),
            ),
        );
    });
    assert_eq!(history.step(), Ok(()));
    assert_eq!(history.step(), Err(error));
    assert_eq!(history.world().resource::<Seen>().0.len(), 1);
}

#[test]
fn another_thread_stops_a_run_within_a_step() {
    /// Both ends of the talk between the step and the other thread.
    #[derive(Resource)]
    struct Talk(Mutex<(mpsc::Sender<()>, mpsc::Receiver<()>)>);
    let (ask, asked) = mpsc::channel();
    let (answer, answered) = mpsc::channel();
    let mut history = with(small(9), |app| {
        // The fifth step asks to be stopped, and goes on only once that has been done.
        let stop = |clock: Res<Clock>, talk: Res<Talk>| {
            if clock.steps == 5 {
                let talk = talk.0.lock().unwrap();
                talk.0.send(()).unwrap();
                talk.1.recv().unwrap();
            }
        };
        let note = |mut seen: ResMut<Seen>| seen.0.push("last");
        app.init_resource::<Seen>().add_systems(
            TectonicStep,
            (
                stop.after(TectonicSystems::Move)
                    .before(TectonicSystems::Uplift),
                note.in_set(TectonicSystems::Last),
            ),
        );
    });
    history
        .world_mut()
        .insert_resource(Talk(Mutex::new((ask, answered))));
    let cancellation = history.cancellation();
    let other = std::thread::spawn(move || {
        asked.recv().unwrap();
        cancellation.cancel();
        answer.send(()).unwrap();
    });
    assert_eq!(run_to(&mut history, 1_000.0), Outcome::Cancelled);
    other.join().unwrap();
    assert_eq!(history.steps(), 5);
    assert_eq!(
        history.world().resource::<Seen>().0.len(),
        4,
        "the fifth step went on to its end"
    );
    assert_eq!(run_to(&mut history, 1_000.0), Outcome::Cancelled);
    assert_eq!(history.steps(), 5, "a run that was cancelled went on");
}

/// A last step that stops half-way reaches the end of time, but the planet is not finished.
#[test]
fn a_run_cancelled_in_its_last_step_is_not_finished() {
    let mut history = with(small(9), |app| {
        let stop = |clock: Res<Clock>, cancellation: Res<Cancellation>| {
            if clock.time_my == 2.0 {
                cancellation.cancel();
            }
        };
        app.add_systems(TectonicStep, stop.in_set(TectonicSystems::First));
    });
    let mut last = 0.0;
    let outcome = history.run_until(2.0, |progress| {
        last = progress.time_my;
        ControlFlow::Continue(())
    });
    assert_eq!(outcome, Ok(Outcome::Cancelled));
    assert!(last < 2.0, "the caller was shown half a step");
}

#[test]
fn progress_rises_to_one() {
    let mut history = History::new(small(10)).unwrap();
    let mut seen = Vec::new();
    let outcome = history.run_until(7.3, |progress| {
        seen.push(*progress);
        ControlFlow::Continue(())
    });
    assert_eq!(outcome, Ok(Outcome::Finished));
    assert_eq!(history.time_my(), 7.3);
    assert_eq!(seen.len() as u64, history.steps());
    assert!(seen[0].fraction > 0.0 && seen[0].steps == 1);
    assert!(
        seen.windows(2)
            .all(|pair| pair[0].fraction < pair[1].fraction)
    );
    for progress in &seen {
        assert_eq!(progress.end_my, 7.3);
        assert_eq!(progress.fraction, progress.time_my / 7.3);
    }
    assert_eq!(seen.last().unwrap().fraction, 1.0);
    // A run may go on, and a caller may end it.
    let outcome = history.run_until(20.0, |progress| {
        if progress.fraction > 0.5 {
            ControlFlow::Break(())
        } else {
            ControlFlow::Continue(())
        }
    });
    assert_eq!(outcome, Ok(Outcome::Cancelled));
    assert!((10.0..12.0).contains(&history.time_my()));
}

#[test]
fn no_step_takes_a_sub_plate_too_far() {
    let recipe = small(11);
    let step = recipe.constants.step.clone();
    let spacing = recipe.spacing_km();
    let mut history = History::new(recipe).unwrap();
    let mut fastest = history.world().resource::<Clock>().fastest;
    while history.time_my() < 30.0 {
        history.step().unwrap();
        let clock = history.world().resource::<Clock>();
        assert!(clock.step_my * fastest <= step.courant * spacing * 1.000_01);
        assert!(clock.step_my <= step.longest);
        fastest = clock.fastest;
    }
}

/// Builds the schedule of the step without running it.
fn build_schedule(history: &mut History) -> bool {
    history
        .world_mut()
        .schedule_scope(TectonicStep, |world, schedule| {
            schedule.initialize(world).is_ok()
        })
}

#[test]
fn no_order_of_systems_is_left_to_chance() {
    assert!(build_schedule(&mut History::new(small(12)).unwrap()));
    let thicken = |mut rows: Query<&mut Thickness, With<SubPlate>>| {
        rows.iter_mut().for_each(|mut thickness| thickness.0 += 0.0);
    };
    // In a set of one's own alone it is fine ...
    let mut fine = with(small(12), move |app| {
        app.add_systems(TectonicStep, thicken.in_set(TectonicSystems::Last));
    });
    assert!(build_schedule(&mut fine));
    // ... but beside a stage that also writes thickness its order must be said.
    let mut ambiguous = with(small(12), move |app| {
        app.add_systems(TectonicStep, thicken.in_set(TectonicSystems::Uplift));
    });
    assert!(!build_schedule(&mut ambiguous));
}

#[test]
fn any_app_can_grow_a_planet() {
    let recipe = Recipe::earth_like(3)
        .with_sub_plates(500)
        .with_duration(50.0);
    let mut app = App::new();
    app.add_plugins(SimulationPlugins);
    populate(app.world_mut(), &recipe).unwrap();
    app.add_systems(Update, |world: &mut World| {
        world.run_schedule(TectonicStep);
    });
    for _ in 0..3 {
        app.update();
    }
    let mut history = History::new(recipe).unwrap();
    for _ in 0..3 {
        history.step().unwrap();
    }
    let clock = app.world().resource::<Clock>();
    assert_eq!(clock.steps, 3);
    assert_eq!(clock.time_my, history.time_my());
    assert_eq!(
        Surface::capture(app.world_mut()).unwrap().elevation,
        history.surface().unwrap().elevation
    );
}
