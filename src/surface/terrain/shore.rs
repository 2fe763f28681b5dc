//! Coasts that stay ragged: the displacement that maps end with goes on, half as far with every halving of the
//! wavelength. Away from the sea's level it fades, so that it costs nothing inland.

use super::super::{
    ground::smooth,
    texture::{FINEST_KM, Texture},
};
use crate::simulation::Surface;
use fastnoise_lite::FastNoiseLite;
use glam::DVec3;

/// Finest wavelength in m: shorter ones are those of waves and tides.
const FINEST_M: f64 = 150.0;
/// Displacement in m per m of wavelength, of each octave.
const STRAIN: f64 = 0.22;
/// How much further than its amplitude an octave displaces at most; the test below measures it.
pub(super) const FURTHEST: f64 = 1.5;
/// Elevation and depth in m at which nothing of it is left.
const FADES_M: f32 = 250.0;

/// Displacement of one surface at one level of detail.
pub(super) struct Shore {
    pub warp: Option<FastNoiseLite>,
    left_out_m: f64,
}

impl Shore {
    pub fn new(surface: &Surface, detail_m: f64) -> Self {
        let radius_m = 1000.0 * surface.radius_km;
        let first = 500.0 * FINEST_KM * surface.radius_km / 6371.0;
        let count = |finest: f64| (libm::log2(first / finest).floor() + 1.0).max(0.0) as i32;
        let (all, octaves) = (count(FINEST_M), count(FINEST_M.max(2.0 * detail_m)));
        let displacement = |octave: i32| STRAIN * first / libm::exp2(f64::from(octave));
        Self {
            warp: (octaves > 0).then(|| {
                Texture::shore(
                    surface.seed,
                    radius_m / first,
                    octaves,
                    displacement(0) / radius_m,
                )
            }),
            left_out_m: FURTHEST * (octaves..all).map(displacement).sum::<f64>(),
        }
    }

    /// How far the octaves left out can move the shore.
    pub fn error_m(&self) -> f64 {
        self.left_out_m
    }

    /// Where to look in place of a direction at this height, if it is near the sea's level.
    pub fn displace(&self, direction: DVec3, height: f32) -> Option<DVec3> {
        let near = 1.0 - height.abs() / FADES_M;
        let warp = self.warp.as_ref().filter(|_| near > 0.0)?;
        let [x, y, z] = direction.as_vec3().to_array();
        let (u, v, w) = warp.domain_warp_3d(x, y, z);
        let offset = DVec3::new(f64::from(u - x), f64::from(v - y), f64::from(w - z));
        Some((direction + offset * f64::from(smooth(near))).normalize())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_octave_displaces_as_far_as_is_said() {
        let warp = Texture::shore(5, 300.0, 1, 0.001);
        let far = (0..20_000).map(|i| {
            let (sin, cos) = libm::sincosf(i as f32 * 0.7);
            let (x, y, z) = (cos * 0.9, sin * 0.9, i as f32 * 1e-5);
            let (u, v, w) = warp.domain_warp_3d(x, y, z);
            f64::from((u - x).hypot(v - y).hypot(w - z)) / 0.001
        });
        let furthest = far.fold(0.0, f64::max);
        assert!((0.5..FURTHEST).contains(&furthest), "{furthest}");
    }
}
