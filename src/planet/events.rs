//! What a planet tells the game. All events are triggered on the planet's entity: observe them there
//! with `commands.entity(planet).observe(…)`, or everywhere with `app.add_observer(…)`.

use crate::simulation::{EventRecord, Intervention, Progress, TectonicError};
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

/// Lets something happen to a planet: *you* trigger it on the planet's entity,
/// `commands.trigger(Intervene { entity, what })`.
///
/// It happens at the start of the history's next step, and the planet's
/// [`recipe`](super::Planet::recipe) gets it with the time at which it did: growing that recipe again grows
/// the same planet, bit for bit. What became of it, [`EventHappened`] tells. Asked of a planet that rests,
/// it waits until the history goes on; asked of one whose recipe is replaced in the same frame, it happens
/// to the new one.
#[derive(EntityEvent, Debug, Clone, PartialEq)]
pub struct Intervene {
    /// The planet.
    pub entity: Entity,
    /// What shall happen.
    pub what: Intervention,
}

/// An event has had its time: one of the recipe, or one that [`Intervene`] asked for.
#[derive(EntityEvent, Debug, Clone, PartialEq)]
pub struct EventHappened {
    /// The planet.
    pub entity: Entity,
    /// What became of it. Its [`failure`](EventRecord::failure) says why nothing happened, if nothing did.
    pub record: EventRecord,
}

/// What [`Intervene`] asked for is not possible at any time. Nothing was changed.
#[derive(EntityEvent, Debug, Clone, PartialEq)]
pub struct InterventionRefused {
    /// The planet.
    pub entity: Entity,
    /// What was asked for.
    pub what: Intervention,
    /// Which value is wrong, and what is allowed.
    pub error: TectonicError,
}
