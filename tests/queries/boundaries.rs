//! Boundaries, plates and coasts.

use super::{directions, nonsense, planet};
use bevy_tectonics::prelude::*;
use bevy_tectonics::simulation::BoundaryKind;
use bevy_tectonics::surface::BoundarySegment;
use glam::DVec3;
use std::collections::BTreeMap;

#[test]
fn segments_are_closed() {
    let mut ends: BTreeMap<[u64; 3], usize> = BTreeMap::new();
    for segment in planet().boundaries() {
        for end in segment.ends {
            let bits = end.to_array().map(f64::to_bits);
            *ends.entry(bits).or_default() += 1;
        }
    }
    assert!(ends.len() > 100);
    assert!(ends.values().all(|count| (2..=3).contains(count)));
    // Three plates meet somewhere.
    assert!(ends.values().any(|&count| count == 3));
}

#[test]
fn segments_part_the_places_of_plates() {
    let surface = planet();
    for segment in surface.boundaries() {
        assert!(segment.plates[0] < segment.plates[1]);
        assert_eq!(
            segment.plates,
            segment.sub_plates.map(|v| surface.plate[v as usize])
        );
        let [a, b] = segment.ends;
        assert!(a.is_normalized() && b.is_normalized());
        if segment.length_km < 1.0 {
            continue;
        }
        let middle = segment.point(0.5);
        let left = middle.cross(b - a).normalize();
        let aside = |side: f64| surface.at(middle + left * side * 1e-6).plate;
        assert_eq!([aside(1.0), aside(-1.0)], segment.plates);
    }
}

#[test]
fn kinds_are_those_of_the_simulation() {
    let surface = planet();
    let mut lengths: BTreeMap<u8, f64> = BTreeMap::new();
    for segment in surface.boundaries() {
        *lengths.entry(segment.kind as u8).or_default() += segment.length_km;
        assert_ne!(segment.kind, BoundaryKind::Joined);
        let [u, v] = segment.sub_plates;
        let h = surface.mesh.half_edge_between(u, v).unwrap();
        let kind = surface.boundary[(h / 2) as usize];
        let kind = if h.is_multiple_of(2) {
            kind
        } else {
            kind.reversed()
        };
        assert_eq!(segment.kind, kind);
        assert_eq!(segment.subducting().is_some(), kind.is_subducting());
        let rotation = |id: u16| surface.plate(id).unwrap().rotation;
        let [left, right] = segment.plates.map(rotation);
        let slip = (right - left).cross(segment.point(0.5)) * surface.radius_km;
        assert!((slip - segment.slip.as_dvec3()).length() < 1e-3);
        assert!(segment.opening.abs() <= segment.speed() * 1.0001);
    }
    // Ridges part and trenches close, on the whole.
    let mean = |kinds: fn(BoundaryKind) -> bool| {
        let segments = || surface.boundaries().iter().filter(|s| kinds(s.kind));
        let weight = |s: &BoundarySegment| f64::from(s.opening) * s.length_km;
        segments().map(weight).sum::<f64>() / segments().map(|s| s.length_km).sum::<f64>()
    };
    assert!(mean(|kind| kind == BoundaryKind::Ridge) > 5.0);
    assert!(mean(BoundaryKind::is_subducting) < -5.0);
    assert!(lengths.len() >= 4, "{lengths:?}");
    for (edge, &kind) in surface.boundary.iter().enumerate() {
        let edge = edge as u32;
        let joined = !surface.mesh.is_edge(edge) || {
            let (u, v) = surface.mesh.endpoints(edge);
            surface.plate[u as usize] == surface.plate[v as usize]
        };
        assert_eq!(joined, kind == BoundaryKind::Joined);
    }
}

#[test]
fn a_planet_without_history_knows_its_boundaries() {
    let recipe = Recipe::earth_like(5).with_sub_plates(1000);
    let surface = History::new(recipe).unwrap().surface().unwrap();
    assert!(surface.boundaries().len() > 50);
    assert!(surface.boundary.len() >= surface.mesh.edge_count());
}

/// Distance to an arc by trying many of its points.
fn brute_distance(direction: DVec3) -> f64 {
    let surface = planet();
    let chord = surface
        .boundaries()
        .iter()
        .flat_map(|segment| (0..=64).map(|i| segment.point(f64::from(i) / 64.0)))
        .map(|point| point.distance(direction))
        .fold(f64::INFINITY, f64::min);
    2.0 * libm::asin(0.5 * chord) * surface.radius_km
}

#[test]
fn the_nearest_boundary_is_the_nearest() {
    let surface = planet();
    for direction in directions(300) {
        let near = surface.nearest_boundary(5.0 * direction).unwrap();
        let brute = brute_distance(direction);
        // The tried points are up to 1/128 of a segment away from the nearest.
        assert!(near.distance_km <= brute + 1e-6 && near.distance_km > brute - 3.0);
        assert_eq!(near.segment, surface.boundaries()[near.number]);
        let angle = libm::acos(near.point.dot(direction).min(1.0));
        assert!((angle * surface.radius_km - near.distance_km).abs() < 0.1);
    }
    for segment in surface.boundaries() {
        let near = surface.nearest_boundary(segment.point(0.3)).unwrap();
        assert!(near.distance_km < 1e-6);
    }
    for direction in nonsense() {
        assert_eq!(
            surface.nearest_boundary(direction),
            surface.nearest_boundary(DVec3::Z)
        );
    }
}

#[test]
fn one_plate_has_no_boundary() {
    let mut surface = planet().clone();
    surface.plate.fill(1);
    assert_eq!(surface.nearest_boundary(DVec3::X), None);
    assert_eq!(surface.boundaries(), []);
    assert_eq!(surface.plates().len(), 1);
}

#[test]
fn plates_cover_the_planet_in_order() {
    let surface = planet();
    let plates = surface.plates();
    assert!(plates.len() > 3 && plates.windows(2).all(|pair| pair[0].id < pair[1].id));
    let sphere = 4.0 * std::f64::consts::PI * surface.radius_km * surface.radius_km;
    let area: f64 = plates.iter().map(|plate| plate.area_km2).sum();
    assert!((area / sphere - 1.0).abs() < 1e-6);
    let count: usize = plates.iter().map(|plate| plate.sub_plates as usize).sum();
    assert_eq!(count, surface.mesh.vertex_count());
    for plate in plates {
        assert_eq!(surface.plate(plate.id), Some(plate));
        assert!((0.0..=1.0 + 1e-12).contains(&plate.continental_share));
        assert!(plate.centre.is_normalized());
        let fastest = plate.rotation.length() * surface.radius_km;
        assert!(plate.speed <= 1.5 * fastest + 5.0, "{plate:?}");
        assert!(plate.velocity(plate.centre, surface.radius_km).length() <= fastest * 1.0001);
    }
    assert!(plates.iter().any(|plate| plate.speed > 1.0));
    assert_eq!(surface.plate(u16::MAX), None);
}

#[test]
fn coasts_are_land_by_the_sea() {
    let surface = planet();
    let is_land = |v: u32| surface.elevation[v as usize] > 0.0;
    let coasts: Vec<u32> = surface.coasts().collect();
    assert!(coasts.len() > 20 && coasts.windows(2).all(|pair| pair[0] < pair[1]));
    for v in coasts {
        assert!(is_land(v) && surface.mesh.neighbours(v).any(|w| !is_land(w)));
    }
}
