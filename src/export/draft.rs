//! Files that appear whole or not at all.

use std::{
    fs::{self, File},
    io::{self, Write},
    path::{Path, PathBuf},
    sync::{Arc, OnceLock},
};

use super::{
    ExportError, FILES, FILM_FILE, GEOGRAPHY_FILES, GLOBE_FILE, HISTORY_FILE, TABLE_FILES,
};

/// A file under a temporary name. Dropping it removes it; [`publish`] gives it its real name.
pub(super) struct Draft {
    temporary: PathBuf,
    target: PathBuf,
    pen: Pen,
}

/// Writes into a [`Draft`] and remembers the first failure: encoders finish in `Drop`, where errors are
/// lost.
#[derive(Clone)]
pub(super) struct Pen {
    file: Arc<File>,
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
        self.note((&*self.file).write(bytes))
    }

    fn flush(&mut self) -> io::Result<()> {
        self.note((&*self.file).flush())
    }
}

impl Draft {
    /// Starts the file that will be called `name` in `folder`, creating the folder where needed.
    pub(super) fn create(folder: &Path, name: &str) -> Result<Self, ExportError> {
        fs::create_dir_all(folder).map_err(|error| ExportError::write(folder, error))?;
        let target = folder.join(name);
        refuse_folder(&target)?;
        // The process id keeps two programs that export into one folder apart.
        let temporary = folder.join(format!(".{name}.{}.partial", std::process::id()));
        let file = File::create(&temporary).map_err(|error| ExportError::write(&target, error))?;
        let pen = Pen {
            file: Arc::new(file),
            failure: Arc::default(),
        };
        Ok(Self {
            temporary,
            target,
            pen,
        })
    }

    pub(super) fn pen(&self) -> Pen {
        self.pen.clone()
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
}

impl Drop for Draft {
    fn drop(&mut self) {
        // After publishing nothing has this name any more; otherwise nobody is left to hear a failure.
        let _ = fs::remove_file(&self.temporary);
    }
}

/// Syncs all drafts to disk and only then renames them, so that a full disk leaves none of them.
pub(super) fn publish(drafts: Vec<Draft>) -> Result<Vec<PathBuf>, ExportError> {
    for draft in &drafts {
        draft.sync()?;
    }
    let mut paths = Vec::with_capacity(drafts.len());
    for draft in &drafts {
        fs::rename(&draft.temporary, &draft.target).map_err(|error| draft.error(error))?;
        paths.push(draft.target.clone());
    }
    // The renames themselves last only once the folder is synced; not every file system can.
    #[cfg(unix)]
    if let Some(folder) = paths.first().and_then(|path| path.parent()) {
        let _ = File::open(folder).and_then(|folder| folder.sync_all());
    }
    Ok(paths)
}

/// Creates `folder` where it does not exist and tries to write a megabyte into it, so that a long run
/// does not end at a folder that is read-only or a disk that is full.
///
/// # Errors
/// [`ExportError::Write`] with the folder and the cause.
pub fn check_folder(folder: &Path) -> Result<(), ExportError> {
    let at_folder = |error: io::Error| ExportError::write(folder, error);
    fs::create_dir_all(folder).map_err(at_folder)?;
    let single = [HISTORY_FILE, FILM_FILE, GLOBE_FILE];
    let others = (single.into_iter().chain(GEOGRAPHY_FILES)).chain(TABLE_FILES);
    for name in FILES.into_iter().chain(others) {
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
        let message = check_folder(&file).unwrap_err().to_string();
        assert!(message.contains("taken"), "{message}");
        assert!(check_folder(&folder.path().join("new/deep")).is_ok());
    }
}
