//! Random numbers that depend on what they are for, never on what was drawn before.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// What a random stream decides.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u64)]
pub enum Purpose {
    /// Jitter of the starting points.
    Points = 1,
    /// Seeds of plates.
    Plates,
    /// Order of the flood fill's frontier.
    Frontier,
    /// Cratons.
    Continents,
    /// First rotations.
    Rotations,
    /// Rifts.
    Rift,
    /// New subduction zones.
    Foundering,
    /// First warmth of the mantle.
    Mantle,
    /// Low-frequency noise of the surface.
    Swell,
    /// Places and strengths of hot spots.
    HotSpots = 40,
    /// Outlines of scripted events.
    Events,
}

/// A counter-based stream (`ChaCha8`) keyed by seed, purpose, step and number.
#[must_use]
pub fn stream(seed: u64, purpose: Purpose, step: u64, number: u64) -> ChaCha8Rng {
    let mut key = [0_u8; 32];
    for (bytes, word) in key
        .chunks_exact_mut(8)
        .zip([seed, purpose as u64, step, number])
    {
        bytes.copy_from_slice(&word.to_le_bytes());
    }
    ChaCha8Rng::from_seed(key)
}

/// A number in [0, 1).
pub fn unit(rng: &mut ChaCha8Rng) -> f64 {
    rng.random::<f64>()
}

/// A number in [0, n). Zero for an empty range.
pub fn below(rng: &mut ChaCha8Rng, n: usize) -> usize {
    if n == 0 {
        0
    } else {
        rng.random_range(0..n as u64) as usize
    }
}

/// A direction, even over the sphere.
pub fn direction(rng: &mut ChaCha8Rng) -> glam::DVec3 {
    let z = 2.0 * unit(rng) - 1.0;
    let (sin, cos) = libm::sincos(core::f64::consts::TAU * unit(rng));
    let r = (1.0 - z * z).max(0.0).sqrt();
    glam::DVec3::new(r * cos, r * sin, z)
}

/// Shuffles in place (Fisher–Yates).
pub fn shuffle<T>(rng: &mut ChaCha8Rng, items: &mut [T]) {
    for i in (1..items.len()).rev() {
        items.swap(i, below(rng, i + 1));
    }
}
