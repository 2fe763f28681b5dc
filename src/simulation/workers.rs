//! Threads of the simulation's own, so that a game's frame never waits for a step.

use bevy::{
    platform::time::Instant,
    prelude::*,
    tasks::{TaskPool, TaskPoolBuilder, futures_lite::future::yield_now},
};
use core::{
    hint::spin_loop,
    ops::Range,
    panic::AssertUnwindSafe,
    sync::atomic::{AtomicUsize, Ordering},
    time::Duration,
};
use std::{
    panic::{catch_unwind, resume_unwind},
    sync::{Arc, Mutex, PoisonError},
};

/// Rows of one piece of parallel work. Fixed, so that no result depends on the number of threads.
pub(super) const CHUNK: usize = 2048;
/// Pieces that a sweep is cut into at most: each costs a microsecond or two.
const PIECES: usize = 64;

/// The same for work on few things that each cost more, such as fronts.
pub(super) const FEW: usize = 512;

/// How long a thread stays awake for the next parallel work. To wake one takes tens of microseconds, and a step
/// has some thirty such works, on average some tenths of a millisecond apart.
const VIGIL: Duration = Duration::from_micros(500);
/// Turns of an idle thread's loop between two looks for work, some tenths of a microsecond.
const TURNS: u32 = 16;
/// Turns for which the caller waits for others without sleeping, a few tenths of a millisecond.
const PATIENCE: u32 = 8192;

/// Threads on which stages split their work; none by default.
#[derive(Resource, Debug, Default)]
pub struct Workers(Option<Crew>);

/// Threads that stay awake from one work to the next.
#[derive(Debug)]
struct Crew {
    pool: TaskPool,
    vigil: Arc<Vigil>,
}

impl Crew {
    /// Tells the threads that there is work, and that more is to be expected.
    fn rouse(&self) {
        self.vigil.works.fetch_add(1, Ordering::Relaxed);
        while self.vigil.awake.load(Ordering::Relaxed) < self.pool.thread_num() {
            self.vigil.awake.fetch_add(1, Ordering::Relaxed);
            self.pool.spawn(self.vigil.clone().keep()).detach();
        }
    }
}

/// What keeps threads from falling asleep while they may soon be needed again.
#[derive(Debug, Default)]
struct Vigil {
    /// Tasks that keep a thread awake.
    awake: AtomicUsize,
    /// Works so far.
    works: AtomicUsize,
}

impl Vigil {
    /// Does nothing, in turns with what else there is to do, until no work has come for a while.
    async fn keep(self: Arc<Self>) {
        let (mut works, mut since) = (self.works.load(Ordering::Relaxed), Instant::now());
        while since.elapsed() < VIGIL {
            for _ in 0..TURNS {
                spin_loop();
            }
            yield_now().await;
            let now = self.works.load(Ordering::Relaxed);
            if now != works {
                (works, since) = (now, Instant::now());
            }
        }
        self.awake.fetch_sub(1, Ordering::Relaxed);
    }
}

impl Workers {
    /// This many threads, the caller's among them.
    #[must_use]
    pub fn new(threads: usize) -> Self {
        Self((threads > 1).then(|| {
            let pool = TaskPoolBuilder::new()
                .num_threads(threads - 1)
                .thread_name("Tectonics".into())
                .build();
            Crew {
                pool,
                vigil: Arc::default(),
            }
        }))
    }

    /// How many there are, the caller's among them. No result may depend on it.
    pub(super) fn threads(&self) -> usize {
        let helpers = self.0.as_ref().map_or(0, |crew| crew.pool.thread_num());
        1 + helpers
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
        let Some(crew) = self.0.as_ref().filter(|_| parts.len() > 1) else {
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
        let (begun, ended) = (AtomicUsize::new(0), AtomicUsize::new(0));
        let mut done = Vec::new();
        let helped = crew.pool.scope(|scope| {
            for _ in 0..crew.pool.thread_num() {
                scope.spawn(async {
                    begun.fetch_add(1, Ordering::AcqRel);
                    let done = toil().collect::<Vec<_>>();
                    ended.fetch_add(1, Ordering::AcqRel);
                    done
                });
            }
            crew.rouse();
            done.extend(toil());
            // Whoever is at a last part has mostly nearly finished: to sleep until then would take longer.
            let busy = || ended.load(Ordering::Acquire) < begun.load(Ordering::Acquire);
            for _ in (0..PATIENCE).take_while(|_| busy()) {
                spin_loop();
            }
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
