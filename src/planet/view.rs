//! How a planet wants to be drawn. Plain data: renderers and panels read and write it.

use crate::surface::Overlay;
use bevy::prelude::*;

/// How a planet is drawn. The default is a planet as seen from space.
#[derive(Component, Debug, Clone, PartialEq, Reflect)]
#[reflect(Component, Default)]
pub struct PlanetView {
    /// A field that colours the ground in place of its natural colours. [`Overlay::Boundaries`] and
    /// [`Overlay::Velocity`] are drawn as lines and arrows instead, by the switches below.
    pub overlay: Option<Overlay>,
    /// How far the overlay covers the natural colours, 0 to 1.
    pub overlay_opacity: f32,
    /// Draws the boundaries of plates as lines whose colour tells their kind.
    pub boundaries: bool,
    /// Draws the velocity of plates as arrows.
    pub velocities: bool,
    /// Heights are drawn this many times larger than they are. At 1 no mountain can be seen from space:
    /// the highest is a thousandth of the radius.
    pub exaggeration: f32,
    /// Whether the sea is drawn.
    pub sea: bool,
    /// Level of the drawn sea in m above the planet's own.
    pub sea_level_m: f32,
}

impl Default for PlanetView {
    fn default() -> Self {
        Self {
            overlay: None,
            overlay_opacity: 0.85,
            boundaries: false,
            velocities: false,
            exaggeration: 12.0,
            sea: true,
            sea_level_m: 0.0,
        }
    }
}
