//! What a planet measures, for the game to read.

use crate::simulation::{Statistics, StatisticsHistory};
use bevy::prelude::*;

/// What a planet measured at the moment of its [`PlanetSurface`](super::PlanetSurface), and before.
/// Comes and changes with it; written by [`PlanetPlugin`](super::PlanetPlugin) alone.
///
/// The history stays empty unless the simulation is told to keep one, see
/// [`StatisticsPlugin`](crate::simulation::StatisticsPlugin).
#[derive(Component, Debug, Clone, Default, PartialEq, Reflect)]
#[reflect(Component, Default)]
pub struct PlanetStatistics {
    /// Figures of the surface.
    pub now: Statistics,
    /// Figures over time, at the moments that the simulation recorded.
    pub history: StatisticsHistory,
}
