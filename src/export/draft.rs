//! Files that appear whole or not at all.

use super::ExportError;
use atomic_write_file::AtomicWriteFile;
use std::{
    fs::{self, File},
    io::{self, BufWriter, Write},
    path::{Path, PathBuf},
    sync::{Arc, OnceLock},
};

/// A file without a name, or under a temporary one where the system knows no such files. Dropping it
/// removes it, as does the end of the program; [`publish`] gives it its real name.
pub(super) struct Draft {
    target: PathBuf,
    pen: Pen,
}

/// Writes into a [`Draft`] and remembers the first failure: encoders finish in `Drop`, where errors are
/// lost.
#[derive(Clone)]
pub(super) struct Pen {
    file: Arc<AtomicWriteFile>,
    failure: Arc<OnceLock<io::Error>>,
}

impl Pen {
    fn note<T>(&self, result: io::Result<T>) -> io::Result<T> {
        if let Err(error) = &result
            && error.kind() != io::ErrorKind::Interrupted
        {
            // Only the first failure counts.
            let _ = self.failure.set(copy(error));
        }
        result
    }
}

impl Write for Pen {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.note(self.file.as_file().write(bytes))
    }

    fn flush(&mut self) -> io::Result<()> {
        self.note(self.file.as_file().flush())
    }
}

impl Draft {
    /// Starts the file that will be called `name` in `folder`, creating the folder where needed.
    pub(super) fn create(folder: &Path, name: &str) -> Result<Self, ExportError> {
        fs::create_dir_all(folder).map_err(|error| ExportError::write(folder, error))?;
        let target = folder.join(name);
        refuse_folder(&target)?;
        let file =
            AtomicWriteFile::open(&target).map_err(|error| ExportError::write(&target, error))?;
        let pen = Pen {
            file: Arc::new(file),
            failure: Arc::default(),
        };
        Ok(Self { target, pen })
    }

    pub(super) fn pen(&self) -> Pen {
        self.pen.clone()
    }

    /// Has the whole file written.
    pub(super) fn fill(
        &self,
        write: impl FnOnce(&mut BufWriter<Pen>) -> io::Result<()>,
    ) -> Result<(), ExportError> {
        let mut writer = BufWriter::new(self.pen());
        write(&mut writer)
            .and_then(|()| writer.flush())
            .map_err(|error| self.error(error))
    }

    pub(super) fn error(&self, source: impl Into<io::Error>) -> ExportError {
        ExportError::write(&self.target, source)
    }

    fn sync(&self) -> Result<(), ExportError> {
        if let Some(failure) = self.pen.failure.get() {
            return Err(self.error(copy(failure)));
        }
        self.pen.file.sync_all().map_err(|error| self.error(error))
    }

    fn publish(self) -> Result<PathBuf, ExportError> {
        let Self { target, pen } = self;
        let whole = Arc::into_inner(pen.file)
            .ok_or_else(|| io::Error::other("somebody still writes to it"))
            .and_then(AtomicWriteFile::commit);
        whole.map_err(|error| ExportError::write(&target, error))?;
        Ok(target)
    }
}

/// Syncs all drafts to disk and only then names them, so that a full disk leaves none of them.
pub(super) fn publish(drafts: Vec<Draft>) -> Result<Vec<PathBuf>, ExportError> {
    for draft in &drafts {
        draft.sync()?;
    }
    drafts.into_iter().map(Draft::publish).collect()
}

/// Creates `folder` where it does not exist and tries to write a megabyte into it, so that a long run
/// does not end at a folder that is read-only or a disk that is full, or at a folder that has the name of
/// one of `files`.
///
/// # Errors
/// [`ExportError::Write`] with the folder and the cause.
pub fn check_folder<'a>(
    folder: &Path,
    files: impl IntoIterator<Item = &'a str>,
) -> Result<(), ExportError> {
    let at_folder = |error: io::Error| ExportError::write(folder, error);
    fs::create_dir_all(folder).map_err(at_folder)?;
    for name in files {
        refuse_folder(&folder.join(name))?;
    }
    let probe = folder.join(format!(".probe.{}.partial", std::process::id()));
    let written = File::create(&probe).and_then(|mut file| {
        file.write_all(&vec![0x55; 1 << 20])?;
        file.sync_all()
    });
    let removed = if probe.exists() {
        fs::remove_file(&probe)
    } else {
        Ok(())
    };
    written.and(removed).map_err(at_folder)
}

/// A folder cannot be replaced by a file; better found before the first rename than between two.
fn refuse_folder(target: &Path) -> Result<(), ExportError> {
    if target.is_dir() {
        let error = io::Error::new(
            io::ErrorKind::IsADirectory,
            "there is a folder of that name",
        );
        return Err(ExportError::write(target, error));
    }
    Ok(())
}

/// `io::Error` is not `Clone`; the operating system's code carries the whole message.
fn copy(error: &io::Error) -> io::Error {
    error.raw_os_error().map_or_else(
        || io::Error::new(error.kind(), error.to_string()),
        io::Error::from_raw_os_error,
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_draft_leaves_nothing_unless_published() {
        let folder = tempfile::tempdir().unwrap();
        let draft = Draft::create(folder.path(), "a.txt").unwrap();
        draft.pen().write_all(b"half").unwrap();
        drop(draft);
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);

        let draft = Draft::create(folder.path(), "a.txt").unwrap();
        draft.pen().write_all(b"whole").unwrap();
        let paths = publish(vec![draft]).unwrap();
        assert_eq!(paths, [folder.path().join("a.txt")]);
        assert_eq!(fs::read(&paths[0]).unwrap(), b"whole");
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
    }

    #[test]
    fn a_folder_that_is_a_file_is_refused_by_name() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("taken");
        fs::write(&file, b"").unwrap();
        let message = check_folder(&file, []).unwrap_err().to_string();
        assert!(message.contains("taken"), "{message}");
        assert!(check_folder(&folder.path().join("new/deep"), []).is_ok());
    }
}
