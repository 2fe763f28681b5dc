//! What the game and the thread that grows a planet tell each other: orders one way, a report the other.

use super::{
    events::GrowthFailure, grower::Worker, statistics::PlanetStatistics, surface::PlanetSurface,
};
use crate::simulation::{
    Cancellation, EventRecord, Intervention, Progress, TectonicError, TectonicEvent,
};
use std::sync::{Mutex, MutexGuard, OnceLock, PoisonError};

/// Both sides hold the lock only to copy a few values, never while they work.
#[derive(Debug, Default)]
pub(super) struct Desk {
    papers: Mutex<Papers>,
    cancellation: OnceLock<Cancellation>,
}

#[derive(Debug, Default)]
struct Papers {
    orders: Orders,
    report: Report,
    /// What shall happen at the next step.
    asked: Vec<Intervention>,
    /// Files to which the history is to be saved.
    #[cfg(feature = "save")]
    saves: Vec<std::path::PathBuf>,
}

/// What the game wants.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Orders {
    /// The history runs while its time lies before this, in My.
    pub target_my: f64,
    /// When the history is finished, in My.
    pub end_my: f64,
    /// Whether only steps that are owed run.
    pub paused: bool,
    /// Steps to run whatever the time, while paused.
    pub steps: u32,
    /// Whether to take snapshots before the end.
    pub publish: bool,
    /// The planet is gone, or grows anew.
    pub stop: bool,
}

/// What the thread has done since the last look.
#[derive(Debug, Default)]
pub(super) struct Report {
    pub progress: Progress,
    /// Empty when nothing has changed.
    pub stage_seconds: Vec<(&'static str, f64)>,
    pub snapshot: Option<(PlanetSurface, PlanetStatistics)>,
    /// Events that were asked for, as the history's recipe has them now.
    pub recorded: Vec<TectonicEvent>,
    /// What became of events, of the recipe's too.
    pub happened: Vec<EventRecord>,
    /// What was asked for but is not possible at all.
    pub refused: Vec<(Intervention, TectonicError)>,
    /// What has been saved.
    #[cfg(feature = "save")]
    pub saved: Vec<super::saves::Saved>,
    /// The history, when it rests.
    pub returned: Option<Box<Worker>>,
    pub failure: Option<GrowthFailure>,
}

impl Desk {
    fn papers(&self) -> MutexGuard<'_, Papers> {
        // Values are replaced whole, so a panic elsewhere cannot have left half of one.
        self.papers.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Gives orders; steps add up while paused. Returns what there is to report.
    pub(super) fn order(&self, orders: Orders) -> Report {
        let papers = &mut *self.papers();
        let steps = if orders.paused {
            papers.orders.steps.saturating_add(orders.steps)
        } else {
            0
        };
        papers.orders = Orders { steps, ..orders };
        let progress = papers.report.progress;
        core::mem::replace(
            &mut papers.report,
            Report {
                progress,
                ..Report::default()
            },
        )
    }

    /// Stops the history between two stages. Returns it if it lay here.
    pub(super) fn stop(&self) -> Option<Box<Worker>> {
        if let Some(cancellation) = self.cancellation.get() {
            cancellation.cancel();
        }
        let papers = &mut *self.papers();
        papers.orders.stop = true;
        papers.report.returned.take()
    }

    /// Makes a new history stoppable.
    pub(super) fn watch(&self, cancellation: Cancellation) {
        // Each desk has one history.
        let _ = self.cancellation.set(cancellation);
        let stop = self.papers().orders.stop;
        if stop && let Some(cancellation) = self.cancellation.get() {
            cancellation.cancel();
        }
    }

    /// Takes one step off those owed, if there is one.
    pub(super) fn take_step(&self) -> (Orders, bool) {
        let orders = &mut self.papers().orders;
        let before = *orders;
        orders.steps = before.steps.saturating_sub(1);
        (before, before.steps > 0)
    }

    /// Puts a step back that was taken too early.
    pub(super) fn owe_step(&self) {
        let orders = &mut self.papers().orders;
        orders.steps = orders.steps.saturating_add(1);
    }

    /// Asks for changes at the next step.
    pub(super) fn ask(&self, what: Vec<Intervention>) {
        if !what.is_empty() {
            self.papers().asked.extend(what);
        }
    }

    /// Takes what was asked for.
    pub(super) fn take_asked(&self) -> Vec<Intervention> {
        core::mem::take(&mut self.papers().asked)
    }

    /// Asks for the history to be saved.
    #[cfg(feature = "save")]
    pub(super) fn ask_to_save(&self, paths: Vec<std::path::PathBuf>) {
        self.papers().saves.extend(paths);
    }

    /// Takes what is to be saved.
    #[cfg(feature = "save")]
    pub(super) fn take_saves(&self) -> Vec<std::path::PathBuf> {
        core::mem::take(&mut self.papers().saves)
    }

    /// Whether anything is still to be saved.
    #[cfg(feature = "save")]
    pub(super) fn has_saves(&self) -> bool {
        !self.papers().saves.is_empty()
    }

    /// Whether the last snapshot was taken.
    pub(super) fn wants_snapshot(&self) -> bool {
        self.papers().report.snapshot.is_none()
    }

    /// Lays a change of the report on the desk.
    pub(super) fn report(&self, write: impl FnOnce(&mut Report)) {
        write(&mut self.papers().report);
    }

    /// Takes a history that rests, unless nobody waits for it: then it is dropped. Each knows the other,
    /// so together they would live for ever.
    pub(super) fn give_back(&self, worker: Box<Worker>) {
        let mut papers = self.papers();
        if papers.orders.stop {
            // Not under the lock: a world is large.
            drop(papers);
            drop(worker);
        } else {
            papers.report.returned = Some(worker);
        }
    }
}
