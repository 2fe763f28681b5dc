//! What a planet's air is like.

use bevy::prelude::*;

/// The air of a planet as it is seen from close by: the blue of its sky, the haze before its mountains. From afar,
/// where Earth's true air would be a line too thin to see, every planet has the same thicker rim. The default is
/// Earth's air; planets without this component have it too.
#[derive(Component, Debug, Clone, Copy, PartialEq, Reflect)]
#[reflect(Component, Default)]
pub struct PlanetAir {
    /// How much of the light that comes straight down the air scatters: optical depth for red, green and blue.
    pub depth: Vec3,
    /// Height in m in which the air thins to 1/e.
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
