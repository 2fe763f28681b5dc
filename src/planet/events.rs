//! What a planet tells the game. All events are triggered on the planet's entity: observe them there
//! with `commands.entity(planet).observe(…)`, or everywhere with `app.add_observer(…)`.

use crate::simulation::{Progress, TectonicError};
use bevy::prelude::*;
use thiserror::Error;

/// A new [`PlanetSurface`](super::PlanetSurface) is there.
#[derive(EntityEvent, Debug, Clone, Copy, PartialEq)]
pub struct SurfaceChanged {
    /// The planet.
    pub entity: Entity,
    /// Time of the surface in My.
    pub time_my: f64,
    /// Whether this is the first surface of a recipe: another planet than the one before, if there
    /// was one.
    pub first: bool,
}

/// A history has come further.
#[derive(EntityEvent, Debug, Clone, Copy, PartialEq)]
pub struct GrowthProgressed {
    /// The planet.
    pub entity: Entity,
    /// Where it stands.
    pub progress: Progress,
}

/// A history has reached its end; the surface of that moment is there. It may go on later, if the end
/// is moved.
#[derive(EntityEvent, Debug, Clone, Copy, PartialEq)]
pub struct GrowthFinished {
    /// The planet.
    pub entity: Entity,
    /// When it stopped, in My.
    pub time_my: f64,
}

/// A history cannot go on. The last surface stays; another recipe starts anew.
#[derive(EntityEvent, Debug, Clone, PartialEq)]
pub struct GrowthFailed {
    /// The planet.
    pub entity: Entity,
    /// Why.
    pub failure: GrowthFailure,
}

/// Why a history cannot go on.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum GrowthFailure {
    /// The recipe was refused, or a step could not be completed.
    #[error(transparent)]
    Tectonic(#[from] TectonicError),
    /// A stage panicked: a defect in it, perhaps in one of your own.
    #[error("a stage of the simulation panicked; the thread's message says where")]
    Panicked,
}
