//! Fields of a planet as colours, and the legends that explain them.

mod colors;
mod legend;

#[cfg(feature = "render")]
pub(crate) use colors::{ARROW_COLOR, ARROW_LONGEST, ARROW_RADII, OUTLINE};
pub use colors::{boundary_color, plate_color};

use crate::simulation::{Crust, Orogeny};
use bevy::prelude::*;

/// A field that can be shown in place of, or over, the natural colours of a planet.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Reflect)]
pub enum Overlay {
    /// A colour for every plate.
    Plates,
    /// Kind of crust.
    Crust,
    /// Age of the crust in My.
    Age,
    /// Thickness of the crust in km.
    Thickness,
    /// Speed in mm/yr.
    Speed,
    /// Elevation in steps of 500 m, as a school atlas has it.
    Elevation,
    /// Kind and age of the last mountain building.
    Orogeny,
    /// Boundaries of plates by kind.
    Boundaries,
    /// Velocity as arrows.
    Velocity,
}

impl Overlay {
    /// All overlays.
    pub const ALL: [Self; 9] = [
        Self::Plates,
        Self::Crust,
        Self::Age,
        Self::Thickness,
        Self::Speed,
        Self::Elevation,
        Self::Orogeny,
        Self::Boundaries,
        Self::Velocity,
    ];

    /// Name for people, in English.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Plates => "Plates",
            Self::Crust => "Crust",
            Self::Age => "Age of crust",
            Self::Thickness => "Thickness of crust",
            Self::Speed => "Speed",
            Self::Elevation => "Elevation",
            Self::Orogeny => "Mountain building",
            Self::Boundaries => "Boundaries",
            Self::Velocity => "Velocity",
        }
    }
}

/// What overlays show of one place. Values may be interpolated or not.
///
/// ```
/// use bevy_tectonics::prelude::*;
/// use bevy_tectonics::surface::OverlayValues;
///
/// let young = OverlayValues { age: 3.0, ..OverlayValues::default() };
/// let [red, green, blue, opacity] = Overlay::Age.color(&young);
/// assert!(red > green && red > blue && opacity == 255);
/// ```
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct OverlayValues {
    /// Elevation in m above the sea.
    pub elevation: f32,
    /// Kind of crust.
    pub crust: Crust,
    /// Age of the crust in My.
    pub age: f32,
    /// Id of the plate, 0 = none.
    pub plate: u16,
    /// Thickness of the crust in km.
    pub thickness: f32,
    /// Speed in km/My (= mm/yr).
    pub speed: f32,
    /// Kind of the last mountain building.
    pub orogeny: Orogeny,
    /// Time since the last mountain building in My.
    pub orogeny_age: f32,
}

/// What the colours of an overlay mean.
#[derive(Debug, Clone, PartialEq)]
pub struct Legend {
    /// Name of the overlay.
    pub title: &'static str,
    /// Unit of the values; empty for kinds.
    pub unit: &'static str,
    /// Colours with what they stand for, in order. Values between two entries of a scale have colours
    /// between, linear in sRGB.
    pub entries: Vec<LegendEntry>,
    /// Whether the entries are points of a continuous scale rather than kinds.
    pub scale: bool,
    /// Colours of places that have no value on the scale.
    pub others: Vec<LegendEntry>,
}

/// One colour of a [`Legend`].
#[derive(Debug, Clone, PartialEq)]
pub struct LegendEntry {
    /// The colour, sRGB, components 0–255.
    pub color: [u8; 3],
    /// What it stands for.
    pub label: String,
}
