//! The step: a schedule of its own with one ordered set per stage.

use super::{clock::Clock, error::TectonicError, recipe::Recipe};
use bevy::ecs::schedule::{LogLevel, ScheduleBuildSettings, ScheduleLabel, SingleThreadedExecutor};
use bevy::platform::time::Instant;
use bevy::prelude::*;
use core::time::Duration;
use std::sync::{
    Arc,
    atomic::{AtomicBool, Ordering},
};

/// One step of the history. Run it with [`History::step`](super::History::step), or with
/// `world.run_schedule(TectonicStep)` in a world of your own.
#[derive(ScheduleLabel, Debug, Clone, PartialEq, Eq, Hash, Default)]
pub struct TectonicStep;

/// Stages of [`TectonicStep`], chained in this order. `First` and `Last` are empty: they are yours.
#[derive(SystemSet, Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum TectonicSystems {
    /// Yours: before anything of the step has run. The clock already shows the step's end.
    First,
    /// Scripted events whose time has come.
    ApplyEvents,
    /// Split and merge cells, and now and then sort their rows.
    Refine,
    /// Find fronts and name their kind.
    ClassifyBoundaries,
    /// New crust where plates part.
    CreateCrust,
    /// Rotations of plates, deviations of margins.
    ApplyForces,
    /// Sub-plates move: plates turn, and each sub-plate follows its [`Deviation`](super::Deviation).
    /// To push sub-plates yourself, set their deviation in `First`.
    Move,
    /// Arcs, trenches, plateaus.
    Uplift,
    /// Remove crust that goes under or is crushed.
    ResolveCollisions,
    /// Delaunay and slivers.
    RepairMesh,
    /// Wear, sediment, isostasy, sea.
    Erode,
    /// Sutures, rifts, new trenches, splinters.
    ReorganizePlates,
    /// Yours: the step is complete, every check holds.
    Last,
}

impl TectonicSystems {
    /// All stages in their order.
    pub const ALL: [Self; 13] = [
        Self::First,
        Self::ApplyEvents,
        Self::Refine,
        Self::ClassifyBoundaries,
        Self::CreateCrust,
        Self::ApplyForces,
        Self::Move,
        Self::Uplift,
        Self::ResolveCollisions,
        Self::RepairMesh,
        Self::Erode,
        Self::ReorganizePlates,
        Self::Last,
    ];

    /// Name in `snake_case`, as in file names and timings.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::First => "first",
            Self::ApplyEvents => "apply_events",
            Self::Refine => "refine",
            Self::ClassifyBoundaries => "classify_boundaries",
            Self::CreateCrust => "create_crust",
            Self::ApplyForces => "apply_forces",
            Self::Move => "move",
            Self::Uplift => "uplift",
            Self::ResolveCollisions => "resolve_collisions",
            Self::RepairMesh => "repair_mesh",
            Self::Erode => "erode",
            Self::ReorganizePlates => "reorganize_plates",
            Self::Last => "last",
        }
    }
}

/// Error that ended the step, if one did. Later stages of the step do not run.
#[derive(Resource, Debug, Clone, Default)]
pub struct StepFailure(pub Option<TectonicError>);

/// Asks a running history to stop; the step under way stops between two stages.
#[derive(Resource, Debug, Clone, Default)]
pub struct Cancellation(Arc<AtomicBool>);

impl Cancellation {
    /// Asks for the stop. May be called from any thread.
    pub fn cancel(&self) {
        self.0.store(true, Ordering::Relaxed);
    }

    /// Whether the stop was asked for.
    #[must_use]
    pub fn is_cancelled(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }
}

/// Keeps a stage's error for the caller of the step: `my_stage.pipe(record_failure)`.
pub fn record_failure(In(result): In<Result<(), TectonicError>>, mut failure: ResMut<StepFailure>) {
    if let Err(error) = result {
        failure.0.get_or_insert(error);
    }
}

/// Time spent in each stage, in the order of [`TectonicSystems::ALL`]. Never read by a decision.
#[derive(Resource, Debug, Clone)]
pub struct StageTimings {
    /// Time by stage since the start.
    pub total: [Duration; 13],
    lap: Instant,
}

impl Default for StageTimings {
    fn default() -> Self {
        Self {
            total: [Duration::ZERO; 13],
            lap: Instant::now(),
        }
    }
}

/// Builds the schedule: ordered sets, one thread, no ambiguity tolerated.
pub(super) fn configure(app: &mut App) {
    app.init_schedule(TectonicStep)
        .edit_schedule(TectonicStep, |schedule| {
            schedule
                .set_executor(SingleThreadedExecutor::new())
                .set_build_settings(ScheduleBuildSettings {
                    ambiguity_detection: LogLevel::Error,
                    ..default()
                });
            for (i, pair) in TectonicSystems::ALL.windows(2).enumerate() {
                schedule.configure_sets((pair[0], pair[1]).chain());
                let lap = move |mut timings: ResMut<StageTimings>| {
                    let now = Instant::now();
                    let spent = now - timings.lap;
                    timings.total[i] += spent;
                    timings.lap = now;
                };
                schedule.add_systems(lap.after(pair[0]).before(pair[1]));
            }
            for stage in TectonicSystems::ALL {
                schedule.configure_sets(stage.run_if(going));
            }
            schedule.add_systems(
                (
                    begin_step.run_if(going),
                    |mut timings: ResMut<StageTimings>| timings.lap = Instant::now(),
                )
                    .chain()
                    .before(TectonicSystems::First),
            );
        });
}

/// Sets the clock to the end of the step.
fn begin_step(recipe: Res<Recipe>, mut clock: ResMut<Clock>) {
    clock.begin_step(&recipe);
}

/// Stages run while the step is neither failed nor cancelled.
pub(super) fn going(failure: Res<StepFailure>, cancellation: Res<Cancellation>) -> bool {
    failure.0.is_none() && !cancellation.is_cancelled()
}
