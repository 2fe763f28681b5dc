//! A planet as files: six data maps, one map for people, a summary, and what other programs read.
//!
//! | file | content |
//! |---|---|
//! | `elevation.png` | 16-bit grey, metres above sea level + 32768 |
//! | `crust.png` | 8-bit grey, 0 oceanic, 255 continental |
//! | `age.png` | 16-bit grey, crust age in 0.1 My, saturating |
//! | `plate.png` | 16-bit grey, plate id (0 = none) |
//! | `velocity_east.png`, `velocity_north.png` | 16-bit grey, 0.01 mm/yr + 32768 |
//! | `map.png` | for people: coloured relief with hill shading, sea and plate boundaries |
//! | `planet.json` | the [`Summary`]: recipe, statistics, ledger, costs |
//! | `history.csv` | on request, by [`write_history`]: the statistics over time |
//!
//! Maps are equirectangular, W × W/2 pixels. The centre of pixel (x, y) lies at longitude
//! −180 + (x + ½)·360/W and latitude 90 − (y + ½)·180/H degrees. These formats are a promise: programs
//! outside this crate read them.
//!
//! Files appear whole or not at all: each is written without a name, synced, and named only once all of
//! them are complete. The bytes depend on the planet and the width, never on the number of
//! threads.
//!
//! [`write_planet`] exports a history; [`Maps::write`] only a [`Surface`].
//!
//! # For other programs
//!
//! | files | by |
//! |---|---|
//! | heights, normals and colours as a rectangle or a cube map | [`Textures`] |
//! | `planet.glb`: a glTF model | [`Globe`] |
//! | `sub_plates.csv`, `plates.csv` | [`write_tables`] |
//! | `plates.geojson`, `boundaries.geojson`, `poles.geojson`, `rotations.rot` | [`write_geography`] |
//! | `rotations.rot` of a whole history, for `GPlates` | [`write_rotations`] |
//! | `map_0000.png` and on, `history.png` that moves | [`Maps::write_frame`], [`Film`] |

mod chart;
mod draft;
mod film;
mod geography;
mod globe;
mod grid;
mod history;
mod maps;
mod relief;
mod rotations;
mod sheet;
mod skin;
mod summary;
mod tables;
mod textures;

use std::{
    io,
    path::{Path, PathBuf},
};

pub use draft::check_folder;
pub use film::{FILM_FILE, Film};
pub use geography::{
    GEOGRAPHY_FILES, boundaries_geojson, plates_geojson, poles_geojson, write_geography,
};
pub use globe::{GLOBE_FILE, Globe};
pub use history::{HISTORY_FILE, history_csv, write_history};
pub use maps::Maps;
pub use rotations::{ROTATIONS_FILE, rotations_rot, write_rotations};
pub use summary::{Seconds, Summary};
pub use tables::{TABLE_FILES, plates_csv, sub_plates_csv, write_tables};
pub use textures::{Layout, Textures};

use crate::simulation::{History, Surface, TectonicError};
use crate::surface::{SurfaceError, check_columns};

/// Names of the files that [`write_planet`] writes.
pub const FILES: [&str; 8] = [
    "elevation.png",
    "crust.png",
    "age.png",
    "plate.png",
    "velocity_east.png",
    "velocity_north.png",
    "map.png",
    "planet.json",
];

/// Why maps could not be written.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ExportError {
    /// The width is odd or outside [`Maps::WIDTHS`].
    #[error("the map width is {0}, but must be an even number from 16 to 16384")]
    Width(u32),
    /// The number of texels along an edge of a cube is outside [`Textures::SIDES`].
    #[error("the side of a cube is {0} texels, but must be from 8 to 8192")]
    Side(u32),
    /// The number of texels along an edge of a globe is outside [`Globe::SIDES`].
    #[error("the side of a globe is {0} texels, but must be from 8 to 4096")]
    GlobeSide(u32),
    /// The number of quads along an edge of a globe is outside [`Globe::QUADS`].
    #[error("the number of quads along an edge of a globe is {0}, but must be from 1 to 1024")]
    Quads(u32),
    /// The width of a film is outside [`Film::WIDTHS`].
    #[error("the width of a film is {0}, but must be an even number from 16 to 4096")]
    FilmWidth(u32),
    /// The number of pictures is not what the film was begun with, or outside [`Film::PICTURES`].
    #[error(
        "the film has {0} pictures, but must have as many as it was begun with, from 1 to 10000"
    )]
    Pictures(u32),
    /// The number of threads is outside [`Maps::THREADS`].
    #[error("the number of threads is {0}, but must be from 1 to 256")]
    Threads(usize),
    /// A file or folder could not be written; nothing half-written is left behind.
    #[error("cannot write {}: {source}", path.display())]
    Write {
        /// The file or folder.
        path: PathBuf,
        /// What the operating system, or the encoder, said.
        source: io::Error,
    },
    /// A surface that was changed holds what is no number.
    #[error("the surface has values of {field} that are not finite")]
    NotFinite {
        /// The column.
        field: &'static str,
    },
    /// The surface cannot be sampled.
    #[error(transparent)]
    Surface(#[from] SurfaceError),
    /// The history could not be read.
    #[error(transparent)]
    History(#[from] TectonicError),
}

/// What every program may rely on: a value for each sub-plate, and none that is no number.
fn check_surface(surface: &Surface) -> Result<(), ExportError> {
    check_columns(surface)?;
    for (field, expected, found) in [
        ("thickness", surface.plate.len(), surface.thickness.len()),
        (
            "volcanism age",
            surface.plate.len(),
            surface.volcanism_age.len(),
        ),
    ] {
        if found != expected {
            return Err(SurfaceError {
                field,
                found,
                expected,
            }
            .into());
        }
    }
    let are_numbers = |column: &[f32]| column.iter().all(|value| value.is_finite());
    let fields = [
        ("elevation", are_numbers(&surface.elevation)),
        ("thickness", are_numbers(&surface.thickness)),
        ("age", are_numbers(&surface.age)),
        ("orogeny age", are_numbers(&surface.orogeny_age)),
        ("velocity", surface.velocity.iter().all(|v| v.is_finite())),
        (
            "rotations",
            surface.rotations.iter().all(|r| r.1.is_finite()),
        ),
    ];
    match fields.into_iter().find(|&(_, is_finite)| !is_finite) {
        Some((field, _)) => Err(ExportError::NotFinite { field }),
        None => Ok(()),
    }
}

impl ExportError {
    fn write(path: &Path, source: impl Into<io::Error>) -> Self {
        Self::Write {
            path: path.to_owned(),
            source: source.into(),
        }
    }
}

/// Writes all maps and `planet.json` of a history's present state into `folder`, which is created where
/// it does not exist, and returns the paths of the files.
///
/// `total_seconds` is the wall time the history has cost, as the caller measured it; it goes into the
/// summary beside the stages' own.
///
/// # Errors
/// [`ExportError`] names the file and the cause. Then none of the files was written or replaced, unless
/// the operating system fails between two renames.
pub fn write_planet(
    history: &mut History,
    total_seconds: f64,
    folder: &Path,
    maps: &Maps,
) -> Result<Vec<PathBuf>, ExportError> {
    let surface = history.surface()?;
    let mut drafts = maps.draft(&surface, folder, &mut |_| ())?;
    drafts.push(Summary::new(history, &surface, total_seconds)?.draft(folder)?);
    draft::publish(drafts)
}
