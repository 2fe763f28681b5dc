//! What can be asked of a [`Surface`](crate::simulation::Surface): the ground in any direction.
//!
//! [`Raster`] samples it finer than its sub-plates, with ragged coasts and rough mountains. [`Overlay`]
//! shows its fields as colours.

mod overlay;
mod ramp;
pub(crate) mod raster;
mod texture;
#[cfg(any(feature = "export", feature = "render"))]
pub(crate) mod tint;

pub use overlay::{
    Legend, LegendEntry, Overlay, OverlayValues, boundary_color, plate_color,
};
#[cfg(feature = "render")]
pub(crate) use overlay::{ARROW_COLOR, ARROW_LONGEST, ARROW_RADII, OUTLINE};
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
