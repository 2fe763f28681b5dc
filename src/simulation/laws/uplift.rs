//! Uplift of the plate that overrides a trench (Cortial et al. 2019, section 4.1).

use super::super::constants::LawConstants;

/// Uplift `u₀ f(d) g(v) h(z̃)` in km/My at a distance in km from the trench, for plates that move at
/// this speed in km/My relative to each other, over crust whose surface lies at `elevation_km`.
#[must_use]
pub fn uplift_rate(constants: &LawConstants, distance: f64, speed: f64, elevation_km: f64) -> f64 {
    constants.uplift
        * by_distance(constants, distance)
        * (speed / constants.reference_speed)
        * by_relief(normalised(constants, elevation_km))
}

/// f: a cubic from 0 at the trench up to 1 at the control distance, and another down to 0 at `r_s`.
/// The paper draws it without figures.
#[must_use]
pub fn by_distance(constants: &LawConstants, distance: f64) -> f64 {
    let (peak, end) = (constants.uplift_peak, constants.subduction_distance);
    let smooth = |x: f64| {
        let x = x.clamp(0.0, 1.0);
        x * x * (3.0 - 2.0 * x)
    };
    if distance < peak {
        smooth(distance / peak)
    } else {
        smooth((end - distance) / (end - peak).max(1e-9))
    }
}

/// z̃ = (z − `z_t)/(z_c` − `z_t)`: 0 at the depth of trenches, 1 at the height of the highest land.
#[must_use]
pub fn normalised(constants: &LawConstants, elevation_km: f64) -> f64 {
    let (trench, highest) = (constants.trench_elevation, constants.highest_elevation);
    ((elevation_km - trench) / (highest - trench).max(1e-9)).clamp(0.0, 1.0)
}

/// h(z̃) = z̃²: high relief that is dragged under, forced to subduct, lifts more than abyssal plains do.
#[must_use]
pub fn by_relief(normalised: f64) -> f64 {
    normalised * normalised
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn uplift_by_distance_speed_and_relief() {
        let constants = LawConstants::default();
        // At the control distance f = 1; g = 50/100; z̃ = (−4 + 10)/20 = 0.3, h = 0.09:
        // 0.6 · 1 · 0.5 · 0.09 = 0.027 km/My.
        assert!((uplift_rate(&constants, 640.0, 50.0, -4.0) - 0.027).abs() < 1e-12);
        // Half way up, f = 0.5² (3 − 2 · 0.5) = 0.5; at sea level z̃ = 0.5, h = 0.25; g = 1:
        // 0.6 · 0.5 · 1 · 0.25 = 0.075 km/My.
        assert!((uplift_rate(&constants, 320.0, 100.0, 0.0) - 0.075).abs() < 1e-12);
        // (1800 − 1220)/(1800 − 640) = 0.5: half way down, f = 0.5.
        assert!((by_distance(&constants, 1220.0) - 0.5).abs() < 1e-12);
        assert_eq!(by_distance(&constants, 0.0), 0.0);
        assert_eq!(by_distance(&constants, 1800.0), 0.0);
        assert_eq!(by_distance(&constants, 2500.0), 0.0);
    }

    /// Forced subduction: a plateau that is dragged under lifts what rides over it more than plain floor does.
    #[test]
    fn a_plateau_dragged_under_lifts_more() {
        let constants = LawConstants::default();
        let at = |elevation| uplift_rate(&constants, 640.0, 60.0, elevation);
        // z̃ = 8/20 against 5/20: (8/5)² = 2.56.
        assert!((at(-2.0) / at(-5.0) - 2.56).abs() < 1e-12);
        // Nothing lies deeper than a trench.
        assert_eq!(at(-10.0), 0.0);
        assert_eq!(at(-11.0), 0.0);
    }
}
