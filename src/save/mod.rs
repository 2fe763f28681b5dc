//! Planets that last: a history as bytes, at any step, and back to the same bits.
//!
//! [`write()`] and [`read`] are for files, [`to_bytes`] and [`from_bytes`] for everything else. A loaded history
//! goes on exactly as the saved one would have: [`History::state_hash`] is the same after every further step,
//! on any number of threads.
//!
//! ```
//! use bevy_tectonics::{prelude::*, save};
//!
//! let mut history = History::new(Recipe::earth_like(7).with_sub_plates(500))?;
//! history.step()?;
//! let bytes = save::to_bytes(&mut history)?;
//! let mut loaded = save::from_bytes(&bytes, SimulationPlugins)?;
//! history.step()?;
//! loaded.step()?;
//! assert_eq!(loaded.state_hash()?, history.state_hash()?);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # What is in a save
//!
//! Everything that a step reads: the recipe with its events, clock, plates, contacts, hot spots, mantle, sea,
//! ledger, the statistics over time, every column of the sub-plates and the mesh with all its numbers; some 40
//! bytes for each sub-plate. Components of your own come along if they are [`SavedComponent`]s; resources of
//! your own do not. Stages are code: load with those that the planet was saved with.
//!
//! # What can go wrong
//!
//! Saves are not trusted. Lengths are verified before anything is allocated, every section has a checksum, and
//! what a step could not start from is refused: a [`SaveError`] tells files that are cut short, damaged, of a
//! later version or of another kind apart. A file is replaced only by a complete one, so a crash or a full
//! disk leaves the old one whole.
//!
//! Versions of this crate read the saves of all earlier ones. They need not grow the same planet from then on:
//! the recipe's laws are kept, but stages may have been improved.

mod component;
mod container;
mod error;
mod numbers;
mod planet;
mod sites;
mod text;
mod validate;

pub use component::{SavedComponent, SavedComponentPlugin};
pub use error::SaveError;

use crate::simulation::History;
use atomic_write_file::AtomicWriteFile;
use bevy::app::PluginGroup;
use std::{fs, io, io::Write, path::Path};

/// A history as bytes, between two steps.
///
/// # Errors
/// [`SaveError::Tectonic`] if the sub-plates no longer lie in one table, [`SaveError::Component`] and
/// [`SaveError::TooLarge`] for what cannot be stored.
pub fn to_bytes(history: &mut History) -> Result<Vec<u8>, SaveError> {
    let checkpoint = history.checkpoint()?;
    let mut sections = Vec::new();
    for (name, bytes) in planet::pack(&checkpoint)? {
        sections.push((name.to_owned(), bytes));
    }
    sections.extend(component::pack(history.world_mut())?);
    Ok(container::assemble(&sections))
}

/// A history from bytes, with the stages that are to go on.
///
/// # Errors
/// Everything that [`SaveError`] names but [`SaveError::Io`].
pub fn from_bytes(bytes: &[u8], plugins: impl PluginGroup) -> Result<History, SaveError> {
    let sections = container::open(bytes)?;
    let checkpoint = planet::unpack(&sections)?;
    let mut history = History::resume(checkpoint, plugins)?;
    component::unpack(history.world_mut(), &sections)?;
    Ok(history)
}

/// Writes a history to a file. What was there before stays until the new save is complete and on the disk.
///
/// # Errors
/// As [`to_bytes`], and [`SaveError::Io`] if the file cannot be written.
pub fn write(history: &mut History, path: &Path) -> Result<(), SaveError> {
    let bytes = to_bytes(history)?;
    let replace = || -> io::Result<()> {
        let mut file = AtomicWriteFile::open(path)?;
        file.write_all(&bytes)?;
        file.commit()
    };
    replace().map_err(|source| SaveError::Io {
        path: path.into(),
        source,
    })
}

/// Reads a history from a file, with the stages that are to go on.
///
/// # Errors
/// As [`from_bytes`], and [`SaveError::Io`] if the file cannot be read.
pub fn read(path: &Path, plugins: impl PluginGroup) -> Result<History, SaveError> {
    let bytes = bytes_of(path).map_err(|source| SaveError::Io {
        path: path.into(),
        source,
    })?;
    from_bytes(&bytes, plugins)
}

/// Largest save that is read, in bytes: two million sub-plates take a tenth of it.
const LARGEST: u64 = 1 << 30;

/// What a file holds. To open a pipe may take for ever, to read a device as well.
fn bytes_of(path: &Path) -> io::Result<Vec<u8>> {
    let metadata = fs::metadata(path)?;
    let refuse = |what| Err(io::Error::new(io::ErrorKind::InvalidInput, what));
    if !metadata.is_file() {
        return refuse("it is not a regular file");
    }
    if metadata.len() > LARGEST {
        return refuse("it is larger than a gigabyte");
    }
    fs::read(path)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simulation::{Recipe, SimulationPlugins, streams};
    use rand::RngExt;

    /// Seals a file whose record says something else.
    fn with_record(file: &[u8], change: impl Fn(String) -> String) -> Vec<u8> {
        let sections = container::open(file).unwrap();
        let sections: Vec<(String, Vec<u8>)> = sections
            .iter()
            .map(|section| {
                let mut bytes = section.bytes.to_vec();
                if section.name == planet::RECORD {
                    let record = text::inflate(&bytes, 1 << 20).unwrap();
                    let record = change(String::from_utf8(record).unwrap());
                    bytes = text::deflate(record.as_bytes());
                }
                (section.name.to_owned(), bytes)
            })
            .collect();
        container::assemble(&sections)
    }

    #[test]
    fn small_files_do_not_claim_much_memory() {
        let mut history = History::new(Recipe::earth_like(3).with_sub_plates(300)).unwrap();
        let file = to_bytes(&mut history).unwrap();
        let load = |change: &dyn Fn(String) -> String| {
            from_bytes(&with_record(&file, change), SimulationPlugins).map(|_| ())
        };
        load(&|record| record).unwrap();
        let moments = format!("moments:[{}]", "(),".repeat(200_000));
        for (from, to) in [
            ("moments:[]", moments.as_str()),
            ("sub_plates:300,edge", "sub_plates:600,edge"),
            ("edge_slots:894", "edge_slots:5000"),
            ("steps:0", "steps:18446744073709551615"),
            ("waited:0.0", "waited:-5.0"),
        ] {
            let change = |record: String| {
                assert!(record.contains(from), "{from} in {record}");
                record.replacen(from, to, 1)
            };
            let error = load(&change).unwrap_err().to_string();
            assert!(error.contains("\"record\""), "{from}: {error}");
        }
    }

    /// How many mutations the test below tries; many more are worth an hour now and then.
    fn tries() -> u64 {
        let wanted = std::env::var("BEVY_TECTONICS_MUTATIONS");
        wanted
            .ok()
            .and_then(|wanted| wanted.parse().ok())
            .unwrap_or(3_000)
    }

    /// Checksums find accidents. Here somebody has sealed the file again after changing what is in it: what
    /// loads then must be a planet that can be stepped, or fail to, without a panic.
    #[test]
    fn files_that_lie_are_refused_or_grow() {
        let mut history = History::new(Recipe::earth_like(3).with_sub_plates(300)).unwrap();
        for _ in 0..30 {
            history.step().unwrap();
        }
        let file = to_bytes(&mut history).unwrap();
        let sections = container::open(&file).unwrap();
        let whole: Vec<(String, Vec<u8>)> = sections
            .iter()
            .map(|section| {
                // The record is text inside.
                let bytes = if section.name == planet::RECORD {
                    text::inflate(section.bytes, 1 << 20).unwrap()
                } else {
                    section.bytes.to_vec()
                };
                (section.name.to_owned(), bytes)
            })
            .collect();
        let mut loaded = 0;
        for number in 0..tries() {
            let mut rng = streams::stream(number, streams::Purpose::Events, 0, 0);
            let mut sections = whole.clone();
            let which = rng.random_range(0..sections.len());
            let bytes = &mut sections[which].1;
            for _ in 0..rng.random_range(1..4) {
                let at = rng.random_range(0..bytes.len());
                match rng.random_range(0..5) {
                    0 => bytes[at] = rng.random(),
                    1 => bytes[at] ^= 1 << rng.random_range(0..8),
                    2 => bytes.truncate(at.max(1)),
                    3 => bytes.insert(at, rng.random()),
                    // A figure of another size, where there is one.
                    _ => bytes[at] = b'0' + rng.random_range(0..10_u8),
                }
            }
            for (name, bytes) in &mut sections {
                if name == planet::RECORD {
                    *bytes = text::deflate(bytes);
                }
            }
            let Ok(mut history) = from_bytes(&container::assemble(&sections), SimulationPlugins)
            else {
                continue;
            };
            loaded += 1;
            for _ in 0..3 {
                if history.step().is_err() {
                    break;
                }
            }
        }
        // Some changes mean nothing, or another planet: both kinds of answer have been seen.
        assert!(loaded > 0 && loaded < tries(), "{loaded}");
    }
}
