//! Starts from files: height maps as PNG, outlines of plates as `GeoJSON`, their motions as JSON.
//!
//! [`begin`] starts the history of any recipe, with the files it names. Planets in a game do so by
//! themselves. [`read`] stops half-way, with plain data that can be changed before it goes to
//! [`History::imported`], and [`read_with`] takes the files from wherever a game keeps them. [`ImageStart`]
//! says what the files must be.
//!
//! Files are not trusted: sizes are verified before anything is allocated, and whoever names a device or a
//! pipe in a recipe is refused.

mod heights;
mod plates;

use crate::simulation::{History, ImageStart, ImportedWorld, Recipe, Start, TectonicError};
use bevy::app::PluginGroup;
use std::{
    fs::{self, File},
    io::{self, BufRead, BufReader, Read, Seek},
    path::Path,
};

/// Largest text that is read, in bytes: the outlines of Earth's plates take one million.
const LONGEST_TEXT: u64 = 32 << 20;

/// Starts the history of a recipe; one with [`Start::Image`] from its files.
///
/// # Errors
/// As [`History::new`] and [`read`].
pub fn begin(recipe: Recipe, plugins: impl PluginGroup) -> Result<History, TectonicError> {
    recipe.validate()?;
    match &recipe.start {
        Start::Image(image) => {
            let world = read(image)?;
            History::imported(recipe, world, plugins)
        }
        _ => History::with_plugins(recipe, plugins),
    }
}

/// Reads the files of an imported start.
///
/// # Errors
/// [`TectonicError::Recipe`] for figures outside their range, [`TectonicError::Import`] with the file, what is wrong
/// with it and what is allowed.
pub fn read(image: &ImageStart) -> Result<ImportedWorld, TectonicError> {
    read_with(image, open)
}

/// Reads the files of an imported start with `open`, which is asked for each by its name.
///
/// ```
/// use bevy_tectonics::{import, simulation::ImageStart};
/// use std::io::Cursor;
///
/// let image = ImageStart { heights: "earth.png".into(), ..ImageStart::default() };
/// let error = import::read_with(&image, |_| Ok(Cursor::new(b"no picture"))).unwrap_err();
/// assert!(error.to_string().contains("earth.png"));
/// ```
///
/// # Errors
/// As [`read`].
pub fn read_with<R: BufRead + Seek>(
    image: &ImageStart,
    mut open: impl FnMut(&str) -> io::Result<R>,
) -> Result<ImportedWorld, TectonicError> {
    image.validate()?;
    let mut plates = Vec::new();
    if let Some(path) = &image.plate_polygons {
        plates = plates::polygons(path, &text(path, plates::OUTLINES, &mut open)?)?;
        if let Some(path) = &image.plate_rotations {
            plates::turn(
                path,
                &text(path, plates::ROTATIONS, &mut open)?,
                &mut plates,
            )?;
        }
    }
    let world = ImportedWorld {
        heights: heights::read(image, &mut open)?,
        plates,
    };
    world.validate().map_err(|error| match error {
        TectonicError::Import {
            what,
            found,
            allowed,
        } => TectonicError::Import {
            what: format!(
                "{}, {what}",
                image.plate_polygons.as_deref().unwrap_or_default()
            ),
            found,
            allowed,
        },
        other => other,
    })?;
    Ok(world)
}

/// The same start with relative paths led to a folder, such as that of the recipe, where the files lie
/// there. Other paths stay as they are.
#[must_use]
pub fn beside(folder: &Path, image: &ImageStart) -> ImageStart {
    let lead = |path: &String| {
        let beside = folder.join(path);
        if !path.is_empty() && beside.is_file() {
            beside.to_string_lossy().into_owned()
        } else {
            path.clone()
        }
    };
    ImageStart {
        heights: lead(&image.heights),
        plate_polygons: image.plate_polygons.as_ref().map(lead),
        plate_rotations: image.plate_rotations.as_ref().map(lead),
        ..image.clone()
    }
}

/// Opens a file on the disk. To open a pipe may take for ever, to read a device as well.
fn open(path: &str) -> io::Result<BufReader<File>> {
    if !fs::metadata(path)?.is_file() {
        return Err(io::Error::new(
            io::ErrorKind::InvalidInput,
            "it is not a regular file",
        ));
    }
    File::open(path).map(BufReader::new)
}

/// The text of a file.
fn text<R: Read>(
    path: &str,
    allowed: &str,
    open: &mut impl FnMut(&str) -> io::Result<R>,
) -> Result<String, TectonicError> {
    let refuse = |found: String| TectonicError::import(path, found, allowed);
    let cannot = |error: io::Error| refuse(format!("it cannot be read ({error})"));
    let mut text = String::new();
    let file = open(path).map_err(cannot)?;
    let length = file
        .take(LONGEST_TEXT + 1)
        .read_to_string(&mut text)
        .map_err(cannot)?;
    if length as u64 > LONGEST_TEXT {
        return Err(refuse(format!("it is longer than {LONGEST_TEXT} bytes")));
    }
    Ok(text)
}

/// What is wrong with a text of JSON.
fn fault(error: &serde_json::Error) -> String {
    if error.is_eof() {
        format!("it ends too early ({error})")
    } else {
        format!("it cannot be read ({error})")
    }
}
