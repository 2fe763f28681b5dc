//! Hot spots: places in the mantle that plates glide over.

use super::{
    recipe::Recipe,
    streams::{self, Purpose},
};
use bevy::prelude::*;
use glam::DVec3;
use serde::{Deserialize, Serialize};

/// A hot spot: an entity of the planet's world, fixed in the mantle. It thickens whatever crust lies
/// above it, so that a plate which glides over it carries a chain of islands away.
///
/// Spawn and despawn hot spots between steps, or by [events](super::Intervention).
#[derive(Component, Debug, Clone, Copy, PartialEq, Serialize, Deserialize, Reflect)]
#[reflect(Component)]
pub struct HotSpot {
    /// Tells hot spots apart; they act in the order of their ids.
    pub id: u16,
    /// Place as a unit vector.
    pub place: DVec3,
    /// Magma that it could deliver onto normal sea floor, in km³/My. What it does deliver becomes less
    /// as its volcanoes grow.
    pub flux: f64,
    /// Since when, in My on the planet's clock.
    pub since_my: f64,
}

impl HotSpot {
    /// The hot spots of a recipe: even over the sphere, each with a strength of its own.
    pub(super) fn scattered(recipe: &Recipe) -> Vec<Self> {
        let constants = &recipe.constants.hot_spots;
        (0..recipe.hot_spots as u16)
            .map(|id| {
                let mut rng = streams::stream(recipe.seed, Purpose::HotSpots, 0, id.into());
                let place = streams::direction(&mut rng);
                let strength = 1.0 + constants.flux_spread * (2.0 * streams::unit(&mut rng) - 1.0);
                Self {
                    id,
                    place,
                    flux: constants.flux * strength,
                    since_my: 0.0,
                }
            })
            .collect()
    }

    /// All hot spots in the order of their ids, so that nothing depends on the order of entities.
    pub(super) fn in_order(hot_spots: &Query<&Self>) -> Vec<Self> {
        let mut all: Vec<Self> = hot_spots.iter().copied().collect();
        all.sort_by_key(|hot_spot| hot_spot.id);
        all
    }
}
