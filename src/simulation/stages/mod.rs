//! The stages of a step, one file each, in the order of [`TectonicSystems`](super::TectonicSystems).

pub(super) mod apply_events;
pub(super) mod apply_forces;
pub(super) mod classify_boundaries;
pub(super) mod create_crust;
mod crushed_crust;
pub(super) mod erode;
pub(super) mod hot_spots;
mod inland;
#[path = "move.rs"]
pub(super) mod motion;
pub(super) mod refine;
pub(super) mod reorganize_plates;
pub(super) mod repair_mesh;
pub(super) mod resolve_collisions;
pub(super) mod sort_rows;
pub(super) mod uplift;
pub(super) mod wear;

pub use apply_forces::mantle::Mantle;
#[cfg(feature = "save")]
pub(crate) use erode::RockColumn;
pub use erode::sea_floor_depth;
pub use reorganize_plates::Splits;
