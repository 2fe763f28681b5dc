//! The night sky: stars, and the band of a galaxy seen from within.
//!
//! A sky is drawn once, on a background task, into a cube map that Bevy's [`Skybox`] shows. How much of it is seen
//! depends on where the camera is: the light of a day sky is added to that of the stars, but drowns them in the eye.

use super::{PlanetAir, cube, globe::pool};
use crate::{
    planet::{Planet, PlanetSurface},
    simulation::streams::{direction, unit},
    surface::{
        cube::{axes, centre, point},
        ground::{ramp, smooth},
    },
};
use bevy::{
    asset::AssetEventSystems,
    light::Skybox,
    math::DVec3,
    prelude::*,
    render::render_resource::TextureFormat,
    tasks::{Task, futures::check_ready, futures_lite::future},
    transform::TransformSystems,
};
use fastnoise_lite::{FastNoiseLite, FractalType, NoiseType};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

/// A sky full of stars behind everything that a camera sees: put it on a 3D camera. Every seed has another sky.
///
/// It is there after a second or so as a [`Skybox`], in place of the one that the camera had, takes 25 MB of the
/// GPU's memory for each camera, and goes when this component does. From the ground of a planet with air, stars are
/// seen by night only: [`DirectionalLight`]s of more than 1 lux are suns.
#[derive(Component, Debug, Clone, Copy, PartialEq, Reflect)]
#[reflect(Component, Default)]
pub struct Stars {
    /// What the sky is drawn from; any number.
    pub seed: u64,
    /// How bright the middle of a star of magnitude 0 is where nothing outshines it, in cd/m² like
    /// [`Skybox::brightness`], 0 or more. Bevy's default exposure shows 1,000 cd/m² as white: with the default of
    /// 4,000 the twenty brightest stars or so are white, and the faintest are just seen.
    pub brightness: f32,
}

impl Default for Stars {
    fn default() -> Self {
        Self {
            seed: 0,
            brightness: 4000.0,
        }
    }
}

/// Texels along an edge of the cube map.
const SIZE: u32 = 1024;
/// Stars of a sky: two thirds of Earth's, whose Bright Star Catalogue has 9,110 down to the same magnitude.
const COUNT: usize = 6000;
/// Magnitudes. The brightest is that of Sirius.
const FAINTEST: f64 = 6.5;
const BRIGHTEST: f64 = -1.5;
/// Standard deviation of a drawn star, in texels in the middle of a face.
const SPREAD: f64 = 0.6;
/// Texels up to which a star reaches where the cube stretches it most.
const REACH: i32 = 5;
/// Light of the galaxy where it is densest, relative to a star of magnitude 0: about 21 magnitudes per square second
/// of arc, like bright parts of the Milky Way.
const GLOW: f32 = 0.0018;
/// Sine of the latitude over which the galaxy thins to 1/e, away from its core.
const WIDTH: f32 = 0.1;

/// Illuminance in lux up to which a light is a moon.
const MOON: f32 = 1.0;
/// Sine of the height of the sun at which stars begin to fade: 12 degrees below the horizon.
const DUSK: f32 = -0.208;
/// Scale heights of the air above which nothing outshines the stars.
const TOP: f32 = 12.0;
/// How well sunlit air hides stars, per optical depth: so well that the sky is almost black where they come out.
const HIDES: f32 = 200.0;

/// The sky that a camera has, or waits for. Dropping it stops the drawing.
#[derive(Component)]
struct Night {
    seed: u64,
    task: Option<Task<Vec<u8>>>,
}

pub(super) fn plugin(app: &mut App) {
    app.register_type::<Stars>()
        .add_observer(disappear)
        .add_systems(
            PostUpdate,
            (
                paint.before(AssetEventSystems),
                dim.after(TransformSystems::Propagate),
            )
                .chain(),
        );
}

/// Has skies drawn, and shows them.
fn paint(
    mut commands: Commands,
    mut images: ResMut<Assets<Image>>,
    mut cameras: Query<(Entity, &Stars, Option<&mut Night>), With<Camera3d>>,
) {
    for (camera, &Stars { seed, .. }, night) in &mut cameras {
        let Some(mut night) = night.filter(|night| night.seed == seed) else {
            let task = Some(pool().spawn(draw(seed, SIZE)));
            commands.entity(camera).try_insert(Night { seed, task });
            continue;
        };
        let Some(texels) = night.task.as_mut().and_then(check_ready) else {
            continue;
        };
        night.task = None;
        // Three floats with a common exponent: as small as 8 bits a colour, but Sirius is 1,600 times as bright as
        // the faintest star.
        let mut image = cube::image("stars", SIZE, TextureFormat::Rgb9e5Ufloat);
        image.texture_descriptor.mip_level_count = 1;
        image.data = Some(texels);
        commands.entity(camera).try_insert(Skybox {
            image: Some(images.add(image)),
            ..default()
        });
    }
}

/// Lets the stars fade where the sky is bright.
fn dim(
    suns: Query<(&DirectionalLight, &GlobalTransform)>,
    planets: Query<(
        &Planet,
        &PlanetSurface,
        &GlobalTransform,
        Option<&PlanetAir>,
    )>,
    mut cameras: Query<(&Stars, &GlobalTransform, &mut Skybox), (With<Camera3d>, With<Night>)>,
) {
    for (stars, camera, mut skybox) in &mut cameras {
        let mut brightness = if stars.brightness.is_finite() {
            stars.brightness.max(0.0)
        } else {
            0.0
        };
        for (planet, surface, to_world, air) in &planets {
            let radius = planet.radius * to_world.scale().x;
            let offset = camera.translation() - to_world.translation();
            let away = offset.length();
            if !(radius > 0.0 && radius.is_finite() && away > 0.0 && away.is_finite()) {
                continue;
            }
            let sun = suns
                .iter()
                .filter(|(sun, _)| sun.illuminance > MOON)
                .map(|(_, light)| light.back().dot(offset / away))
                .fold(-1.0, f32::max);
            let air = air.copied().unwrap_or_default();
            brightness *= seen(away / radius - 1.0, sun, air.uniform(surface.radius_km));
        }
        if skybox.brightness != brightness {
            skybox.brightness = brightness;
        }
    }
}

/// Share of the stars' light that is seen from an altitude in radii, with the sine of the sun's height over the
/// horizon, and the air as shaders have it.
fn seen(altitude: f32, sun: f32, air: Vec4) -> f32 {
    let height = altitude.max(0.0) / air.w;
    let above = (libm::expf(-height) - libm::expf(-TOP)).max(0.0);
    let depth = above * (air.x + air.y + air.z) / 3.0;
    let day = smooth(ramp(DUSK, 0.0, sun));
    (1.0 - day * (1.0 - libm::expf(-HIDES * depth))).max(0.0)
}

/// Takes the sky away with the stars.
fn disappear(gone: On<Remove, Stars>, mut commands: Commands) {
    if let Ok(mut camera) = commands.get_entity(gone.entity) {
        camera.try_remove::<(Night, Skybox)>();
    }
}

/// A star: where it is, and its light, relative to a white one of magnitude 0.
struct Star {
    towards: DVec3,
    light: Vec3,
}

/// What a sky is drawn from.
struct Sky {
    stars: Vec<Star>,
    /// The pole of the galaxy, and where its core is.
    pole: Vec3,
    core: Vec3,
    clouds: FastNoiseLite,
    dust: FastNoiseLite,
}

impl Sky {
    fn new(seed: u64) -> Self {
        // Apart from all streams of a planet with the same seed.
        let mut key = [0_u8; 32];
        key[..8].copy_from_slice(&seed.to_le_bytes());
        key[8..13].copy_from_slice(b"stars");
        let mut rng = ChaCha8Rng::from_seed(key);
        let pole = direction(&mut rng);
        let stars = (0..COUNT).map(|_| Star::new(&mut rng, pole)).collect();
        let noise = |stream: i32, frequency, octaves, gain| {
            let seed = (seed ^ (seed >> 32)) as i32;
            let mut noise = FastNoiseLite::with_seed(seed.wrapping_add(stream));
            noise.set_noise_type(Some(NoiseType::OpenSimplex2));
            noise.set_fractal_type(Some(FractalType::FBm));
            noise.set_fractal_octaves(Some(octaves));
            noise.set_fractal_gain(Some(gain));
            noise.set_frequency(Some(frequency));
            noise
        };
        Self {
            stars,
            pole: pole.as_vec3(),
            core: pole.any_orthonormal_vector().as_vec3(),
            clouds: noise(1, 3.0, 5, 0.5),
            dust: noise(2, 4.0, 6, 0.6),
        }
    }

    /// Light of the galaxy from a direction: wider and brighter towards the core, with lanes of dust in its plane.
    fn glow(&self, towards: Vec3) -> Vec3 {
        let core = 0.5 + 0.5 * towards.dot(self.core);
        let bulge = core * core;
        let latitude = towards.dot(self.pole) / (WIDTH * (1.0 + bulge));
        if latitude.abs() > 3.5 {
            return Vec3::ZERO;
        }
        let clouds = self.clouds.get_noise_3d(towards.x, towards.y, towards.z);
        let dust = self.dust.get_noise_3d(towards.x, towards.y, towards.z);
        let off = latitude + 0.5 * dust;
        let light = (0.3 + 0.7 * bulge) * (1.0 + 1.2 * clouds).max(0.0) * libm::expf(-off * off);
        let lane = 3.0 * (latitude + clouds);
        let depth = 2.0 * libm::expf(-lane * lane) * (0.6 + 2.0 * dust).clamp(0.0, 1.0);
        // Dust takes more of the blue.
        let left = [0.8_f32, 1.0, 1.3].map(|share| libm::expf(-share * depth));
        GLOW * light * Vec3::new(1.04, 1.0, 0.9) * Vec3::from(left)
    }
}

impl Star {
    fn new(rng: &mut ChaCha8Rng, pole: DVec3) -> Self {
        // Half as many at the poles of the galaxy as along its band.
        let towards = loop {
            let towards = direction(rng);
            if unit(rng) >= 0.5 * towards.dot(pole).abs() {
                break towards;
            }
        };
        // With every magnitude there are 10^0.5 times as many: Hipparcos counts 15, 49, 172, 511, 1,600 and 4,968
        // stars brighter than 1 to 6 (oeis.org/A053406).
        let magnitude = FAINTEST + 2.0 * libm::log10(1.0 - unit(rng));
        let light = libm::pow(10.0, -0.4 * magnitude.max(BRIGHTEST));
        // White to blue ones, and orange giants: 6,500 to 20,000 K, and 3,300 to 5,300 K, even in 1/K.
        let mireds = if unit(rng) < 0.6 {
            50.0 + 104.0 * unit(rng)
        } else {
            190.0 + 110.0 * unit(rng)
        };
        Self {
            towards,
            light: light as f32 * colour(1e6 / mireds),
        }
    }

    /// Adds the star to a face, if it is seen there: as a small round spot, whichever way the cube stretches.
    fn splat(&self, face: usize, size: u32, texels: &mut [Vec3]) {
        let [along, down, out] = axes(face);
        let depth = self.towards.dot(out);
        // Corners of a face are at 0.58.
        if depth < 0.5 {
            return;
        }
        let edge = size as i32;
        let place = |axis: DVec3| {
            let share = 0.5 * (1.0 + self.towards.dot(axis) / depth);
            (share * f64::from(size)).floor() as i32
        };
        let reach = |at: i32| (at - REACH).max(0)..(at + REACH + 1).min(edge);
        let spread = SPREAD * 2.0 / f64::from(size);
        for y in reach(place(down)) {
            for x in reach(place(along)) {
                let texel = point(face, centre(x, size), centre(y, size)).normalize();
                let off = texel.distance_squared(self.towards) / (2.0 * spread * spread);
                texels[(y * edge + x) as usize] += self.light * libm::exp(-off) as f32;
            }
        }
    }
}

/// Colour of a black body of a temperature in K, as bright as white: what it radiates at 650, 550 and 450 nm by
/// Planck's law, relative to one of 6,500 K, the white of sRGB.
fn colour(kelvin: f64) -> Vec3 {
    let [red, green, blue] = [650.0, 550.0, 450.0].map(|wavelength_nm| {
        // Planck's second constant, in nm K.
        let ratio = 1.4388e7 / wavelength_nm;
        (libm::expm1(ratio / 6500.0) / libm::expm1(ratio / kelvin)) as f32
    });
    Vec3::new(red, green, blue) / (0.2126 * red + 0.7152 * green + 0.0722 * blue)
}

/// The texels of all faces, one after the other; [`Skybox`] mirrors them, which nobody can tell. Others have their
/// turn after every row.
async fn draw(seed: u64, size: u32) -> Vec<u8> {
    let sky = Sky::new(seed);
    let count = size as usize * size as usize;
    let mut bytes = Vec::with_capacity(6 * 4 * count);
    for face in 0..6 {
        let mut texels = Vec::with_capacity(count);
        for y in 0..size as i32 {
            for x in 0..size as i32 {
                let towards = point(face, centre(x, size), centre(y, size)).normalize();
                texels.push(sky.glow(towards.as_vec3()));
            }
            future::yield_now().await;
        }
        for star in &sky.stars {
            star.splat(face, size, &mut texels);
        }
        bytes.extend(texels.into_iter().map(pack).flat_map(u32::to_le_bytes));
    }
    bytes
}

/// A colour as `Rgb9e5Ufloat` has it: 9 bits for each component, and 5 for the exponent of them all.
fn pack(colour: Vec3) -> u32 {
    let colour = colour.clamp(Vec3::ZERO, Vec3::splat(65_408.0));
    let largest = colour.max_element();
    let mut exponent = (largest.to_bits() >> 23).max(111) - 111;
    // Two to the power of 24 less the exponent: what one is worth.
    let one = |exponent: u32| f32::from_bits((151 - exponent) << 23);
    if largest * one(exponent) >= 511.5 {
        exponent += 1;
    }
    let [red, green, blue] = (colour * one(exponent) + 0.5).to_array().map(|c| c as u32);
    red | (green << 9) | (blue << 18) | (exponent << 27)
}

#[cfg(test)]
mod tests {
    use super::*;
    use bevy::tasks::block_on;
    use core::time::Duration;

    #[test]
    fn a_seed_is_a_sky() {
        let sky = block_on(draw(7, 64));
        assert_eq!(sky.len(), 6 * 64 * 64 * 4);
        assert_eq!(sky, block_on(draw(7, 64)));
        assert_ne!(sky, block_on(draw(8, 64)));
    }

    #[test]
    fn stars_are_as_many_and_as_coloured_as_they_should_be() {
        let stars = Sky::new(3).stars;
        let brighter = |magnitude: f32| {
            let limit = libm::powf(10.0, -0.4 * magnitude);
            let luminance = Vec3::new(0.2126, 0.7152, 0.0722);
            let bright = |star: &&Star| star.light.dot(luminance) > limit;
            stars.iter().filter(bright).count()
        };
        assert_eq!((brighter(6.501), brighter(-1.501)), (COUNT, 0));
        // A tenth for every two magnitudes, within four standard deviations.
        assert!((510..690).contains(&brighter(4.5)), "{}", brighter(4.5));
        assert!((30..90).contains(&brighter(2.5)), "{}", brighter(2.5));
        let ratios = || stars.iter().map(|star| star.light.z / star.light.x);
        assert!(ratios().filter(|&ratio| ratio > 1.2).count() > COUNT / 4);
        assert!(ratios().filter(|&ratio| ratio < 0.8).count() > COUNT / 4);
    }

    #[test]
    fn stars_are_round_spots_also_across_edges() {
        let sums = |towards: DVec3| -> [f32; 6] {
            let light = Vec3::ONE;
            let star = Star { towards, light };
            core::array::from_fn(|face| {
                let mut texels = vec![Vec3::ZERO; 64 * 64];
                star.splat(face, 64, &mut texels);
                texels.iter().map(|texel| texel.x).sum()
            })
        };
        // In the middle of a face, as much as the integral of the spot.
        let [_, _, top, ..] = sums(DVec3::new(0.004, 1.0, -0.007).normalize());
        assert!((top / 2.262 - 1.0).abs() < 0.01, "{top}");
        let [right, left, top, bottom, front, back] = sums(DVec3::new(1.0, 0.2, 1.0).normalize());
        assert!(right > 1.0 && (right / front - 1.0).abs() < 1e-3);
        assert_eq!([left, top, bottom, back], [0.0; 4]);
    }

    #[test]
    fn colours_are_packed_to_the_nearest() {
        for i in 0..2000_u16 {
            let colour = Vec3::new(1.0, 0.7, 0.3) * libm::powf(1.01, 100.0 - f32::from(i));
            let bits = pack(colour);
            let one = libm::exp2f(24.0 - (bits >> 27) as f32);
            let unpacked = Vec3::from([0_u32, 9, 18].map(|at| ((bits >> at) & 511) as f32 / one));
            let off = (unpacked - colour).abs().max_element();
            assert!(off <= colour.x / 511.0 || off < 5e-8, "{colour}");
        }
    }

    #[test]
    fn stars_are_seen_by_night_in_space_and_without_air() {
        let air = PlanetAir::default().uniform(6371.0);
        assert!(seen(0.0, 0.3, air) < 1e-3, "day");
        assert!(seen(-0.001, 0.0, air) < 1e-3, "sunrise, below the sea");
        assert_eq!(seen(0.0, -0.21, air), 1.0, "night");
        assert_eq!(seen(12.01 * air.w, 1.0, air), 1.0, "space");
        assert_eq!(seen(0.0, 1.0, air * Vec4::W), 1.0, "no air");
        let thin = air * Vec4::new(0.01, 0.01, 0.01, 1.0);
        assert!((0.5..0.9).contains(&seen(0.0, 1.0, thin)), "thin air");
        for i in 0..100_u8 {
            let share = f32::from(i) / 100.0;
            let (sun, height) = (DUSK * share, TOP * share * air.w);
            assert!(seen(0.0, sun + 0.01 * DUSK, air) >= seen(0.0, sun, air));
            assert!(seen(height + 0.1 * air.w, 1.0, air) >= seen(height, 1.0, air));
        }
    }

    #[test]
    fn a_sky_comes_and_goes_with_the_stars() {
        let mut app = App::new();
        app.add_plugins((MinimalPlugins, AssetPlugin::default()))
            .init_asset::<Image>()
            .add_plugins(plugin);
        let camera = (Camera3d::default(), Stars::default());
        let camera = app.world_mut().spawn(camera).id();
        for _ in 0..60_000 {
            app.update();
            if app.world().get::<Skybox>(camera).is_some() {
                break;
            }
            std::thread::sleep(Duration::from_millis(1));
        }
        let skybox = app.world().get::<Skybox>(camera).expect("a sky");
        assert_eq!(skybox.brightness, Stars::default().brightness);
        let images = app.world().resource::<Assets<Image>>();
        let image = skybox.image.as_ref().and_then(|image| images.get(image));
        let bytes = image.and_then(|image| image.data.as_ref()).map(Vec::len);
        assert_eq!(bytes, Some(6 * 4 * 1024 * 1024));
        app.world_mut().entity_mut(camera).remove::<Stars>();
        app.update();
        assert!(app.world().get::<Skybox>(camera).is_none());
    }
}
