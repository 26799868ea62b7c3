//! A cell's folder: files that appear whole or not at all, and checksums of what is in it.

use std::collections::BTreeMap;
use std::fs::{self, File};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use plan::FileFact;

use crate::RunError;

/// Writes a file so that a reader, or a crash, finds the old one or the new one and nothing between.
///
/// # Errors
/// [`RunError::Write`] with the file's name.
pub fn write_whole(path: &Path, content: &[u8]) -> Result<(), RunError> {
    let partial = path.with_extension("partial");
    let write = || -> io::Result<()> {
        let mut file = File::create(&partial)?;
        file.write_all(content)?;
        file.sync_all()?;
        fs::rename(&partial, path)?;
        // The rename itself is only safe once its folder is.
        path.parent()
            .map_or(Ok(()), |folder| File::open(folder)?.sync_all())
    };
    write().map_err(|problem| {
        let _ = fs::remove_file(&partial);
        RunError::write(path, problem)
    })
}

/// Moves a cell's folder aside, if there is one, to the first free `ID.unfinished-N` beside it: what
/// is in it is never overwritten.
///
/// # Errors
/// When it cannot be renamed.
pub fn move_aside(folder: &Path) -> io::Result<()> {
    if !folder.exists() {
        return Ok(());
    }
    // Not `with_extension`: an id may have a point in it, as in `3.3hz`.
    let beside = |n: u32| PathBuf::from(format!("{}.unfinished-{n}", folder.display()));
    let aside = (1..).map(beside).find(|aside| !aside.exists());
    aside.map_or(Ok(()), |aside| fs::rename(folder, aside))
}

/// Length and checksum of every file in `folder`, by name; `except` is left out.
///
/// # Errors
/// When a file cannot be read.
pub(crate) fn inventory(folder: &Path, except: &str) -> io::Result<BTreeMap<String, FileFact>> {
    let mut files = BTreeMap::new();
    for entry in fs::read_dir(folder)? {
        let entry = entry?;
        let name = entry.file_name().to_string_lossy().into_owned();
        if name != except && entry.file_type()?.is_file() {
            files.insert(name, FileFact::of(File::open(entry.path())?)?);
        }
    }
    Ok(files)
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    #[test]
    fn a_file_is_known_by_its_length_and_the_published_checksum_of_abc() {
        let folder = tempfile::tempdir().unwrap();
        write_whole(&folder.path().join("a"), b"abc").unwrap();
        write_whole(&folder.path().join("manifest.json"), b"{}").unwrap();
        let files = inventory(folder.path(), "manifest.json").unwrap();
        assert_eq!(files.len(), 1);
        assert_eq!(files["a"].bytes, 3);
        // FIPS 180-2, appendix B.1.
        assert_eq!(
            files["a"].sha256,
            "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad"
        );
    }

    #[test]
    fn a_folder_that_cannot_be_written_is_named_with_the_remedy() {
        let error = write_whole(Path::new("/proc/nowhere/manifest.json"), b"{}").unwrap_err();
        let text = error.to_string();
        assert!(
            text.contains("/proc/nowhere/manifest.json") && text.contains("--out"),
            "{text}"
        );
    }
}
