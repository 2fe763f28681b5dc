//! Books of crust: nothing is made or lost unseen.

use super::sub_plate::{Crust, MaterialArea, Thickness};
use bevy::prelude::*;
use serde::{Deserialize, Serialize};

/// Volumes of continental crust in km³ and areas of sea floor in km², since the start.
///
/// `initial + arc_magma + plume_magma + accreted + prescribed + rounded − eroded − scraped` is the continental volume,
/// where [`accreted`](Self::accreted_km3) sums four of the books; see [`closing_error`](Self::closing_error).
#[derive(Resource, Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize, Reflect)]
#[reflect(Resource)]
pub struct Ledger {
    /// Continental volume at the start, km³.
    pub initial_km3: f64,
    /// Magma that arcs, and by the published law docking terranes, added to continents, km³.
    pub arc_magma_km3: f64,
    /// Magma that hot spots added to continents, km³.
    pub plume_magma_km3: f64,
    /// Island arcs that grew as thick as continents, km³.
    pub island_arcs_km3: f64,
    /// Enclosed seas that filled up, km³.
    pub filled_seas_km3: f64,
    /// Margins that rivers built out, their sea floor included, km³.
    pub built_margins_km3: f64,
    /// Sea floor buried under crust that collisions pushed out, km³.
    pub buried_floor_km3: f64,
    /// Rock lost to the deep sea, km³.
    pub eroded_km3: f64,
    /// Rock that sinking plates scraped off fore-arcs, km³.
    #[serde(default)]
    pub scraped_km3: f64,
    /// What events made continental less what they made sea floor, km³.
    pub prescribed_km3: f64,
    /// What the rounding of thicknesses and areas has added to continents or taken, km³: next to nothing, but for
    /// the last sliver of a vanishing one.
    pub rounded_km3: f64,
    /// Area of crust made at ridges, km².
    pub area_created_km2: f64,
    /// Area of crust consumed at trenches and in collisions, km².
    pub area_consumed_km2: f64,
    /// Continental area shortened in collisions, km².
    pub area_shortened_km2: f64,
    /// Continental area made by stretching in rifts, km².
    pub area_stretched_km2: f64,
}

impl Ledger {
    /// Sea floor, island arcs and filled basins that became continental, km³.
    #[must_use]
    pub fn accreted_km3(&self) -> f64 {
        self.island_arcs_km3 + self.filled_seas_km3 + self.built_margins_km3 + self.buried_floor_km3
    }

    /// Continental volume that the books say is there, km³.
    #[must_use]
    pub fn booked_km3(&self) -> f64 {
        self.initial_km3
            + self.arc_magma_km3
            + self.plume_magma_km3
            + self.accreted_km3()
            + self.prescribed_km3
            + self.rounded_km3
            - self.eroded_km3
            - self.scraped_km3
    }

    /// Growth of the continents since the start, as a share of their volume then. What events made or
    /// took counts as there from the start: it is not for arcs and rivers to correct.
    #[must_use]
    pub fn growth(&self, found_km3: f64) -> f64 {
        found_km3 / (self.initial_km3 + self.prescribed_km3).max(1.0) - 1.0
    }

    /// Difference between the volume found and the volume booked, as a share of the latter. Where
    /// next to nothing is left of the first continents, or of what came and went since, a share of a
    /// thousandth of that: sums do not round to less than their terms allow.
    #[must_use]
    pub fn closing_error(&self, found_km3: f64) -> f64 {
        let booked = self.booked_km3();
        let largest = self.initial_km3.max(self.eroded_km3 + self.scraped_km3);
        (found_km3 - booked) / booked.abs().max(1e-3 * largest).max(1.0)
    }
}

/// Volume of all continental crust in km³.
pub(super) fn continental_volume(
    crust: &[Crust],
    thickness: &[Thickness],
    area: &[MaterialArea],
) -> f64 {
    (0..crust.len())
        .filter(|&v| crust[v].is_continental())
        .map(|v| thickness[v].0 * area[v].0)
        .sum()
}
