//! A planet in a game: spawn it, watch it, stand on it, grow another.
//!
//! [`PlanetPlugin`] and one entity with a [`Planet`] are all it takes. Each planet has a simulation
//! world of its own that runs on threads of the planets' own, so a frame never waits for a step; what
//! the game sees of it are immutable snapshots, [`PlanetSurface`].
//!
//! ```
//! use bevy::prelude::*;
//! use bevy_tectonics::prelude::*;
//!
//! App::new()
//!     .add_plugins((MinimalPlugins, PlanetPlugin::default()))
//!     .add_systems(Startup, |mut commands: Commands| {
//!         commands
//!             .spawn(Planet::new(Recipe::earth_like(42).with_sub_plates(500)))
//!             .observe(|grown: On<GrowthFinished>, mut commands: Commands| {
//!                 info!("{:.0} My later", grown.time_my);
//!                 commands.entity(grown.entity).despawn();
//!             });
//!     })
//!     .update();
//! # use bevy::log::info;
//! ```
//!
//! | component | who writes it | what it says |
//! |---|---|---|
//! | [`Planet`] | you | what to grow, how large, how fast, until when |
//! | [`PlanetView`] | you | how it is drawn: overlays, exaggeration, sea |
//! | [`Growth`] | the plugin | where the history stands |
//! | [`PlanetSurface`] | the plugin | the newest snapshot; there once the first is taken |
//! | [`PlanetStatistics`] | the plugin | what it measures, and measured; there with the snapshot |
//!
//! Events on the planet's entity: [`SurfaceChanged`], [`GrowthProgressed`], [`GrowthFinished`],
//! [`GrowthFailed`], [`EventHappened`]. To change a planet while it grows, trigger [`Intervene`] on it; to keep
//! it, `SavePlanet` and `LoadPlanet` (feature `save`).
//!
//! # Frames of reference
//!
//! In a planet's own space, the one of its `Transform`, north is `+Y`, as Bevy's up is, and the
//! surface lies [`Planet::radius`] from the origin. The simulation and [`Surface`](crate::simulation::Surface) have north at `+Z`:
//! [`to_scene`] and [`from_scene`] turn directions.

mod desk;
mod events;
mod frame;
mod grower;
mod growth;
mod plugin;
mod query;
#[cfg(feature = "save")]
mod saves;
mod statistics;
mod surface;
mod threads;
mod view;

pub use events::{
    EventHappened, GrowthFailed, GrowthFailure, GrowthFinished, GrowthProgressed, Intervene,
    InterventionRefused, SurfaceChanged,
};
pub use frame::{from_scene, to_scene};
pub use growth::{Growth, GrowthState};
pub use plugin::{PlanetPlugin, PlanetSystems};
pub use query::{Pick, Planets};
#[cfg(feature = "save")]
pub use saves::{LoadFailed, LoadPlanet, PlanetLoaded, PlanetSaved, SaveFailed, SavePlanet};
pub use statistics::PlanetStatistics;
pub use surface::PlanetSurface;
pub use threads::PlanetThreads;
pub use view::PlanetView;

use crate::simulation::Recipe;
use bevy::prelude::*;

/// A planet that grows. Spawn it, change it, despawn it at any time.
///
/// * Another [`recipe`](Self::recipe) grows another planet in its place, see [`Regrowth`].
/// * Despawning stops its history within one step.
/// * Neither the frame rate nor pauses nor the pace change the history: the same recipe grows the same
///   planet, bit for bit.
#[derive(Component, Debug, Clone, PartialEq, Reflect)]
#[reflect(Component)]
#[require(Growth, grower::Grower, PlanetView, Transform)]
#[cfg_attr(feature = "save", require(saves::Saves))]
pub struct Planet {
    /// What the planet grows from.
    pub recipe: Recipe,
    /// Radius at sea level in units of the game's world.
    pub radius: f32,
    /// How fast time passes.
    pub pace: Pace,
    /// Time at which the history rests, in My. None: [`Recipe::duration_my`].
    pub until_my: Option<f64>,
    /// Whether the history rests now.
    pub paused: bool,
    /// Steps still to run while paused.
    pub steps_owed: u32,
    /// What is seen while another recipe grows.
    pub regrowth: Regrowth,
}

impl Default for Planet {
    fn default() -> Self {
        Self {
            recipe: Recipe::default(),
            radius: 1.0,
            pace: Pace::default(),
            until_my: None,
            paused: false,
            steps_owed: 0,
            regrowth: Regrowth::default(),
        }
    }
}

/// How fast the time of a planet passes.
#[derive(Debug, Clone, Copy, Default, PartialEq, Reflect)]
pub enum Pace {
    /// As fast as the machine can.
    #[default]
    Fastest,
    /// This many My in a second of the game's time, or less where the machine is too slow. Zero and
    /// anything that is no positive number stand still.
    MyPerSecond(f64),
}

impl Pace {
    /// My in a second, if that is limited.
    fn rate(self) -> Option<f64> {
        match self {
            Self::MyPerSecond(rate) if rate < f64::INFINITY => Some(rate.max(0.0)),
            Self::MyPerSecond(rate) if rate.is_nan() => Some(0.0),
            _ => None,
        }
    }
}

/// What is seen while a planet with another recipe grows in place of an old one.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Reflect)]
pub enum Regrowth {
    /// The old surface, until the new history is finished. It grows at the fastest pace.
    #[default]
    Hidden,
    /// The new surface, from its first moment.
    Shown,
}

impl Planet {
    /// A planet of radius 1 that grows as fast as the machine can, until the recipe's end.
    #[must_use]
    pub fn new(recipe: Recipe) -> Self {
        Self {
            recipe,
            ..Self::default()
        }
    }

    /// The same planet with another radius, in units of the game's world.
    #[must_use]
    pub fn with_radius(mut self, radius: f32) -> Self {
        self.radius = radius;
        self
    }

    /// The same planet with another pace.
    #[must_use]
    pub fn with_pace(mut self, pace: Pace) -> Self {
        self.pace = pace;
        self
    }

    /// The same planet that rests at another time, in My.
    #[must_use]
    pub fn with_end(mut self, until_my: f64) -> Self {
        self.until_my = Some(until_my);
        self
    }

    /// The same planet with another way to show a new recipe.
    #[must_use]
    pub fn with_regrowth(mut self, regrowth: Regrowth) -> Self {
        self.regrowth = regrowth;
        self
    }

    /// Time at which the history rests, in My. No number counts as the recipe's duration.
    #[must_use]
    pub fn end_my(&self) -> f64 {
        self.until_my
            .filter(|until| !until.is_nan())
            .unwrap_or(self.recipe.duration_my)
    }

    /// Lets the history rest after the step under way.
    pub fn pause(&mut self) {
        self.paused = true;
    }

    /// Lets it go on.
    pub fn resume(&mut self) {
        self.paused = false;
        self.steps_owed = 0;
    }

    /// Pauses, and runs one step, beyond the end too.
    pub fn step(&mut self) {
        self.paused = true;
        self.steps_owed = self.steps_owed.saturating_add(1);
    }

    /// Runs on until the first step that reaches this time, in My. A history cannot run backwards:
    /// an earlier time lets it rest where it is.
    pub fn run_to(&mut self, time_my: f64) {
        self.until_my = Some(time_my);
        self.resume();
    }
}
