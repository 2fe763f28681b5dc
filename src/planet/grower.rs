//! The hidden side of a planet: its history, on a thread or at rest.

use super::{
    Planet, Regrowth,
    desk::{Desk, Orders, Report},
    events::GrowthFailure,
    statistics::PlanetStatistics,
    surface::PlanetSurface,
    threads::PlanetThreads,
};
#[cfg(feature = "save")]
use crate::simulation::Progress;
use crate::simulation::{History, Intervention, Recipe, TectonicError};
use bevy::app::PluginGroupBuilder;
use bevy::platform::time::Instant;
use bevy::prelude::*;
use bevy::tasks::futures_lite::future;
use core::{fmt, time::Duration};
use std::sync::Arc;

/// Snapshots are at least this far apart while a history runs.
const SNAPSHOT_INTERVAL: Duration = Duration::from_millis(100);
/// Snapshots take at most this share of a history's time.
const SNAPSHOT_SHARE: u32 = 10;

/// A history that falls behind the game's time makes up for this many seconds at most.
const ARREARS_SECONDS: f64 = 1.0;

/// Makes the stages of every planet's simulation world.
#[derive(Resource, Clone)]
pub(super) struct Stages(pub Arc<dyn Fn() -> PluginGroupBuilder + Send + Sync>);

impl fmt::Debug for Stages {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Stages")
    }
}

/// Holds the history of a planet while it rests, and the way to it while it runs.
#[derive(Component, Debug, Default)]
pub(super) struct Grower {
    pub job: Option<Job>,
    /// How far the game's time has come, in My; the history follows it.
    pub clock_my: f64,
    pub threads: PlanetThreads,
    /// What shall happen to the planet, until it lies on the desk of its history.
    pub asked: Vec<Intervention>,
    /// Files that a history which has ended was to be saved to, and perhaps was not.
    #[cfg(feature = "save")]
    pub unsaved: Vec<std::path::PathBuf>,
}

/// One recipe being grown.
#[derive(Debug)]
pub(super) struct Job {
    pub recipe: Recipe,
    pub desk: Arc<Desk>,
    pub idle: Option<Box<Worker>>,
    /// Files to which it is being saved.
    #[cfg(feature = "save")]
    pub saving: Vec<std::path::PathBuf>,
    /// Whether it was loaded, and so has a surface to show at once.
    pub is_loaded: bool,
    /// Whether one of its surfaces is what the game sees.
    pub shown: bool,
    /// Whether the first moment is laid out.
    pub started: bool,
    pub failed: bool,
}

impl Grower {
    /// What is being grown.
    pub(super) fn recipe(&self) -> Option<&Recipe> {
        self.job.as_ref().map(|job| &job.recipe)
    }

    /// What the planet wants in this frame, which takes `seconds` of the game's time.
    pub(super) fn orders(
        &mut self,
        planet: &Planet,
        time_my: f64,
        surface_is_shown: bool,
        seconds: f64,
        steps: u32,
    ) -> Orders {
        let end_my = planet.end_my();
        let job = self.job.as_ref();
        let shown = job.is_some_and(|job| job.shown || job.is_loaded);
        let publish = shown || !surface_is_shown || planet.regrowth == Regrowth::Shown;
        let target_my = if planet.paused {
            self.clock_my = time_my;
            f64::NEG_INFINITY
        } else if let Some(rate) = planet.pace.rate().filter(|_| publish) {
            self.clock_my += rate * seconds;
            self.clock_my = self.clock_my.min(time_my + rate * ARREARS_SECONDS);
            self.clock_my.min(end_my)
        } else {
            self.clock_my = time_my;
            end_my
        };
        Orders {
            target_my,
            end_my,
            paused: planet.paused,
            steps,
            publish,
            stop: false,
        }
    }

    /// Starts a recipe; what grew before stops within a step.
    pub(super) fn sow(&mut self, recipe: &Recipe, stages: &Stages, threads: &PlanetThreads) {
        self.begin(recipe.clone(), None, stages, threads);
    }

    /// Goes on with a history; what grew before stops within a step.
    #[cfg(feature = "save")]
    pub(super) fn plant(
        &mut self,
        history: History,
        progress: Progress,
        stages: &Stages,
        threads: &PlanetThreads,
    ) {
        self.begin(history.recipe().clone(), Some(history), stages, threads);
        if let Some(job) = &self.job {
            job.desk.report(|report| report.progress = progress);
        }
    }

    fn begin(
        &mut self,
        recipe: Recipe,
        history: Option<History>,
        stages: &Stages,
        threads: &PlanetThreads,
    ) {
        self.stop();
        self.threads = threads.clone();
        self.clock_my = history.as_ref().map_or(0.0, History::time_my);
        let desk = Arc::new(Desk::default());
        let mut events_told = 0;
        let is_loaded = history.is_some();
        if let Some(history) = &history {
            desk.watch(history.cancellation());
            events_told = history.event_log().len();
        }
        self.job = Some(Job {
            recipe: recipe.clone(),
            idle: Some(Box::new(Worker {
                desk: desk.clone(),
                recipe,
                stages: stages.clone(),
                history,
                published_my: None,
                events_told,
                next_snapshot: Instant::now(),
            })),
            desk,
            #[cfg(feature = "save")]
            saving: Vec::new(),
            is_loaded,
            shown: false,
            started: is_loaded,
            failed: false,
        });
    }

    fn stop(&mut self) {
        if let Some(job) = self.job.take() {
            #[cfg(feature = "save")]
            self.unsaved.extend(job.saving);
            let returned = job.desk.stop();
            if let Some(worker) = job.idle.or(returned) {
                self.threads.retire(worker);
            }
        }
    }
}

impl Drop for Grower {
    fn drop(&mut self) {
        self.stop();
    }
}

impl Job {
    /// Takes the history back if it rests.
    pub(super) fn receive(&mut self, report: &mut Report) {
        self.idle = report.returned.take().or(self.idle.take());
        self.started |= !report.stage_seconds.is_empty();
        self.failed |= report.failure.is_some();
    }

    /// Lets the history run if it rests and has something to do: on a thread, or until `deadline` here.
    pub(super) fn run(&mut self, orders: &Orders, threads: &PlanetThreads, deadline: Instant) {
        if self.failed {
            return;
        }
        let Some(mut worker) = self.idle.take_if(|worker| worker.is_needed(orders)) else {
            return;
        };
        if threads.has_any() {
            threads.spawn(worker.run());
            return;
        }
        loop {
            match worker.work() {
                Work::Again if Instant::now() < deadline => {}
                Work::Again | Work::Rest => {
                    self.idle = Some(worker);
                    return;
                }
                Work::Over => return,
            }
        }
    }
}

/// What is left to do after one piece of work.
enum Work {
    Again,
    Rest,
    Over,
}

/// A history with what it needs to run by itself.
#[derive(Debug)]
pub(super) struct Worker {
    desk: Arc<Desk>,
    recipe: Recipe,
    stages: Stages,
    history: Option<History>,
    published_my: Option<f64>,
    /// Events of the log that the game knows of.
    events_told: usize,
    next_snapshot: Instant,
}

impl Worker {
    /// Works until there is nothing to do. Other planets have their turn after every step.
    async fn run(mut self: Box<Self>) {
        loop {
            match self.work() {
                Work::Again => future::yield_now().await,
                Work::Rest => {
                    let desk = self.desk.clone();
                    return desk.give_back(self);
                }
                Work::Over => return,
            }
        }
    }

    fn is_needed(&self, orders: &Orders) -> bool {
        let Some(history) = &self.history else {
            return true;
        };
        #[cfg(feature = "save")]
        if self.desk.has_saves() {
            return true;
        }
        let time_my = history.time_my();
        orders.steps > 0
            || time_my < orders.target_my
            || (self.published_my != Some(time_my) && (orders.publish || time_my >= orders.end_my))
    }

    /// Lays out the first moment, or runs one step.
    fn work(&mut self) -> Work {
        match self.try_work() {
            Ok(work) => work,
            Err(error) => {
                self.desk
                    .report(|report| report.failure = Some(GrowthFailure::Tectonic(error)));
                Work::Over
            }
        }
    }

    fn try_work(&mut self) -> Result<Work, TectonicError> {
        let (orders, owed) = self.desk.take_step();
        if orders.stop {
            return Ok(Work::Over);
        }
        let Some(history) = &mut self.history else {
            let history = begin(&self.recipe, (self.stages.0)())?;
            self.desk.watch(history.cancellation());
            self.history = Some(history);
            if orders.publish || orders.end_my <= 0.0 {
                self.publish()?;
            }
            self.report_progress(&orders);
            // The step that was owed has not run yet.
            if owed {
                self.desk.owe_step();
            }
            return Ok(Work::Again);
        };
        #[cfg(feature = "save")]
        for path in self.desk.take_saves() {
            let result = crate::save::write(history, &path);
            let saved = (path, history.time_my(), result);
            self.desk.report(|report| report.saved.push(saved));
        }
        let go = owed || history.time_my() < orders.target_my;
        if go {
            // A planet's own recipe alone decides where steps end, never the game's clock.
            intervene(&self.desk, history);
            history.step()?;
            let happened = history
                .event_log()
                .get(self.events_told..)
                .unwrap_or_default();
            if !happened.is_empty() {
                self.events_told += happened.len();
                self.desk
                    .report(|report| report.happened.extend_from_slice(happened));
            }
            if history.cancellation().is_cancelled() {
                return Ok(Work::Over);
            }
            self.report_progress(&orders);
        }
        let time_my = self.history.as_ref().map_or(0.0, History::time_my);
        let due = Instant::now() >= self.next_snapshot && self.desk.wants_snapshot();
        let resting = !go || time_my >= orders.end_my;
        let wanted = orders.publish || time_my >= orders.end_my;
        if wanted && (due || resting) && self.published_my != Some(time_my) {
            self.publish()?;
        }
        Ok(if go { Work::Again } else { Work::Rest })
    }

    fn publish(&mut self) -> Result<(), TectonicError> {
        let Some(history) = &mut self.history else {
            return Ok(());
        };
        let start = Instant::now();
        let surface = history.surface()?;
        // No frame shall wait for what the first query would work out.
        surface.prepare();
        let now = history.statistics()?;
        let snapshot = PlanetSurface {
            surface: Arc::new(surface),
            statistics: Arc::new(now.clone()),
        };
        let statistics = PlanetStatistics {
            now,
            history: history.statistics_history(),
        };
        self.published_my = Some(history.time_my());
        self.desk
            .report(|report| report.snapshot = Some((snapshot, statistics)));
        self.next_snapshot =
            Instant::now() + SNAPSHOT_INTERVAL.max(SNAPSHOT_SHARE * start.elapsed());
        Ok(())
    }

    fn report_progress(&self, orders: &Orders) {
        let Some(history) = &self.history else {
            return;
        };
        let progress = history.progress(orders.end_my);
        let stage_seconds = history.stage_seconds();
        self.desk.report(|report| {
            report.progress = progress;
            report.stage_seconds = stage_seconds;
        });
    }
}

/// The first moment of a recipe, with the files it names.
fn begin(recipe: &Recipe, stages: PluginGroupBuilder) -> Result<History, TectonicError> {
    #[cfg(feature = "import")]
    return crate::import::begin(recipe.clone(), stages);
    #[cfg(not(feature = "import"))]
    History::with_plugins(recipe.clone(), stages)
}

/// Takes what was asked for into the history, and says how its recipe has it now.
fn intervene(desk: &Desk, history: &mut History) {
    for what in desk.take_asked() {
        match history.apply(what.clone()) {
            Ok(event) => desk.report(|report| report.recorded.push(event)),
            Err(error) => desk.report(|report| report.refused.push((what, error))),
        }
    }
}

impl Drop for Worker {
    fn drop(&mut self) {
        if std::thread::panicking() {
            self.desk
                .report(|report| report.failure = Some(GrowthFailure::Panicked));
        }
    }
}
