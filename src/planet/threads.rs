//! Threads on which planets grow.

use bevy::prelude::*;
use bevy::tasks::{TaskPool, TaskPoolBuilder, available_parallelism};
use core::time::Duration;
use std::sync::Arc;

/// Threads of the planets' own: long work on Bevy's task pools would hold up the game's.
#[derive(Resource, Debug, Clone, Default)]
pub struct PlanetThreads(Option<Arc<TaskPool>>);

impl PlanetThreads {
    /// Time that planets may take in each frame where there are no threads.
    pub(super) const SLICE: Duration = Duration::from_millis(4);

    /// This many threads, which the planets share step by step. With none, and on platforms without
    /// threads such as the web, planets grow in short slices within the game's frames.
    #[must_use]
    pub fn new(threads: usize) -> Self {
        if threads == 0 || cfg!(target_arch = "wasm32") {
            return Self(None);
        }
        Self(Some(Arc::new(
            TaskPoolBuilder::new()
                .num_threads(threads)
                .thread_name("Planets".into())
                .build(),
        )))
    }

    /// One thread less than the machine has cores, but at least one.
    #[must_use]
    pub fn available() -> Self {
        Self::new(available_parallelism().saturating_sub(1).max(1))
    }

    pub(super) fn has_any(&self) -> bool {
        self.0.is_some()
    }

    /// Runs work beside the game. Without threads it is dropped.
    pub(super) fn spawn(&self, work: impl Future<Output = ()> + Send + 'static) {
        if let Some(pool) = &self.0 {
            pool.spawn(work).detach();
        }
    }

    /// Drops something large where no frame waits for it.
    pub(super) fn retire(&self, what: impl Send + 'static) {
        if let Some(pool) = &self.0 {
            pool.spawn(async move { drop(what) }).detach();
        }
    }
}
