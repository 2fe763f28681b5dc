//! From a snapshot to cube maps, on background tasks: one per face.

use super::{
    climate::{climate, interior},
    cube::Levels,
    grain::{FaceGrain, Grain},
    paint::{Paint, Sample},
    walk::{Walk, mean},
};
use crate::{
    planet::to_scene,
    simulation::{Crust, Surface},
    surface::{
        Pixel,
        cube::{axes, centre, direction},
        ground::{Corner, Ground},
    },
};
use bevy::{math::DVec3, tasks::futures_lite::future};
use std::sync::{Arc, OnceLock};

/// Texels along an edge of the map of velocities.
pub(super) const VELOCITY_SIZE: u32 = 64;
/// Terrain in the shading beyond what the elevation has, as a share of the height.
const FLOURISH: f32 = 0.10;

/// A snapshot with what the bakes of its faces share.
pub(super) struct Scene {
    pub surface: Arc<Surface>,
    pub overlay: Option<Paint>,
    ready: OnceLock<Prepared>,
}

struct Prepared {
    corners: Vec<Corner>,
    /// How far inland, 0 to 1, by sub-plate.
    interior: Vec<f32>,
}

/// The cube maps of one face.
pub(super) struct Face {
    /// Elevation in km; the ground's slope in m per km, as a vector in the scene.
    pub relief: Levels,
    /// Youth of mountains, aridity, latitude of the climate in degrees, variety from −1 to 1.
    pub climate: Levels,
    /// Velocity in km/My, as a vector in the scene.
    pub velocity: Levels,
    pub overlay: Option<Levels>,
}

impl Scene {
    pub(super) fn new(surface: Arc<Surface>, overlay: Option<Paint>) -> Self {
        Self {
            surface,
            overlay,
            ready: OnceLock::new(),
        }
    }

    fn prepared(&self) -> &Prepared {
        self.ready.get_or_init(|| Prepared {
            corners: (0..self.surface.mesh.vertex_count())
                .map(|vertex| Corner::of(&self.surface, vertex))
                .collect(),
            interior: interior(&self.surface),
        })
    }

    /// Bakes a face. Others have their turn after every few rows.
    pub(super) async fn face(self: Arc<Self>, grain: Arc<Grain>, face: usize) -> Face {
        let noise = grain.face(face).await;
        let size = grain.size();
        let (elevation, shade) = self.heights(noise, size).await;
        let relief = relief(face, size, &elevation, &shade, self.surface.radius_km);
        let relief = Levels::halves(size, relief);
        future::yield_now().await;
        let climate = self.climate(noise, face, size / 2).await;
        let velocity = self.velocity(face);
        let overlay = match &self.overlay {
            Some(paint) => Some(self.paint(paint, &grain, noise, face, &elevation).await),
            None => None,
        };
        Face {
            relief,
            climate,
            velocity,
            overlay,
        }
    }

    /// Elevation, and the heights that shade the ground, in m; with the border.
    async fn heights(&self, noise: &FaceGrain, size: u32) -> (Vec<f32>, Vec<f32>) {
        let corners = &self.prepared().corners;
        let row = size as usize + 2;
        let mut elevations = Vec::with_capacity(row * row);
        let mut shades = Vec::with_capacity(row * row);
        let mut start = Walk::new(&self.surface.mesh);
        for (y, (coasts, terrains)) in noise
            .coast
            .chunks(row)
            .zip(noise.terrain.chunks(row))
            .enumerate()
        {
            let mut walk = start;
            for (x, (coast, terrain)) in coasts.iter().zip(terrains).enumerate() {
                let (vertices, weights) = walk.locate(unit(coast));
                if x == 0 {
                    start = walk;
                }
                let ground = Ground::between(vertices.map(|v| corners[v as usize]), weights);
                let [terrain, hills] = terrain.map(|value| f32::from(value) / 32_767.0);
                let (elevation, grain) = ground.detail(|| terrain, || hills);
                elevations.push(elevation);
                // The deep sea's relief is subdued, or trenches would blacken the coasts beside them.
                shades.push(
                    elevation.max(-80.0 + 0.15 * elevation.min(0.0))
                        + FLOURISH * elevation.max(0.0) * grain,
                );
            }
            if y % 8 == 0 {
                future::yield_now().await;
            }
        }
        (elevations, shades)
    }

    async fn climate(&self, noise: &FaceGrain, face: usize, size: u32) -> Levels {
        let prepared = self.prepared();
        let mut texels = Vec::with_capacity((size * size) as usize);
        let mut start = Walk::new(&self.surface.mesh);
        let row = 2 * size as usize + 2;
        for y in 0..size as usize {
            let mut walk = start;
            for x in 0..size as usize {
                let texel = (2 * y + 1) * row + 2 * x + 1;
                let coast = noise.coast[texel];
                let (vertices, weights) = walk.locate(unit(&coast));
                if x == 0 {
                    start = walk;
                }
                let youth = mean(vertices, weights, |v| prepared.corners[v].youth);
                let interior = mean(vertices, weights, |v| prepared.interior[v]);
                let place = direction(face, x as i32, y as i32, size);
                let latitude = libm::asin(place.z.clamp(-1.0, 1.0)).to_degrees() as f32;
                let wander = noise.wander[y * size as usize + x];
                let terrain = f32::from(noise.terrain[texel][0]) / 32_767.0;
                let [arid, latitude, variety] = climate(latitude, interior, wander, terrain);
                texels.push([youth, arid, latitude, variety]);
            }
            if y % 8 == 0 {
                future::yield_now().await;
            }
        }
        Levels::halves(size, texels)
    }

    fn velocity(&self, face: usize) -> Levels {
        let mut walk = Walk::new(&self.surface.mesh);
        let size = VELOCITY_SIZE;
        let texels = (0..size * size)
            .map(|i| {
                let place = direction(face, (i % size) as i32, (i / size) as i32, size);
                let (vertices, weights) = walk.locate(place);
                let velocity = mean(vertices, weights, |v| self.surface.velocity[v]);
                to_scene(velocity.as_dvec3()).extend(0.0).to_array()
            })
            .collect();
        Levels::halves(size, texels)
    }

    async fn paint(
        &self,
        paint: &Paint,
        grain: &Grain,
        noise: &FaceGrain,
        face: usize,
        elevation: &[f32],
    ) -> Levels {
        let (surface, corners) = (&*self.surface, &self.prepared().corners);
        let size = grain.size();
        let row = size as usize + 2;
        let mut texels = Vec::with_capacity((size * size) as usize);
        let plates = grain.plates(noise, face).await;
        let (mut start, mut first) = (Walk::new(&surface.mesh), 0);
        for y in 0..size as usize {
            let (mut walk, mut nearest) = (start, first);
            for x in 0..size as usize {
                let texel = (y + 1) * row + x + 1;
                let (vertices, weights) = walk.locate(unit(&noise.coast[texel]));
                let plate = unit(&plates[y * size as usize + x]);
                nearest = surface.mesh.nearest(plate, nearest);
                if x == 0 {
                    (start, first) = (walk, nearest);
                }
                let ground = Ground::between(vertices.map(|v| corners[v as usize]), weights);
                let pixel = Pixel {
                    elevation: elevation[texel],
                    crust: if ground.continental >= 0.5 {
                        Crust::Continental
                    } else {
                        Crust::Oceanic
                    },
                    age: ground.age,
                    plate: surface.plate[nearest as usize],
                    velocity: surface.velocity[nearest as usize],
                    grain: 0.0,
                };
                texels.push(paint(
                    surface,
                    &Sample {
                        vertices,
                        weights,
                        nearest,
                        pixel,
                    },
                ));
            }
            if y % 4 == 0 {
                future::yield_now().await;
            }
        }
        Levels::colours(size, &texels)
    }
}

fn unit(direction: &[f32; 3]) -> DVec3 {
    DVec3::from(direction.map(f64::from)).normalize_or(DVec3::Z)
}

/// Elevation with the slope of the ground, without the border.
fn relief(
    face: usize,
    size: u32,
    elevation: &[f32],
    shade: &[f32],
    radius_km: f64,
) -> Vec<[f32; 4]> {
    let row = size as usize + 2;
    let [along, down, out] = axes(face);
    let mut texels = Vec::with_capacity((size * size) as usize);
    // From half the difference across two texels to metres per km.
    let scale = f64::from(size) / (4.0 * radius_km);
    for y in 0..size as usize {
        let t = centre(y as i32, size);
        for x in 0..size as usize {
            let s = centre(x as i32, size);
            let i = (y + 1) * row + x + 1;
            let rise_s = f64::from(shade[i + 1] - shade[i - 1]);
            let rise_t = f64::from(shade[i + row] - shade[i - row]);
            // The gradient on the sphere of a function of the face's plane: with r² = 1 + s² + t², its
            // component within the plane is r (h_s, h_t) + …, and it has none along the direction.
            let length = (1.0 + s * s + t * t).sqrt();
            let inward = -(s * rise_s + t * rise_t);
            let slope = (along * rise_s + down * rise_t + out * inward) * (length * scale);
            let [x, y, z] = slope.as_vec3().to_array();
            texels.push([elevation[i] / 1000.0, x, y, z]);
        }
    }
    texels
}

#[cfg(test)]
mod tests {
    use super::{super::paint::paint, *};
    use crate::{
        simulation::{History, Recipe},
        surface::{Overlay, Raster},
    };
    use bevy::tasks::block_on;
    use std::time::Instant;

    fn decode(bytes: &[u8]) -> f32 {
        let bits = u16::from_le_bytes([bytes[0], bytes[1]]);
        let (exponent, fraction) = (i32::from((bits >> 10) & 31), f32::from(bits & 1023));
        let size = if exponent == 0 {
            fraction * libm::exp2f(-24.0)
        } else {
            (1024.0 + fraction) * libm::exp2f((exponent - 25) as f32)
        };
        if bits & 0x8000 == 0 { size } else { -size }
    }

    #[test]
    fn the_elevation_drawn_is_the_one_sampled() {
        let mut history =
            History::with_threads(Recipe::earth_like(5).with_sub_plates(500), 1).unwrap();
        let surface = Arc::new(history.surface().unwrap());
        let size = 32;
        let grain = Arc::new(Grain::new(&surface, size));
        let scene = Arc::new(Scene::new(surface.clone(), None));
        let raster = Raster::new(&surface).unwrap();
        let mut summits = 0;
        for face in 0..6 {
            let baked = block_on(scene.clone().face(grain.clone(), face));
            for (i, texel) in (0..).zip(baked.relief.levels[0].chunks(8)) {
                let place = direction(face, i % size as i32, i / size as i32, size);
                let sampled = raster.sample(place).elevation;
                let drawn = 1000.0 * decode(texel);
                // Half precision, and the rounding of directions where the ground is steep.
                assert!((sampled - drawn).abs() < 1.0 + 1e-3 * sampled.abs());
                summits += i32::from(sampled > 300.0);
            }
        }
        assert!(summits > 0);
    }

    #[test]
    #[ignore = "a measurement"]
    fn how_long_a_bake_takes() {
        let recipe = Recipe::earth_like(5).with_sub_plates(40_000);
        let mut history = History::with_threads(recipe, 1).unwrap();
        let surface = Arc::new(history.surface().unwrap());
        for size in [128, 512] {
            let grain = Arc::new(Grain::new(&surface, size));
            for what in ["with noise", "without"] {
                let start = Instant::now();
                let scene = Arc::new(Scene::new(surface.clone(), None));
                for face in 0..6 {
                    block_on(scene.clone().face(grain.clone(), face));
                }
                println!(
                    "{size} {what}: {:.0} ms",
                    start.elapsed().as_secs_f64() * 1e3
                );
            }
            let start = Instant::now();
            let scene = Arc::new(Scene::new(surface.clone(), paint(Overlay::Plates)));
            for face in 0..6 {
                block_on(scene.clone().face(grain.clone(), face));
            }
            println!(
                "{size} overlay: {:.0} ms",
                start.elapsed().as_secs_f64() * 1e3
            );
        }
    }
}
