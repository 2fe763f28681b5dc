//! Depth of sea floor by age.

use super::{super::constants::LawConstants, SeaFloorLaw};

/// Age from which the plate model of Parsons & Sclater (1977) departs from cooling, in My.
const PLATE_AGE: f64 = 70.0;
/// When Yggdrasill's sea floor starts to sink, in My.
const SINK_BEGIN: f64 = 2.0;
/// How fast it does, in m/My (0.006 m/yr).
const SINK_SPEED: f64 = 6000.0;

impl SeaFloorLaw {
    /// Depth in m, positive down, of normal sea floor of an age in My; what is younger than 0 counts
    /// as 0.
    #[must_use]
    pub fn depth(self, constants: &LawConstants, age_my: f64) -> f64 {
        let age = age_my.max(0.0);
        match self {
            Self::Gdh1 => super::super::stages::sea_floor_depth(age_my),
            Self::ParsonsSclater => parsons_sclater(age),
            Self::Cortial => cortial(constants, age),
            Self::Yggdrasill => yggdrasill(constants, age),
        }
    }
}

/// `2500 + 350 √t` up to 70 My, then `6400 − 3200 e^(−t/62.8)` (Parsons & Sclater 1977, equations
/// 21 and 22).
fn parsons_sclater(age: f64) -> f64 {
    if age < PLATE_AGE {
        2500.0 + 350.0 * age.sqrt()
    } else {
        6400.0 - 3200.0 * libm::exp(-age / 62.8)
    }
}

/// `dz/dt = −(1 − z/z_t) ε_o` from `z_r` (Cortial et al. 2019, section 4.5), integrated:
/// `z = z_t + (z_r − z_t) e^(ε_o t/z_t)`.
fn cortial(constants: &LawConstants, age: f64) -> f64 {
    let (ridge, trench) = (constants.ridge_elevation, constants.trench_elevation);
    let left = libm::exp(constants.sea_floor_damping * age / trench);
    -1e3 * (trench + (ridge - trench) * left)
}

/// From the ridge to the abyssal plain at 6,000 m/My, once 2 My old (Yggdrasill, step 9). Its slow
/// damping beside that, 60 m/My at most, has no time to matter.
fn yggdrasill(constants: &LawConstants, age: f64) -> f64 {
    let (ridge, abyss) = (constants.ridge_elevation, constants.abyss_elevation);
    (-1e3 * ridge + SINK_SPEED * (age - SINK_BEGIN).max(0.0)).min(-1e3 * abyss)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[track_caller]
    fn lies(law: SeaFloorLaw, age: f64, depth: f64) {
        let found = law.depth(&LawConstants::default(), age);
        assert!((found - depth).abs() < 0.5, "{law:?} at {age}: {found}");
    }

    #[test]
    fn parsons_and_sclater() {
        lies(SeaFloorLaw::ParsonsSclater, -1.0, 2500.0);
        // 2500 + 350 · √36 = 4600.
        lies(SeaFloorLaw::ParsonsSclater, 36.0, 4600.0);
        // 6400 − 3200 e^(−125.6/62.8) = 6400 − 3200 · 0.135335 = 5966.9.
        lies(SeaFloorLaw::ParsonsSclater, 125.6, 5966.9);
    }

    #[test]
    fn cortials_damping() {
        lies(SeaFloorLaw::Cortial, 0.0, 1000.0);
        // −10 + 9 e^(−0.04 · 100/10) = −10 + 9 · 0.670320 = −3.96712 km.
        lies(SeaFloorLaw::Cortial, 100.0, 3967.1);
        // −10 + 9 e^(−1) = −10 + 9 · 0.367879 = −6.68909 km.
        lies(SeaFloorLaw::Cortial, 250.0, 6689.1);
        // The step of the paper, z −= (1 − z/z_t) ε_o dt, leads to the same place.
        let (mut z, dt) = (-1.0, 0.01);
        for _ in 0..10_000 {
            z -= (1.0 - z / -10.0) * 0.04 * dt;
        }
        lies(SeaFloorLaw::Cortial, 100.0, -1e3 * z);
    }

    #[test]
    fn yggdrasills_fall() {
        lies(SeaFloorLaw::Yggdrasill, 1.9, 1000.0);
        // 1000 + 6000 · 0.5 = 4000.
        lies(SeaFloorLaw::Yggdrasill, 2.5, 4000.0);
        lies(SeaFloorLaw::Yggdrasill, 100.0, 6000.0);
    }
}
