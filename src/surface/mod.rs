//! What can be asked of a [`Surface`](crate::simulation::Surface): the ground in any direction.
//!
//! [`Raster`] samples it finer than its sub-plates, with ragged coasts and rough mountains.

pub(crate) mod ground;
mod overlay;
pub(crate) mod raster;
pub(crate) mod texture;
#[cfg(any(feature = "export", feature = "render"))]
pub(crate) mod tint;

pub use overlay::{Legend, LegendEntry, Overlay};
pub use raster::{Pixel, Raster, direction};

/// A column of a surface does not have one value per sub-plate.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("the surface has {found} values of {field} for {expected} sub-plates")]
pub struct SurfaceError {
    /// The column.
    pub field: &'static str,
    /// Its length.
    pub found: usize,
    /// The number of sub-plates.
    pub expected: usize,
}
