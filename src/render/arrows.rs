//! Arrows over the ground that show where it moves, and how fast.

use super::drape::{Drape, Frame, Paint};
use crate::surface::raster::Hints;
use crate::surface::{ARROW_COLOR, ARROW_LONGEST, ARROW_RADII, OUTLINE};
use bevy::math::DVec3;
use core::f64::consts::{FRAC_PI_2, PI};

/// How many places have an arrow.
const COUNT: u32 = 640;
/// Half the width of a shaft in radii.
const SHAFT: f64 = 0.0032;
/// Length of a head, and half its width, in radii.
const HEAD: [f64; 2] = [0.024, 0.0125];
/// Width of the line around an arrow in radii.
const LINE: f64 = 0.0024;
/// Shorter arrows are dots.
const SHORTEST: f64 = 0.008;

/// Lays the arrows.
pub(super) fn lay(drape: &mut Drape) {
    let (fill, outline) = (Paint::new(ARROW_COLOR), Paint::new(OUTLINE));
    let mut hints = Hints::default();
    for place in places() {
        let velocity = drape.raster().look(place, &mut hints).velocity.as_dvec3();
        match course(place, velocity) {
            Some((frame, 0.0)) => drape.figure(&frame, &dot(), false, fill, outline),
            Some((frame, length)) => drape.figure(&frame, &arrow(length), true, fill, outline),
            None => {}
        }
    }
}

/// Where an arrow points and how long it is in radii; 0 for a dot.
fn course(place: DVec3, velocity: DVec3) -> Option<(Frame, f64)> {
    if !velocity.is_finite() {
        return None;
    }
    let along = velocity - place * place.dot(velocity);
    let length = along.length() * f64::from(ARROW_RADII);
    if length < SHORTEST {
        return Some((Frame::new(place, place.any_orthonormal_vector())?, 0.0));
    }
    Some((
        Frame::new(place, along)?,
        length.min(f64::from(ARROW_LONGEST)),
    ))
}

/// Evenly spread directions: a Fibonacci lattice.
fn places() -> impl Iterator<Item = DVec3> {
    const GOLDEN_ANGLE: f64 = 2.399_963_229_728_653;
    (0..COUNT).map(|i| {
        let z = 1.0 - (2.0 * f64::from(i) + 1.0) / f64::from(COUNT);
        let ring = (1.0 - z * z).sqrt();
        let (sin, cos) = libm::sincos(GOLDEN_ANGLE * f64::from(i));
        DVec3::new(ring * cos, ring * sin, z)
    })
}

/// Half the outline of an arrow from its tail at the place. Short ones are smaller in all.
fn arrow(length: f64) -> [([f64; 2], [f64; 2]); 4] {
    let size = (length / (2.0 * HEAD[0])).min(1.0);
    let (shaft, [head, wide]) = (SHAFT * size, HEAD.map(|part| part * size));
    let neck = length - head;
    // The slanted side's line is as wide as that of the shaft.
    let slant = libm::hypot(head, wide);
    let tip = length + LINE * slant / wide;
    let barb = wide * (tip - neck + LINE) / head;
    [
        ([0.0, shaft], [-LINE, shaft + LINE]),
        ([neck, shaft], [neck - LINE, shaft + LINE]),
        ([neck, wide], [neck - LINE, barb]),
        ([length, 0.0], [tip, 0.0]),
    ]
}

/// Half the outline of a dot around the place.
fn dot() -> [([f64; 2], [f64; 2]); 7] {
    core::array::from_fn(|i| {
        let (sin, cos) = libm::sincos(PI * i as f64 / 6.0 - FRAC_PI_2);
        let on_circle = |radius: f64| [radius * sin, radius * cos.max(0.0)];
        (on_circle(1.2 * SHAFT), on_circle(1.2 * SHAFT + LINE))
    })
}

#[cfg(test)]
mod tests {
    use super::super::drape::tests::{assert_sound, flat, positions, surface, triangles};
    use super::*;
    use bevy::math::Vec3;

    #[test]
    fn every_place_has_an_arrow() {
        let mut surface = surface();
        // Eastwards, equally fast everywhere.
        let eastwards = |site: &DVec3| DVec3::Z.cross(*site).normalize_or(DVec3::X) * 50.0;
        let sites = surface.mesh.sites().iter();
        surface.velocity = sites.map(|site| eastwards(site).as_vec3()).collect();
        let mut drape = Drape::new(&surface, flat()).unwrap();
        lay(&mut drape);
        let all = drape.finish().unwrap();
        assert_sound(&all);
        let mut drape = Drape::new(&surface, flat()).unwrap();
        let (frame, length) = course(DVec3::X, DVec3::Y * 50.0).unwrap();
        let paint = Paint::new(ARROW_COLOR);
        drape.figure(&frame, &arrow(length), true, paint, paint);
        let one = drape.finish().unwrap();
        assert_eq!(
            positions(&all).len(),
            COUNT as usize * positions(&one).len()
        );
        assert!(triangles(&all).len() < 80 * COUNT as usize);
    }

    #[test]
    fn arrows_point_along_the_ground() {
        let (frame, length) = course(DVec3::X, DVec3::new(70.0, 0.0, -50.0)).unwrap();
        assert!(frame.ahead.distance(DVec3::NEG_Z) < 1e-9);
        assert!(frame.left.distance(DVec3::Y) < 1e-9);
        assert!((length - 0.06).abs() < 1e-6);
        let tip = frame.place([length, 0.0]);
        assert!((libm::acos(tip.dot(DVec3::X)) - length).abs() < 1e-9);
        let (_, longest) = course(DVec3::X, DVec3::Y * 1e9).unwrap();
        assert!((longest - f64::from(ARROW_LONGEST)).abs() < 1e-9);
        assert!(course(DVec3::X, DVec3::X).is_some_and(|(_, length)| length == 0.0));
        assert!(course(DVec3::X, DVec3::NAN).is_none());
    }

    #[test]
    fn resting_ground_has_dots_and_nonsense_has_nothing() {
        let mut surface = surface();
        surface.velocity.fill(Vec3::ZERO);
        let mut drape = Drape::new(&surface, flat()).unwrap();
        lay(&mut drape);
        let dots = drape.finish().unwrap();
        assert_sound(&dots);
        assert_eq!(positions(&dots).len(), COUNT as usize * 3 * 14);

        surface.velocity.fill(Vec3::NAN);
        let mut drape = Drape::new(&surface, flat()).unwrap();
        lay(&mut drape);
        assert!(drape.finish().is_none());
    }

    #[test]
    fn length_tells_the_speed_up_to_a_limit() {
        let [.., (tip, _)] = arrow(0.06);
        assert_eq!(tip, [0.06, 0.0]);
        for length in [SHORTEST, 0.02, 0.2] {
            for (inside, outside) in arrow(length) {
                assert!(inside[0].is_finite() && outside[1] >= inside[1]);
            }
        }
    }
}
