//! What can be wrong with a save, in one sentence each, with the place in the file.

use crate::simulation::TectonicError;
use std::{io, path::PathBuf};
use thiserror::Error;

/// Why a planet could not be saved or loaded.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum SaveError {
    /// A file could not be read or written. A save that was there before is still there, whole.
    #[error("{}: {source}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// What the operating system says.
        source: io::Error,
    },
    /// The bytes are no save at all.
    #[error("this is no saved planet: it begins with {found:02x?} instead of \"TECTONIC\"")]
    Foreign {
        /// The first bytes, up to eight.
        found: Vec<u8>,
    },
    /// The save is of a version that this program does not know.
    #[error("the save is of version {found}, and this program reads versions 1 to {newest}")]
    Version {
        /// Version of the save.
        found: u32,
        /// Newest version that can be read.
        newest: u32,
    },
    /// The end of the save is missing.
    #[error("the save ends after {found} bytes of {expected}")]
    Truncated {
        /// Length in bytes.
        found: u64,
        /// Length that it says it has, in bytes.
        expected: u64,
    },
    /// Bytes of the save have changed since it was written, or make no sense.
    #[error(
        "the save is damaged in its section \"{section}\", which begins at byte {offset}: {what}"
    )]
    Damaged {
        /// Name of the section.
        section: String,
        /// Where the section begins, in bytes from the beginning.
        offset: u64,
        /// What is wrong with it.
        what: String,
    },
    /// Something is too large to be stored.
    #[error("{what} takes {bytes} bytes, and may take at most {most}")]
    TooLarge {
        /// What.
        what: String,
        /// Its size in bytes.
        bytes: usize,
        /// Largest size in bytes.
        most: usize,
    },
    /// A component of your own could not be written.
    #[error("component \"{name}\" cannot be saved: {what}")]
    Component {
        /// Its [`NAME`](super::SavedComponent::NAME).
        name: String,
        /// What its serialisation says.
        what: String,
    },
    /// A planet in a game failed or was replaced before it was saved, or reading a file panicked.
    #[error("the planet is gone, or a stage of the simulation has panicked")]
    Failed,
    /// The world is in no state to be saved, or the recipe is not allowed any more.
    #[error(transparent)]
    Tectonic(#[from] TectonicError),
}

/// A fault somewhere in a section, before it is known where that lies.
pub(super) type Fault = String;
