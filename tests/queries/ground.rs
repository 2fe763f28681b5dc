//! Elevations, normals, places.

use super::{directions, nonsense, planet};
use bevy_tectonics::mesh::SphereMesh;
use bevy_tectonics::surface::{Relief, direction, direction_of, east_north, lat_lon};
use glam::{DMat3, DVec3};

/// Linear interpolation in whichever triangle has the direction.
fn brute_elevation(direction: DVec3) -> f64 {
    let surface = planet();
    let mesh: &SphereMesh = &surface.mesh;
    let weights = |h: u32| {
        let [a, b, c] = mesh.triangle_vertices(h).map(|v| mesh.site(v));
        DMat3::from_cols(a, b, c).inverse() * direction
    };
    let h = mesh
        .triangles()
        .max_by(|&g, &h| {
            let [g, h] = [g, h].map(|h| weights(h).min_element());
            g.total_cmp(&h)
        })
        .unwrap();
    let weights = weights(h);
    let heights = mesh
        .triangle_vertices(h)
        .map(|v| f64::from(surface.elevation[v as usize]));
    weights.dot(DVec3::from(heights)) / weights.element_sum()
}

fn brute_nearest(direction: DVec3) -> u32 {
    let sites = planet().mesh.sites();
    (0..sites.len() as u32)
        .min_by(|&u, &v| {
            let [u, v] = [u, v].map(|v| sites[v as usize].distance_squared(direction));
            u.total_cmp(&v)
        })
        .unwrap()
}

#[test]
fn elevations_and_sub_plates_agree_with_brute_force() {
    let surface = planet();
    let mut hint = 0;
    for direction in directions(200) {
        let brute = brute_elevation(direction);
        assert!((f64::from(surface.elevation(direction)) - brute).abs() < 0.01);
        assert_eq!(
            surface.elevation_from(direction, &mut hint),
            surface.elevation(direction)
        );
        let nearest = brute_nearest(direction);
        assert_eq!(surface.nearest(direction), nearest);
        let place = surface.at(3.0 * direction);
        assert_eq!(place.sub_plate, nearest);
        assert_eq!(place.plate, surface.plate[nearest as usize]);
        assert_eq!(place.crust, surface.crust[nearest as usize]);
        assert_eq!(place.age, surface.age[nearest as usize]);
        assert_eq!(place.thickness, surface.thickness[nearest as usize]);
        assert_eq!(place.orogeny, surface.orogeny[nearest as usize]);
        assert!((f64::from(place.elevation) - brute).abs() < 0.01);
        assert!(place.velocity.dot(direction.as_vec3()).abs() < 1e-3);
        assert!(place.normal.is_normalized() && place.direction.is_normalized());
    }
}

#[test]
fn every_sub_plate_has_its_own_elevation() {
    let surface = planet();
    for v in 0..surface.mesh.vertex_count() as u32 {
        let site = surface.mesh.site(v);
        assert_eq!(surface.nearest(site), v);
        assert!((surface.elevation(site) - surface.elevation[v as usize]).abs() < 0.01);
        let start = surface.mesh.site(surface.start(site));
        assert!(start.distance(site) * surface.radius_km < 4.0 * surface.spacing_km());
    }
}

#[test]
fn nothing_special_happens_at_poles_and_meridians() {
    let surface = planet();
    for latitude in [-90.0, -89.999, -45.0, 0.0, 45.0, 89.999, 90.0] {
        let [west, east] = [-180.0, 180.0].map(|lon| surface.at_lat_lon(latitude, lon));
        assert!((west.elevation - east.elevation).abs() < 0.01);
        assert_eq!(west.sub_plate, east.sub_plate);
        let near = surface.elevation(direction_of(latitude, 180.0 - 1e-7));
        assert!((near - east.elevation).abs() < 0.1);
    }
    for (pole, sign) in [(DVec3::Z, 1.0), (DVec3::NEG_Z, -1.0)] {
        assert!(
            (surface.elevation(pole) - surface.at_lat_lon(90.0 * sign, 77.0).elevation).abs()
                < 0.01
        );
        assert_eq!(lat_lon(pole), (90.0 * sign, 0.0));
        let (east, north) = east_north(pole);
        assert!(east.distance(DVec3::Y) < 1e-12);
        assert!(north.distance(DVec3::X * -sign) < 1e-12);
    }
}

#[test]
fn degrees_there_and_back() {
    assert!(direction_of(0.0, 0.0).distance(DVec3::X) < 1e-15);
    assert!(direction_of(0.0, 90.0).distance(DVec3::Y) < 1e-15);
    assert!(direction_of(90.0, 12.0).distance(DVec3::Z) < 1e-15);
    assert_eq!(
        direction_of(30.0, 60.0),
        direction(60_f64.to_radians(), 30_f64.to_radians())
    );
    for there in directions(500) {
        let (latitude, longitude) = lat_lon(17.0 * there);
        assert!(direction_of(latitude, longitude).distance(there) < 1e-14);
        let (east, north) = east_north(there);
        assert!(DMat3::from_cols(east, north, there).determinant() > 1.0 - 1e-12);
        assert!(north.z >= 0.0 && east.z.abs() < 1e-15);
    }
}

#[test]
fn normals_follow_the_slope_and_are_continuous() {
    let surface = planet();
    let step = 1e-7;
    let mut steepest = 0.0_f64;
    for direction in directions(2000) {
        let (east, north) = east_north(direction);
        for relief in [Relief::TRUE_SCALE, Relief::exaggerated(30.0)] {
            let normal = surface.normal(direction, relief);
            assert!(normal.is_normalized());
            for aside in [east, north] {
                let near = surface.normal(direction + aside * step, relief);
                assert!(near.distance(normal) < 1e-4);
            }
            steepest = steepest.max(normal.angle_between(direction));
        }
        // Exaggeration multiplies the slope, but for the height of the ground itself.
        let tangent = |factor: f64| {
            let normal = surface.normal(direction, factor);
            (normal / normal.dot(direction) - direction).length()
        };
        let (one, ten) = (tangent(1.0), tangent(10.0));
        assert!((ten - 10.0 * one).abs() < 0.03 * ten + 1e-12);
    }
    assert!(steepest > 0.05);
}

#[test]
fn the_normal_of_an_even_slope_is_exact() {
    // Elevation 2 km × the height over the equator: uphill is north everywhere.
    let mut surface = planet().clone();
    for v in 0..surface.mesh.vertex_count() {
        surface.elevation[v] = 2000.0 * surface.mesh.sites()[v].z as f32;
    }
    for direction in directions(500) {
        let (_, north) = east_north(direction);
        let (radius_m, slope) = (1000.0 * surface.radius_km, 2000.0 * north.z);
        let expected = (direction * (radius_m + 2000.0 * direction.z) - north * slope).normalize();
        assert!(surface.normal(direction, 1.0).distance(expected) < 0.03 * 2000.0 / radius_m);
    }
}

#[test]
fn points_lie_on_the_ground_or_the_sea() {
    let surface = planet();
    for direction in directions(300) {
        let elevation = f64::from(surface.elevation(direction));
        let radius = |relief: Relief| surface.point(direction, relief).length();
        let expected = 1.0 + 50.0 * elevation / (1000.0 * surface.radius_km);
        assert!((radius(Relief::exaggerated(50.0)) - expected).abs() < 1e-7);
        assert!((radius(Relief::exaggerated(50.0).with_sea()) - expected.max(1.0)).abs() < 1e-7);
        if elevation < 0.0 {
            let sea = surface.normal(direction, Relief::TRUE_SCALE.with_sea());
            assert_eq!(sea, direction);
        }
    }
}

#[test]
fn nonsense_stands_for_the_north_pole() {
    let surface = planet();
    for direction in nonsense() {
        assert_eq!(surface.at(direction), surface.at(DVec3::Z));
        assert_eq!(surface.elevation(direction), surface.elevation(DVec3::Z));
        assert_eq!(
            surface.elevation_from(direction, &mut { u32::MAX }),
            surface.elevation(DVec3::Z)
        );
        assert_eq!(surface.nearest(direction), surface.nearest(DVec3::Z));
        assert_eq!(
            surface.point(direction, f64::NAN),
            surface.point(DVec3::Z, 1.0)
        );
        assert!(surface.normal(direction, f64::INFINITY).is_normalized());
        assert_eq!(lat_lon(direction), (90.0, 0.0));
    }
    for length in [1e-300, 1e300] {
        let direction = DVec3::new(0.6, 0.0, -0.8);
        assert_eq!(
            surface.nearest(direction * length),
            surface.nearest(direction)
        );
    }
    assert_eq!(direction_of(f64::NAN, 0.0), DVec3::Z);
    assert_eq!(direction_of(0.0, f64::INFINITY), DVec3::Z);
}
