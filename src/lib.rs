//! Grow whole planets by plate tectonics.
//!
//! A [`Recipe`](simulation::Recipe) goes in, millions of years pass, and a planet with continents,
//! mountain belts, ridges and trenches comes out. It needs no window, and the same recipe grows the same
//! planet, bit for bit, on any number of threads.
//!
//! # Getting started
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
//! `cargo run --release --example generate -- --seed 7 --out target/planet` grows a planet and writes
//! its maps.
//!
//! # Table of contents
//!
//! * **Growing a planet**: [`History`](simulation::History), [`Recipe`](simulation::Recipe),
//!   [`Start`](simulation::Start), [`Drive`](simulation::Drive), [`constants`](simulation::constants)
//! * **Reading it**: [`Surface`](simulation::Surface), [`Statistics`](simulation::Statistics),
//!   [`Ledger`](simulation::Ledger)
//! * **Asking it**: [`surface`] has elevations, boundaries, plates, rays and patches of ground
//! * **Its world**: [`SubPlate`](simulation::SubPlate) and its components, [`Plate`](simulation::Plate),
//!   [`Topology`](simulation::Topology), [`Columns`](simulation::Columns)
//! * **The step**: [`TectonicStep`](simulation::TectonicStep),
//!   [`TectonicSystems`](simulation::TectonicSystems), [`Clock`](simulation::Clock)
//! * **Stages of your own**: [`SimulationPlugins`](simulation::SimulationPlugins),
//!   [`History::with_plugins`](simulation::History::with_plugins),
//!   [`record_failure`](simulation::record_failure), [`streams`](simulation::streams),
//!   [`Workers`](simulation::Workers)
//! * **Trust**: [`History::check`](simulation::History::check),
//!   [`History::state_hash`](simulation::History::state_hash),
//!   [`TectonicError`](simulation::TectonicError)
//! * **Maps**: `export` (a cargo feature)
//! * **The sphere**: [`SphereMesh`](mesh::SphereMesh), usable without Bevy's ECS
//!
//! # Cargo features
//!
//! | feature | default | adds |
//! |---|---|---|
//! | `export` | yes | equirectangular maps, the coloured relief map and `planet.json` |
//!
//! Without default features the crate compiles no renderer, no window and no image codec.
#![warn(missing_docs)]
#![forbid(unsafe_code)]
#![cfg_attr(docsrs, feature(doc_cfg))]

#[cfg(feature = "editor")]
pub mod editor;
#[cfg(feature = "export")]
pub mod export;
pub mod mesh;
pub mod planet;
#[cfg(feature = "render")]
pub mod render;
pub mod simulation;
pub mod surface;

/// What most programs need.
pub mod prelude {
    pub use crate::planet::{
        Growth, GrowthFailed, GrowthFinished, GrowthProgressed, GrowthState, Pace, Planet,
        PlanetPlugin, PlanetSurface, PlanetSystems, PlanetView, Planets, Regrowth, SurfaceChanged,
    };
    pub use crate::simulation::{
        Crust, History, Orogeny, Outcome, Progress, Recipe, SimulationPlugins, Statistics, Surface,
        TectonicError, TectonicStep, TectonicSystems,
    };
    pub use crate::surface::Overlay;
}

/// Compiles the code of the README.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
