//! Hot spots start and end.

use super::{
    super::super::{
        clock::Clock,
        events::{EventFailure, LatLon},
        hot_spot::HotSpot,
        recipe::Recipe,
    },
    Verdict,
};
use bevy::prelude::*;

/// A hot spot that is to end may lie this far off, in km.
const REACH_KM: f64 = 1_000.0;

/// Starts a hot spot of a strength, as a multiple of the nominal flux.
pub(super) fn start_hot_spot(
    In((place, strength)): In<(LatLon, f64)>,
    mut commands: Commands,
    recipe: Res<Recipe>,
    clock: Res<Clock>,
    hot_spots: Query<&HotSpot>,
) -> Verdict {
    let id = hot_spots
        .iter()
        .map(|hot_spot| hot_spot.id)
        .max()
        .map_or(Some(0), |last| last.checked_add(1));
    let Some(id) = id else {
        return Ok(Err(EventFailure::NoIdLeft));
    };
    commands.spawn(HotSpot {
        id,
        place: place.direction(),
        flux: recipe.constants.hot_spots.flux * strength,
        since_my: clock.began_my,
    });
    Ok(Ok(()))
}

/// Ends the hot spot nearest to a place.
pub(super) fn stop_hot_spot(
    In(place): In<LatLon>,
    mut commands: Commands,
    recipe: Res<Recipe>,
    hot_spots: Query<(Entity, &HotSpot)>,
) -> Verdict {
    let direction = place.direction();
    let nearest = hot_spots
        .iter()
        .map(|(entity, hot_spot)| (direction.distance(hot_spot.place), hot_spot.id, entity))
        .min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    let found = nearest.filter(|(chord, ..)| {
        2.0 * libm::asin((0.5 * chord).min(1.0)) * recipe.radius_km <= REACH_KM
    });
    let Some((.., entity)) = found else {
        return Ok(Err(EventFailure::NoHotSpot {
            place,
            reach_km: REACH_KM,
        }));
    };
    commands.entity(entity).despawn();
    Ok(Ok(()))
}
