//! Published laws by name: which formula the stages use for what.
//!
//! Each file holds the formulas of one phenomenon as plain functions; their constants are
//! [`LawConstants`](super::constants::LawConstants). The defaults are this crate's own choices, which
//! are calibrated together; a published law brings its source's scale with it.

pub mod collision;
pub mod erosion;
pub mod ridge;
pub mod sea_floor;
pub mod uplift;

use bevy::prelude::*;
use serde::{Deserialize, Serialize};

/// How deep sea floor lies by its age.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize, Reflect)]
#[serde(rename_all = "kebab-case")]
pub enum SeaFloorLaw {
    /// Half-space cooling up to 20 My, then the plate model GDH1 (Stein & Stein 1992).
    #[default]
    Gdh1,
    /// Half-space cooling up to 70 My, then a plate (Parsons & Sclater 1977).
    ParsonsSclater,
    /// Damping towards the depth of trenches (Cortial et al. 2019, section 4.5).
    Cortial,
    /// A fall to the abyssal plain between 2 and 4 My (Yggdrasill).
    Yggdrasill,
}

/// How subduction raises the overriding plate.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize, Reflect)]
#[serde(rename_all = "kebab-case")]
pub enum UpliftLaw {
    /// Magma in proportion to convergence, in a band behind the trench.
    #[default]
    Magma,
    /// `u₀ f(d) g(v) h(z̃)` (Cortial et al. 2019, section 4.1), as thickness by isostasy.
    Cortial,
}

/// What continents that meet raise.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize, Reflect)]
#[serde(rename_all = "kebab-case")]
pub enum CollisionLaw {
    /// Crushed crust alone, which thickens both sides volume for volume.
    #[default]
    Crush,
    /// Besides, a surge of elevation around the terrane at the moment it docks (Cortial et al. 2019,
    /// section 4.2), as thickness by isostasy.
    Cortial,
}

/// How land is worn down.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize, Reflect)]
#[serde(rename_all = "kebab-case")]
pub enum ErosionLaw {
    /// By the height above a base level that rises inland.
    #[default]
    BaseLevel,
    /// In proportion to elevation, with sediment in trenches and low-frequency noise (Cortial et al.
    /// 2019, section 4.5).
    Cortial,
    /// A share of each difference in height for every metre of rain (Tectonics.js).
    Rain,
}

/// The laws that a planet follows.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize, Reflect)]
#[serde(default, deny_unknown_fields)]
pub struct Laws {
    /// Depth of sea floor by age.
    pub sea_floor: SeaFloorLaw,
    /// Uplift at subduction.
    pub uplift: UpliftLaw,
    /// Collision.
    pub collision: CollisionLaw,
    /// Erosion.
    pub erosion: ErosionLaw,
}
