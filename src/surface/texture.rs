//! Detail finer than the spacing of sub-plates: ragged coasts and rough mountains.
//!
//! A map of interpolated triangles has straight coasts. Before anything is looked up, its direction is
//! displaced by smooth noise, the *warp*; everything that shares a warp stays consistent.

use fastnoise_lite::{DomainWarpType, FastNoiseLite, FractalType, NoiseType};
use glam::DVec3;

/// Lengths are tuned on Earth and scale with the radius.
const EARTH_RADIUS_KM: f64 = 6371.0;
/// The finest wavelength of coasts and terrain.
pub(super) const FINEST_KM: f64 = 36.0;
/// Amplitude relative to the next longer octave.
const COAST_GAIN: f32 = 0.6;
/// Root mean square of the displacement that an amplitude of one produces (measured).
const WARP_RMS: f32 = 0.354;

/// Share of the broadest octave that bends plate boundaries: as much as never folds.
const PLATE_SHARE: f32 = 0.45;

/// The noise of one planet: depends on its seed, radius and spacing alone.
pub(crate) struct Texture {
    coast: FastNoiseLite,
    plates: FastNoiseLite,
    terrain: FastNoiseLite,
    hills: FastNoiseLite,
}

impl Texture {
    /// `spacing_km` is the mean distance of neighbouring sub-plates.
    pub(crate) fn new(seed: u64, radius_km: f64, spacing_km: f64) -> Self {
        let earth = radius_km / EARTH_RADIUS_KM;
        let (broadest_km, rms_km) = Self::shape(radius_km, spacing_km);
        let octaves = octaves(broadest_km, FINEST_KM * earth);
        let frequency = (radius_km / broadest_km) as f32;
        let rms = (rms_km / radius_km) as f32;

        let noise = |stream: u64, frequency: f32, octaves: i32| {
            let mut noise = FastNoiseLite::with_seed(fold(seed, stream));
            noise.set_noise_type(Some(NoiseType::OpenSimplex2));
            noise.set_frequency(Some(frequency));
            noise.set_fractal_octaves(Some(octaves));
            noise
        };
        let warp = |octaves: i32, amplitude: f32| {
            let mut warp = noise(1, frequency, octaves);
            warp.set_domain_warp_type(Some(DomainWarpType::OpenSimplex2));
            warp.set_fractal_type(Some(FractalType::DomainWarpIndependent));
            warp.set_fractal_gain(Some(COAST_GAIN));
            // The library divides by the sum of the octaves' amplitudes; we want the first octave, and
            // with it every other, the same however many follow.
            warp.set_domain_warp_amp(Some(amplitude * series(octaves)));
            warp
        };
        let first = rms / (WARP_RMS * root_sum_square(octaves));

        // A plain sum of octaves. Ridged noise has its crests where a noise is nought, so they close in rings,
        // of one size everywhere: snow lay in honeycombs. And its mean lifts the land that it is laid on.
        let mut terrain = noise(2, (radius_km / (260.0 * earth)) as f32, 4);
        terrain.set_fractal_type(Some(FractalType::FBm));
        terrain.set_fractal_gain(Some(0.55));
        let mut hills = noise(3, (radius_km / (90.0 * earth)) as f32, 2);
        hills.set_fractal_type(Some(FractalType::FBm));
        Self {
            coast: warp(octaves, first),
            plates: warp(1, PLATE_SHARE * first),
            terrain,
            hills,
        }
    }

    /// The broadest wavelength and the root mean square of the coasts' displacement, in km.
    pub(crate) fn shape(radius_km: f64, spacing_km: f64) -> (f64, f64) {
        let earth = radius_km / EARTH_RADIUS_KM;
        // Coasts are about equally ragged at every resolution: coarse meshes need wide meanders to hide
        // their triangles, fine ones keep what is below 500 km and lose only what the mesh resolves.
        let broadest_km = (3.0 * spacing_km).clamp(480.0 * earth, 1400.0 * earth);
        let rms_km = (0.42 * spacing_km)
            .clamp(68.0 * earth, 160.0 * earth)
            .min(1.2 * spacing_km);
        (broadest_km, rms_km)
    }

    /// Where to look up elevation, crust and age for a place on the map.
    pub(crate) fn coast(&self, direction: DVec3) -> DVec3 {
        displace(&self.coast, direction)
    }

    /// Where to look up plates: the broadest meanders of [`coast`](Self::coast) alone. It never folds,
    /// so a plate that is one piece on the mesh is one piece on the map.
    pub(crate) fn plates(&self, direction: DVec3) -> DVec3 {
        displace(&self.plates, direction)
    }

    /// Mountains and valleys, −1 to 1 and nought in the mean, of a place that [`coast`](Self::coast) has
    /// displaced: undisturbed, they are as round as the noise.
    pub(crate) fn terrain(&self, place: DVec3) -> f32 {
        let [x, y, z] = place.as_vec3().to_array();
        self.terrain.get_noise_3d(x, y, z).clamp(-1.0, 1.0)
    }

    /// Abyssal hills, −1 to 1.
    pub(crate) fn hills(&self, direction: DVec3) -> f32 {
        let [x, y, z] = direction.as_vec3().to_array();
        self.hills.get_noise_3d(x, y, z).clamp(-1.0, 1.0)
    }
}

#[cfg(feature = "terrain")]
impl Texture {
    /// What displaces coasts, what roughens land, and what roughens the sea floor.
    #[cfg(feature = "render")]
    pub(super) fn noises(&self) -> [&FastNoiseLite; 3] {
        [&self.coast, &self.terrain, &self.hills]
    }

    /// A displacement of octaves that go half as far each, from this frequency and amplitude in radii on.
    pub(super) fn shore(seed: u64, frequency: f64, octaves: i32, amplitude: f64) -> FastNoiseLite {
        let mut warp = FastNoiseLite::with_seed(fold(seed, 4));
        warp.set_noise_type(Some(NoiseType::OpenSimplex2));
        warp.set_domain_warp_type(Some(DomainWarpType::OpenSimplex2));
        warp.set_fractal_type(Some(FractalType::DomainWarpIndependent));
        warp.set_fractal_gain(Some(0.5));
        warp.set_fractal_octaves(Some(octaves));
        warp.set_frequency(Some(frequency as f32));
        // As above: the first octave counts, however many follow.
        let series: f64 = (0..octaves)
            .map(|octave| libm::exp2(-f64::from(octave)))
            .sum();
        warp.set_domain_warp_amp(Some((amplitude * series) as f32));
        warp
    }
}

fn displace(warp: &FastNoiseLite, direction: DVec3) -> DVec3 {
    let [x, y, z] = direction.as_vec3().to_array();
    let (u, v, w) = warp.domain_warp_3d(x, y, z);
    let offset = DVec3::new(f64::from(u - x), f64::from(v - y), f64::from(w - z));
    (direction + offset).normalize()
}

/// How many octaves lead from the broadest wavelength down to the finest.
fn octaves(broadest: f64, finest: f64) -> i32 {
    let mut count = 1;
    let mut wavelength = broadest;
    while wavelength > 1.5 * finest {
        wavelength *= 0.5;
        count += 1;
    }
    count
}

fn amplitudes(octaves: i32) -> impl Iterator<Item = f32> {
    std::iter::successors(Some(1.0_f32), |amplitude| Some(amplitude * COAST_GAIN))
        .take(octaves.max(1) as usize)
}

fn series(octaves: i32) -> f32 {
    amplitudes(octaves).sum()
}

fn root_sum_square(octaves: i32) -> f32 {
    amplitudes(octaves)
        .map(|amplitude| amplitude * amplitude)
        .sum::<f32>()
        .sqrt()
}

/// A 32-bit seed for one of the streams, mixed so that neighbouring seeds share nothing (`SplitMix64`).
fn fold(seed: u64, stream: u64) -> i32 {
    let seed = (mix(seed.wrapping_add(stream.wrapping_mul(0x9E37_79B9_7F4A_7C15))) >> 32) as i32;
    // The library counts upwards from it, octave by octave.
    seed.min(i32::MAX - 2_000_000)
}

/// Scrambles bits; the upper half is the better one.
pub(super) fn mix(mut bits: u64) -> u64 {
    bits = (bits ^ (bits >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    (bits ^ (bits >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn directions() -> impl Iterator<Item = DVec3> {
        (0..4000).map(|i| {
            let z = 1.0 - (2.0 * f64::from(i) + 1.0) / 4000.0;
            let (sin, cos) = libm::sincos(f64::from(i) * 2.399_963_229_728_653);
            DVec3::new((1.0 - z * z).sqrt() * cos, (1.0 - z * z).sqrt() * sin, z)
        })
    }

    /// Spacings of 1,000 to a million sub-plates on Earth.
    const SPACINGS_KM: [f64; 5] = [714.0, 226.0, 113.0, 56.0, 22.6];

    #[test]
    fn coasts_meander_by_tens_of_kilometres_at_every_spacing() {
        for spacing in SPACINGS_KM {
            let texture = Texture::new(7, 6371.0, spacing);
            let square: f64 = directions()
                .map(|d| (texture.coast(d) - d).length_squared())
                .sum();
            let rms = (square / 4000.0).sqrt() * 6371.0;
            assert!((15.0..220.0).contains(&rms), "{spacing} km: {rms} km");
        }
    }

    #[test]
    fn the_warp_of_plates_never_folds() {
        for spacing in SPACINGS_KM {
            let texture = Texture::new(7, 6371.0, spacing);
            let mut least = f64::MAX;
            for d in directions() {
                let (east, north) = d.any_orthonormal_pair();
                let step = 1e-3;
                let at = |offset: DVec3| texture.plates((d + offset * step).normalize());
                let u = (at(east) - at(-east)) / (2.0 * step);
                let v = (at(north) - at(-north)) / (2.0 * step);
                let orientation =
                    u.cross(v).dot(texture.plates(d)) * east.cross(north).dot(d).signum();
                least = least.min(orientation);
            }
            assert!(least > 0.05, "{spacing} km: area scale {least}");
        }
    }

    #[test]
    fn seeds_and_streams_differ() {
        assert_ne!(fold(1, 1), fold(1, 2));
        assert_ne!(fold(1, 1), fold(2, 1));
    }
}
