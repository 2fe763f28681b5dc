//! Starts from files: height maps as PNG, outlines of plates as `GeoJSON`, their motions as JSON.
//!
//! [`begin`] starts the history of any recipe, with the files it names. Planets in a game do so by
//! themselves. [`read`] stops half-way, with plain data that can be changed before it goes to
//! [`History::imported`]. [`ImageStart`] says what the files must be.

mod heights;
mod plates;

use crate::simulation::{History, ImageStart, ImportedWorld, Recipe, Start, TectonicError};
use bevy::app::PluginGroup;
use std::{fs, path::Path};

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
    image.validate()?;
    let mut plates = Vec::new();
    if let Some(path) = &image.plate_polygons {
        plates = plates::polygons(path)?;
        if let Some(path) = &image.plate_rotations {
            plates::turn(path, &mut plates)?;
        }
    }
    let world = ImportedWorld {
        heights: heights::read(image)?,
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

/// The text of a file.
fn text(path: &str, allowed: &str) -> Result<String, TectonicError> {
    fs::read_to_string(path).map_err(|error| {
        TectonicError::import(path, format!("it cannot be read ({error})"), allowed)
    })
}
