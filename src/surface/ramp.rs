//! Linear ramps of colour over a value.

use glam::Vec3;

/// Value, red, green, blue (0–255), in the order of values.
pub(crate) type Ramp = [(f32, [u8; 3])];

/// The colour of a value, components 0–1. Beyond the ends the colours of the ends hold; what is not a
/// number has the first.
pub(crate) fn look_up(table: &Ramp, value: f32) -> Vec3 {
    let colour = |[r, g, b]: [u8; 3]| Vec3::new(f32::from(r), f32::from(g), f32::from(b)) / 255.0;
    let above = table.partition_point(|&(step, _)| step < value);
    match (
        above.checked_sub(1).and_then(|below| table.get(below)),
        table.get(above),
    ) {
        (Some(&(low, dark)), Some(&(high, light))) => {
            let share = ((value - low) / (high - low)).clamp(0.0, 1.0);
            colour(dark).lerp(colour(light), share)
        }
        (Some(&(_, only)), None) | (None, Some(&(_, only))) => colour(only),
        (None, None) => Vec3::ZERO,
    }
}
