//! Colours of land and sea, as linear ramps over elevation in metres.

use fastnoise_lite::{FastNoiseLite, FractalType, NoiseType};
use glam::Vec3;

use super::ground::{ramp, smooth};
pub(crate) use super::ramp::{Ramp, look_up};

const HUMID: &Ramp = &[
    (0.0, [104, 148, 94]),
    (150.0, [124, 162, 100]),
    (450.0, [158, 180, 112]),
    (900.0, [194, 192, 130]),
    (1600.0, [198, 172, 122]),
    (2600.0, [170, 136, 104]),
    (3800.0, [150, 122, 108]),
    (5000.0, [182, 174, 170]),
    (6500.0, [232, 230, 228]),
];
const ARID: &Ramp = &[
    (0.0, [206, 192, 142]),
    (250.0, [220, 202, 150]),
    (800.0, [214, 186, 134]),
    (1600.0, [200, 162, 116]),
    (2600.0, [174, 136, 104]),
    (3800.0, [154, 124, 108]),
    (5000.0, [184, 174, 168]),
    (6500.0, [232, 230, 228]),
];
const BOREAL: &Ramp = &[
    (0.0, [122, 150, 116]),
    (300.0, [142, 162, 122]),
    (800.0, [166, 168, 134]),
    (1500.0, [166, 150, 124]),
    (2500.0, [156, 138, 122]),
    (3800.0, [172, 164, 160]),
    (5000.0, [226, 226, 226]),
];
const SEA: &Ramp = &[
    (-10500.0, [12, 26, 62]),
    (-8000.0, [20, 44, 94]),
    (-6500.0, [30, 66, 124]),
    (-5500.0, [42, 88, 150]),
    (-4500.0, [58, 110, 170]),
    (-3500.0, [80, 136, 188]),
    (-2500.0, [104, 160, 204]),
    (-1200.0, [130, 184, 216]),
    (-300.0, [156, 204, 226]),
    (-140.0, [178, 218, 232]),
    (0.0, [196, 228, 236]),
];
const ICE: Vec3 = Vec3::new(0.945, 0.962, 0.975);
const PACK_ICE: Vec3 = Vec3::new(0.86, 0.91, 0.94);

/// Noise that bends the belts of climate, so that they do not run along parallels.
pub(crate) struct Wander(FastNoiseLite);

impl Wander {
    pub(crate) fn new(seed: u64) -> Self {
        let mut noise = FastNoiseLite::with_seed((seed ^ (seed >> 32)) as i32);
        noise.set_noise_type(Some(NoiseType::OpenSimplex2));
        noise.set_fractal_type(Some(FractalType::FBm));
        noise.set_fractal_octaves(Some(5));
        noise.set_frequency(Some(1.7));
        Self(noise)
    }

    /// −1 to 1 in a direction of the simulation.
    pub(crate) fn at(&self, direction: Vec3) -> f32 {
        let noise = self.0.get_noise_3d(direction.x, direction.y, direction.z);
        (1.6 * noise).clamp(-1.0, 1.0)
    }
}

/// The climate that a latitude suggests, bent by [`Wander`].
pub(crate) struct Climate {
    /// The latitude whose climate this is, degrees; never negative by much.
    #[cfg_attr(
        not(feature = "render"),
        expect(dead_code, reason = "for climate maps")
    )]
    pub latitude: f32,
    pub arid: f32,
    boreal: f32,
    /// Height above which snow lies, m.
    snow_m: f32,
    ice: f32,
    pack_ice: f32,
}

impl Climate {
    pub(crate) fn at(latitude_degrees: f32, wander: f32) -> Self {
        let latitude = latitude_degrees.abs() + 7.0 * wander;
        // Dry where air sinks between the tropics and the westerlies; patchy, as on Earth.
        let belt = smooth(ramp(11.0, 19.0, latitude)) * (1.0 - smooth(ramp(27.0, 37.0, latitude)));
        let arid = belt * (0.78 + 0.5 * wander).clamp(0.0, 1.0);
        let cold = ramp(25.0, 72.0, latitude);
        Self {
            latitude,
            arid,
            boreal: smooth(ramp(46.0, 60.0, latitude)),
            snow_m: 5400.0 * (1.0 - cold * cold) - 200.0 * cold,
            ice: smooth(ramp(68.0, 75.0, latitude)),
            pack_ice: smooth(ramp(76.0, 84.0, latitude)),
        }
    }

    /// Colour of land, components 0–1.
    pub(crate) fn land(&self, elevation: f32) -> Vec3 {
        let green = look_up(HUMID, elevation).lerp(look_up(BOREAL, elevation), self.boreal);
        let ground = green.lerp(look_up(ARID, elevation), self.arid);
        let snow = smooth(ramp(self.snow_m - 300.0, self.snow_m + 500.0, elevation));
        ground.lerp(ICE, self.ice.max(snow * 0.92))
    }

    /// Colour of the sea, components 0–1.
    pub(crate) fn sea(&self, elevation: f32) -> Vec3 {
        look_up(SEA, elevation).lerp(PACK_ICE, 0.72 * self.pack_ice)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ramps_rise_and_cover_everything() {
        for table in [HUMID, ARID, BOREAL, SEA] {
            assert!(table.windows(2).all(|pair| pair[0].0 < pair[1].0));
            for elevation in [-20_000.0, -1.0, 0.0, 777.0, 20_000.0] {
                assert!(look_up(table, elevation).cmpgt(Vec3::ZERO).all());
            }
        }
    }

    #[test]
    fn poles_are_white_and_the_tropics_are_not() {
        assert!(Climate::at(85.0, 0.0).land(100.0).min_element() > 0.9);
        assert!(Climate::at(0.0, 0.0).land(100.0).max_element() < 0.75);
        let desert = Climate::at(23.0, 0.0).land(200.0);
        assert!(desert.x > desert.y && desert.y > desert.z);
    }
}
