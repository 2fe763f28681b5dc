//! What can be asked of a [`Surface`](crate::simulation::Surface): the ground in any direction, its
//! boundaries and plates, and where rays meet it.
//!
//! | question | asked of |
//! |---|---|
//! | how high, which way is up, what is it made of | [`elevation`], [`at`], [`at_lat_lon`], [`normal`], [`point`] |
//! | which fault is near, where are all of them | [`nearest_boundary`], [`boundaries`] |
//! | which plates are there, where is the coast | [`plates`], [`coasts`] |
//! | what does a ray hit | [`ray`] |
//! | where is the highest range, the longest ridge, a rift | [`landmark`] |
//! | ground for a collider or a navigation mesh | [`patch`] |
//! | the ground in more detail than was simulated | [`Raster`], and down to metres `Terrain` (feature `terrain`) |
//! | its fields as colours | [`Overlay`] |
//!
//! # Places
//!
//! A place is a direction from the planet's centre in the planet's own frame: north is +Z, longitude 0 on
//! the equator +X, longitude 90° east +Y. Queries take directions of any length; the north pole stands for
//! one that is zero or not finite, and no query panics. [`direction_of`] and [`lat_lon`] translate to and
//! from degrees, [`east_north`] gives the other two axes.
//!
//! # Two kinds of ground
//!
//! A surface interpolates the elevations that were simulated, one per sub-plate: smooth, fast, and all
//! that rays, normals and patches know. [`Raster`] adds noise on top, ragged coasts, rough mountains and
//! bent boundaries: what maps show. Ask the surface about physics and history, the raster where
//! something must fit a map. They differ by up to a spacing of sub-plates sideways. `Terrain` starts from the
//! raster's ground and goes on where that ends: from some 40 km down to a metre.
//!
//! # Costs
//!
//! Queries cost about a microsecond, on planets of any size. What they share is worked out when first
//! asked for; [`prepare`] does so at once, best in the background. A surface is `Send` and `Sync`: put it
//! in an `Arc` and ask from many threads.
//!
//! [`elevation`]: crate::simulation::Surface::elevation
//! [`at`]: crate::simulation::Surface::at
//! [`at_lat_lon`]: crate::simulation::Surface::at_lat_lon
//! [`normal`]: crate::simulation::Surface::normal
//! [`point`]: crate::simulation::Surface::point
//! [`nearest_boundary`]: crate::simulation::Surface::nearest_boundary
//! [`boundaries`]: crate::simulation::Surface::boundaries
//! [`plates`]: crate::simulation::Surface::plates
//! [`coasts`]: crate::simulation::Surface::coasts
//! [`ray`]: crate::simulation::Surface::ray
//! [`patch`]: crate::simulation::Surface::patch
//! [`landmark`]: crate::simulation::Surface::landmark
//! [`prepare`]: crate::simulation::Surface::prepare

mod boundary;
mod coordinates;
mod crossing;
#[cfg(any(feature = "export", feature = "render"))]
pub(crate) mod cube;
pub(crate) mod ground;
mod landmarks;
mod overlay;
mod patch;
mod plates;
mod query;
mod ramp;
pub(crate) mod raster;
mod ray;
mod start;
#[cfg(feature = "terrain")]
mod terrain;
pub(crate) mod texture;
#[cfg(any(feature = "export", feature = "render"))]
pub(crate) mod tint;

pub use crate::simulation::surface::{BoundarySegment, PlateSummary};
pub use boundary::NearBoundary;
pub use coordinates::{direction_of, east_north, lat_lon};
pub use landmarks::Landmark;
#[cfg(feature = "render")]
pub(crate) use overlay::{ARROW_COLOR, ARROW_LONGEST, ARROW_RADII, OUTLINE};
pub use overlay::{Legend, LegendEntry, Overlay, OverlayValues, boundary_color, plate_color};
pub use patch::HeightField;
pub use query::{Place, Relief};
#[cfg(feature = "export")]
pub(crate) use raster::check_columns;
pub use raster::{Pixel, Raster, direction};
pub use ray::RayHit;
#[cfg(feature = "terrain")]
pub use terrain::{Exemplar, ExemplarError, Exemplars, Landform, Survey, Terrain, TerrainSample};
#[cfg(all(feature = "render", feature = "terrain"))]
pub(crate) use terrain::{TooWide, Words, vectors, weights};

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
