//! Planets with a look of their own.

use super::{PlanetAir, PlanetClouds, PlanetPalette};
use crate::{planet::Planet, simulation::Recipe};
use bevy::prelude::*;

/// A planet with everything that goes with it: how it grows, its colours, its air, its clouds.
///
/// ```
/// use bevy::prelude::*;
/// use bevy_tectonics::render::Preset;
///
/// fn setup(mut commands: Commands) {
///     commands.spawn(Preset::OldDry.planet(7));
/// }
/// ```
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Hash, Reflect)]
pub enum Preset {
    /// Green and blue, with a blue rim.
    #[default]
    EarthLike,
    /// Small, bare continents in seas green with iron, below a thick amber haze: [`Recipe::young_hot`].
    YoungHot,
    /// Ochre highlands around what is left of the seas, below thin, dusty air: [`Recipe::old_dry`].
    OldDry,
}

impl Preset {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::EarthLike, Self::YoungHot, Self::OldDry];

    /// Its name, for menus and arguments.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::EarthLike => "earth-like",
            Self::YoungHot => "young-hot",
            Self::OldDry => "old-dry",
        }
    }

    /// What it is grown from.
    #[must_use]
    pub fn recipe(self, seed: u64) -> Recipe {
        match self {
            Self::EarthLike => Recipe::earth_like(seed),
            Self::YoungHot => Recipe::young_hot(seed),
            Self::OldDry => Recipe::old_dry(seed),
        }
    }

    /// Everything but the history: for a planet whose recipe is one's own.
    #[must_use]
    pub fn look(self) -> (PlanetPalette, PlanetAir, PlanetClouds) {
        let clouds = PlanetClouds::default();
        match self {
            Self::EarthLike => (PlanetPalette::EARTH_LIKE, PlanetAir::default(), clouds),
            Self::YoungHot => (
                PlanetPalette::YOUNG_HOT,
                // Organic haze, as early Earth may have had and Titan has, dims the blue and glows amber.
                PlanetAir {
                    depth: Vec3::new(0.22, 0.15, 0.08),
                    scale_height_m: 11_000.0,
                },
                PlanetClouds {
                    cover: 0.4,
                    color: Color::linear_rgb(0.80, 0.70, 0.55),
                    ..clouds
                },
            ),
            Self::OldDry => (
                PlanetPalette::OLD_DRY,
                // Dust, as on Mars: the sky is butterscotch, and thin.
                PlanetAir {
                    depth: Vec3::new(0.11, 0.08, 0.045),
                    scale_height_m: 10_000.0,
                },
                PlanetClouds {
                    cover: 0.08,
                    height_m: 9000.0,
                    color: Color::linear_rgba(0.86, 0.82, 0.78, 0.6),
                    ..clouds
                },
            ),
        }
    }

    /// The planet as a bundle to be spawned.
    #[must_use]
    pub fn planet(self, seed: u64) -> (Planet, PlanetPalette, PlanetAir, PlanetClouds) {
        let (palette, air, clouds) = self.look();
        (Planet::new(self.recipe(seed)), palette, air, clouds)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn presets_have_names_and_recipes_of_their_own() {
        for (i, preset) in Preset::ALL.into_iter().enumerate() {
            assert!(preset.recipe(3).validate().is_ok());
            for other in &Preset::ALL[..i] {
                assert_ne!(preset.name(), other.name());
                assert_ne!(preset.recipe(3), other.recipe(3));
                assert_ne!(preset.look(), other.look());
            }
        }
    }
}
