//! Draws planets in a Bevy scene.

mod arrows;
mod boundaries;
mod chain;
mod drape;
mod lines;

use bevy::prelude::*;

/// Draws every planet that has a [`PlanetSurface`](crate::planet::PlanetSurface).
#[derive(Debug, Clone, Default)]
pub struct PlanetRenderPlugin;

impl Plugin for PlanetRenderPlugin {
    fn build(&self, app: &mut App) {
        app.add_plugins(lines::plugin);
    }
}
