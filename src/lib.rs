//! Grow whole planets by plate tectonics.
#![warn(missing_docs)]
#![forbid(unsafe_code)]
#![cfg_attr(docsrs, feature(doc_cfg))]

#[cfg(feature = "export")]
pub mod export;
pub mod mesh;
pub mod simulation;

/// What most programs need.
pub mod prelude {
    pub use crate::simulation::{
        Crust, History, Orogeny, Outcome, Progress, Recipe, SimulationPlugins, Statistics, Surface,
        TectonicError, TectonicStep, TectonicSystems,
    };
}
