//! What can be asked of a surface, against brute force and what can be worked out by hand.

#[path = "queries/boundaries.rs"]
mod boundaries;
#[path = "queries/ground.rs"]
mod ground;
#[path = "queries/landmarks.rs"]
mod landmarks;
#[path = "queries/patches.rs"]
mod patches;
#[path = "queries/rays.rs"]
mod rays;

use bevy_tectonics::prelude::*;
use glam::DVec3;
use std::ops::ControlFlow;
use std::sync::OnceLock;

/// A planet with some history: fronts of all kinds, mountains, trenches.
fn planet() -> &'static Surface {
    static PLANET: OnceLock<Surface> = OnceLock::new();
    PLANET.get_or_init(|| {
        let recipe = Recipe::earth_like(7).with_sub_plates(3000);
        let mut history = History::with_threads(recipe, 1).unwrap();
        history
            .run_until(30.0, |_| ControlFlow::Continue(()))
            .unwrap();
        history.surface().unwrap()
    })
}

/// Directions all over the sphere, in no order.
fn directions(count: u32) -> impl Iterator<Item = DVec3> {
    const GOLDEN_ANGLE: f64 = 2.399_963_229_728_653;
    (0..count).map(move |i| {
        let i = i.wrapping_mul(7919) % count;
        let z = 1.0 - f64::from(2 * i + 1) / f64::from(count);
        let (sin, cos) = libm::sincos(f64::from(i) * GOLDEN_ANGLE);
        let ring = (1.0 - z * z).sqrt();
        DVec3::new(ring * cos, ring * sin, z)
    })
}

/// Directions that are none.
fn nonsense() -> [DVec3; 5] {
    [
        DVec3::ZERO,
        DVec3::NAN,
        DVec3::INFINITY,
        DVec3::new(0.0, f64::NAN, 1.0),
        DVec3::new(f64::NEG_INFINITY, 1.0, 0.0),
    ]
}

#[test]
fn a_surface_goes_to_any_thread() {
    fn check<T: Send + Sync + 'static>() {}
    check::<Surface>();
    planet().prepare();
    std::thread::scope(|scope| {
        for _ in 0..2 {
            scope.spawn(|| assert!(planet().elevation(DVec3::X).is_finite()));
        }
    });
}

#[test]
fn what_queries_keep_is_no_part_of_a_surface() {
    let surface = planet();
    surface.prepare();
    let mut other = surface.clone();
    assert_eq!(*surface, other);
    other.elevation.fill(1234.0);
    assert_ne!(*surface, other);
    assert_eq!(other.elevation(DVec3::X), 1234.0);
    assert!(other.normal(DVec3::X, 1.0).distance(DVec3::X) < 1e-12);
}
