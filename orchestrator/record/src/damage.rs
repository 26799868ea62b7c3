//! A file that is not as its manifest or its plan says, and how that is found.

use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use crate::fact::{FileFact, OTHER_BYTES, other_length};
use crate::file;
use crate::manifest::{Manifest, Unreadable};
use crate::rows::ReadError;

/// A file that does not match its manifest, or a manifest that does not match its plan.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{}: {problem}", path.display())]
pub struct Damage {
    /// The file.
    pub path: PathBuf,
    /// What is wrong with it.
    pub problem: String,
}

impl Damage {
    /// The damaged files in a cell's folder, among those that its manifest lists.
    #[must_use]
    pub fn of(folder: &Path, manifest: &Manifest) -> Vec<Damage> {
        Damage::among(folder, manifest, |_| true)
    }

    /// The damaged files among those that the manifest lists and that `is_asked` for.
    #[must_use]
    pub fn among(
        folder: &Path,
        manifest: &Manifest,
        is_asked: impl Fn(&str) -> bool,
    ) -> Vec<Damage> {
        let asked = manifest.files.iter().filter(|(name, _)| is_asked(name));
        asked
            .filter_map(|(name, fact)| {
                let path = folder.join(name);
                let problem = problem(&path, fact)?;
                Some(Damage { path, problem })
            })
            .collect()
    }
}

impl From<ReadError> for Damage {
    fn from(error: ReadError) -> Self {
        let (path, problem) = error.parts();
        Damage { path, problem }
    }
}

impl From<Unreadable> for Damage {
    fn from(unreadable: Unreadable) -> Self {
        let (path, problem) = match unreadable {
            Unreadable::Closed { path, problem } => (path, problem.to_string()),
            Unreadable::Unknown { path, problem } => (path, problem.to_string()),
        };
        Damage { path, problem }
    }
}

/// What is wrong with a file, compared with its length and checksum in the manifest; `None` if
/// nothing is.
fn problem(path: &Path, asked: &FileFact) -> Option<String> {
    let found = file::open(path).and_then(|file| {
        // The length is compared first: a sparse file can be too long to read.
        let bytes = file.metadata()?.len();
        if bytes == asked.bytes {
            FileFact::of(file).map(Ok)
        } else {
            Ok(Err(bytes))
        }
    });
    match found {
        Ok(Ok(found)) if found == *asked => None,
        Ok(Ok(found)) if found.bytes == asked.bytes => Some(OTHER_BYTES.to_owned()),
        Ok(Ok(FileFact { bytes, .. }) | Err(bytes)) => Some(other_length(bytes, asked)),
        Err(problem) if problem.kind() == ErrorKind::NotFound => Some("it is gone".to_owned()),
        Err(problem) => Some(problem.to_string()),
    }
}
