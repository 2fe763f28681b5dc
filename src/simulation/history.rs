//! A history: one world, one planet, from its recipe to any later time.

use super::{
    check,
    checkpoint::Checkpoint,
    clock::Clock,
    error::TectonicError,
    events::{self, EventLog, EventRecord, Intervention, TectonicEvent},
    ledger::Ledger,
    plugin::SimulationPlugins,
    recipe::Recipe,
    schedule::{Cancellation, StageTimings, StepFailure, TectonicStep, TectonicSystems},
    start::{self, ImportedWorld},
    statistics::{self, Statistics, StatisticsHistory, StatisticsInterval},
    surface::Surface,
    workers::Workers,
};
use bevy::app::PluginGroup;
use bevy::prelude::*;
use core::ops::ControlFlow;
use serde::Serialize;

/// Where a long run stands.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct Progress {
    /// Time since the start in My.
    pub time_my: f64,
    /// When the run ends, in My.
    pub end_my: f64,
    /// Steps since the start.
    pub steps: u64,
    /// Share of the run that is done, 0 to 1.
    pub fraction: f64,
}

/// How a run ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Outcome {
    /// At its end.
    Finished,
    /// Earlier, because it was told to.
    Cancelled,
}

/// A planet's history in a world of its own.
///
/// ```
/// use bevy_tectonics::prelude::*;
///
/// let mut history = History::new(Recipe::earth_like(7).with_sub_plates(500))?;
/// history.run_until(5.0, |_| core::ops::ControlFlow::Continue(()))?;
/// println!("{:.1} % land", 100.0 * history.statistics()?.land_share);
/// # Ok::<(), TectonicError>(())
/// ```
#[derive(Debug)]
pub struct History {
    world: World,
    /// Whether a step has stopped half-way.
    is_interrupted: bool,
}

impl History {
    /// The start of a planet.
    ///
    /// # Errors
    /// [`TectonicError::Recipe`] for an invalid recipe, [`TectonicError::Build`] if its points
    /// cannot be triangulated, [`TectonicError::Import`] for a start that must be
    /// [`imported`](Self::imported).
    pub fn new(recipe: Recipe) -> Result<Self, TectonicError> {
        Self::with_plugins(recipe, SimulationPlugins)
    }

    /// The start of a planet whose stages work on this many threads. The planet is the same on any
    /// number of them.
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub fn with_threads(recipe: Recipe, threads: usize) -> Result<Self, TectonicError> {
        let mut history = Self::new(recipe)?;
        history.world.insert_resource(Workers::new(threads));
        Ok(history)
    }

    /// The start of a planet whose stages are yours to choose: disable or replace plugins of
    /// [`SimulationPlugins`], and add systems of your own to [`TectonicStep`].
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub fn with_plugins(recipe: Recipe, plugins: impl PluginGroup) -> Result<Self, TectonicError> {
        Self::begin(&recipe, plugins, None)
    }

    /// The start of a planet that was made elsewhere, for a recipe with [`Start::Image`](super::Start::Image). The
    /// cargo feature `import` reads such a world from files; here it may come from anywhere.
    ///
    /// ```
    /// use bevy_tectonics::prelude::*;
    /// use bevy_tectonics::simulation::{HeightMap, ImageStart, ImportedWorld, Start};
    ///
    /// let mut recipe = Recipe::earth_like(7).with_sub_plates(500);
    /// recipe.start = Start::Image(ImageStart::default());
    /// let row = |y: usize| (0..64).map(move |x| if x < 24 && y > 8 { 300.0 } else { -4000.0 });
    /// let world = ImportedWorld {
    ///     heights: HeightMap::new(64, (0..32).flat_map(row).collect())?,
    ///     plates: Vec::new(),
    /// };
    /// let mut history = History::imported(recipe, world, SimulationPlugins)?;
    /// assert!(history.statistics()?.land_share > 0.2);
    /// # Ok::<(), TectonicError>(())
    /// ```
    ///
    /// # Errors
    /// As [`new`](Self::new), and [`TectonicError::Import`] if the world cannot be used.
    pub fn imported(
        recipe: Recipe,
        imported: ImportedWorld,
        plugins: impl PluginGroup,
    ) -> Result<Self, TectonicError> {
        Self::begin(&recipe, plugins, Some(imported))
    }

    fn begin(
        recipe: &Recipe,
        plugins: impl PluginGroup,
        imported: Option<ImportedWorld>,
    ) -> Result<Self, TectonicError> {
        recipe.validate()?;
        let mut world = empty_world(plugins);
        if let Some(imported) = imported {
            world.insert_resource(imported);
        }
        start::populate(&mut world, recipe)?;
        if world
            .get_resource::<StatisticsInterval>()
            .is_some_and(|interval| interval.is_set())
        {
            statistics::record(&mut world)?;
        }
        Ok(Self {
            world,
            is_interrupted: false,
        })
    }

    /// The planet as it is now, as plain data that may be kept, and gone on from any number of times.
    ///
    /// ```
    /// use bevy_tectonics::prelude::*;
    ///
    /// let mut history = History::new(Recipe::earth_like(7).with_sub_plates(500))?;
    /// history.step()?;
    /// let then = history.checkpoint()?;
    /// history.step()?;
    /// let mut again = History::resume(then, SimulationPlugins)?;
    /// again.step()?;
    /// assert_eq!(again.state_hash()?, history.state_hash()?);
    /// # Ok::<(), TectonicError>(())
    /// ```
    ///
    /// # Errors
    /// [`TectonicError::Archetype`] if the sub-plates no longer lie in one table,
    /// [`TectonicError::Interrupted`] once a step has failed or was cancelled.
    pub fn checkpoint(&mut self) -> Result<Checkpoint, TectonicError> {
        if self.is_interrupted {
            let time_my = self.time_my();
            return Err(TectonicError::Interrupted { time_my });
        }
        Checkpoint::take(&mut self.world)
    }

    /// Goes on from a moment of another history: with the same stages to the same bits, on any number of
    /// threads. Components of your own begin with their defaults.
    ///
    /// # Errors
    /// [`TectonicError::Recipe`] if the recipe is not allowed any more.
    pub fn resume(
        checkpoint: Checkpoint,
        plugins: impl PluginGroup,
    ) -> Result<Self, TectonicError> {
        checkpoint.recipe().validate()?;
        let mut world = empty_world(plugins);
        checkpoint.fill(&mut world);
        Ok(Self {
            world,
            is_interrupted: false,
        })
    }

    /// Runs one step; nothing once the history was cancelled.
    ///
    /// # Errors
    /// Whatever a stage could not do; the world is then no longer consistent.
    pub fn step(&mut self) -> Result<(), TectonicError> {
        let end = self.recipe().duration_my.max(self.time_my());
        self.step_towards(if end > self.time_my() { end } else { f64::MAX })
    }

    /// Runs one step that does not pass `end_my`.
    fn step_towards(&mut self, end_my: f64) -> Result<(), TectonicError> {
        // Stages do not run once cancelled; neither may the clock.
        if self.cancellation().is_cancelled() {
            return Ok(());
        }
        self.world.resource_mut::<Clock>().stop_at_my = end_my;
        self.world.run_schedule(TectonicStep);
        self.world.clear_trackers();
        let failure = self.world.resource_mut::<StepFailure>().0.take();
        self.is_interrupted |= failure.is_some() || self.cancellation().is_cancelled();
        failure.map_or(Ok(()), Err)
    }

    /// Runs until a time, calling `each_step` after every step. `Break` stops the run, as does
    /// [`cancellation`](Self::cancellation).
    ///
    /// # Errors
    /// As [`step`](Self::step).
    pub fn run_until(
        &mut self,
        time_my: f64,
        mut each_step: impl FnMut(&Progress) -> ControlFlow<()>,
    ) -> Result<Outcome, TectonicError> {
        while self.time_my() < time_my {
            if self.cancellation().is_cancelled() {
                return Ok(Outcome::Cancelled);
            }
            self.step_towards(time_my)?;
            // The step may have stopped between two stages; even a last one is then not finished.
            if self.cancellation().is_cancelled() {
                return Ok(Outcome::Cancelled);
            }
            if each_step(&self.progress(time_my)).is_break() {
                return Ok(Outcome::Cancelled);
            }
        }
        Ok(Outcome::Finished)
    }

    /// Lets something happen at the start of the next step, and notes it in the
    /// [recipe](Self::recipe) so that growing that again grows the same planet, bit for bit. (As long as
    /// both run alike: where [`run_until`](Self::run_until) stops on its way, a step ends.)
    ///
    /// Returns the event as the recipe has it now. What became of it stands in the
    /// [log](Self::event_log) after that step.
    ///
    /// # Errors
    /// [`TectonicError::Recipe`] if a value lies outside its range, or there are too many events.
    pub fn apply(&mut self, what: Intervention) -> Result<TectonicEvent, TectonicError> {
        what.validate("event")?;
        let clock = self.world.resource::<Clock>();
        let event = TectonicEvent {
            at_my: clock.time_my,
            what,
            // Where a run was told to stop, no step would end by itself.
            between_steps: clock.steps > 0 && clock.time_my != clock.stop_at_my,
        };
        let mut recipe = self.world.resource_mut::<Recipe>();
        events::one_more(&recipe.events)?;
        events::record(&mut recipe.events, event.clone());
        Ok(event)
    }

    /// What became of the events so far, in the order in which they had their time.
    #[must_use]
    pub fn event_log(&self) -> &[EventRecord] {
        &self.world.resource::<EventLog>().0
    }

    /// Where a run to `end_my` stands.
    #[must_use]
    pub fn progress(&self, end_my: f64) -> Progress {
        let time_my = self.time_my();
        Progress {
            time_my,
            end_my,
            steps: self.steps(),
            fraction: if end_my > 0.0 {
                (time_my / end_my).min(1.0)
            } else {
                1.0
            },
        }
    }

    /// A handle that stops this history from another thread, between two stages.
    #[must_use]
    pub fn cancellation(&self) -> Cancellation {
        self.world.resource::<Cancellation>().clone()
    }

    /// Verifies everything the planet promises: the mesh, the fields, the plates, the ledger.
    ///
    /// # Errors
    /// The first promise that is broken.
    pub fn check(&mut self) -> Result<(), TectonicError> {
        check::check(&mut self.world)
    }

    /// What the planet measures now; also the world's [`Statistics`] from now on.
    ///
    /// # Errors
    /// [`TectonicError::Archetype`] if the sub-plates no longer lie in one table.
    pub fn statistics(&mut self) -> Result<Statistics, TectonicError> {
        let now = Statistics::measure(&mut self.world)?;
        self.world.insert_resource(now.clone());
        Ok(now)
    }

    /// Measures now, as [`statistics`](Self::statistics) does, and adds the moment to
    /// [`statistics_history`](Self::statistics_history).
    ///
    /// # Errors
    /// [`TectonicError::Archetype`] if the sub-plates no longer lie in one table.
    pub fn record_statistics(&mut self) -> Result<Statistics, TectonicError> {
        statistics::record(&mut self.world)
    }

    /// What the planet measured over time, at the moments that were recorded: by
    /// [`record_statistics`](Self::record_statistics), or by themselves once a [`StatisticsInterval`]
    /// is set.
    #[must_use]
    pub fn statistics_history(&self) -> StatisticsHistory {
        let history = self.world.get_resource::<StatisticsHistory>();
        history.cloned().unwrap_or_default()
    }

    /// An immutable copy of what people see of the planet.
    ///
    /// # Errors
    /// [`TectonicError::Archetype`] if the sub-plates no longer lie in one table.
    pub fn surface(&mut self) -> Result<Surface, TectonicError> {
        Surface::capture(&mut self.world)
    }

    /// Hash of every field of the state: equal for equal planets, on any number of threads.
    ///
    /// # Errors
    /// [`TectonicError::Archetype`] if the sub-plates no longer lie in one table.
    pub fn state_hash(&mut self) -> Result<u64, TectonicError> {
        check::state_hash(&mut self.world)
    }

    /// The recipe the planet grows from.
    #[must_use]
    pub fn recipe(&self) -> &Recipe {
        self.world.resource::<Recipe>()
    }

    /// Time since the start in My.
    #[must_use]
    pub fn time_my(&self) -> f64 {
        self.world.resource::<Clock>().time_my
    }

    /// Steps since the start.
    #[must_use]
    pub fn steps(&self) -> u64 {
        self.world.resource::<Clock>().steps
    }

    /// The books of crust.
    #[must_use]
    pub fn ledger(&self) -> Ledger {
        *self.world.resource::<Ledger>()
    }

    /// Seconds spent in each stage since the start.
    #[must_use]
    pub fn stage_seconds(&self) -> Vec<(&'static str, f64)> {
        let timings = self.world.resource::<StageTimings>();
        TectonicSystems::ALL
            .iter()
            .zip(timings.total)
            .map(|(stage, time)| (stage.name(), time.as_secs_f64()))
            .collect()
    }

    /// The world of the planet, for queries of your own.
    #[must_use]
    pub fn world(&self) -> &World {
        &self.world
    }

    /// The world of the planet, to add systems, components and resources of your own.
    pub fn world_mut(&mut self) -> &mut World {
        &mut self.world
    }
}

/// A world with the stages and without a planet.
fn empty_world(plugins: impl PluginGroup) -> World {
    let mut app = App::empty();
    plugins.build().finish(&mut app);
    app.finish();
    app.cleanup();
    core::mem::take(app.world_mut())
}
