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
    let (mut value, mut slope, mut error) = (0.0, Vec3::ZERO, 0.0);
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
        let wave_vector = (across + along * tilt) * (TAU / length);
        let (sin, cos) = libm::sincosf(offset.dot(wave_vector) + TAU * part(6 * i + 23));
        value += share * amplitude * sin;
        slope += wave_vector * (share * amplitude * cos);
    }
    (value, slope, error)
}
