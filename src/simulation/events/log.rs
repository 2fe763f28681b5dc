//! What became of events.

use super::{LatLon, TectonicEvent};
use bevy::prelude::*;
use serde::{Deserialize, Serialize};
use thiserror::Error;

/// Events that have happened, or could not, in the order in which they did.
#[derive(Resource, Debug, Clone, Default, PartialEq)]
pub struct EventLog(pub Vec<EventRecord>);

/// What became of one event.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct EventRecord {
    /// When its time had come, in My: [`at_my`](TectonicEvent::at_my), or where the first step after it
    /// began.
    pub time_my: f64,
    /// The event as the recipe has it.
    pub event: TectonicEvent,
    /// Why it could not be done, if it could not. The planet is then as it would be without it.
    pub failure: Option<EventFailure>,
}

/// Why an event could not be done.
#[derive(Debug, Clone, Copy, PartialEq, Error, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
#[non_exhaustive]
pub enum EventFailure {
    /// No plate has that id any more, or yet.
    #[error("there is no plate {id}")]
    NoPlate {
        /// The id.
        id: u16,
    },
    /// A line does not divide the plate under its middle into pieces that are large enough.
    #[error(
        "the line leaves only {share:.5} of the sphere on one of its sides of plate {plate}, less than \
         a plate needs ({least:.5})"
    )]
    Undivided {
        /// Id of the plate under the middle of the line.
        plate: u16,
        /// Area of the smaller part as a share of the sphere.
        share: f64,
        /// The least area of a part.
        least: f64,
    },
    /// A plate is too small to break into that many pieces.
    #[error("plate {plate} is too small to break up")]
    TooSmall {
        /// Id of the plate.
        plate: u16,
    },
    /// No sub-plate lies within the disc.
    #[error("no sub-plate lies within {radius_km} km of {centre}")]
    NothingThere {
        /// Middle of the disc.
        centre: LatLon,
        /// Its radius in km.
        radius_km: f64,
    },
    /// No hot spot is near.
    #[error("no hot spot lies within {reach_km} km of {place}")]
    NoHotSpot {
        /// Where one was looked for.
        place: LatLon,
        /// How far, in km.
        reach_km: f64,
    },
    /// All ids of plates, or of hot spots, have been used.
    #[error("no id is left for what is new")]
    NoIdLeft,
}
