//! Threads of the simulation's own, so that a game's frame never waits for a step.

use bevy::prelude::*;
use bevy::tasks::{TaskPool, TaskPoolBuilder};
use core::{ops::Range, panic::AssertUnwindSafe};
use std::{
    panic::{catch_unwind, resume_unwind},
    sync::{Mutex, PoisonError},
};

/// Rows of one piece of parallel work. Fixed, so that no result depends on the number of threads.
pub(super) const CHUNK: usize = 2048;
/// Pieces that a sweep is cut into at most: each costs a microsecond or two.
const PIECES: usize = 64;

/// The same for work on few things that each cost more, such as fronts.
pub(super) const FEW: usize = 512;

/// Threads on which stages split their work; none by default.
#[derive(Resource, Debug, Default)]
pub struct Workers(Option<TaskPool>);

impl Workers {
    /// This many threads, the caller's among them.
    #[must_use]
    pub fn new(threads: usize) -> Self {
        Self((threads > 1).then(|| {
            TaskPoolBuilder::new()
                .num_threads(threads - 1)
                .thread_name("Tectonics".into())
                .build()
        }))
    }

    /// Maps fixed ranges of `0..count` and returns the results in their order.
    pub fn map<T: Send + 'static>(
        &self,
        count: usize,
        work: impl Fn(Range<usize>) -> T + Sync,
    ) -> Vec<T> {
        let rows = CHUNK.max(count.div_ceil(PIECES));
        let ranges = (0..count.div_ceil(rows)).map(|i| i * rows..((i + 1) * rows).min(count));
        self.run(ranges, work)
    }

    /// Works on each part and returns the results in their order. Parts of columns that are written come
    /// from `chunks_mut` of [`CHUNK`] rows.
    pub(super) fn run<P: Send, T: Send + 'static>(
        &self,
        parts: impl ExactSizeIterator<Item = P> + Send,
        work: impl Fn(P) -> T + Sync,
    ) -> Vec<T> {
        let Some(pool) = self.0.as_ref().filter(|_| parts.len() > 1) else {
            return parts.map(work).collect();
        };
        // Whoever is free takes the next part. The caller begins at once, so that a thread which sleeps too
        // long costs nothing.
        let queue = Mutex::new(parts.enumerate());
        let take = || {
            let mut queue = queue.lock().unwrap_or_else(PoisonError::into_inner);
            queue.next()
        };
        // A panic waits until nobody works on borrowed columns any more.
        let attempt = |part| catch_unwind(AssertUnwindSafe(|| work(part)));
        let toil = || core::iter::from_fn(take).map(|(i, part)| (i, attempt(part)));
        let mut done = Vec::new();
        let helped = pool.scope(|scope| {
            for _ in 0..pool.thread_num() {
                scope.spawn(async { toil().collect::<Vec<_>>() });
            }
            done.extend(toil());
        });
        done.extend(helped.into_iter().flatten());
        done.sort_unstable_by_key(|(i, _)| *i);
        let results = done.into_iter().map(|(_, result)| result);
        results
            .map(|result| result.unwrap_or_else(|panic| resume_unwind(panic)))
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::sync::atomic::{AtomicUsize, Ordering};

    #[test]
    fn results_come_in_order_on_any_number_of_threads() {
        let sum = |range: Range<usize>| (range.start, range.map(|i| i as f64).sum::<f64>());
        let one = Workers::default().map(100_000, sum);
        let three = Workers::new(3).map(100_000, sum);
        assert_eq!(one, three);
        assert_eq!(one.len(), 100_000_usize.div_ceil(CHUNK));
    }

    #[test]
    fn the_first_panic_is_told_when_all_have_finished() {
        let finished = AtomicUsize::new(0);
        let work = |part: usize| {
            assert!(!part.is_multiple_of(7) || part == 0, "part {part}");
            finished.fetch_add(1, Ordering::Relaxed);
        };
        let run = || Workers::new(3).run(0..40, work);
        let panic = catch_unwind(AssertUnwindSafe(run)).unwrap_err();
        assert_eq!(panic.downcast_ref::<String>().unwrap(), "part 7");
        assert_eq!(finished.into_inner(), 40 - 5);
    }
}
