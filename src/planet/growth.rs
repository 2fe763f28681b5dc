//! Where a planet's history stands, for the game to read.

use super::events::GrowthFailure;
use crate::simulation::Progress;
use bevy::prelude::*;

/// Where the history of a planet stands. Written by [`PlanetPlugin`](super::PlanetPlugin) alone.
#[derive(Component, Debug, Clone, Default, PartialEq)]
pub struct Growth {
    /// What it is doing.
    pub state: GrowthState,
    /// How far it has come. Of the new history while another recipe grows.
    pub progress: Progress,
    /// Whether the history belongs to another recipe than the surface that is shown.
    pub hidden: bool,
    /// Seconds spent in each stage of the step since the start, in the order of the step.
    pub stage_seconds: Vec<(&'static str, f64)>,
}

/// What a history is doing.
#[derive(Debug, Clone, Default, PartialEq)]
pub enum GrowthState {
    /// The first moment is being laid out.
    #[default]
    Starting,
    /// Steps run.
    Growing,
    /// Paused, or waiting for the game's time.
    Resting,
    /// At its end.
    Finished,
    /// It cannot go on.
    Failed(GrowthFailure),
}
