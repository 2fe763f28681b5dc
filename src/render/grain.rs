//! What never changes about a planet: the noise behind its coasts, terrain and climate. Computed once,
//! it makes every later bake several times cheaper.

use crate::{
    simulation::Surface,
    surface::{cube::direction, texture::Texture, tint::Wander},
};
use bevy::tasks::futures_lite::future;
use std::sync::OnceLock;

/// Change of the noise's shape, as a share, up to which a planet keeps the one it has.
const TOLERANCE: f64 = 0.05;

/// The noise of one planet at the texels of a cube map.
pub(super) struct Grain {
    seed: u64,
    radius_km: f64,
    shape: (f64, f64),
    texture: Texture,
    wander: Wander,
    size: u32,
    faces: [OnceLock<FaceGrain>; 6],
}

/// One face with a border of one texel, in rows.
#[derive(Default)]
pub(super) struct FaceGrain {
    /// Where to look up the ground, in the simulation's frame.
    pub coast: Vec<[f32; 3]>,
    /// Terrain and abyssal hills, as shares of 32,767.
    pub terrain: Vec<[i16; 2]>,
    /// Bend of the climate on a map half as fine, without border.
    pub wander: Vec<f32>,
    /// Where to look up plates, without border; only overlays ask.
    plates: OnceLock<Vec<[f32; 3]>>,
}

impl Grain {
    pub(super) fn new(surface: &Surface, size: u32) -> Self {
        let (seed, radius_km) = (surface.seed, surface.radius_km);
        let spacing = surface.spacing_km();
        Self {
            seed,
            radius_km,
            shape: Texture::shape(radius_km, spacing),
            texture: Texture::new(seed, radius_km, spacing),
            wander: Wander::new(seed),
            size,
            faces: Default::default(),
        }
    }

    pub(super) fn size(&self) -> u32 {
        self.size
    }

    /// Whether this is the noise of `surface`. The number of sub-plates varies a little in the course
    /// of a history, and with it the shape of the noise: coasts that follow it would tremble.
    pub(super) fn suits(&self, surface: &Surface) -> bool {
        let shape = Texture::shape(surface.radius_km, surface.spacing_km());
        let near = |a: f64, b: f64| (a - b).abs() <= TOLERANCE * b;
        self.seed == surface.seed
            && self.radius_km == surface.radius_km
            && near(shape.0, self.shape.0)
            && near(shape.1, self.shape.1)
    }

    /// Whether all faces are there.
    pub(super) fn is_ready(&self) -> bool {
        self.faces.iter().all(|face| face.get().is_some())
    }

    /// A face, computed now if it is not there yet. Others have their turn after every row.
    pub(super) async fn face(&self, face: usize) -> &FaceGrain {
        let slot = &self.faces[face % 6];
        if let Some(grain) = slot.get() {
            return grain;
        }
        let grain = self.compute(face).await;
        slot.get_or_init(|| grain)
    }

    /// Where to look up the plates of a face, computed when first asked for.
    pub(super) async fn plates<'a>(&self, noise: &'a FaceGrain, face: usize) -> &'a [[f32; 3]] {
        if let Some(plates) = noise.plates.get() {
            return plates;
        }
        let size = self.size;
        let mut plates = Vec::with_capacity((size * size) as usize);
        for y in 0..size as i32 {
            for x in 0..size as i32 {
                let place = self.texture.plates(direction(face, x, y, size));
                plates.push(place.as_vec3().to_array());
            }
            future::yield_now().await;
        }
        noise.plates.get_or_init(|| plates)
    }

    async fn compute(&self, face: usize) -> FaceGrain {
        let size = self.size;
        let border = size as i32;
        let texels = (size as usize + 2) * (size as usize + 2);
        let mut grain = FaceGrain {
            coast: Vec::with_capacity(texels),
            terrain: Vec::with_capacity(texels),
            wander: Vec::with_capacity(texels / 4),
            plates: OnceLock::new(),
        };
        for y in -1..=border {
            for x in -1..=border {
                let direction = direction(face, x, y, size);
                let place = self.texture.coast(direction);
                grain.coast.push(place.as_vec3().to_array());
                let quantum = |value: f32| (value * 32_767.0) as i16;
                grain.terrain.push([
                    quantum(self.texture.terrain(place)),
                    quantum(self.texture.hills(direction)),
                ]);
            }
            future::yield_now().await;
        }
        let half = size / 2;
        for y in 0..half as i32 {
            for x in 0..half as i32 {
                let direction = direction(face, x, y, half);
                grain.wander.push(self.wander.at(direction.as_vec3()));
            }
            future::yield_now().await;
        }
        grain
    }
}
