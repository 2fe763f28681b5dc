//! The history of a planet: sub-plates as entities on one mesh, a step of ordered stages.
//!
//! [`History`] is the way in: a [`Recipe`] goes in, steps are run, a [`Surface`] comes out. Under it
//! lies an ordinary Bevy world: sub-plates are entities ([`SubPlate`]), plates are entities
//! ([`Plate`]), the mesh and the books are resources, and each stage is a plugin of
//! [`SimulationPlugins`] that can be replaced.
//!
//! # Determinism
//!
//! The same recipe grows the same planet, bit for bit. Sums run in a fixed order, random numbers
//! come from streams keyed by what they decide ([`streams`]), transcendental functions from `libm`.

mod boundaries;
mod check;
pub(crate) mod checkpoint;
mod clock;
mod columns;
pub mod constants;
mod error;
mod events;
#[cfg(test)]
mod fixtures;
mod history;
mod hot_spot;
pub mod laws;
mod ledger;
mod plate;
mod plugin;
pub(crate) mod precision;
mod reach;
mod recipe;
mod rotations;
mod schedule;
mod sea;
mod stages;
mod start;
mod statistics;
pub mod streams;
mod sub_plate;
pub(crate) mod surface;
mod topology;
mod workers;

pub use boundaries::{Boundaries, Contact, Contacts, Front, FrontForce, FrontForces, Motion, Rift};
pub use checkpoint::Checkpoint;
pub use clock::{Clock, Tick};
pub use columns::Columns;
pub use error::TectonicError;
pub(crate) use events::record as record_event;
pub use events::{
    EventFailure, EventLog, EventRecord, HeldMotion, Intervention, LatLon, NewCrust, PlateChoice,
    TectonicEvent,
};
pub use history::{History, Outcome, Progress};
pub use hot_spot::HotSpot;
pub use ledger::Ledger;
pub use plate::{
    DrivingTorque, NextPlateId, Plate, PlateArea, PlateBorn, PlateRow, PlateTable, Rotation,
};
pub use plugin::{
    ApplyEventsPlugin, ApplyForcesPlugin, ClassifyBoundariesPlugin, CreateCrustPlugin, ErodePlugin,
    MovePlugin, RefinePlugin, ReorganizePlatesPlugin, RepairMeshPlugin, ResolveCollisionsPlugin,
    SimulationPlugin, SimulationPlugins, UpliftPlugin,
};
pub use reach::{Reach, reach};
pub use recipe::{Drive, FEWEST_SUB_PLATES, MOST_SUB_PLATES, Recipe, RecipeError, Start};
pub use rotations::{PlateRotations, RotationHistory, RotationHistoryPlugin, TotalRotation};
pub use schedule::{
    Cancellation, StageTimings, StepFailure, TectonicStep, TectonicSystems, record_failure,
};
pub use sea::Sea;
#[cfg(feature = "save")]
pub(crate) use stages::RockColumn;
pub use stages::{Mantle, Splits, sea_floor_depth};
pub use start::{
    Column, EulerRotation, HeightMap, Hypsometry, ImageStart, ImportedPlate, ImportedWorld, Normal,
    Normals, PlatePolygon, populate,
};
pub use statistics::{
    Gathering, Measure, Statistics, StatisticsHistory, StatisticsInterval, StatisticsPlugin,
};
pub use sub_plate::{
    Created, Crust, Deviation, Elevation, FoldDirection, MaterialArea, Orogeny, OrogenyBegan,
    PlateId, Position, RidgeDirection, Slab, SubPlate, Thickness, Trench, Velocity, Volcanism,
};
pub use surface::Surface;
pub use topology::{BoundaryKind, EdgeState, Topology};
pub use workers::Workers;
