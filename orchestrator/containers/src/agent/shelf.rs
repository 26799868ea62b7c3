//! A run's folder as an orchestrator sees it: plain files, read in parts.
//!
//! These calls wait for the disk, so they belong on a thread that may block.

use std::collections::BTreeMap;
use std::fs::{self, File};
use std::io::{self, Read, Seek, SeekFrom};
use std::path::Path;

use crate::agent::refusal::Refusal;
use crate::name::Name;
use crate::wire::PART_BYTES;

/// A part of a file, and the length of the whole.
#[derive(Debug, PartialEq, Eq)]
pub(crate) struct Part {
    pub(crate) bytes: Vec<u8>,
    pub(crate) size: u64,
}

/// Makes an empty folder, wiping what was there.
pub(crate) fn make_empty(folder: &Path) -> io::Result<()> {
    wipe(folder)?;
    fs::create_dir_all(folder)
}

/// Removes a folder with all its files; a missing folder is fine.
pub(crate) fn wipe(folder: &Path) -> io::Result<()> {
    match fs::remove_dir_all(folder) {
        Err(problem) if problem.kind() != io::ErrorKind::NotFound => Err(problem),
        _ => Ok(()),
    }
}

/// Name and length of each file.
pub(crate) fn list(folder: &Path) -> io::Result<BTreeMap<String, u64>> {
    let mut files = BTreeMap::new();
    for entry in fs::read_dir(folder)? {
        let entry = entry?;
        let name = entry.file_name().to_string_lossy().into_owned();
        if name.parse::<Name>().is_err() || !entry.file_type()?.is_file() {
            continue;
        }
        match entry.metadata() {
            Ok(meta) => files.insert(name, meta.len()),
            // Renamed since it was listed; the orchestrator will ask again.
            Err(problem) if problem.kind() == io::ErrorKind::NotFound => None,
            Err(problem) => return Err(problem),
        };
    }
    Ok(files)
}

/// Reads a file from byte `from` to its present end, but no more than one answer can carry.
pub(crate) fn read(folder: &Path, name: &Name, from: u64) -> Result<Part, Refusal> {
    let mut file = match File::open(folder.join(name.as_str())) {
        Err(problem) if problem.kind() == io::ErrorKind::NotFound => {
            return Err(Refusal::File(name.clone()));
        }
        file => file?,
    };
    let meta = file.metadata()?;
    if !meta.is_file() {
        return Err(Refusal::File(name.clone()));
    }
    let size = meta.len();
    if from > size {
        return Err(Refusal::Range(name.clone(), size));
    }
    file.seek(SeekFrom::Start(from))?;
    let mut bytes = Vec::new();
    file.take(PART_BYTES.min(size - from))
        .read_to_end(&mut bytes)?;
    Ok(Part { bytes, size })
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    #[test]
    fn a_large_file_comes_in_parts_that_make_the_whole() {
        let folder = tempfile::tempdir().unwrap();
        let name: Name = "rows.csv".parse().unwrap();
        let whole: Vec<u8> = (0..2 * PART_BYTES + 7).map(|n| (n % 251) as u8).collect();
        fs::write(folder.path().join(name.as_str()), &whole).unwrap();
        let mut got = Vec::new();
        loop {
            let part = read(folder.path(), &name, got.len() as u64).unwrap();
            assert_eq!(part.size, whole.len() as u64);
            if part.bytes.is_empty() {
                break;
            }
            got.extend(part.bytes);
        }
        assert!(got == whole);
        let past = read(folder.path(), &name, whole.len() as u64 + 1);
        assert!(matches!(past, Err(Refusal::Range(_, size)) if size == whole.len() as u64));
    }

    #[test]
    fn only_plain_files_are_shown() {
        let folder = tempfile::tempdir().unwrap();
        fs::create_dir(folder.path().join("folder")).unwrap();
        fs::write(folder.path().join(".hidden"), "x").unwrap();
        std::os::unix::fs::symlink("/etc/passwd", folder.path().join("link")).unwrap();
        fs::write(folder.path().join("ticks.csv"), "abc").unwrap();
        let files = list(folder.path()).unwrap();
        assert_eq!(files, BTreeMap::from([("ticks.csv".to_owned(), 3)]));
        let sub = read(folder.path(), &"folder".parse().unwrap(), 0);
        assert!(matches!(sub, Err(Refusal::File(_))));
    }
}
