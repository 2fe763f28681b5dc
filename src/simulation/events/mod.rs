//! Scripted events: what happens to a planet because somebody wants it to.
//!
//! A recipe has a list of them, [`Recipe::events`](super::Recipe::events); a game or a program adds to it
//! while the planet grows, with [`History::apply`](super::History::apply). A step ends exactly when an
//! event is due, so the result does not depend on how long steps are otherwise. What cannot be done any
//! more when its time has come is noted in the [`EventLog`] and changes nothing.
//!
//! As JSON, with times in My, places as `[latitude, longitude]` in degrees and turns in degrees per My
//! (see [`Intervention`] for every kind):
//!
//! ```json
//! [
//!   { "at_my": 36, "what": { "set-motion": { "plate": { "at": [10, 40] }, "pole": [90, 0],
//!                            "deg_per_my": -0.6, "hold_my": 40 } } },
//!   { "at_my": 200, "what": { "rift": { "line": [[30, -20], [0, -10], [-30, -20]] } } }
//! ]
//! ```

mod log;
mod place;

pub use log::{EventFailure, EventLog, EventRecord};
pub use place::LatLon;

use super::{error::TectonicError, recipe, sub_plate::PlateId};
use bevy::prelude::*;
use core::ops::RangeInclusive;
use glam::DVec3;
use serde::{Deserialize, Serialize};

/// Something that happens at a time.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, Reflect)]
#[serde(deny_unknown_fields)]
pub struct TectonicEvent {
    /// When, in My on the planet's clock, 0 to 10,000. A step ends there.
    pub at_my: f64,
    /// What happens.
    pub what: Intervention,
    /// No step is cut short for it: it happens at the start of the first step that begins at or after its
    /// time. Set on events that were given while the planet grew, so that growing it again takes the same
    /// steps.
    #[serde(default, skip_serializing_if = "core::ops::Not::not")]
    pub between_steps: bool,
}

/// How a planet can be changed.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, Reflect)]
#[serde(rename_all = "kebab-case")]
pub enum Intervention {
    /// Turns a plate otherwise (Cortial et al. 2019, section 7.3: prescribed geodetic movements).
    SetMotion {
        /// Which plate.
        plate: PlateChoice,
        /// Euler pole about which it turns counter-clockwise.
        pole: LatLon,
        /// How fast, −20 to 20 degrees per My; 1 degree is 111 km on Earth.
        deg_per_my: f64,
        /// How long it is held to that motion, 0 to 10,000 My. Then, with 0 at once, the recipe's drive
        /// takes over.
        #[serde(default)]
        hold_my: f64,
    },
    /// Breaks the plate under the middle of a line along it (Cortial et al. 2019, section 5: rifting
    /// triggered by the user). The line goes on straight to the edges of the plate; what lies to its
    /// right becomes a plate of its own, and the two are pushed apart.
    Rift {
        /// 2 to 1,000 places along the line.
        line: Vec<LatLon>,
    },
    /// Makes the crust of a disc of one kind.
    SetCrust {
        /// Middle of the disc.
        centre: LatLon,
        /// Radius of the disc along the surface, 1 to 200,000 km. It may be the whole planet.
        radius_km: f64,
        /// What it becomes.
        crust: NewCrust,
    },
    /// Starts a hot spot.
    StartHotSpot {
        /// Where.
        place: LatLon,
        /// How strong as a multiple of [`flux`](super::constants::HotSpotConstants::flux), more than 0 to
        /// 10.
        #[serde(default = "nominal")]
        strength: f64,
    },
    /// Ends the hot spot that is nearest to a place, if one lies within 1,000 km.
    StopHotSpot {
        /// Where.
        place: LatLon,
    },
    /// Lets a supercontinent break up: its plate forgets all collisions, which would hold it fast, and
    /// breaks into pieces that are pushed apart.
    BreakUp {
        /// Which plate.
        plate: PlateChoice,
        /// Into how many pieces, 2 to 4.
        #[serde(default = "three")]
        pieces: u8,
    },
}

fn nominal() -> f64 {
    1.0
}

fn three() -> u8 {
    3
}

/// Names a plate.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, Reflect)]
#[serde(rename_all = "kebab-case")]
pub enum PlateChoice {
    /// The plate that lies there when the event happens.
    At(LatLon),
    /// The plate of this id.
    Id(u16),
}

/// What crust becomes.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, Reflect)]
#[serde(rename_all = "kebab-case")]
pub enum NewCrust {
    /// Sea floor of normal thickness.
    Oceanic {
        /// Its age, 0 to 1,000 My; from it follows its depth.
        age_my: f64,
    },
    /// Continent.
    Continental {
        /// Its thickness, 10 to 70 km; 37 km is a lowland.
        thickness_km: f64,
    },
}

impl TectonicEvent {
    /// Allowed times in My.
    pub const AT_MY: RangeInclusive<f64> = 0.0..=10_000.0;

    /// Something that happens at a time in My, to which a step is cut.
    #[must_use]
    pub fn new(at_my: f64, what: Intervention) -> Self {
        Self {
            at_my,
            what,
            between_steps: false,
        }
    }

    /// Says which value lies outside its range, if one does. `path` says where the event stands.
    pub(super) fn validate(&self, path: &str) -> Result<(), TectonicError> {
        within(path, "at_my", self.at_my, Self::AT_MY, " My")?;
        self.what.validate(path)
    }

    /// Times in My at which a step ends because of this event.
    pub(super) fn stops(&self) -> impl Iterator<Item = f64> {
        let exact = (!self.between_steps).then_some(self.at_my);
        let release = match self.what {
            Intervention::SetMotion { hold_my, .. } if hold_my > 0.0 => Some(self.at_my + hold_my),
            _ => None,
        };
        exact.into_iter().chain(release)
    }
}

impl Intervention {
    /// Allowed turns in degrees per My.
    pub const DEG_PER_MY: RangeInclusive<f64> = -20.0..=20.0;
    /// Allowed lengths of time for which a motion is held, in My.
    pub const HOLD_MY: RangeInclusive<f64> = 0.0..=10_000.0;
    /// Allowed numbers of places along a rift.
    pub const LINE: RangeInclusive<usize> = 2..=1_000;
    /// Allowed radii of discs in km.
    pub const RADIUS_KM: RangeInclusive<f64> = 1.0..=200_000.0;
    /// Allowed ages of new sea floor in My.
    pub const AGE_MY: RangeInclusive<f64> = 0.0..=1_000.0;
    /// Allowed thicknesses of new continents in km.
    pub const THICKNESS_KM: RangeInclusive<f64> = 10.0..=70.0;
    /// Allowed strengths of hot spots.
    pub const STRENGTH: RangeInclusive<f64> = 0.01..=10.0;
    /// Allowed numbers of pieces of a supercontinent.
    pub const PIECES: RangeInclusive<u8> = 2..=4;

    /// Says which value lies outside its range, if one does.
    ///
    /// # Errors
    /// [`TectonicError::Recipe`] with the first offending value and what is allowed; its path starts with
    /// `path`.
    pub fn validate(&self, path: &str) -> Result<(), TectonicError> {
        let name = self.name();
        let path = &format!("{path}.{name}");
        match self {
            Self::SetMotion {
                plate,
                pole,
                deg_per_my,
                hold_my,
            } => {
                plate.validate(path)?;
                pole.validate(&format!("{path}.pole"))?;
                within(
                    path,
                    "deg_per_my",
                    *deg_per_my,
                    Self::DEG_PER_MY,
                    " degrees per My",
                )?;
                within(path, "hold_my", *hold_my, Self::HOLD_MY, " My")
            }
            Self::Rift { line } => {
                let places = line.len();
                if !Self::LINE.contains(&places) {
                    return Err(TectonicError::Recipe {
                        field: format!("{path}.line"),
                        value: format!("{places} places long"),
                        allowed: format!(
                            "from {} to {} places long",
                            Self::LINE.start(),
                            Self::LINE.end()
                        ),
                    });
                }
                for (i, place) in line.iter().enumerate() {
                    place.validate(&format!("{path}.line[{i}]"))?;
                }
                for (i, pair) in line.windows(2).enumerate() {
                    let (a, b) = (pair[0].direction(), pair[1].direction());
                    // Neither one place twice nor two opposite ones: no one great circle joins them.
                    if a.cross(b).length() < 1e-6 {
                        return Err(TectonicError::Recipe {
                            field: format!("{path}.line[{}]", i + 1),
                            value: pair[1].to_string(),
                            allowed: "neither the place before it nor the one opposite to that"
                                .into(),
                        });
                    }
                }
                Ok(())
            }
            Self::SetCrust {
                centre,
                radius_km,
                crust,
            } => {
                centre.validate(&format!("{path}.centre"))?;
                within(path, "radius_km", *radius_km, Self::RADIUS_KM, " km")?;
                match crust {
                    NewCrust::Oceanic { age_my } => {
                        within(path, "crust.oceanic.age_my", *age_my, Self::AGE_MY, " My")
                    }
                    NewCrust::Continental { thickness_km } => within(
                        path,
                        "crust.continental.thickness_km",
                        *thickness_km,
                        Self::THICKNESS_KM,
                        " km",
                    ),
                }
            }
            Self::StartHotSpot { place, strength } => {
                place.validate(&format!("{path}.place"))?;
                within(path, "strength", *strength, Self::STRENGTH, "")
            }
            Self::StopHotSpot { place } => place.validate(&format!("{path}.place")),
            Self::BreakUp { plate, pieces } => {
                plate.validate(path)?;
                within(path, "pieces", *pieces, Self::PIECES, "")
            }
        }
    }

    /// Name as in a recipe's JSON.
    #[must_use]
    pub fn name(&self) -> &'static str {
        match self {
            Self::SetMotion { .. } => "set-motion",
            Self::Rift { .. } => "rift",
            Self::SetCrust { .. } => "set-crust",
            Self::StartHotSpot { .. } => "start-hot-spot",
            Self::StopHotSpot { .. } => "stop-hot-spot",
            Self::BreakUp { .. } => "break-up",
        }
    }

    /// Speed in km/My that the event gives to a plate at most, where that is known before.
    pub(super) fn speed(&self, radius_km: f64) -> f64 {
        match self {
            Self::SetMotion { deg_per_my, .. } => deg_per_my.to_radians().abs() * radius_km,
            _ => 0.0,
        }
    }
}

impl PlateChoice {
    fn validate(self, path: &str) -> Result<(), TectonicError> {
        match self {
            Self::At(place) => place.validate(&format!("{path}.plate.at")),
            Self::Id(id) => within(path, "plate.id", id, 1..=u16::MAX, ""),
        }
    }
}

fn within<T: PartialOrd + core::fmt::Display>(
    path: &str,
    field: &str,
    value: T,
    range: RangeInclusive<T>,
    unit: &str,
) -> Result<(), TectonicError> {
    let dot = if path.is_empty() { "" } else { "." };
    recipe::within(&format!("{path}{dot}{field}"), value, range, unit)
}

/// Rotation to which an event holds a plate; a component of the plate. Whatever drives plates, this is
/// how it turns until then.
#[derive(Component, Debug, Clone, Copy, PartialEq, Serialize, Deserialize, Reflect)]
#[reflect(Component)]
pub struct HeldMotion {
    /// Angular velocity in rad/My.
    pub rotation: DVec3,
    /// End in My on the planet's clock.
    pub until_my: f64,
}

/// Puts events in the order of time; those of one time stay in the order in which they stand.
pub(crate) fn sort(events: &mut [TectonicEvent]) {
    events.sort_by(|a, b| a.at_my.total_cmp(&b.at_my));
}

/// Adds an event after all that are not later.
pub(crate) fn record(events: &mut Vec<TectonicEvent>, event: TectonicEvent) {
    events.push(event);
    sort(events);
}

/// Says whether there is room for one more event.
pub(super) fn one_more(events: &[TectonicEvent]) -> Result<(), TectonicError> {
    within(
        "",
        "number of events",
        events.len() + 1,
        super::Recipe::EVENTS,
        "",
    )
}

/// Who an event was about, for messages.
impl core::fmt::Display for PlateChoice {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::At(place) => write!(f, "at {place}"),
            Self::Id(id) => write!(f, "{id}"),
        }
    }
}

impl From<PlateId> for PlateChoice {
    fn from(id: PlateId) -> Self {
        Self::Id(id.0)
    }
}
