//! Erosion, sediment and rain.

use super::super::constants::LawConstants;

/// Height that continental crust loses in km, `z/z_c ε_c dt` (Cortial et al. 2019, section 4.5);
/// negative below the sea: there it gains.
#[must_use]
pub fn continental_wear(constants: &LawConstants, elevation_km: f64, time_my: f64) -> f64 {
    elevation_km / constants.highest_elevation * constants.erosion * time_my
}

/// Sediment that a trench takes in m, `ε_t dt` (same section).
#[must_use]
pub fn trench_sediment(constants: &LawConstants, time_my: f64) -> f64 {
    1e3 * constants.sediment * time_my
}

/// Share of a difference in height that rain carries to lower neighbours, all together, in a time
/// (Tectonics.js: a fraction per metre of rain), at a spacing of 226 km.
#[must_use]
pub fn rain_share(constants: &LawConstants, latitude: f64, time_my: f64) -> f64 {
    constants.rain_erosion * constants.precipitation * precipitation(latitude) * time_my
}

/// Rain by latitude in rad as a multiple of its mean over the sphere: wet at the equator, dry in the
/// horse latitudes, wet again under the westerlies, dry at the poles. Tectonics.js rains evenly and
/// names this as what is missing.
#[must_use]
pub fn precipitation(latitude: f64) -> f64 {
    /// Makes the mean over the sphere 1.
    const MEAN: f64 = 0.853_6;
    let degrees = latitude.to_degrees().abs();
    let bell = |centre: f64, width: f64| {
        let x = (degrees - centre) / width;
        libm::exp(-x * x)
    };
    (0.25 + 1.65 * bell(0.0, 13.0) + 0.85 * bell(48.0, 16.0)) / MEAN
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn high_land_wears_in_proportion() {
        let constants = LawConstants::default();
        // 4/10 · 0.03 · 2 = 0.024 km.
        assert!((continental_wear(&constants, 4.0, 2.0) - 0.024).abs() < 1e-12);
        // −1/10 · 0.03 · 2 = −0.006 km: it rises.
        assert!((continental_wear(&constants, -1.0, 2.0) + 0.006).abs() < 1e-12);
        // 0.3 mm/yr · 2 My = 600 m.
        assert!((trench_sediment(&constants, 2.0) - 600.0).abs() < 1e-9);
    }

    #[test]
    fn rain_carries_a_share() {
        let constants = LawConstants::default();
        // 1.8e-7 · 7.8e5 = 0.1404 a My, times the rain of the place.
        let share = rain_share(&constants, 0.5, 2.0);
        assert!((share - 0.2808 * precipitation(0.5)).abs() < 1e-12);
    }

    #[test]
    fn rain_has_its_mean_and_its_belts() {
        let (mut sum, mut weight) = (0.0, 0.0);
        for i in 0..18_000 {
            let latitude = (f64::from(i) / 100.0 - 90.0 + 0.005).to_radians();
            let area = libm::cos(latitude);
            sum += precipitation(latitude) * area;
            weight += area;
        }
        assert!((sum / weight - 1.0).abs() < 1e-3, "{}", sum / weight);
        let at = |degrees: f64| precipitation(degrees.to_radians());
        assert!(at(0.0) > at(48.0) && at(48.0) > at(25.0) && at(25.0) > at(85.0));
        assert_eq!(at(30.0), at(-30.0));
    }
}
