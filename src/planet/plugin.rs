//! The plugin: tends every planet once a frame.

use super::{
    Growth, GrowthState, Planet, PlanetStatistics, PlanetSurface, PlanetThreads, PlanetView,
    desk::Report,
    events::{
        EventHappened, GrowthFailed, GrowthFinished, GrowthProgressed, Intervene,
        InterventionRefused, SurfaceChanged,
    },
    grower::{Grower, Job, Stages},
};
use crate::simulation::{SimulationPlugins, record_event};
use bevy::app::PluginGroupBuilder;
use bevy::platform::time::Instant;
use bevy::prelude::*;
use std::sync::Arc;

/// Grows every entity that has a [`Planet`].
///
/// ```
/// use bevy::prelude::*;
/// use bevy_tectonics::prelude::*;
///
/// App::new().add_plugins((MinimalPlugins, PlanetPlugin::default().with_threads(1)));
/// ```
#[derive(Debug, Clone)]
pub struct PlanetPlugin {
    threads: Option<usize>,
    stages: Stages,
}

impl Default for PlanetPlugin {
    fn default() -> Self {
        Self {
            threads: None,
            stages: Stages(Arc::new(|| SimulationPlugins.build())),
        }
    }
}

impl PlanetPlugin {
    /// Grows planets on this many threads, which they share step by step. With none they grow in
    /// slices of 4 ms within the frames, as they do on the web. By default one thread less than the
    /// machine has cores, but at least one.
    #[must_use]
    pub fn with_threads(mut self, threads: usize) -> Self {
        self.threads = Some(threads);
        self
    }

    /// Gives the simulation world of every planet other stages than [`SimulationPlugins`]: fewer,
    /// others, or more. The function is called on a planet's thread for every planet that starts.
    #[must_use]
    pub fn with_simulation(
        mut self,
        stages: impl Fn() -> PluginGroupBuilder + Send + Sync + 'static,
    ) -> Self {
        self.stages = Stages(Arc::new(stages));
        self
    }
}

/// What [`PlanetPlugin`] does in `PreUpdate`, so that systems in `Update` see the newest surfaces.
#[derive(SystemSet, Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum PlanetSystems {
    /// Snapshots and reports arrive, events are triggered, orders go out.
    Tend,
}

impl Plugin for PlanetPlugin {
    fn build(&self, app: &mut App) {
        let threads = self
            .threads
            .map_or_else(PlanetThreads::available, PlanetThreads::new);
        app.insert_resource(threads)
            .insert_resource(self.stages.clone())
            .register_type::<Planet>()
            .register_type::<PlanetView>()
            .register_type::<PlanetStatistics>()
            .add_observer(intervene)
            .add_systems(PreUpdate, tend_planets.in_set(PlanetSystems::Tend));
        #[cfg(feature = "save")]
        app.add_observer(super::saves::ask_to_save)
            .add_observer(super::saves::ask_to_load)
            .add_systems(
                PreUpdate,
                super::saves::tend_saves
                    .in_set(PlanetSystems::Tend)
                    .before(tend_planets),
            );
    }
}

/// Checks what somebody asks for, and keeps it until the planet is tended next.
fn intervene(asked: On<Intervene>, mut commands: Commands, mut growers: Query<&mut Grower>) {
    let Intervene { entity, what } = asked.event();
    if let Err(error) = what.validate("event") {
        commands.trigger(InterventionRefused {
            entity: *entity,
            what: what.clone(),
            error,
        });
    } else if let Ok(mut grower) = growers.get_mut(*entity) {
        grower.asked.push(what.clone());
    }
}

type Tended = (
    Entity,
    &'static mut Planet,
    &'static mut Growth,
    &'static mut Grower,
    Option<&'static mut PlanetSurface>,
);

fn tend_planets(
    mut commands: Commands,
    threads: Res<PlanetThreads>,
    stages: Res<Stages>,
    time: Option<Res<Time>>,
    mut planets: Query<Tended>,
) {
    let seconds = time.map_or(0.0, |time| time.delta_secs_f64());
    let deadline = Instant::now() + PlanetThreads::SLICE;
    for (entity, mut planet, mut growth, mut grower, mut surface) in &mut planets {
        let grower = &mut *grower;
        let anew = grower.recipe().is_none_or(|recipe| {
            // Recipes are long: most frames change nothing.
            planet.is_changed() && *recipe != planet.recipe
        });
        if anew {
            grower.sow(&planet.recipe, &stages, &threads);
            growth.set_if_neq(Growth::default());
        }
        // Taking what is owed is no change that anyone waits for.
        let steps = core::mem::take(&mut planet.bypass_change_detection().steps_owed);
        let time_my = growth.progress.time_my;
        let orders = grower.orders(&planet, time_my, surface.is_some(), seconds, steps);
        let Some(job) = &mut grower.job else {
            continue;
        };
        job.desk.ask(core::mem::take(&mut grower.asked));
        let mut report = job.desk.order(orders);
        job.receive(&mut report);
        for event in report.recorded.drain(..) {
            // Both, or the planet would be grown anew.
            record_event(&mut job.recipe.events, event.clone());
            record_event(&mut planet.recipe.events, event);
        }
        for record in report.happened.drain(..) {
            commands.trigger(EventHappened { entity, record });
        }
        for (what, error) in report.refused.drain(..) {
            commands.trigger(InterventionRefused {
                entity,
                what,
                error,
            });
        }
        #[cfg(feature = "save")]
        {
            let saved = core::mem::take(&mut report.saved);
            super::saves::answer(&mut commands, entity, &mut job.saving, saved);
            if report.failure.is_some() {
                grower.unsaved.append(&mut job.saving);
            }
        }
        job.run(&orders, &threads, deadline);

        let now = describe(&growth, &planet, job, &report, surface.is_some());
        if let Some((snapshot, statistics)) = report.snapshot {
            let changed = SurfaceChanged {
                entity,
                time_my: snapshot.time_my,
                first: !core::mem::replace(&mut job.shown, true),
            };
            if let Some(surface) = &mut surface {
                threads.retire(core::mem::replace(&mut **surface, snapshot));
            } else {
                commands.entity(entity).insert(snapshot);
            }
            commands.entity(entity).insert(statistics);
            commands.trigger(changed);
        }
        if growth.progress != now.progress {
            commands.trigger(GrowthProgressed {
                entity,
                progress: now.progress,
            });
        }
        if now.state == GrowthState::Finished && growth.state != GrowthState::Finished {
            commands.trigger(GrowthFinished {
                entity,
                time_my: now.progress.time_my,
            });
        }
        if let Some(failure) = report.failure {
            commands.trigger(GrowthFailed { entity, failure });
        }
        growth.set_if_neq(now);
    }
}

/// Where the history stands after this report.
fn describe(
    before: &Growth,
    planet: &Planet,
    job: &Job,
    report: &Report,
    surface_is_shown: bool,
) -> Growth {
    let mut now = before.clone();
    now.progress = report.progress;
    if !report.stage_seconds.is_empty() {
        now.stage_seconds.clone_from(&report.stage_seconds);
    }
    now.hidden = surface_is_shown && !job.shown && report.snapshot.is_none();
    now.state = if let Some(failure) = &report.failure {
        GrowthState::Failed(failure.clone())
    } else if job.failed {
        before.state.clone()
    } else if !job.started {
        GrowthState::Starting
    } else if job.idle.is_none() {
        GrowthState::Growing
    } else if now.progress.time_my >= planet.end_my() {
        GrowthState::Finished
    } else if planet.paused || planet.pace.rate() == Some(0.0) {
        GrowthState::Resting
    } else {
        GrowthState::Growing
    };
    now
}
