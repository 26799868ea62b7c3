//! A cell's folder while it is written: who may write it, how its files are written whole or not at all, and the
//! checksums of what is in it.

use std::collections::BTreeMap;
use std::fs::{self, File};
use std::io;
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};

use plan::Verdict;
use rustix::fs::{FlockOperation, Mode, OFlags, flock};
use rustix::io::Errno;

use crate::fact::FileFact;
use crate::file;
use crate::manifest::Manifest;

/// Why a folder of results cannot be written.
#[derive(Debug, thiserror::Error)]
pub enum Unwritable {
    /// A file of it could not be written.
    #[error("cannot write {path}: {problem}; free space or choose another folder with --out")]
    Failed {
        /// The file or folder.
        path: String,
        /// The error of the operating system.
        problem: io::Error,
    },
    /// Another process runs the cell in it.
    #[error(
        "{0} is in use by another run of this cell; let it end, or choose another folder with --out"
    )]
    InUse(String),
}

impl Unwritable {
    /// The operating system's refusal to write `path`.
    #[must_use]
    pub fn failed(path: &Path, problem: io::Error) -> Self {
        Unwritable::Failed {
            path: path.display().to_string(),
            problem,
        }
    }
}

/// Writes a file atomically: a reader, also after a crash, finds the old file or the new one, and
/// nothing between.
///
/// # Errors
/// [`Unwritable::Failed`] with the file's name.
pub fn write_whole(path: &Path, content: &[u8]) -> Result<(), Unwritable> {
    file::write_durably(path, content).map_err(|problem| Unwritable::failed(path, problem))
}

/// Writes a file of a running cell. A reader finds nothing or the whole file; [`sync`] brings it onto the disk.
///
/// # Errors
/// [`Unwritable::Failed`] with the file's name.
pub fn write(path: &Path, content: &[u8]) -> Result<(), Unwritable> {
    file::write(path, content).map_err(|problem| Unwritable::failed(path, problem))
}

/// Moves a cell's folder aside, if there is one, to the first free `ID.unfinished-N` beside it, or to
/// `ID.disturbed-N` if its run was disturbed. Its content is never overwritten.
///
/// # Errors
/// If it cannot be renamed.
pub fn move_aside(folder: &Path) -> io::Result<()> {
    // A symbolic link that leads nowhere also takes the name.
    let is_there = |path: &Path| fs::symlink_metadata(path).is_ok();
    if !is_there(folder) {
        return Ok(());
    }
    // Not `with_extension`: an id may have a dot in it, as in `3.3hz`.
    let manifest = Manifest::read(folder).ok().flatten();
    let word = match manifest.map(|manifest| manifest.verdict) {
        Some(Verdict::Disturbed) => "disturbed",
        _ => "unfinished",
    };
    let beside = |n: u32| PathBuf::from(format!("{}.{word}-{n}", folder.display()));
    let aside = (1..).map(beside).find(|aside| !is_there(aside));
    aside.map_or(Ok(()), |aside| fs::rename(folder, aside))
}

/// Makes the cell's folder; what an earlier attempt left there is moved aside. Until the returned file is closed,
/// or this process ends in whatever way, no other process can do the same.
///
/// # Errors
/// [`Unwritable::InUse`] if another process runs the cell in there, and if the folder cannot be made.
pub fn make_room(campaign: &Path, folder: &Path) -> Result<File, Unwritable> {
    let fail = |problem| Unwritable::failed(folder, problem);
    let below = folder.strip_prefix(campaign).unwrap_or(folder);
    fs::create_dir_all(campaign).map_err(fail)?;
    // Check this before anything in there is renamed: a symbolic link may lead to somebody else's
    // files.
    file::make_folder(campaign, below.parent().unwrap_or(below)).map_err(fail)?;
    loop {
        let is_new = match fs::create_dir(folder) {
            Err(problem) if problem.kind() == io::ErrorKind::AlreadyExists => false,
            made => made.map(|()| true).map_err(fail)?,
        };
        let lock = match open_folder(folder) {
            Ok(lock) => lock,
            // A link or a file of this name; or another process has just moved the folder aside.
            Err(Errno::LOOP | Errno::NOTDIR | Errno::NOENT) => {
                move_aside(folder).map_err(fail)?;
                continue;
            }
            Err(problem) => return Err(fail(problem.into())),
        };
        match flock(&lock, FlockOperation::NonBlockingLockExclusive) {
            Err(Errno::WOULDBLOCK) => {
                return Err(Unwritable::InUse(folder.display().to_string()));
            }
            // Some network file systems lock no folder, since it cannot be written: there, nothing but this is lost.
            Err(Errno::NOSYS | Errno::OPNOTSUPP | Errno::BADF | Errno::NOLCK) | Ok(()) => {}
            Err(problem) => return Err(fail(problem.into())),
        }
        // Who moves a folder aside has its lock: so it may have another name since it was opened.
        let is_there = open_folder(folder).is_ok_and(|now| is_one(&now, &lock));
        match (is_there, is_new) {
            (true, true) => return Ok(lock),
            (true, false) => move_aside(folder).map_err(fail)?,
            (false, _) => {}
        }
    }
}

fn open_folder(path: &Path) -> rustix::io::Result<File> {
    let flags = OFlags::RDONLY | OFlags::DIRECTORY | OFlags::NOFOLLOW | OFlags::CLOEXEC;
    rustix::fs::open(path, flags, Mode::empty()).map(File::from)
}

/// Whether two files are the same one.
fn is_one(one: &File, other: &File) -> bool {
    let id = |file: &File| file.metadata().map(|found| (found.dev(), found.ino())).ok();
    id(one).is_some() && id(one) == id(other)
}

/// Removes everything from a cell's folder that this process has made room for.
///
/// # Errors
/// If something in there cannot be removed.
pub fn clear(folder: &Path) -> io::Result<()> {
    for entry in fs::read_dir(folder)? {
        let entry = entry?;
        if entry.file_type()?.is_dir() {
            fs::remove_dir_all(entry.path())?;
        } else {
            fs::remove_file(entry.path())?;
        }
    }
    Ok(())
}

/// Length and checksum of every file in `folder`, by name; `except` is left out. A file that is `known`, since this
/// process counted its bytes as it wrote them, is not read once more. Only where nobody else could write the folder may
/// a file be known: of any other run each file counts as it is on the disk.
///
/// # Errors
/// If a file cannot be read.
pub fn inventory(
    folder: &Path,
    except: &str,
    known: &BTreeMap<String, FileFact>,
) -> io::Result<BTreeMap<String, FileFact>> {
    let mut files = BTreeMap::new();
    for entry in fs::read_dir(folder)? {
        let entry = entry?;
        let name = entry.file_name().to_string_lossy().into_owned();
        if name != except && entry.file_type()?.is_file() {
            let fact = match known.get(&name) {
                Some(fact) => fact.clone(),
                None => FileFact::of(file::open(&entry.path())?)?,
            };
            files.insert(name, fact);
        }
    }
    Ok(files)
}

/// Brings the files that a manifest vouches for onto the disk, so that no power cut takes one of them from it.
///
/// # Errors
/// If one cannot be written.
pub fn sync(folder: &Path, manifest: &Manifest) -> io::Result<()> {
    let mut names = manifest.files.keys();
    names.try_for_each(|name| file::open(&folder.join(name))?.sync_all())
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
        let files = inventory(folder.path(), "manifest.json", &BTreeMap::new()).unwrap();
        assert_eq!(files.len(), 1);
        assert_eq!(files["a"].bytes, 3);
        // FIPS 180-2, appendix B.1.
        assert_eq!(
            files["a"].sha256,
            "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad"
        );
    }

    #[test]
    fn a_cell_s_folder_is_one_process_s_at_a_time() {
        let campaign = tempfile::tempdir().unwrap();
        let folder = campaign.path().join("cells/a");
        let count = || fs::read_dir(campaign.path().join("cells")).unwrap().count();
        for n in 1..=20 {
            let start = std::sync::Barrier::new(8);
            let rooms: Vec<_> = std::thread::scope(|scope| {
                let all: Vec<_> = (0..8)
                    .map(|_| {
                        scope.spawn(|| {
                            start.wait();
                            make_room(campaign.path(), &folder)
                        })
                    })
                    .collect();
                all.into_iter().map(|one| one.join().unwrap()).collect()
            });
            let (got, refused): (Vec<_>, Vec<_>) = rooms.into_iter().partition(Result::is_ok);
            assert_eq!(got.len(), 1, "{refused:?}");
            for refused in refused {
                let words = refused.unwrap_err().to_string();
                assert!(words.contains("cells/a is in use"), "{words}");
            }
            // What was there is kept aside, once.
            fs::write(folder.join("rows.csv"), "1").unwrap();
            let aside = fs::read_dir(campaign.path().join("cells"))
                .unwrap()
                .flatten();
            let kept = aside.filter(|entry| entry.path().join("rows.csv").exists());
            assert_eq!(kept.count(), n);
        }
        // A link leads nowhere: it is moved like a folder.
        fs::remove_dir_all(&folder).unwrap();
        std::os::unix::fs::symlink("/nowhere", &folder).unwrap();
        let before = count();
        make_room(campaign.path(), &folder).unwrap();
        assert_eq!(count(), before + 1);
        assert!(fs::symlink_metadata(&folder).unwrap().is_dir());
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
