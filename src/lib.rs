//! Grow whole planets by plate tectonics.
//!
//! A [`Recipe`](simulation::Recipe) goes in, millions of years pass, and a planet with continents,
//! mountain belts, ridges and trenches comes out: on screen in a game, or without a window. The same
//! recipe grows the same planet, bit for bit, on any number of threads.
//!
//! # Getting started
//!
//! In a game, [`TectonicsPlugins`] and one entity with a [`Planet`](planet::Planet) are all it takes:
//!
//! ```
//! use bevy::prelude::*;
//! use bevy_tectonics::prelude::*;
//!
//! App::new()
//!     .add_plugins((MinimalPlugins, TectonicsPlugins)) // `DefaultPlugins` to see something
//!     .add_systems(Startup, |mut commands: Commands| {
//!         commands.spawn(Planet::new(Recipe::earth_like(42).with_sub_plates(500)));
//!     })
//!     .update();
//! ```
//!
//! Without a game, [`History`](simulation::History) runs a recipe step by step:
//!
//! ```
//! use bevy::math::DVec3;
//! use bevy_tectonics::prelude::*;
//! use core::ops::ControlFlow;
//!
//! let recipe = Recipe::earth_like(7).with_sub_plates(500);
//! let mut history = History::new(recipe)?;
//! history.run_until(2.0, |_| ControlFlow::Continue(()))?;
//!
//! let surface = history.surface()?;
//! println!("{:.0} m at the north pole", surface.elevation(DVec3::Z));
//! # Ok::<(), TectonicError>(())
//! ```
//!
//! # Table of contents
//!
//! * **Planets in a game**: [`Planet`](planet::Planet), [`Growth`](planet::Growth),
//!   [`PlanetSurface`](planet::PlanetSurface), [`PlanetView`](planet::PlanetView),
//!   [`Planets`](planet::Planets), [`SurfaceChanged`](planet::SurfaceChanged)
//! * **Seeing it**: `render`, `editor` (cargo features)
//! * **Growing a planet**: [`History`](simulation::History), [`Recipe`](simulation::Recipe),
//!   [`Start`](simulation::Start), [`Drive`](simulation::Drive), [`Laws`](simulation::laws::Laws),
//!   [`constants`](simulation::constants)
//! * **Reading it**: [`Surface`](simulation::Surface), [`Statistics`](simulation::Statistics),
//!   [`StatisticsHistory`](simulation::StatisticsHistory),
//!   [`PlanetStatistics`](planet::PlanetStatistics),
//!   [`Ledger`](simulation::Ledger)
//! * **Asking it**: [`surface`] has elevations, boundaries, plates, rays and patches of ground
//! * **Its world**: [`SubPlate`](simulation::SubPlate) and its components, [`Plate`](simulation::Plate),
//!   [`Topology`](simulation::Topology), [`Columns`](simulation::Columns)
//! * **The step**: [`TectonicStep`](simulation::TectonicStep),
//!   [`TectonicSystems`](simulation::TectonicSystems), [`Clock`](simulation::Clock)
//! * **Events**: [`Intervention`](simulation::Intervention), [`TectonicEvent`](simulation::TectonicEvent),
//!   [`History::apply`](simulation::History::apply), [`Intervene`](planet::Intervene),
//!   [`HotSpot`](simulation::HotSpot)
//! * **Stages of your own**: [`SimulationPlugins`](simulation::SimulationPlugins),
//!   [`History::with_plugins`](simulation::History::with_plugins),
//!   [`record_failure`](simulation::record_failure), [`streams`](simulation::streams),
//!   [`Workers`](simulation::Workers)
//! * **Trust**: [`History::check`](simulation::History::check),
//!   [`History::state_hash`](simulation::History::state_hash),
//!   [`TectonicError`](simulation::TectonicError)
//! * **Maps, and files for other programs**: `export` (a cargo feature)
//! * **Worlds that last and travel**: `save` (a cargo feature), [`Checkpoint`](simulation::Checkpoint), share codes:
//!   `recipe.to_string()` and `code.parse::<Recipe>()`, see [`RecipeError`](simulation::RecipeError)
//! * **Planets that begin as Earth, or as a map you drew**: `import` (a cargo feature),
//!   [`ImageStart`](simulation::ImageStart), [`ImportedWorld`](simulation::ImportedWorld)
//! * **The sphere**: [`SphereMesh`](mesh::SphereMesh), usable without Bevy's ECS
//!
//! # Cargo features
//!
//! | feature | default | adds |
//! |---|---|---|
//! | `render` | yes | planets and overlays in a Bevy scene |
//! | `export` | yes | maps, textures, models, tables, `GeoJSON`, rotations and films of a planet |
//! | `import` | with `export` | starts read from height maps and outlines of plates |
//! | `terrain` | yes | the ground between sub-plates, down to metres |
//! | `window` | yes | what the examples need to open a window |
//! | `save` | no | planets as bytes and files, to go on from where they were |
//! | `editor` | no | a control panel with `bevy_egui` |
//!
//! Without default features the crate compiles no renderer, no window and no image codec.
#![warn(missing_docs)]
#![forbid(unsafe_code)]
#![cfg_attr(docsrs, feature(doc_cfg))]

use bevy::app::{PluginGroup, PluginGroupBuilder};

#[cfg(feature = "editor")]
pub mod editor;
#[cfg(feature = "export")]
pub mod export;
#[cfg(feature = "import")]
pub mod import;
pub mod mesh;
pub mod planet;
#[cfg(feature = "render")]
pub mod render;
#[cfg(feature = "save")]
pub mod save;
pub mod simulation;
pub mod surface;

/// What most programs need.
pub mod prelude {
    pub use crate::TectonicsPlugins;
    pub use crate::planet::{
        EventHappened, Growth, GrowthFailed, GrowthFinished, GrowthProgressed, GrowthState,
        Intervene, InterventionRefused, Pace, Planet, PlanetPlugin, PlanetStatistics,
        PlanetSurface, PlanetSystems, PlanetView, Planets, Regrowth, SurfaceChanged,
    };
    #[cfg(feature = "save")]
    pub use crate::planet::{
        LoadFailed, LoadPlanet, PlanetLoaded, PlanetSaved, SaveFailed, SavePlanet,
    };
    pub use crate::simulation::{
        Crust, History, Intervention, LatLon, Orogeny, Outcome, Progress, Recipe,
        SimulationPlugins, Statistics, Surface, TectonicError, TectonicStep, TectonicSystems,
    };
    pub use crate::surface::Overlay;
}

/// Everything a game with planets needs: add it after `DefaultPlugins`.
///
/// | plugin | feature | what it does |
/// |---|---|---|
/// | [`PlanetPlugin`](planet::PlanetPlugin) | | grows planets in the background |
/// | `PlanetRenderPlugin` | `render` | draws them |
///
/// Planets are set up by replacing the plugin:
/// `TectonicsPlugins.set(PlanetPlugin::default().with_threads(2))`.
#[derive(Debug, Clone, Copy, Default)]
pub struct TectonicsPlugins;

impl PluginGroup for TectonicsPlugins {
    fn build(self) -> PluginGroupBuilder {
        let group = PluginGroupBuilder::start::<Self>().add(planet::PlanetPlugin::default());
        #[cfg(feature = "render")]
        let group = group.add(render::PlanetRenderPlugin);
        group
    }
}

/// Compiles the code of the README.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
