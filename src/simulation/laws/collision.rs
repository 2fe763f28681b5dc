//! What the arrival of a terrane does to a continent (Cortial et al. 2019, section 4.2).

use super::super::constants::LawConstants;
use glam::DVec3;

/// Reach of a collision in km, `r_c √(v/v₀) A/A₀`: `v` the relative speed in km/My, `A` the terrane's
/// area, `A₀` the mean area of a plate at the start, both in km². Terranes larger than a plate count as
/// one, or the reach would pass `r_c` without bound.
#[must_use]
pub fn collision_reach(
    constants: &LawConstants,
    speed: f64,
    area_km2: f64,
    plate_area_km2: f64,
) -> f64 {
    let share = (area_km2 / plate_area_km2.max(1.0)).clamp(0.0, 1.0);
    constants.collision_distance * (speed.max(0.0) / constants.reference_speed).sqrt() * share
}

/// Surge of elevation in km at a distance in km from the terrane, `Δ_c A (1 − (d/r)²)²`; 0 beyond
/// the reach `r`.
#[must_use]
pub fn collision_surge(constants: &LawConstants, area_km2: f64, distance: f64, reach: f64) -> f64 {
    let x = distance / reach;
    if reach > 0.0 && x < 1.0 {
        let near = 1.0 - x * x;
        constants.collision * area_km2 * near * near
    } else {
        0.0
    }
}

/// Fold direction at `p` around a terrane's centroid `q`, `(n × (p − q)/|p − q|) × n`: the tangent that
/// points away from the centroid. Zero at the centroid itself.
#[must_use]
pub fn collision_fold(p: DVec3, q: DVec3) -> DVec3 {
    let n = p.normalize_or_zero();
    n.cross((p - q).normalize_or_zero()).cross(n)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reach_grows_with_speed_and_area() {
        let constants = LawConstants::default();
        // 4200 · √(25/100) · 4e6/2e7 = 4200 · 0.5 · 0.2 = 420 km.
        assert!((collision_reach(&constants, 25.0, 4e6, 2e7) - 420.0).abs() < 1e-9);
        // The share of area is bounded: 4200 · 1 · 1.
        assert!((collision_reach(&constants, 100.0, 5e7, 2e7) - 4200.0).abs() < 1e-9);
        assert_eq!(collision_reach(&constants, -1.0, 4e6, 2e7), 0.0);
    }

    #[test]
    fn the_surge_fades_to_the_reach() {
        let constants = LawConstants::default();
        // 1.3e-5 · 1e5 = 1.3 km at the terrane.
        assert!((collision_surge(&constants, 1e5, 0.0, 400.0) - 1.3).abs() < 1e-12);
        // Half way: (1 − 0.25)² = 0.5625; 1.3 · 0.5625 = 0.73125 km.
        assert!((collision_surge(&constants, 1e5, 200.0, 400.0) - 0.731_25).abs() < 1e-12);
        assert_eq!(collision_surge(&constants, 1e5, 400.0, 400.0), 0.0);
        assert_eq!(collision_surge(&constants, 1e5, 0.0, 0.0), 0.0);
    }

    #[test]
    fn folds_point_away_from_the_centroid() {
        // p = x, q = (0.8, 0.6, 0): p − q = (0.2, −0.6, 0), of length √0.4; its tangent part is −y,
        // 0.6/√0.4 = 0.948683 long.
        let fold = collision_fold(DVec3::X, DVec3::new(0.8, 0.6, 0.0));
        assert!((fold - DVec3::new(0.0, -0.948_683, 0.0)).length() < 1e-6);
        assert_eq!(collision_fold(DVec3::X, DVec3::X), DVec3::ZERO);
    }
}
