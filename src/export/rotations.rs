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
/// with the plate's number, the age in My before the last moment, latitude, longitude and angle in degrees of
/// the rotation that leads from the last moment back to that age, and the fixed plate, which is always
/// 0: the frame of the planet.
///
/// Numbers are ids, but one higher from 999 on, which stands for a comment there. Lines of a plate reach back
/// to when it came to be, or the recording began. Outlines of plates that no longer are rest from their
/// end on.
///
/// # Errors
/// What `writer` says.
pub fn rotations_rot(rotations: &RotationHistory, mut writer: impl Write) -> io::Result<()> {
    // 0 is no plate but the frame.
    for plate in rotations.plates().filter(|plate| plate.id != 0) {
        let number = gplates_id(plate.id);
        for total in &plate.totals {
            let (lat, lon) = lat_lon(total.rotation);
            let angle = total.rotation.length().to_degrees();
            writeln!(
                writer,
                "{number:<5} {:>12.6} {lat:>14.9} {lon:>14.9} {angle:>14.9}  000 !plate {}",
                total.age_my, plate.id
            )?;
        }
    }
    Ok(())
}

/// A plate's number in the PLATES format, where 999 is a comment.
pub(super) fn gplates_id(plate: u16) -> u32 {
    u32::from(plate) + u32::from(plate >= 999)
}

/// Writes `rotations.rot` into `folder`, which is created where it does not exist, and returns the file's
/// path. See [`rotations_rot`].
///
/// # Errors
/// [`ExportError::Write`] names the file and the cause; then it was neither written nor replaced.
pub fn write_rotations(rotations: &RotationHistory, folder: &Path) -> Result<PathBuf, ExportError> {
    let draft = Draft::create(folder, ROTATIONS_FILE)?;
    draft.fill(|pen| rotations_rot(rotations, pen))?;
    draft::publish(vec![draft])?;
    Ok(folder.join(ROTATIONS_FILE))
}
