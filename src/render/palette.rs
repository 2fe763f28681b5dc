//! Colours of planets: assets, in files that people edit.

use super::{globe::Globe, material::PlanetMaterial};
use crate::{
    planet::Planet,
    surface::tint::{Ramp, look_up},
};
use bevy::{
    asset::{AssetLoader, LoadContext, RenderAssetUsages, io::Reader, uuid_handle},
    image::{ImageSampler, ImageSamplerDescriptor},
    prelude::*,
    render::render_resource::{Extent3d, ShaderType, TextureDimension, TextureFormat},
};
use core::ops::RangeInclusive;
use serde::{Deserialize, Serialize};
use thiserror::Error;

/// The colours of a planet: put it on a [`Planet`]. Planets without it are [`EARTH_LIKE`](Self::EARTH_LIKE).
///
/// ```
/// use bevy::prelude::*;
/// use bevy_tectonics::{prelude::*, render::PlanetPalette};
///
/// fn setup(mut commands: Commands, assets: Res<AssetServer>) {
///     let mine = PlanetPalette(assets.load("mine.palette.ron"));
///     commands.spawn((Planet::new(Recipe::earth_like(7)), mine));
/// }
/// ```
#[derive(Component, Debug, Clone, PartialEq, Eq, Reflect)]
#[reflect(Component, Default)]
pub struct PlanetPalette(pub Handle<Palette>);

impl PlanetPalette {
    /// Green lowlands, tan deserts, blue seas, white poles.
    pub const EARTH_LIKE: Self = Self(uuid_handle!("4d61bd6c-0d0a-4d8f-9e6b-6f0a4f0c1a01"));
    /// Bare basalt and rust, seas green with iron, no ice.
    pub const YOUNG_HOT: Self = Self(uuid_handle!("4d61bd6c-0d0a-4d8f-9e6b-6f0a4f0c1a02"));
    /// Ochre highlands, salt on the shores of what is left of its seas.
    pub const OLD_DRY: Self = Self(uuid_handle!("4d61bd6c-0d0a-4d8f-9e6b-6f0a4f0c1a03"));
}

impl Default for PlanetPalette {
    fn default() -> Self {
        Self::EARTH_LIKE
    }
}

/// Every colour of a planet, as an asset: files end in `.palette.ron`. Those that come with the crate, in
/// `assets/palettes/`, are the best to start from.
#[derive(Asset, TypePath, Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Palette {
    /// Ground where it is warm and wet, by height above the sea in m: at least one colour, heights rise.
    #[serde(with = "gradient")]
    pub lush: Gradient,
    /// Ground where it is mild.
    #[serde(with = "gradient")]
    pub temperate: Gradient,
    /// Ground where winters are long.
    #[serde(with = "gradient")]
    pub boreal: Gradient,
    /// Ground beside the ice.
    #[serde(with = "gradient")]
    pub tundra: Gradient,
    /// Ground where it is dry.
    #[serde(with = "gradient")]
    pub arid: Gradient,
    /// Bare rock of young ranges and of cliffs.
    #[serde(with = "gradient")]
    pub rock: Gradient,
    /// Water, by depth in m.
    #[serde(with = "gradient")]
    pub sea: Gradient,
    /// The bed of a sea that is not drawn, by depth in m; its first colour is that of beaches.
    #[serde(with = "gradient")]
    pub bed: Gradient,
    /// Ice and snow on land.
    #[serde(with = "hex")]
    pub ice: Srgba,
    /// Ice at sea.
    #[serde(with = "hex")]
    pub pack_ice: Srgba,
    /// Loose stones below cliffs.
    #[serde(with = "hex")]
    pub scree: Srgba,
    /// Foam of the surf.
    #[serde(with = "hex")]
    pub foam: Srgba,
    /// What woods make of the ground below them: factors on red, green and blue, 0 to 4 like the next three.
    pub woods: [f32; 3],
    /// The same of clearings between them.
    pub clearings: [f32; 3],
    /// The same of stony ground where little grows.
    pub stones: [f32; 3],
    /// The same of sandy ground.
    pub sand: [f32; 3],
    /// Height of the snow line in m at the equator, 0 to 100,000; it sinks to the sea where the ice begins.
    pub snow_line_m: f32,
    /// Degrees of latitude from which ice covers the land, 26 to 1,000: from 95 there is none.
    pub ice_latitude: f32,
    /// Degrees of latitude from which ice covers the sea, 0 to 1,000.
    pub pack_ice_latitude: f32,
}

/// Colours by height or depth in m.
pub type Gradient = Vec<(f32, Srgba)>;

/// Why a file is no palette.
#[derive(Debug, Error)]
pub enum PaletteError {
    /// The file could not be read.
    #[error("the palette cannot be read: {0}")]
    Io(#[from] std::io::Error),
    /// It is no RON, or something is missing or unknown.
    #[error("the palette is wrong at {0}")]
    Ron(#[from] ron::error::SpannedError),
    /// A gradient has no colours, or heights that do not rise.
    #[error("the palette's {0} must have at least one colour, at heights that rise")]
    Gradient(&'static str),
    /// A number lies outside of its range.
    #[error("the palette's {field} is {value}, but must be between {lowest} and {highest}")]
    Number {
        /// Name of the field.
        field: &'static str,
        /// Its value.
        value: f32,
        /// Smallest value.
        lowest: f32,
        /// Largest value.
        highest: f32,
    },
}

impl Palette {
    /// Reads a palette.
    ///
    /// # Errors
    /// [`PaletteError`] says what is wrong, and where.
    pub fn from_ron(bytes: &[u8]) -> Result<Self, PaletteError> {
        let palette: Self = ron::de::from_bytes(bytes)?;
        palette.validate()?;
        Ok(palette)
    }

    fn rows(&self) -> [(&'static str, &Gradient); ROWS] {
        [
            ("lush", &self.lush),
            ("temperate", &self.temperate),
            ("boreal", &self.boreal),
            ("tundra", &self.tundra),
            ("arid", &self.arid),
            ("rock", &self.rock),
            ("sea", &self.sea),
            ("bed", &self.bed),
        ]
    }

    fn validate(&self) -> Result<(), PaletteError> {
        for (name, gradient) in self.rows() {
            let finite = gradient.iter().all(|(height, _)| height.is_finite());
            if gradient.is_empty() || !finite || !gradient.is_sorted_by(|a, b| a.0 < b.0) {
                return Err(PaletteError::Gradient(name));
            }
        }
        let within = |field, value: f32, range: RangeInclusive<f32>| {
            if range.contains(&value) {
                return Ok(());
            }
            let (lowest, highest) = range.into_inner();
            Err(PaletteError::Number {
                field,
                value,
                lowest,
                highest,
            })
        };
        let factors = [
            ("woods", self.woods),
            ("clearings", self.clearings),
            ("stones", self.stones),
            ("sand", self.sand),
        ];
        for (field, values) in factors {
            for value in values {
                within(field, value, 0.0..=4.0)?;
            }
        }
        within("snow_line_m", self.snow_line_m, 0.0..=100_000.0)?;
        within("ice_latitude", self.ice_latitude, 26.0..=1000.0)?;
        within("pack_ice_latitude", self.pack_ice_latitude, 0.0..=1000.0)
    }

    /// The gradients as a table that shaders look up: a row for each, sea level on the left.
    pub(super) fn image(&self) -> Image {
        let mut texels = Vec::new();
        for (_, gradient) in self.rows() {
            let ramp: Vec<_> = gradient
                .iter()
                .map(|&(height, color)| {
                    let [red, green, blue, _] = color.to_u8_array();
                    (height, [red, green, blue])
                })
                .collect();
            let ramp: &Ramp = &ramp;
            for column in 0..COLUMNS {
                let share = column as f32 / (COLUMNS - 1) as f32;
                let colour = look_up(ramp, EXTENT_M * share * share);
                texels.extend(colour.to_array().map(|value| (value * 255.0 + 0.5) as u8));
                texels.push(255);
            }
        }
        Image {
            sampler: ImageSampler::Descriptor(ImageSamplerDescriptor::linear()),
            ..Image::new(
                Extent3d {
                    width: COLUMNS,
                    height: ROWS as u32,
                    depth_or_array_layers: 1,
                },
                TextureDimension::D2,
                texels,
                TextureFormat::Rgba8UnormSrgb,
                RenderAssetUsages::RENDER_WORLD,
            )
        }
    }

    /// Everything else that shaders want to know of it.
    pub(super) fn tints(&self) -> Tints {
        let colour = |color: Srgba, w: f32| {
            let LinearRgba {
                red, green, blue, ..
            } = color.into();
            Vec4::new(red, green, blue, w)
        };
        let factors = |rgb: [f32; 3]| Vec3::from(rgb).extend(1.0);
        Tints {
            ice: colour(self.ice, 0.001 * self.snow_line_m),
            pack_ice: colour(self.pack_ice, self.pack_ice_latitude),
            scree: colour(self.scree, self.ice_latitude),
            foam: colour(self.foam, 1.0),
            woods: factors(self.woods),
            clearings: factors(self.clearings),
            stones: factors(self.stones),
            sand: factors(self.sand),
        }
    }
}

/// Columns of the table. Heights are spread by their square root: coasts and shelves need most.
const COLUMNS: u32 = 256;
/// Rows of the table, in the order that `ground.wgsl` names them.
const ROWS: usize = 8;
/// Height of the last column on land and depth of that at sea, in m. Mirrored in `ground.wgsl`.
const EXTENT_M: f32 = 8000.0;

/// Colours that do not depend on heights. The order is that of `ground.wgsl`.
#[derive(ShaderType, Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct Tints {
    /// In w: the snow line at the equator in km.
    ice: Vec4,
    /// In w: the latitude from which it covers the sea.
    pack_ice: Vec4,
    /// In w: the latitude from which ice covers the land.
    scree: Vec4,
    foam: Vec4,
    woods: Vec4,
    clearings: Vec4,
    stones: Vec4,
    sand: Vec4,
}

/// Loads palettes.
#[derive(Default, TypePath)]
struct PaletteLoader;

impl AssetLoader for PaletteLoader {
    type Asset = Palette;
    type Settings = ();
    type Error = PaletteError;

    async fn load(
        &self,
        reader: &mut dyn Reader,
        (): &(),
        _: &mut LoadContext<'_>,
    ) -> Result<Palette, PaletteError> {
        let mut bytes = Vec::new();
        reader.read_to_end(&mut bytes).await?;
        Palette::from_ron(&bytes)
    }

    fn extensions(&self) -> &[&str] {
        &["palette.ron"]
    }
}

/// What comes with the crate.
const BUILT_IN: [(PlanetPalette, &[u8]); 3] = [
    (
        PlanetPalette::EARTH_LIKE,
        include_bytes!("../../assets/palettes/earth_like.palette.ron"),
    ),
    (
        PlanetPalette::YOUNG_HOT,
        include_bytes!("../../assets/palettes/young_hot.palette.ron"),
    ),
    (
        PlanetPalette::OLD_DRY,
        include_bytes!("../../assets/palettes/old_dry.palette.ron"),
    ),
];

pub(super) fn plugin(app: &mut App) {
    app.init_asset::<Palette>()
        .register_asset_loader(PaletteLoader);
    let mut palettes = app.world_mut().resource_mut::<Assets<Palette>>();
    for (PlanetPalette(handle), bytes) in BUILT_IN {
        match Palette::from_ron(bytes) {
            Ok(palette) => {
                let _ = palettes.insert(&handle, palette);
            }
            Err(error) => error!("{error}"),
        }
    }
}

/// Hands planets the colours that they want, once those are there, and whenever they change.
pub(super) fn dye(
    mut changes: MessageReader<AssetEvent<Palette>>,
    palettes: Res<Assets<Palette>>,
    mut images: ResMut<Assets<Image>>,
    mut materials: ResMut<Assets<PlanetMaterial>>,
    mut planets: Query<(Option<&PlanetPalette>, &mut Globe), With<Planet>>,
) {
    let changed: Vec<AssetId<Palette>> = changes
        .read()
        .filter_map(|event| match event {
            AssetEvent::Added { id } | AssetEvent::Modified { id } => Some(*id),
            _ => None,
        })
        .collect();
    for (wanted, mut globe) in &mut planets {
        let globe = globe.bypass_change_detection();
        let id = wanted.unwrap_or(&PlanetPalette::EARTH_LIKE).0.id();
        if globe.palette == Some(id) && !changed.contains(&id) {
            continue;
        }
        let Some(palette) = palettes.get(id) else {
            continue;
        };
        if let Some(mut material) = materials.get_mut(&globe.material) {
            material.palette = images.add(palette.image());
            globe.tints = palette.tints();
            globe.palette = Some(id);
        }
    }
}

/// A colour as `#rrggbb`.
mod hex {
    use bevy::color::Srgba;
    use serde::{Deserialize, Deserializer, Serializer, de::Error};

    pub fn serialize<S: Serializer>(color: &Srgba, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(&color.to_hex())
    }

    pub fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Srgba, D::Error> {
        let text = String::deserialize(deserializer)?;
        Srgba::hex(&text)
            .map_err(|_| D::Error::custom(format!("{text:?} is no colour: #rrggbb is")))
    }
}

/// Colours by height as a list of pairs.
mod gradient {
    use super::{Gradient, Srgba};
    use serde::{Deserialize, Deserializer, Serialize, Serializer};

    #[derive(Serialize, Deserialize)]
    #[serde(transparent)]
    struct Color(#[serde(with = "super::hex")] Srgba);

    pub fn serialize<S: Serializer>(steps: &Gradient, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_seq(steps.iter().map(|&(height, color)| (height, Color(color))))
    }

    pub fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Gradient, D::Error> {
        let steps = Vec::<(f32, Color)>::deserialize(deserializer)?;
        Ok(steps
            .into_iter()
            .map(|(height, color)| (height, color.0))
            .collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn palettes_that_come_along_are_whole_and_differ() {
        let palettes = BUILT_IN.map(|(_, bytes)| Palette::from_ron(bytes).unwrap());
        assert_ne!(palettes[0], palettes[1]);
        assert_ne!(palettes[1], palettes[2]);
        for palette in &palettes {
            let text = ron::to_string(palette).unwrap();
            assert_eq!(&Palette::from_ron(text.as_bytes()).unwrap(), palette);
            let image = palette.image();
            assert_eq!(image.data.unwrap().len(), 4 * COLUMNS as usize * ROWS);
        }
    }

    #[test]
    fn the_table_begins_at_the_sea_and_ends_at_its_extent() {
        let palette = Palette::from_ron(BUILT_IN[0].1).unwrap();
        let texels = palette.image().data.unwrap();
        let [red, green, blue, _] = palette.lush[0].1.to_u8_array();
        assert_eq!(texels[..4], [red, green, blue, 255]);
        let [red, green, blue, _] = palette.bed[4].1.to_u8_array();
        assert_eq!(texels[texels.len() - 4..], [red, green, blue, 255]);
    }

    #[test]
    fn what_is_wrong_is_said() {
        let text = core::str::from_utf8(BUILT_IN[0].1).unwrap();
        let wrong = |from: &str, to: &str| {
            assert!(text.contains(from), "{from}");
            let text = text.replacen(from, to, 1);
            Palette::from_ron(text.as_bytes()).unwrap_err().to_string()
        };
        for (from, to, says) in [
            (
                "ice_latitude: 71.0",
                "ice_latitude: -3.0",
                "ice_latitude is -3",
            ),
            (
                "snow_line_m: 5400.0",
                "snow_line_m: inf",
                "between 0 and 100000",
            ),
            ("woods: (0.60,", "woods: (9.0,", "woods is 9"),
            ("(300, \"#25401b\")", "(0, \"#25401b\")", "lush must have"),
            ("#e7edf4", "white", "no colour"),
            ("scree:", "screes:", "screes"),
        ] {
            let error = wrong(from, to);
            assert!(error.contains(says), "{error}");
        }
        assert!(Palette::from_ron(&[0xff, 0xfe]).is_err());
    }
}
