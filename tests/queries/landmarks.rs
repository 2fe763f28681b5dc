//! Places worth a look.

use super::planet;
use bevy_tectonics::{
    prelude::*,
    simulation::{BoundaryKind, Orogeny},
    surface::Landmark,
};

#[test]
fn landmarks_are_what_they_are_called() {
    let surface = planet();
    let mut found = 0;
    for landmark in Landmark::ALL {
        let Some((place, across)) = surface.landmark(landmark) else {
            continue;
        };
        found += 1;
        assert!((place.length() - 1.0).abs() < 1e-9, "{landmark:?}");
        assert!((across.length() - 1.0).abs() < 1e-9, "{landmark:?}");
        assert!(across.dot(place).abs() < 1e-9, "{landmark:?}");
        let here = surface.at(place);
        match landmark {
            Landmark::HighestRange => {
                let higher = (0..surface.elevation.len()).find(|&v| {
                    surface.orogeny[v] == Orogeny::Himalayan
                        && surface.orogeny_age[v] < 50.0
                        && surface.elevation[v] > here.elevation + 1e-3
                });
                assert_eq!(higher, None);
                assert_eq!(here.orogeny, Orogeny::Himalayan);
            }
            Landmark::Cordillera => assert_eq!(here.orogeny, Orogeny::Andean),
            Landmark::LongestRidge | Landmark::Rift => {
                let near = surface.nearest_boundary(place).unwrap();
                assert!(near.distance_km < 1e-3);
                assert_eq!(near.segment.kind, BoundaryKind::Ridge);
                let kinds = near.segment.sub_plates.map(|v| surface.crust[v as usize]);
                let is_rift = landmark == Landmark::Rift;
                assert_eq!(kinds[0] == Crust::Continental, is_rift);
            }
            Landmark::PassiveMargin | Landmark::FlatCoast => {
                assert!(surface.coasts().any(|v| v == here.sub_plate));
                // Downhill is where the sea is.
                let step = 0.5 * surface.spacing_km() / surface.radius_km;
                let ahead = (place + across * step).normalize();
                assert!(surface.elevation(ahead) < here.elevation, "{landmark:?}");
            }
            Landmark::OldestRange => {
                assert!(here.elevation > 499.0 && here.orogeny_age >= 100.0);
            }
            Landmark::IslandArc => {
                assert_eq!(here.orogeny, Orogeny::Andean);
                assert!(here.crust == Crust::Oceanic || here.age < 300.0);
            }
            Landmark::VolcanicIsland => {
                let fed = surface.volcanism_age[here.sub_plate as usize];
                assert!(here.elevation > 0.0 && fed.unwrap() < 10.0);
            }
            Landmark::Trench => {
                let deepest = surface.elevation.iter().copied().fold(0.0, f32::min);
                assert!(here.elevation < 0.9 * deepest, "{}", here.elevation);
            }
        }
        let again = surface.landmark(landmark);
        assert_eq!(again, Some((place, across)));
    }
    assert!(found >= 6, "{found} landmarks");
}

#[test]
fn a_planet_without_land_has_no_landmarks_on_land() {
    let mut flat = planet().clone();
    flat.elevation.fill(-3000.0);
    for landmark in [
        Landmark::HighestRange,
        Landmark::OldestRange,
        Landmark::FlatCoast,
        Landmark::VolcanicIsland,
    ] {
        assert_eq!(flat.landmark(landmark), None, "{landmark:?}");
    }
}

#[test]
fn columns_that_are_too_short_are_no_reason_to_panic() {
    let shorten: [fn(&mut Surface); 8] = [
        |surface| surface.elevation.truncate(100),
        |surface| surface.orogeny.truncate(3),
        |surface| surface.orogeny_age.clear(),
        |surface| surface.volcanism_age.clear(),
        |surface| surface.fold.clear(),
        |surface| surface.velocity.truncate(7),
        |surface| surface.crust.truncate(50),
        |surface| surface.age.clear(),
    ];
    for shorten in shorten {
        let mut surface = planet().clone();
        shorten(&mut surface);
        for landmark in Landmark::ALL {
            if let Some((place, across)) = surface.landmark(landmark) {
                assert!(place.is_finite() && across.is_finite());
            }
        }
    }
}
