//! How high terrain stands at a place: what the history's ground there says.

use super::super::{
    ground::{ramp, smooth},
    raster::Base,
};

/// Deviation of plains in m, and how much it grows per m of height: 15 m on a plain 200 m high. By eye: no
/// source gives one.
const PLAIN: (f32, f32) = (6.0, 0.045);
/// Share of the height that mountains deviate by: 360 m where they stand 4,000 m high. With it
/// slopes of young ranges have a mean of 25 to 30°; with half as much again they are steeper than rock stands.
const MOUNTAIN: f32 = 0.09;
/// How much more terrain ranges have than the mean, and basins less: what the noise of maps says.
const RANGES: f32 = 0.5;
/// Heights in m between which land becomes mountains, and roughness of a belt.
const RISES: (f32, f32) = (600.0, 2800.0);
/// Nothing deviates by more than this share of its height or depth: four deviations are possible, and terrain
/// makes no land of sea.
const CAP: f32 = 0.22;
/// Deviation of abyssal hills on new floor in m, and when sediment has buried half of them, in My: some 200 m
/// from trough to crest.
const HILLS: (f32, f32) = (55.0, 60.0);
/// What is never buried: in m.
const OLD_FLOOR: f32 = 12.0;
/// Deviation on continental slopes, which canyons cut.
const SLOPE_M: f32 = 60.0;
/// Deviation in the walls of trenches below this depth, in m.
const TRENCH: (f32, f32) = (-6500.0, 130.0);

/// What terrain may do at a place.
pub(super) struct Strength {
    /// Standard deviation in m of what the larger pieces add.
    pub deviation_m: f32,
    cap_m: f32,
    is_land: bool,
}

impl Strength {
    pub fn at(base: &Base) -> Self {
        let (height, ground) = (base.elevation, &base.ground);
        let cap_m = CAP * height.abs();
        let wanted = if height > 0.0 {
            let mountain = smooth(ramp(RISES.0, RISES.1, height)).max(0.6 * ground.rugged.min(1.0));
            let plain = PLAIN.0 + PLAIN.1 * height;
            // Ranges stand out from the basins between them.
            let range = 1.0 + RANGES * base.grain;
            (plain + (MOUNTAIN * height - plain).max(0.0) * mountain) * range
        } else {
            let floor = OLD_FLOOR
                + HILLS.0 * libm::expf(-core::f32::consts::LN_2 * ground.floor_age / HILLS.1);
            // Shelves are flat: waves planed them.
            let margin =
                smooth(ramp(0.05, 0.5, ground.continental)) * smooth(ramp(-300.0, -900.0, height));
            let trench = smooth(ramp(TRENCH.0, TRENCH.0 - 1500.0, height)) * TRENCH.1;
            let open = smooth(ramp(-900.0, -2500.0, height));
            (floor * open).max(SLOPE_M * margin).max(trench) + 3.0
        };
        Self {
            deviation_m: wanted.min(cap_m),
            cap_m,
            is_land: height > 0.0,
        }
    }

    /// Deviation in m of the smaller pieces, which wish for this one.
    pub fn grain_m(&self, wanted: f32) -> f32 {
        // Mud lies on the sea floor.
        let rock = if self.is_land { 1.0 } else { 0.2 };
        (rock * wanted * (self.deviation_m / 60.0).clamp(0.1, 1.0)).min(0.02 * self.cap_m)
    }
}
