//! What a planet's air is like.
//!
//! How much air lies along a line is known in closed form (`beyond` in `air.wgsl`), after Tectonics.js: within
//! 1.5 % of the integral for planets of 200 to 2,000 scale heights, up to four scale heights above the ground, from
//! straight up to level. The form with a square root alone, which its author gives for speed, is off by 6.6 %.

use bevy::prelude::*;

/// The air of a planet as it is seen from close by: the blue of its sky, the haze before its mountains. From afar,
/// where Earth's true air would be a line too thin to see, it reaches several times higher, as a thinner rim of the
/// same colour. The default is Earth's air; planets without this component have it too.
/// [`PlanetAtmosphere`](super::PlanetAtmosphere) has Bevy draw it.
#[derive(Component, Debug, Clone, Copy, PartialEq, Reflect)]
#[reflect(Component, Default)]
pub struct PlanetAir {
    /// How much of the light that comes straight down the air scatters: optical depth for red, green and blue, each
    /// up to 10.
    pub depth: Vec3,
    /// Height in m in which the air thins to 1/e, from a ten-thousandth to a fiftieth of the radius.
    pub scale_height_m: f32,
}

impl Default for PlanetAir {
    fn default() -> Self {
        Self {
            // Rayleigh scattering at 680, 550 and 440 nm over 8 km, and a little dust.
            depth: Vec3::new(0.055, 0.12, 0.27),
            scale_height_m: 8000.0,
        }
    }
}

impl PlanetAir {
    /// What shaders want to know of it; lengths are in radii.
    pub(super) fn uniform(&self, radius_km: f64) -> Vec4 {
        let depth = self.depth.to_array().map(|depth| {
            if depth.is_finite() {
                depth.clamp(0.0, 10.0)
            } else {
                0.0
            }
        });
        let scale = f64::from(self.scale_height_m) / (1000.0 * radius_km.max(1.0));
        let scale = if scale.is_finite() {
            scale.clamp(1e-4, 0.02)
        } else {
            1e-3
        };
        Vec3::from(depth).extend(scale as f32)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `beyond` of the shader, lengths in scale heights, relative to the density where the line starts.
    fn beyond(x: f64, z: f64) -> f64 {
        let r = (x * x + z * z).sqrt();
        let level = (0.5 / r + 1.0) * (core::f64::consts::FRAC_PI_2 * z).sqrt() + 0.67 * x;
        1.0 / (x / r + 1.0 / level)
    }

    /// The same, summed up along the line in small steps.
    fn summed(x: f64, z: f64) -> f64 {
        let start = (x * x + z * z).sqrt();
        let density = |along: f64| {
            let at = x + along;
            libm::exp(start - (at * at + z * z).sqrt())
        };
        // Simpson's rule, finer where the air is dense.
        let end = 40.0 * start.sqrt();
        let steps = 20_000;
        let place = |i: u32| {
            let share = f64::from(i) / f64::from(steps);
            end * share * share
        };
        (0..steps)
            .map(|i| {
                let (a, b) = (place(i), place(i + 1));
                (b - a) / 6.0 * (density(a) + 4.0 * density(0.5 * (a + b)) + density(b))
            })
            .sum()
    }

    #[test]
    fn the_closed_form_is_within_a_fiftieth_of_the_integral() {
        assert!(include_str!("air.wgsl").contains("+ 0.67 * x / scale;"));
        let mut worst = 0.0_f64;
        for radius in [200.0, 500.0, 800.0, 2000.0] {
            for height in [0.0, 0.5, 2.0, 4.0] {
                for angle in 0..=45 {
                    let (sin, cos) = libm::sincos(f64::from(2 * angle).to_radians());
                    let (x, z) = ((radius + height) * cos, (radius + height) * sin);
                    let error = beyond(x.max(0.0), z.max(1e-6)) / summed(x.max(0.0), z) - 1.0;
                    worst = worst.max(error.abs());
                }
            }
        }
        assert!(worst < 0.015, "{worst}");
    }

    #[test]
    fn nonsense_is_no_air_and_no_panic() {
        let air = PlanetAir {
            depth: Vec3::new(f32::NAN, -1.0, f32::INFINITY),
            scale_height_m: f32::NAN,
        };
        assert_eq!(air.uniform(6371.0), Vec4::new(0.0, 0.0, 0.0, 1e-3));
        assert!(air.uniform(0.0).is_finite());
    }
}
