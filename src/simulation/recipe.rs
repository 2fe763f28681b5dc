//! What a planet is grown from.

mod code;
pub(super) mod sparse;

pub use code::RecipeError;

use super::{
    constants::Constants,
    error::TectonicError,
    events::{Intervention, TectonicEvent},
    laws::Laws,
    start::{Hypsometry, ImageStart},
};
use bevy::prelude::*;
use core::ops::RangeInclusive;
use serde::{Deserialize, Serialize};

/// Smallest number of sub-plates that still holds a handful of plates.
pub const FEWEST_SUB_PLATES: u32 = 200;
/// Fewest sub-plates for each plate of the start.
const FEWEST_PER_PLATE: u32 = 20;
/// Largest number of sub-plates.
pub const MOST_SUB_PLATES: u32 = 2_000_000;

/// How a new world is laid out.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, Reflect)]
#[serde(rename_all = "kebab-case")]
pub enum Start {
    /// Plates grow from random seeds, one shuffled frontier a round (Yggdrasill).
    #[default]
    FloodFill,
    /// Cells of random centres under noise-warped distance (Cortial et al. 2019, section 3).
    Voronoi,
    /// Continents from random great circles, matched to a hypsometric curve; plates as in
    /// [`FloodFill`](Self::FloodFill) (Tectonics.js). The curve says how much is continent and how much
    /// is land: the recipe's shares of both are not read.
    Hypsometric(Hypsometry),
    /// An imported height map, with the outlines and motions of plates where there are any. Files are
    /// read by the cargo feature `import`; see [`History::imported`](super::History::imported).
    Image(ImageStart),
}

impl Start {
    /// Whether it reads the recipe's [`continental_share`](Recipe::continental_share) and
    /// [`land_share`](Recipe::land_share).
    #[must_use]
    pub fn reads_shares(&self) -> bool {
        matches!(self, Self::FloodFill | Self::Voronoi)
    }

    fn validate(&self) -> Result<(), TectonicError> {
        match self {
            Self::FloodFill | Self::Voronoi => Ok(()),
            Self::Hypsometric(hypsometry) => hypsometry.validate(),
            Self::Image(image) => image.validate(),
        }
    }
}

/// What turns the plates.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize, Reflect)]
#[serde(rename_all = "kebab-case")]
pub enum Drive {
    /// Torque balance of the forces at the boundaries, with soft margins.
    #[default]
    Soft,
    /// The same balance on exactly rigid plates.
    Rigid,
    /// Old sea floor founders and drags the mantle towards it; plates are what moves alike
    /// (Tectonics.js).
    Foundering,
    /// Rigid plates keep the rotations they have; slabs turn their axes (Cortial et al. 2019,
    /// section 4.1).
    Prescribed,
}

/// Everything a planet is grown from. The same recipe grows the same planet, bit for bit.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, Resource, Reflect)]
#[serde(default, deny_unknown_fields)]
#[reflect(Resource)]
pub struct Recipe {
    /// Seed of every random stream.
    pub seed: u64,
    /// Number of sub-plates, 200 to 2,000,000.
    pub sub_plates: u32,
    /// Length of the history in My, 0 to 10,000.
    pub duration_my: f64,
    /// Radius in km, 500 to 50,000. Earth's is 6,371.
    pub radius_km: f64,
    /// Layout of the first moment.
    pub start: Start,
    /// Number of plates at the start, 2 to 200.
    pub plates: u32,
    /// Share of the sphere that is continental crust at the start, 0 to 0.9. Earth's is 0.41.
    pub continental_share: f64,
    /// Share of the sphere that is dry at the start, 0 to 0.9; fixes the volume of the sea. Earth's is 0.29.
    pub land_share: f64,
    /// What turns the plates.
    pub drive: Drive,
    /// Which formulas the stages use.
    pub laws: Laws,
    /// Number of hot spots under the plates from the start, 0 to 200. Earth has some 20 to 50 that rise
    /// from deep in the mantle (Courtillot et al. 2003; French & Romanowicz 2015).
    pub hot_spots: u32,
    /// What happens at which time, at most 10,000 events in any order.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub events: Vec<TectonicEvent>,
    /// Constants of the model.
    pub constants: Constants,
}

impl Default for Recipe {
    fn default() -> Self {
        Self {
            seed: 0,
            sub_plates: 10_000,
            duration_my: 250.0,
            radius_km: 6371.0,
            start: Start::default(),
            plates: 24,
            continental_share: 0.41,
            land_share: 0.30,
            drive: Drive::default(),
            laws: Laws::default(),
            hot_spots: 20,
            events: Vec::new(),
            constants: Constants::default(),
        }
    }
}

impl Recipe {
    /// Allowed numbers of sub-plates.
    pub const SUB_PLATES: RangeInclusive<u32> = FEWEST_SUB_PLATES..=MOST_SUB_PLATES;
    /// Allowed lengths of the history in My.
    pub const DURATION_MY: RangeInclusive<f64> = 0.0..=10_000.0;
    /// Allowed radii in km.
    pub const RADIUS_KM: RangeInclusive<f64> = 500.0..=50_000.0;
    /// Allowed numbers of plates; [`most_plates`](Self::most_plates) may be fewer.
    pub const PLATES: RangeInclusive<u32> = 2..=200;
    /// Allowed shares of continental crust and of land.
    pub const SHARES: RangeInclusive<f64> = 0.0..=0.9;
    /// Allowed numbers of hot spots.
    pub const HOT_SPOTS: RangeInclusive<u32> = 0..=200;
    /// Allowed numbers of events.
    pub const EVENTS: RangeInclusive<usize> = 0..=10_000;

    /// A planet like Earth: 10,000 sub-plates, 250 My.
    #[must_use]
    pub fn earth_like(seed: u64) -> Self {
        Self {
            seed,
            ..Self::default()
        }
    }

    /// A young planet: a hot mantle that drives its plates harder, small continents in a sea that covers
    /// nearly everything, many plates and hot spots.
    #[must_use]
    pub fn young_hot(seed: u64) -> Self {
        let mut recipe = Self {
            seed,
            plates: 40,
            continental_share: 0.16,
            land_share: 0.10,
            hot_spots: 70,
            ..Self::default()
        };
        let constants = &mut recipe.constants;
        constants.mantle.speed = 300.0;
        constants.motion.slab_pull *= 1.6;
        constants.motion.slab_suction *= 1.6;
        // More of a hotter mantle melts at its ridges.
        constants.ridges.oceanic_thickness = 9.0;
        constants.plates.plate_count = 28.0;
        recipe
    }

    /// An old planet: few plates, a weaker drive, and little water, which wears its mountains slowly.
    #[must_use]
    pub fn old_dry(seed: u64) -> Self {
        let mut recipe = Self {
            seed,
            plates: 10,
            land_share: 0.8,
            hot_spots: 8,
            ..Self::default()
        };
        let constants = &mut recipe.constants;
        constants.mantle.speed = 60.0;
        constants.motion.slab_pull *= 0.4;
        constants.motion.slab_suction *= 0.4;
        constants.plates.plate_count = 7.0;
        constants.erosion.rate = 0.02;
        recipe
    }

    /// The same recipe with another number of sub-plates, and fewer plates if they are too few for
    /// that many.
    #[must_use]
    pub fn with_sub_plates(mut self, sub_plates: u32) -> Self {
        self.sub_plates = sub_plates;
        self.plates = self.plates.min(self.most_plates());
        self
    }

    /// The largest number of plates that so many sub-plates can hold.
    #[must_use]
    pub fn most_plates(&self) -> u32 {
        (self.sub_plates / FEWEST_PER_PLATE).max(*Self::PLATES.start())
    }

    /// The same recipe with a history of another length, in My.
    #[must_use]
    pub fn with_duration(mut self, duration_my: f64) -> Self {
        self.duration_my = duration_my;
        self
    }

    /// The same recipe with one more event, at a time in My.
    #[must_use]
    pub fn with_event(mut self, at_my: f64, what: Intervention) -> Self {
        self.events.push(TectonicEvent::new(at_my, what));
        self
    }

    /// Nominal spacing of sub-plates in km: the side of a square as large as one cell.
    #[must_use]
    pub fn spacing_km(&self) -> f64 {
        self.cell_area_km2().sqrt()
    }

    /// Nominal area of a sub-plate's cell in km².
    #[must_use]
    pub fn cell_area_km2(&self) -> f64 {
        4.0 * core::f64::consts::PI * self.radius_km * self.radius_km / f64::from(self.sub_plates)
    }

    /// Says which value lies outside its range, if one does.
    ///
    /// # Errors
    /// [`TectonicError::Recipe`] with the first offending value and what is allowed.
    pub fn validate(&self) -> Result<(), TectonicError> {
        within("sub_plates", self.sub_plates, Self::SUB_PLATES, "")?;
        within("duration_my", self.duration_my, Self::DURATION_MY, " My")?;
        within("radius_km", self.radius_km, Self::RADIUS_KM, " km")?;
        within("plates", self.plates, Self::PLATES, "")?;
        if self.plates > self.sub_plates / FEWEST_PER_PLATE {
            return Err(TectonicError::Recipe {
                field: "plates".into(),
                value: self.plates.to_string(),
                allowed: format!(
                    "at most one for every {FEWEST_PER_PLATE} sub-plates, here {}",
                    self.sub_plates / FEWEST_PER_PLATE
                ),
            });
        }
        within(
            "continental_share",
            self.continental_share,
            Self::SHARES,
            "",
        )?;
        within("land_share", self.land_share, Self::SHARES, "")?;
        self.start.validate()?;
        within("hot_spots", self.hot_spots, Self::HOT_SPOTS, "")?;
        within("the number of events", self.events.len(), Self::EVENTS, "")?;
        for (i, event) in self.events.iter().enumerate() {
            event.validate(&format!("events[{i}]"))?;
        }
        self.constants.validate()
    }
}

/// Refuses a value outside its range.
pub(super) fn within<T: PartialOrd + core::fmt::Display>(
    field: &str,
    value: T,
    range: RangeInclusive<T>,
    unit: &str,
) -> Result<(), TectonicError> {
    if range.contains(&value) {
        return Ok(());
    }
    Err(TectonicError::Recipe {
        field: field.into(),
        value: value.to_string(),
        allowed: format!("between {} and {}{unit}", range.start(), range.end()),
    })
}
