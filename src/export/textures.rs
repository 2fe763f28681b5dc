//! What a material wants: heights, normals and colours, as a rectangle or as a cube map.

use super::{
    ExportError, Maps,
    chart::Chart,
    draft::{self, Draft},
    grid::Grid,
    sheet::{Format, Sheet, metres, quantise},
    skin::{Skin, Texel},
};
use crate::simulation::Surface;
use crate::surface::Relief;
use png::{BitDepth, ColorType};
use std::{
    ops::RangeInclusive,
    path::{Path, PathBuf},
};

/// Faces of a cube map in the order of their layers, as files are called.
pub(super) const FACES: [&str; 6] = ["px", "nx", "py", "ny", "pz", "nz"];

/// How pixels are laid over the sphere.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Layout {
    /// Longitudes and latitudes, as [`Maps`] are drawn. Pixels from west to east, even, within
    /// [`Maps::WIDTHS`].
    Rectangle(u32),
    /// The six faces of a cube: no poles, no seams, half the pixels. Texels along an edge, within
    /// [`Textures::SIDES`].
    Cube(u32),
}

/// Textures of a planet: what a material of your own draws it with.
///
/// | file | content |
/// |---|---|
/// | `elevation.png` | 16-bit grey, metres above sea level + 32768 |
/// | `normal.png` | 16-bit RGB, the normal of the ground in the picture's own axes: red to the right, green to the top, blue away from the planet; −1 to 1 as 0 to 65535 |
/// | `colour.png` | 8-bit sRGB, land and sea without light or shade |
///
/// A rectangle has the places of pixels that [`Maps`] has. A cube has six of each, `elevation_px.png` to
/// `elevation_nz.png`, named after the axis in their middle. That is one of a scene, in which north is
/// `+Y`, longitude 0 `+X` and 90° east `−Z`; rows and columns run as in the layers of a cube texture, so
/// that a sampler finds the place by the direction alone.
///
/// ```no_run
/// # use bevy_tectonics::{export::{ExportError, Textures}, simulation::Surface};
/// # fn example(surface: &Surface) -> Result<(), ExportError> {
/// Textures::cube(1024).write(surface, "planet".as_ref())?;
/// # Ok(()) }
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Textures {
    /// How pixels are laid over the sphere.
    pub layout: Layout,
    /// How the ground is drawn whose normals these are.
    pub relief: Relief,
    /// Threads to sample with, within [`Maps::THREADS`]. The textures do not depend on it.
    pub threads: usize,
}

impl Textures {
    /// Allowed texels along an edge of a cube.
    pub const SIDES: RangeInclusive<u32> = 8..=8192;

    /// A rectangle of so many pixels in width, true to scale and with sea floors laid bare.
    #[must_use]
    pub fn rectangle(width: u32) -> Self {
        Self::new(Layout::Rectangle(width))
    }

    /// A cube of so many texels along an edge, true to scale and with sea floors laid bare.
    #[must_use]
    pub fn cube(side: u32) -> Self {
        Self::new(Layout::Cube(side))
    }

    fn new(layout: Layout) -> Self {
        Self {
            layout,
            relief: Relief::TRUE_SCALE,
            threads: Maps::new(*Maps::WIDTHS.start()).threads,
        }
    }

    /// The same textures of ground drawn otherwise.
    #[must_use]
    pub fn with_relief(self, relief: impl Into<Relief>) -> Self {
        Self {
            relief: relief.into(),
            ..self
        }
    }

    /// Says whether the settings can be used.
    ///
    /// # Errors
    /// [`ExportError::Width`], [`ExportError::Side`] or [`ExportError::Threads`].
    pub fn validate(&self) -> Result<(), ExportError> {
        let (width, threads) = match self.layout {
            Layout::Rectangle(width) => (width, self.threads),
            Layout::Cube(side) if Self::SIDES.contains(&side) => {
                (*Maps::WIDTHS.start(), self.threads)
            }
            Layout::Cube(side) => return Err(ExportError::Side(side)),
        };
        Maps { width, threads }.validate()
    }

    /// Writes the textures into `folder`, which is created where it does not exist, and returns their
    /// paths.
    ///
    /// # Errors
    /// [`ExportError`] names the file and the cause; nothing half-written is left behind.
    pub fn write(&self, surface: &Surface, folder: &Path) -> Result<Vec<PathBuf>, ExportError> {
        self.write_with_progress(surface, folder, |_| ())
    }

    /// As [`write`](Self::write), telling `progress` now and then which fraction is done, 0 to 1.
    ///
    /// # Errors
    /// As [`write`](Self::write).
    pub fn write_with_progress(
        &self,
        surface: &Surface,
        folder: &Path,
        mut progress: impl FnMut(f64),
    ) -> Result<Vec<PathBuf>, ExportError> {
        self.validate()?;
        let skin = Skin::new(surface, self.relief, self.threads)?;
        let mut drafts = Vec::new();
        let pictures = self.pictures();
        for (number, (chart, suffix)) in (0_u32..).zip(&pictures) {
            let mut layers = Layer::ALL
                .into_iter()
                .map(|layer| {
                    let name = format!("{}{suffix}.png", layer.name());
                    let sheet = Sheet::create(folder, &name, chart.size(), layer.format())?;
                    Ok((layer, sheet))
                })
                .collect::<Result<Vec<_>, ExportError>>()?;
            skin.paint(*chart, &mut |texels, share| {
                for (layer, sheet) in &mut layers {
                    sheet.append(&layer.encode(texels))?;
                }
                progress((f64::from(number) + share) / pictures.len() as f64);
                Ok(())
            })?;
            let finished: Result<Vec<Draft>, _> = layers
                .into_iter()
                .map(|(_, sheet)| sheet.finish())
                .collect();
            drafts.extend(finished?);
        }
        draft::publish(drafts)
    }

    /// Each picture with what its files' names have behind the layer.
    fn pictures(&self) -> Vec<(Chart, String)> {
        match self.layout {
            Layout::Rectangle(width) => vec![(Chart::Rectangle(Grid::new(width)), String::new())],
            Layout::Cube(side) => (0..)
                .zip(FACES)
                .map(|(face, name)| (Chart::Face(face, side), format!("_{name}")))
                .collect(),
        }
    }
}

#[derive(Clone, Copy)]
enum Layer {
    Elevation,
    Normal,
    Colour,
}

impl Layer {
    const ALL: [Self; 3] = [Self::Elevation, Self::Normal, Self::Colour];

    fn name(self) -> &'static str {
        match self {
            Self::Elevation => "elevation",
            Self::Normal => "normal",
            Self::Colour => "colour",
        }
    }

    fn format(self) -> Format {
        match self {
            Self::Elevation => (ColorType::Grayscale, BitDepth::Sixteen),
            Self::Normal => (ColorType::Rgb, BitDepth::Sixteen),
            Self::Colour => (ColorType::Rgb, BitDepth::Eight),
        }
    }

    fn encode(self, texels: &[Texel]) -> Vec<u8> {
        let mut bytes = Vec::with_capacity(6 * texels.len());
        for texel in texels {
            match self {
                Self::Elevation => bytes.extend(metres(texel.elevation).to_be_bytes()),
                Self::Normal => {
                    for component in texel.normal.to_array() {
                        bytes.extend(quantise((component + 1.0) * 32_767.5).to_be_bytes());
                    }
                }
                Self::Colour => bytes.extend(texel.colour),
            }
        }
        bytes
    }
}
