//! Rays against the ground.

use super::{directions, nonsense, planet};
use bevy_tectonics::prelude::*;
use bevy_tectonics::surface::Relief;
use glam::DVec3;

/// A planet without relief, but for its elevation.
fn even(elevation: f32) -> Surface {
    let mut surface = planet().clone();
    surface.elevation.fill(elevation);
    surface
}

/// Height above the ground in radii.
fn height(surface: &Surface, point: DVec3, relief: Relief) -> f64 {
    point.length() - surface.point(point, relief).length()
}

/// The first change of sides in steps of a given length, halved down.
fn march(surface: &Surface, origin: DVec3, ray: DVec3, relief: Relief, step: f64) -> Option<f64> {
    let above = |s: f64| height(surface, origin + ray * s, relief) >= 0.0;
    let side = above(0.0);
    let mut from = 0.0;
    while from < 4.5 {
        let to = from + step;
        if above(to) != side {
            let (mut low, mut high) = (from, to);
            for _ in 0..60 {
                let middle = 0.5 * (low + high);
                if above(middle) == side {
                    low = middle;
                } else {
                    high = middle;
                }
            }
            return Some(high);
        }
        from = to;
    }
    None
}

#[test]
fn rays_meet_a_sphere_where_they_should() {
    for elevation in [0.0, 5000.0, -5000.0] {
        let surface = even(elevation);
        let relief = Relief::exaggerated(10.0);
        let radius = 1.0 + 10.0 * f64::from(elevation) / (1000.0 * surface.radius_km);
        for (i, outward) in directions(200).enumerate() {
            let side = outward.any_orthonormal_vector();
            let origin = outward * (1.0 + i as f64 * 0.05).max(1.05);
            let aim = side * (i as f64 * 0.005);
            let ray = (aim - origin).normalize();
            let b = origin.dot(ray);
            let square = b * b - origin.length_squared() + radius * radius;
            let hit = surface.ray(origin, ray * 3.0, relief);
            if square < 0.0 {
                assert_eq!(hit, None);
            } else {
                let hit = hit.unwrap();
                let expected = -b - square.sqrt();
                assert!(
                    (hit.distance - expected).abs() < 1e-7,
                    "{} {expected}",
                    hit.distance
                );
                assert!((hit.point.length() - radius).abs() < 1e-9);
                assert!(hit.normal.distance(hit.point.normalize()) < 1e-9);
                assert!(hit.point.distance(origin + ray * hit.distance) < 1e-12 * origin.length());
            }
            // Away from the planet.
            assert_eq!(surface.ray(origin, outward, relief), None);
            // From inside.
            let inside = surface.ray(outward * 0.4, side, relief).unwrap();
            assert!((inside.distance - (radius * radius - 0.16).sqrt()).abs() < 1e-7);
        }
    }
}

#[test]
fn a_tangent_touches_and_what_passes_above_misses() {
    let surface = even(0.0);
    for outward in directions(50) {
        let along = outward.any_orthonormal_vector();
        let at = |radius: f64| surface.ray(outward * radius - along * 2.0, along, 1.0);
        assert!(at(1.0 + 1e-12).is_none());
        let hit = at(1.0 - 1e-12).unwrap();
        assert!((hit.distance - 2.0).abs() < 1e-5);
    }
}

#[test]
fn rays_agree_with_dense_marching() {
    let surface = planet();
    let (mut hits, mut misses) = (0, 0);
    for (relief, step) in [
        (Relief::exaggerated(40.0), 4e-4),
        (Relief::exaggerated(40.0).with_sea(), 4e-4),
        (Relief::TRUE_SCALE, 4e-4),
    ] {
        for (i, outward) in directions(60).enumerate() {
            // Grazing ones: they pass the centre between the lowest and the highest ground.
            let lever = 0.93 + 0.002 * i as f64;
            let ray = outward.any_orthonormal_vector();
            let origin = outward * lever - ray * 1.5;
            let marched = march(surface, origin, ray, relief, step);
            let hit = surface.ray(origin, ray, relief);
            match (hit, marched) {
                (Some(hit), Some(marched)) => {
                    hits += 1;
                    // Marching may step across a summit, never meet ground too early.
                    assert!(hit.distance < marched + 1e-6, "{} {marched}", hit.distance);
                    if hit.distance < marched - 1e-6 {
                        assert!(height(surface, hit.point, relief).abs() < 1e-8);
                    }
                    let ground = height(surface, hit.point, relief);
                    assert!(ground.abs() < 1e-7, "{ground}");
                    assert_eq!(hit.place, surface.at(hit.point));
                }
                (None, None) => misses += 1,
                (Some(hit), None) => assert!(height(surface, hit.point, relief).abs() < 1e-8),
                (None, Some(marched)) => panic!("a hit at {marched} was missed"),
            }
        }
    }
    assert!(hits > 40 && misses > 20, "{hits} hits, {misses} misses");
}

#[test]
fn the_way_down_and_the_way_up_meet_the_ground_between() {
    let surface = planet();
    for relief in [
        Relief::TRUE_SCALE,
        Relief::exaggerated(50.0),
        Relief::exaggerated(50.0).with_sea(),
    ] {
        let sites = surface.mesh.sites().iter().copied().take(200);
        for outward in directions(200).chain(sites).chain([DVec3::Z, DVec3::NEG_Z]) {
            let point = surface.point(outward, relief);
            let down = surface.ray(outward * 2.0, -outward, relief).unwrap();
            assert!(down.point.distance(point) < 1e-7);
            let up = surface.ray(DVec3::ZERO, outward, relief).unwrap();
            assert!(up.point.distance(point) < 1e-7);
            assert!((up.distance + down.distance - 2.0).abs() < 1e-7);
        }
    }
}

#[test]
fn rays_along_edges_of_the_mesh_are_followed() {
    let surface = planet();
    let mesh = &surface.mesh;
    let relief = Relief::exaggerated(30.0);
    for h in mesh.triangles().take(300) {
        let (a, b) = (mesh.site(mesh.origin(h)), mesh.site(mesh.dest(h)));
        // In the plane of the edge, through both of its vertices.
        let origin = a * 1.2;
        let hit = surface.ray(origin, b - origin, relief).unwrap();
        assert!(height(surface, hit.point, relief).abs() < 1e-8);
        assert!(hit.distance <= origin.distance(b) + 0.2);
    }
}

#[test]
fn nonsense_meets_nothing() {
    let surface = planet();
    for vector in nonsense() {
        assert_eq!(surface.ray(DVec3::X * 2.0, vector, 1.0), None);
        if !vector.is_finite() {
            assert_eq!(surface.ray(vector, DVec3::X, 1.0), None);
        }
    }
    // Deepest sea floors would lie beyond the centre.
    assert_eq!(surface.ray(DVec3::X * 2.0, DVec3::NEG_X, 1e6), None);
    assert!(
        surface
            .ray(DVec3::X * 2.0, DVec3::NEG_X, f64::NAN)
            .is_some()
    );
    assert!(surface.ray(DVec3::X * 2.0, DVec3::NEG_X, -3.0).is_some());
    for far in [1e3, 1e8, 1e200, f64::MAX] {
        if let Some(hit) = surface.ray(DVec3::X * far, DVec3::NEG_X, 1.0) {
            assert!(hit.distance.is_finite() && hit.point.is_finite());
        }
        let from = DVec3::new(far, -far, far);
        let _ = surface.ray(from, -from, 1.0);
    }
}

#[test]
fn ground_that_is_no_number_is_not_met() {
    let mut surface = even(0.0);
    surface.elevation[7] = f32::NAN;
    let site = surface.mesh.site(7);
    for relief in [Relief::TRUE_SCALE, Relief::TRUE_SCALE.with_sea()] {
        let _ = surface.ray(site * 2.0, -site, relief);
    }
    assert!(surface.ray(site * -2.0, site, 1.0).is_some());
}
