//! Sampling a surface, finer than its sub-plates.

use std::f64::consts::PI;

use glam::{DVec3, Vec3};

use super::{
    SurfaceError,
    ground::{Corner, Ground},
    texture::Texture,
};
use crate::simulation::{Crust, Surface};

/// The planet at one place.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Pixel {
    /// Metres above sea level.
    pub elevation: f32,
    /// Kind of crust.
    pub crust: Crust,
    /// Time since the crust was made, My.
    pub age: f32,
    /// Plate id, 0 = none.
    pub plate: u16,
    /// Velocity of the plate, km/My (= mm/yr), in the planet's frame.
    pub velocity: Vec3,
    /// Local relief for shading, in units of the elevation's detail, −1 to 1.
    pub(crate) grain: f32,
}

/// The direction of a longitude and latitude in radians. North is +Z, longitude 0 on the equator +X,
/// longitude 90° east +Y.
#[must_use]
pub fn direction(longitude: f64, latitude: f64) -> DVec3 {
    let (sin_lon, cos_lon) = libm::sincos(longitude);
    let (sin_lat, cos_lat) = libm::sincos(latitude);
    DVec3::new(cos_lat * cos_lon, cos_lat * sin_lon, sin_lat)
}

/// Samples a [`Surface`] anywhere, with coasts and terrain finer than its sub-plates.
///
/// * Plate and velocity are those of the nearest sub-plate.
/// * Elevation interpolates two surfaces, one through the continental and one through the oceanic
///   sub-plates of a triangle, blended into a continental slope; land falls off to a shelf.
/// * Crust and age follow the same blend. Detail never turns land into sea or sea into land.
pub struct Raster<'a> {
    surface: &'a Surface,
    texture: Texture,
}

/// The ground as the raster shows it: what terrain stands on.
#[derive(Clone, Copy, Debug)]
pub(super) struct Base {
    pub elevation: f32,
    pub ground: Ground,
    /// See [`Pixel`].
    pub grain: f32,
}

/// Where the last lookups ended: the next ones start there.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Hints {
    coast: u32,
    plate: u32,
}

/// Says whether every column has one value per sub-plate.
pub(crate) fn check_columns(surface: &Surface) -> Result<(), SurfaceError> {
    let expected = surface.mesh.sites().len();
    let columns = [
        ("elevation", surface.elevation.len()),
        ("crust", surface.crust.len()),
        ("age", surface.age.len()),
        ("plate", surface.plate.len()),
        ("velocity", surface.velocity.len()),
        ("orogeny", surface.orogeny.len()),
        ("orogeny age", surface.orogeny_age.len()),
    ];
    match columns.into_iter().find(|&(_, found)| found != expected) {
        Some((field, found)) => Err(SurfaceError {
            field,
            found,
            expected,
        }),
        None => Ok(()),
    }
}

impl<'a> Raster<'a> {
    /// Prepares to sample `surface`.
    ///
    /// # Errors
    /// [`SurfaceError`] when a column does not have one value per sub-plate.
    pub fn new(surface: &'a Surface) -> Result<Self, SurfaceError> {
        check_columns(surface)?;
        let count = surface.mesh.sites().len();
        let spacing = surface.radius_km * (4.0 * PI / count as f64).sqrt();
        Ok(Self {
            surface,
            texture: Texture::new(surface.seed, surface.radius_km, spacing),
        })
    }

    /// The planet in a direction (any length but zero). Costs a walk over the mesh; whole maps are
    /// cheaper in one go.
    #[must_use]
    pub fn sample(&self, direction: DVec3) -> Pixel {
        self.look(direction.normalize(), &mut Hints::default())
    }

    /// Where the raster shows a place of a boundary between plates of the mesh.
    #[cfg(feature = "render")]
    pub(crate) fn bend(&self, place: DVec3) -> DVec3 {
        let mut shown = place;
        // The warp has no inverse in closed form, but it changes slowly.
        for _ in 0..10 {
            shown = (shown + place - self.texture.plates(shown)).normalize_or(place);
        }
        shown
    }

    /// As [`sample`](Self::sample) of a unit vector; lookups nearby are cheaper with the hints of the last.
    pub(crate) fn look(&self, direction: DVec3, hints: &mut Hints) -> Pixel {
        let surface = self.surface;
        hints.plate = surface
            .mesh
            .nearest(self.texture.plates(direction), hints.plate);
        let nearest = hints.plate as usize;
        let Base {
            elevation,
            ground,
            grain,
        } = self.base(direction, &mut hints.coast);
        Pixel {
            elevation,
            crust: if ground.continental >= 0.5 {
                Crust::Continental
            } else {
                Crust::Oceanic
            },
            age: ground.age,
            plate: surface.plate[nearest],
            velocity: surface.velocity[nearest],
            grain,
        }
    }

    /// Elevation alone, with what it stands on.
    pub(super) fn base(&self, direction: DVec3, hint: &mut u32) -> Base {
        let place = self.texture.coast(direction);
        let (vertices, weights) = self.triangle(place, hint);
        let corner = |vertex: u32| Corner::of(self.surface, vertex as usize);
        let ground = Ground::between(vertices.map(corner), weights);
        let (elevation, grain) = ground.detail(
            || self.texture.terrain(place),
            || self.texture.hills(direction),
        );
        Base {
            elevation,
            ground,
            grain,
        }
    }

    /// The triangle whose ground the raster shows in a direction: its corners, and their weights.
    #[cfg(feature = "terrain")]
    pub(super) fn corners(&self, direction: DVec3, hint: &mut u32) -> ([u32; 3], [f64; 3]) {
        self.triangle(self.texture.coast(direction), hint)
    }

    /// The triangle around a place that is displaced already. The smallest number comes first, so that sums do not
    /// depend on the way by which the triangle was found.
    fn triangle(&self, place: DVec3, hint: &mut u32) -> ([u32; 3], [f64; 3]) {
        let mut place = self.surface.mesh.locate(place, *hint);
        let [a, b, c] = place.vertices;
        *hint = a;
        let turns = if a < b && a < c {
            0
        } else if b < c {
            1
        } else {
            2
        };
        place.vertices.rotate_left(turns);
        place.weights.rotate_left(turns);
        (place.vertices, place.weights)
    }

    /// The noise on the interpolated ground.
    #[cfg(all(feature = "render", feature = "terrain"))]
    pub(super) fn texture(&self) -> &Texture {
        &self.texture
    }
}
