//! Rotations of plates as `GPlates` reads them.

use super::{
    ExportError,
    draft::{self, Draft},
};
use crate::simulation::RotationHistory;
use crate::surface::lat_lon;
use std::{
    io::{self, Write},
    path::{Path, PathBuf},
};

/// Name of the file that [`write_rotations`] writes.
pub const ROTATIONS_FILE: &str = "rotations.rot";

/// Writes total rotations in the PLATES format (`.rot`) that `GPlates` reads: a line for each plate and age
/// with the plate's id, the age in My before the last moment, latitude, longitude and angle in degrees of
/// the rotation that leads from the last moment back to that age, and the fixed plate, which is always
/// 0: the frame of the planet.
///
/// Lines of a plate reach back to when it came to be, or the recording began. Outlines of plates that no
/// longer are rest from their end on.
///
/// # Errors
/// What `writer` says.
pub fn rotations_rot(rotations: &RotationHistory, mut writer: impl Write) -> io::Result<()> {
    for plate in rotations.plates() {
        for total in &plate.totals {
            let (lat, lon) = lat_lon(total.rotation);
            let angle = total.rotation.length().to_degrees();
            writeln!(
                writer,
                "{:<5} {:>12.6} {lat:>14.9} {lon:>14.9} {angle:>14.9}  000 !plate {}",
                plate.id, total.age_my, plate.id
            )?;
        }
    }
    Ok(())
}

/// Writes `rotations.rot` into `folder`, which is created where it does not exist, and returns the file's
/// path. See [`rotations_rot`].
///
/// # Errors
/// [`ExportError::Write`] names the file and the cause; then it was neither written nor replaced.
pub fn write_rotations(rotations: &RotationHistory, folder: &Path) -> Result<PathBuf, ExportError> {
    let draft = Draft::create(folder, ROTATIONS_FILE)?;
    let mut pen = io::BufWriter::new(draft.pen());
    rotations_rot(rotations, &mut pen)
        .and_then(|()| pen.flush())
        .map_err(|error| draft.error(error))?;
    draft::publish(vec![draft])?;
    Ok(folder.join(ROTATIONS_FILE))
}
