//! Sea floor: abyssal hills run along the ridge that made them. A piece of it is a few waves across the ridge
//! under the piece's own weight, which makes Gabor noise of their sum (Lagae et al. 2009).

use core::f32::consts::TAU;
use glam::Vec3;

/// Wavelengths in m across the ridge. By eye: no source gives them.
const WAVES_M: [f32; 6] = [11_000.0, 7000.0, 4400.0, 2800.0, 1700.0, 1000.0];
/// How far waves may be tilted towards the ridge: hills become some five times as long as wide.
const ALONG: f32 = 0.2;

/// Value in deviations and slope per m at an offset in m. Waves shorter than two steps of detail are left out, and
/// what they could add is the last figure.
pub(super) fn hills(
    offset: Vec3,
    along: Vec3,
    across: Vec3,
    bits: u64,
    detail_m: f32,
) -> (f32, Vec3, f32) {
    // Amplitudes as the square root of the wavelength: the spectrum of a profile falls with its square.
    let power: f32 = WAVES_M.iter().map(|wave| 0.5 * wave).sum();
    let scale = power.sqrt().recip();
    let (ahead, aside) = (offset.dot(along), offset.dot(across));
    let (mut value, mut slope, mut error) = (0.0, [0.0; 2], 0.0);
    for (i, length) in WAVES_M.into_iter().enumerate() {
        let amplitude = length.sqrt() * scale;
        let part = |bit: usize| (bits.rotate_right(bit as u32) & 0x3F) as f32 / 64.0;
        let length = length * (0.7 + 0.6 * part(7 * i + 11));
        // Fades in over an octave, so that no wave appears at once.
        let share = (length / (2.0 * detail_m) - 1.0).clamp(0.0, 1.0);
        error += amplitude * (1.0 - share);
        if share == 0.0 {
            continue;
        }
        let tilt = ALONG * (2.0 * part(5 * i + 3) - 1.0);
        let turns = (aside + tilt * ahead) / length + part(6 * i + 23);
        let (sin, cos) = sine_cosine(turns);
        let (height, change) = (share * amplitude, share * amplitude * TAU / length);
        value += height * sin;
        slope[0] += change * cos * tilt;
        slope[1] += change * cos;
    }
    (value, along * slope[0] + across * slope[1], error)
}

/// Sine and cosine of an angle in turns, at most a thousand, to 3e-7: a sample of sea floor takes two dozen of them,
/// and libm's, which are good to the last bit, took 600 instructions more a sample on average.
fn sine_cosine(turns: f32) -> (f32, f32) {
    // Made positive, a cast rounds down, faster than a call does.
    const UP: i32 = 1 << 12;
    let halves = (2.0 * turns + 0.5 + UP as f32) as i32 - UP;
    let x = TAU * (turns - 0.5 * halves as f32);
    let y = x * x;
    // Taylor's series on a half turn around 0, of which the next terms are 6e-8 and 7e-9.
    let sin = 1.0 - y * (1.0 / 110.0);
    let sin = 1.0 - y * (1.0 / 72.0) * sin;
    let sin = 1.0 - y * (1.0 / 42.0) * sin;
    let sin = 1.0 - y * (1.0 / 20.0) * sin;
    let sin = x * (1.0 - y * (1.0 / 6.0) * sin);
    let cos = 1.0 - y * (1.0 / 132.0);
    let cos = 1.0 - y * (1.0 / 90.0) * cos;
    let cos = 1.0 - y * (1.0 / 56.0) * cos;
    let cos = 1.0 - y * (1.0 / 30.0) * cos;
    let cos = 1.0 - y * (1.0 / 12.0) * cos;
    let cos = 1.0 - 0.5 * y * cos;
    let sign = 1.0 - 2.0 * (halves & 1) as f32;
    (sign * sin, sign * cos)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sines_are_those_of_libm() {
        for i in -40_000..=40_000_i32 {
            let turns = i as f32 / 1000.0;
            let (sin, cos) = sine_cosine(turns);
            let (s, c) = libm::sincos(core::f64::consts::TAU * f64::from(turns));
            let off = (f64::from(sin) - s).hypot(f64::from(cos) - c);
            assert!(off < 3e-7, "{turns}: {off}");
        }
    }
}
