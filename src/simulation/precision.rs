//! How finely the state is kept.
//!
//! Digits far below what they mean are noise, and every save would have to carry it. Rounding is even, and so
//! fine that it adds up to nothing over a history: the constants say what it comes to.

/// Sites are whole multiples of one radius over this: 6 nm on Earth, so that no edge flips for it.
pub(crate) const SITE_STEPS: f64 = (1_u64 << 50) as f64;
/// Directions that crust carries: a hundred thousandth of a radian in every step, some hundredths of a degree in a
/// long history.
pub(crate) const DIRECTION_STEPS: f32 = (1_u32 << 16) as f32;
/// Rest lengths of springs: 1.5 m on Earth, where springs yield at hundreds.
pub(crate) const REST_STEPS: f64 = (1_u64 << 22) as f64;
/// Thickness of crust: four millimetres each time margins bend or the ground settles. What that adds up to is booked.
pub(crate) const THICKNESS_STEPS: f64 = (1_u64 << 18) as f64;
/// Elevations: 2 cm.
pub(crate) const ELEVATION_STEPS: f64 = 64.0;

// Adding and taking away a number whose neighbours lie a step apart rounds to that step. Compilers do that for
// several numbers at once, unlike `round`.

/// The nearest whole multiple of one over `steps`, a power of two; at most 2⁵¹ steps from zero.
pub(crate) fn round(x: f64, steps: f64) -> f64 {
    const SHIFT: f64 = 1.5 * (1_u64 << 52) as f64;
    ((x * steps + SHIFT) - SHIFT) / steps
}

/// An area to 16 binary digits: half a square kilometre of a cell 226 km wide. What continents lose or gain by it is
/// booked.
pub(crate) fn round_area(x: f64) -> f64 {
    // Half of the last digit kept is added before the others go.
    let bits = x.to_bits() + (1 << (AREA_BITS - 1));
    f64::from_bits(bits & !((1 << AREA_BITS) - 1))
}

/// Binary digits of an area's fraction that are not kept, of 52.
const AREA_BITS: u32 = 52 - 15;

/// A component of a site, between −1 and 1, on its grid.
pub(crate) fn round_site(x: f64) -> f64 {
    const SHIFT: f64 = 1.5 * (1_u64 << 52) as f64 / SITE_STEPS;
    (x + SHIFT) - SHIFT
}

/// A component of a direction on its grid; components beyond 4 a little more coarsely.
pub(crate) fn round_direction(x: f32) -> f32 {
    const SHIFT: f32 = 1.5 * (1_u32 << 23) as f32 / DIRECTION_STEPS;
    (x + SHIFT) - SHIFT
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_rounded_is_a_whole_multiple_nearby() {
        for i in -1000..=1000 {
            let x = 70.0 * libm::sin(f64::from(i));
            for (rounded, x, steps) in [
                (round(x, THICKNESS_STEPS), x, THICKNESS_STEPS),
                (
                    round(100.0 * x, ELEVATION_STEPS),
                    100.0 * x,
                    ELEVATION_STEPS,
                ),
                (round_site(x / 70.0), x / 70.0, SITE_STEPS),
            ] {
                assert_eq!(rounded, (x * steps).round_ties_even() / steps, "{x}");
            }
            let x = (x / 18.0) as f32;
            let expected = (x * DIRECTION_STEPS).round_ties_even() / DIRECTION_STEPS;
            assert_eq!(round_direction(x), expected, "{x}");
        }
        assert_eq!(round_site(-1.0), -1.0);
    }
}
