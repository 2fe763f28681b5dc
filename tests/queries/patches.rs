//! Patches of ground.

use super::{directions, nonsense, planet};
use bevy_tectonics::surface::Relief;
use glam::DVec3;

#[test]
fn patches_agree_with_elevations() {
    let surface = planet();
    for centre in directions(20).chain([DVec3::Z, DVec3::NEG_Z, DVec3::NEG_X]) {
        let patch = surface.patch(centre, 400.0, 17);
        assert_eq!(patch.heights.len(), 17 * 17);
        for (direction, &height) in patch.directions().zip(&patch.heights) {
            assert!((surface.elevation(direction) - height).abs() < 0.01);
        }
        assert!(patch.direction(8, 8).distance(centre) < 1e-12);
        // Rows go south, columns east.
        let half = 200.0 / surface.radius_km;
        let corner = (centre - patch.east * half + patch.north * half).normalize();
        assert!(patch.direction(0, 0).distance(corner) < 1e-12);
        assert_eq!(patch.height(3, 4), Some(patch.heights[3 * 17 + 4]));
        assert_eq!(patch.height(17, 0), None);
        assert_eq!(patch.height(0, 17), None);
    }
}

#[test]
fn vertices_lie_where_their_samples_are() {
    let surface = planet();
    let patch = surface.patch(DVec3::new(0.3, -0.5, 0.4), 900.0, 33);
    let rotation = patch.rotation();
    assert!((rotation * DVec3::Y).distance(patch.centre) < 1e-12);
    assert!((rotation * DVec3::X).distance(patch.east) < 1e-12);
    assert!((rotation * DVec3::Z).distance(-patch.north) < 1e-12);
    for relief in [Relief::TRUE_SCALE, Relief::exaggerated(20.0).with_sea()] {
        let curved = patch.curved_positions(relief);
        assert_eq!(curved.len(), patch.heights.len());
        for (direction, position) in patch.directions().zip(curved) {
            let point = rotation * position.as_dvec3() + patch.centre * patch.radius_m;
            let expected = surface.point(direction, relief) * patch.radius_m;
            assert!(
                point.distance(expected) < 0.5,
                "{}",
                point.distance(expected)
            );
        }
    }
    let flat = patch.positions();
    for (position, &height) in flat.iter().zip(&patch.heights) {
        assert_eq!(position.y, height);
    }
    assert_eq!(flat[0].x, -450_000.0);
    assert_eq!(flat[0].z, -450_000.0);
    assert_eq!(flat[32].x, 450_000.0);
}

#[test]
fn triangles_cover_a_patch_and_face_up() {
    let patch = planet().patch(DVec3::Y, 100.0, 9);
    let (vertices, triangles) = (patch.positions(), patch.triangles());
    assert_eq!(triangles.len(), 2 * 8 * 8);
    let mut area = 0.0;
    for triangle in triangles {
        let [a, b, c] =
            triangle.map(|v| vertices[v as usize].as_dvec3() * DVec3::new(1.0, 0.0, 1.0));
        let up = (b - a).cross(c - a).y;
        assert!(up > 0.0);
        area += 0.5 * up;
    }
    assert!((area / 1e10 - 1.0).abs() < 1e-6);
}

#[test]
fn nonsense_gives_a_patch_too() {
    let surface = planet();
    for centre in nonsense() {
        for size in [f64::NAN, -1.0, 0.0, 1e-9, f64::INFINITY] {
            let patch = surface.patch(centre, size, 0);
            assert_eq!((patch.centre, patch.samples), (DVec3::Z, 2));
            assert!(patch.heights.iter().all(|height| height.is_finite()));
            assert!(
                patch
                    .positions()
                    .iter()
                    .all(|position| position.is_finite())
            );
            let curved = patch.curved_positions(f64::NAN);
            assert!(curved.iter().all(|position| position.is_finite()));
        }
    }
}
