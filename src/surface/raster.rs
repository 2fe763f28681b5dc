//! Sampling a surface, finer than its sub-plates.

use std::f64::consts::PI;

use glam::{DVec3, Vec3};

use super::{SurfaceError, texture::Texture};
use crate::simulation::{Crust, Orogeny, Surface};

/// Land at the foot of a shelf's outer slope, metres: where a continent's margin ends.
const SHELF_EDGE_M: f32 = -130.0;
/// Share of continental weight over which the ocean's depth gives way to the continent's height.
const SLOPE: (f32, f32) = (0.25, 0.65);
/// Height of terrain detail at most, as a share of the land's height.
const ROUGHNESS: (f32, f32) = (0.03, 0.12);
/// Height of abyssal hills on new sea floor, metres.
const HILLS_M: f32 = 70.0;
/// Time in which sediment buries abyssal hills, My.
const BURIAL_MY: f32 = 60.0;
/// Time over which an inactive mountain belt loses its roughness, My.
const SMOOTHING_MY: f32 = 120.0;

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

/// Where the last lookups ended: the next ones start there.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Hints {
    coast: u32,
    plate: u32,
}

impl<'a> Raster<'a> {
    /// Prepares to sample `surface`.
    ///
    /// # Errors
    /// [`SurfaceError`] when a column does not have one value per sub-plate.
    pub fn new(surface: &'a Surface) -> Result<Self, SurfaceError> {
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
        if let Some((field, found)) = columns.into_iter().find(|&(_, found)| found != expected) {
            return Err(SurfaceError {
                field,
                found,
                expected,
            });
        }
        let spacing = surface.radius_km * (4.0 * PI / expected as f64).sqrt();
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
        let ground = self.ground(self.texture.coast(direction), &mut hints.coast);
        let (elevation, grain) = self.detail(direction, &ground);
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

    fn ground(&self, direction: DVec3, hint: &mut u32) -> Ground {
        let surface = self.surface;
        let place = surface.mesh.locate(direction, *hint);
        *hint = place.vertices[0];
        let (mut land, mut sea) = (Blend::default(), Blend::default());
        let mut rugged = 0.0;
        for (vertex, weight) in place.vertices.into_iter().zip(place.weights) {
            let (v, weight) = (vertex as usize, (weight as f32).clamp(0.0, 1.0));
            let blend = if surface.crust[v] == Crust::Continental {
                &mut land
            } else {
                &mut sea
            };
            blend.add(weight, surface.elevation[v], surface.age[v]);
            if surface.orogeny[v] != Orogeny::None {
                rugged += weight * libm::expf(-surface.orogeny_age[v].max(0.0) / SMOOTHING_MY);
            }
        }
        let continental = land.weight / (land.weight + sea.weight);
        let (shore, depth) = (land.elevation(), sea.elevation());
        let elevation = match (shore, depth) {
            (Some(height), None) => height,
            (None, Some(depth)) => depth,
            (Some(height), Some(depth)) => {
                let inland = ramp(SLOPE.1, 1.0, continental);
                let height = if height > SHELF_EDGE_M {
                    SHELF_EDGE_M + (height - SHELF_EDGE_M) * inland
                } else {
                    height
                };
                depth + (height - depth) * smooth(ramp(SLOPE.0, SLOPE.1, continental))
            }
            (None, None) => 0.0,
        };
        let age = if continental >= 0.5 {
            land.age()
        } else {
            sea.age()
        };
        Ground {
            elevation,
            continental,
            age: age.unwrap_or(0.0),
            rugged,
        }
    }

    /// Adds terrain to the interpolated elevation; returns it with the detail's own value for shading.
    fn detail(&self, direction: DVec3, ground: &Ground) -> (f32, f32) {
        let height = ground.elevation;
        if height > 0.0 {
            let mountain = smooth(ramp(300.0, 2500.0, height)).max(ground.rugged.min(1.0));
            let rough = ROUGHNESS.0 + (ROUGHNESS.1 - ROUGHNESS.0) * mountain;
            let grain = self.texture.terrain(direction);
            (height * (1.0 + rough * grain), grain)
        } else {
            let young = libm::expf(-ground.age / BURIAL_MY) * (1.0 - ground.continental);
            let deep = smooth(ramp(-600.0, -2000.0, height));
            let grain = if young * deep > 0.01 {
                self.texture.hills(direction)
            } else {
                0.0
            };
            (
                height + HILLS_M * young * deep * grain,
                grain * young * deep,
            )
        }
    }
}

/// The interpolated planet, before terrain is added.
struct Ground {
    elevation: f32,
    continental: f32,
    age: f32,
    rugged: f32,
}

/// A weighted mean over the vertices of one kind of crust.
#[derive(Default)]
struct Blend {
    weight: f32,
    elevation: f32,
    age: f32,
}

impl Blend {
    fn add(&mut self, weight: f32, elevation: f32, age: f32) {
        self.weight += weight;
        self.elevation += weight * elevation;
        self.age += weight * age;
    }

    fn elevation(&self) -> Option<f32> {
        (self.weight > 0.0).then(|| self.elevation / self.weight)
    }

    fn age(&self) -> Option<f32> {
        (self.weight > 0.0).then(|| self.age / self.weight)
    }
}

/// 0 at `from`, 1 at `to`, linear between, constant beyond.
pub(crate) fn ramp(from: f32, to: f32, value: f32) -> f32 {
    ((value - from) / (to - from)).clamp(0.0, 1.0)
}

/// Eases a 0–1 ramp in and out.
pub(crate) fn smooth(t: f32) -> f32 {
    t * t * (3.0 - 2.0 * t)
}
