//! A game without a window, and what its tests need to watch planets.

use bevy::prelude::*;
use bevy::time::TimeUpdateStrategy;
use bevy_tectonics::prelude::*;
use core::time::Duration;
use std::sync::{
    Arc,
    atomic::{AtomicUsize, Ordering},
};
use std::time::Instant;

/// A headless game whose clock advances by a fixed time per frame.
pub struct Game {
    pub app: App,
    pub log: Log,
}

/// What the planets have said so far.
#[derive(Resource, Debug, Clone, Default)]
pub struct Log {
    /// Times of the surfaces, in My.
    pub surfaces: Vec<f64>,
    pub firsts: usize,
    pub progress: usize,
    pub finished: usize,
    pub failures: Vec<String>,
}

impl Game {
    pub const FRAME: Duration = Duration::from_millis(16);
    /// Longest time that anything here may take on a slow machine.
    const PATIENCE: Duration = Duration::from_secs(240);

    pub fn new(plugin: PlanetPlugin) -> Self {
        let mut app = App::new();
        app.add_plugins((MinimalPlugins, plugin))
            .insert_resource(TimeUpdateStrategy::ManualDuration(Self::FRAME))
            .init_resource::<Log>()
            .add_observer(|surface: On<SurfaceChanged>, mut log: ResMut<Log>| {
                log.surfaces.push(surface.time_my);
                log.firsts += usize::from(surface.first);
            })
            .add_observer(|_: On<GrowthProgressed>, mut log: ResMut<Log>| log.progress += 1)
            .add_observer(|_: On<GrowthFinished>, mut log: ResMut<Log>| log.finished += 1)
            .add_observer(|failed: On<GrowthFailed>, mut log: ResMut<Log>| {
                log.failures.push(failed.failure.to_string());
            });
        Self {
            app,
            log: Log::default(),
        }
    }

    pub fn spawn(&mut self, planet: Planet) -> Entity {
        self.app.world_mut().spawn(planet).id()
    }

    pub fn frame(&mut self) {
        self.app.update();
        self.log = self.app.world().resource::<Log>().clone();
    }

    /// Runs frames until something holds.
    pub fn until(&mut self, mut holds: impl FnMut(&Self) -> bool) {
        let start = Instant::now();
        while !holds(self) {
            assert!(
                start.elapsed() < Self::PATIENCE,
                "waited in vain: {:?}",
                self.log
            );
            self.frame();
            std::thread::sleep(Duration::from_micros(200));
        }
    }

    pub fn planet(&mut self, entity: Entity) -> Mut<'_, Planet> {
        self.app.world_mut().get_mut::<Planet>(entity).unwrap()
    }

    pub fn growth(&self, entity: Entity) -> &Growth {
        self.app.world().get::<Growth>(entity).unwrap()
    }

    pub fn surface(&self, entity: Entity) -> Arc<Surface> {
        self.app
            .world()
            .get::<PlanetSurface>(entity)
            .unwrap()
            .share()
    }

    pub fn elapsed(&self) -> Duration {
        self.app.world().resource::<Time>().elapsed()
    }
}

/// Counts the simulation worlds that are alive, and the steps of them all.
#[derive(Debug, Clone, Default)]
pub struct Probe(Arc<Counts>);

#[derive(Debug, Default)]
struct Counts {
    worlds: AtomicUsize,
    steps: AtomicUsize,
}

/// Lives as long as its simulation world.
#[derive(Resource)]
struct Witness(Arc<Counts>);

impl Drop for Witness {
    fn drop(&mut self) {
        self.0.worlds.fetch_sub(1, Ordering::SeqCst);
    }
}

impl Probe {
    pub fn watch(&self, plugin: PlanetPlugin) -> PlanetPlugin {
        let counts = self.0.clone();
        plugin.with_simulation(move || {
            let counts = counts.clone();
            SimulationPlugins.build().add(move |app: &mut App| {
                counts.worlds.fetch_add(1, Ordering::SeqCst);
                app.insert_resource(Witness(counts.clone()));
                app.add_systems(
                    TectonicStep,
                    (|witness: Res<Witness>| {
                        witness.0.steps.fetch_add(1, Ordering::SeqCst);
                    })
                    .in_set(TectonicSystems::First),
                );
            })
        })
    }

    pub fn worlds(&self) -> usize {
        self.0.worlds.load(Ordering::SeqCst)
    }

    pub fn steps(&self) -> usize {
        self.0.steps.load(Ordering::SeqCst)
    }

    pub fn wait_for_worlds(&self, count: usize) {
        let start = Instant::now();
        while self.worlds() != count {
            assert!(start.elapsed() < Game::PATIENCE, "{} worlds", self.worlds());
            std::thread::sleep(Duration::from_millis(1));
        }
    }
}

/// Random numbers that are the same in every run (`SplitMix64`).
pub struct Dice(pub u64);

impl Dice {
    pub fn below(&mut self, bound: u64) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut bits = self.0;
        bits = (bits ^ (bits >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        bits = (bits ^ (bits >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        (bits ^ (bits >> 31)) % bound
    }
}

/// Memory of this process that is in use; 0 where the system does not tell.
pub fn resident_bytes() -> u64 {
    let pages = std::fs::read_to_string("/proc/self/statm")
        .ok()
        .and_then(|line| line.split(' ').nth(1)?.parse::<u64>().ok());
    4096 * pages.unwrap_or(0)
}
