//! Profile of a mid-ocean ridge (Cortial et al. 2019, section 4.3).

use super::super::constants::LawConstants;

/// Distance over which the profile halves, in km. The paper draws it without figures.
const HALVING: f64 = 320.0;

/// Elevation in km of new sea floor, `α z̄ + (1 − α) z_Γ` with `α = d_Γ/(d_Γ + d_P)`: `ridge_distance`
/// and `plate_distance` in km to the ridge and to the nearest plate, `between_km` the elevation
/// interpolated between the plates. On the ridge itself, where both may be 0, it is the profile's.
#[must_use]
pub fn new_floor_elevation(
    constants: &LawConstants,
    ridge_distance: f64,
    plate_distance: f64,
    between_km: f64,
) -> f64 {
    let sum = ridge_distance + plate_distance;
    let alpha = if sum > 0.0 { ridge_distance / sum } else { 0.0 };
    alpha * between_km + (1.0 - alpha) * ridge_profile(constants, ridge_distance)
}

/// `z_Γ`: elevation in km at a distance in km from a ridge, `z_a + (z_r − z_a) 2^(−d/320 km)`.
#[must_use]
pub fn ridge_profile(constants: &LawConstants, distance: f64) -> f64 {
    let (ridge, abyss) = (constants.ridge_elevation, constants.abyss_elevation);
    abyss + (ridge - abyss) * libm::exp2(-distance / HALVING)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_profile_falls_from_the_ridge_to_the_plain() {
        let constants = LawConstants::default();
        assert_eq!(ridge_profile(&constants, 0.0), -1.0);
        // −6 + 5/2 = −3.5 and −6 + 5/4 = −4.75.
        assert!((ridge_profile(&constants, 320.0) + 3.5).abs() < 1e-12);
        assert!((ridge_profile(&constants, 640.0) + 4.75).abs() < 1e-12);
    }

    #[test]
    fn new_floor_blends_profile_and_flanks() {
        let constants = LawConstants::default();
        // α = 320/(320 + 960) = 0.25: 0.25 · −5 + 0.75 · −3.5 = −3.875 km.
        let blended = new_floor_elevation(&constants, 320.0, 960.0, -5.0);
        assert!((blended + 3.875).abs() < 1e-12);
        assert_eq!(new_floor_elevation(&constants, 0.0, 0.0, -5.0), -1.0);
        // At the plate's edge α = 1: what lies there already.
        assert!((new_floor_elevation(&constants, 320.0, 0.0, -5.0) + 5.0).abs() < 1e-12);
    }
}
