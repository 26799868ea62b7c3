//! Opens and writes the files of a results folder, but never follows a link or reads a pipe.
//!
//! A folder may come from anywhere: a copy, an archive, another machine. So a name in it counts as
//! a file of the folder only if it really is one. No link is followed, since it may lead out of the
//! folder. Only regular files are read, since a read from a pipe may never end. A text is read up
//! to a maximum length, since a file with holes can be larger than memory. A hard link is a file
//! like any other. There is no protection against changes to a folder while it is read.
//!
//! What is in the files, others say.

use std::fs::{self, File, FileType, OpenOptions};
use std::io::{self, ErrorKind, Read, Write};
use std::os::unix::fs::FileTypeExt;
use std::path::{Path, PathBuf};

use rustix::fs::{Mode, OFlags};
use rustix::io::Errno;

/// Maximum bytes of a `plan.json`: a hundred thousand cells of half a kilobyte, and traces.
pub const PLAN_BYTES: u64 = 128 << 20;
/// Maximum bytes of a `manifest.json`: it has the reports of four parts, some kilobytes each.
pub const MANIFEST_BYTES: u64 = 8 << 20;
/// Maximum bytes of a part's report, such as `plant.json`.
pub const REPORT_BYTES: u64 = 4 << 20;

const READ: OFlags = OFlags::RDONLY.union(OFlags::NONBLOCK).union(OFlags::NOCTTY);

/// Opens a regular file for reading; does not follow a link.
///
/// # Errors
/// When the system refuses, or it is a link or not a regular file.
pub fn open(path: &Path) -> io::Result<File> {
    regular(path, READ | OFlags::NOFOLLOW)
}

/// Opens a regular file for reading and writing, and creates it if it does not exist. Does not
/// follow a link, and keeps the content.
///
/// # Errors
/// Those of [`open`].
pub fn open_or_create(path: &Path) -> io::Result<File> {
    let flags = OFlags::RDWR | OFlags::CREATE | OFlags::NONBLOCK | OFlags::NOCTTY;
    regular(path, flags | OFlags::NOFOLLOW)
}

/// Text of a regular file of at most `most_bytes` bytes; does not follow a link.
///
/// # Errors
/// As [`open`], and when it is longer or not UTF-8.
pub fn text(path: &Path, most_bytes: u64) -> io::Result<String> {
    bounded(&open(path)?, most_bytes)
}

/// As [`text()`], but follows a link: for a file that the user named.
///
/// # Errors
/// As [`text()`].
pub fn given_text(path: &Path, most_bytes: u64) -> io::Result<String> {
    bounded(&regular(path, READ)?, most_bytes)
}

/// Writes a file that can be made again. A reader finds either the old file or the new one. A link
/// with its name is replaced, not followed.
///
/// # Errors
/// When it cannot be written.
pub fn write(path: &Path, content: &[u8]) -> io::Result<()> {
    Draft::write(path, content)?.name()
}

/// As [`write()`], of a content in parts, which need not be in memory together.
///
/// # Errors
/// When it cannot be written.
pub fn write_parts(path: &Path, parts: impl IntoIterator<Item = String>) -> io::Result<()> {
    let mut draft = Draft::write(path, &[])?;
    for part in parts {
        draft.file.write_all(part.as_bytes())?;
    }
    draft.name()
}

/// As [`write()`]; also after a crash of the machine, either the old file or the new one is there.
///
/// # Errors
/// When it cannot be written.
pub fn write_durably(path: &Path, content: &[u8]) -> io::Result<()> {
    let draft = Draft::write(path, content)?;
    draft.file.sync_all()?;
    draft.name()?;
    // The name itself is safe only once its folder is synced.
    match path.parent() {
        Some(folder) => File::open(folder)?.sync_all(),
        None => Ok(()),
    }
}

/// A file that is written and has not its name yet. Without one it is removed when dropped.
#[derive(Debug)]
pub struct Draft {
    path: PathBuf,
    partial: PathBuf,
    file: File,
    is_named: bool,
}

impl Draft {
    /// Writes what `path` will be.
    ///
    /// # Errors
    /// When it cannot be written.
    pub fn write(path: &Path, content: &[u8]) -> io::Result<Draft> {
        let partial = path.with_extension("partial");
        // Remove what a killed run or somebody else left there: `create_new` would fail, and
        // follows no link.
        match fs::remove_file(&partial) {
            Err(problem) if problem.kind() != ErrorKind::NotFound => return Err(problem),
            _ => {}
        }
        let file = OpenOptions::new()
            .write(true)
            .create_new(true)
            .open(&partial)?;
        let mut draft = Draft {
            path: path.to_owned(),
            partial,
            file,
            is_named: false,
        };
        draft.file.write_all(content)?;
        Ok(draft)
    }

    /// Gives it its name. A reader finds either an old file of this name or this one.
    ///
    /// # Errors
    /// When it cannot be renamed.
    pub fn name(mut self) -> io::Result<()> {
        fs::rename(&self.partial, &self.path)?;
        self.is_named = true;
        Ok(())
    }
}

impl Drop for Draft {
    fn drop(&mut self) {
        if !self.is_named {
            let _ = fs::remove_file(&self.partial);
        }
    }
}

/// Brings all that was written before onto the disk, of the file system that `folder` is on: one call, however many
/// files. A kernel before 5.8 does not tell of a write that failed meanwhile.
///
/// # Errors
/// When something cannot be written.
pub fn sync_all(folder: &File) -> io::Result<()> {
    Ok(rustix::fs::syncfs(folder)?)
}

/// Creates the folder `below`, a relative path, in `folder`, and the folders in between.
///
/// # Errors
/// When one cannot be created, or is a link or something else that is not a folder.
pub fn make_folder(folder: &Path, below: &Path) -> io::Result<PathBuf> {
    let mut path = folder.to_owned();
    for name in below {
        path.push(name);
        match fs::create_dir(&path) {
            Err(problem) if problem.kind() == ErrorKind::AlreadyExists => check_folder(&path)?,
            made => made?,
        }
    }
    Ok(path)
}

/// Checks that `path` is a folder and not a link; it may also not exist.
///
/// # Errors
/// When it is anything else.
pub fn check_folder(path: &Path) -> io::Result<()> {
    match fs::symlink_metadata(path) {
        Ok(found) if found.is_dir() => Ok(()),
        Ok(found) => Err(refused(format!(
            "{} is {}, and should be a folder",
            path.display(),
            kind(found.file_type())
        ))),
        Err(problem) if problem.kind() == ErrorKind::NotFound => Ok(()),
        Err(problem) => Err(problem),
    }
}

fn regular(path: &Path, flags: OFlags) -> io::Result<File> {
    let file = match rustix::fs::open(path, flags | OFlags::CLOEXEC, Mode::from_raw_mode(0o666)) {
        Ok(file) => File::from(file),
        Err(Errno::LOOP) => return Err(refused("it is a link, which is not followed".to_owned())),
        // A socket, or a pipe opened for writing, cannot be opened at all.
        Err(Errno::NXIO) => {
            return Err(refused(
                "it is a pipe or a socket, not a regular file".to_owned(),
            ));
        }
        Err(problem) => return Err(problem.into()),
    };
    let found = file.metadata()?.file_type();
    if found.is_file() {
        Ok(file)
    } else {
        Err(refused(format!(
            "it is {}, not a regular file",
            kind(found)
        )))
    }
}

fn bounded(file: &File, most_bytes: u64) -> io::Result<String> {
    let too_long = |bytes: u64| {
        refused(format!(
            "it has {bytes} bytes, and such a file has at most {most_bytes}"
        ))
    };
    let bytes = file.metadata()?.len();
    if bytes > most_bytes {
        return Err(too_long(bytes));
    }
    let mut text = String::new();
    // The file may have grown since.
    let read = file.take(most_bytes + 1).read_to_string(&mut text)? as u64;
    if read > most_bytes {
        Err(too_long(read))
    } else {
        Ok(text)
    }
}

fn kind(found: FileType) -> &'static str {
    match found {
        found if found.is_symlink() => "a link",
        found if found.is_dir() => "a folder",
        found if found.is_fifo() => "a pipe",
        found if found.is_socket() => "a socket",
        found if found.is_file() => "a file",
        _ => "a device",
    }
}

fn refused(words: String) -> io::Error {
    io::Error::new(ErrorKind::InvalidInput, words)
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use std::os::unix::fs::symlink;

    use super::*;

    fn words<T: std::fmt::Debug>(outcome: io::Result<T>) -> String {
        outcome.unwrap_err().to_string()
    }

    #[test]
    fn a_file_is_read_and_nothing_in_its_place() {
        let place = tempfile::tempdir().unwrap();
        let path = |name: &str| place.path().join(name);
        fs::write(path("file"), "abc").unwrap();
        fs::hard_link(path("file"), path("hard")).unwrap();
        assert_eq!(text(&path("file"), 3).unwrap(), "abc");
        assert_eq!(text(&path("hard"), 3).unwrap(), "abc");

        symlink(path("file"), path("link")).unwrap();
        symlink(path("nowhere"), path("dangling")).unwrap();
        rustix::fs::mkfifoat(rustix::fs::CWD, path("pipe"), Mode::RUSR | Mode::WUSR).unwrap();
        fs::create_dir(path("folder")).unwrap();
        for open in [open, open_or_create] {
            assert!(words(open(&path("link"))).contains("a link"));
            assert!(words(open(&path("dangling"))).contains("a link"));
            assert!(words(open(&path("pipe"))).contains("a pipe"));
        }
        assert!(words(open(&path("folder"))).contains("a folder"));
        assert!(!path("nowhere").exists());
        assert_eq!(given_text(&path("link"), 3).unwrap(), "abc");
        assert!(words(given_text(&path("pipe"), 3)).contains("a pipe"));
        let missing = open(&path("missing")).unwrap_err();
        assert_eq!(missing.kind(), ErrorKind::NotFound);
    }

    #[test]
    fn a_text_is_read_up_to_its_length_whatever_the_file_says() {
        let place = tempfile::tempdir().unwrap();
        let path = place.path().join("plan.json");
        fs::write(&path, "abc").unwrap();
        assert!(words(text(&path, 2)).contains("3 bytes"));
        File::create(&path).unwrap().set_len(1 << 40).unwrap();
        assert!(words(text(&path, 1 << 20)).contains("at most 1048576"));
        fs::write(&path, [0xff]).unwrap();
        assert!(words(text(&path, 10)).contains("UTF-8"));
    }

    #[test]
    fn what_is_written_replaces_a_link_and_not_what_it_leads_to() {
        let place = tempfile::tempdir().unwrap();
        let path = |name: &str| place.path().join(name);
        fs::write(path("foreign"), "theirs").unwrap();
        for write in [write, write_durably] {
            for name in ["table.txt", "table.partial"] {
                let _ = fs::remove_file(path("table.txt"));
                symlink(path("foreign"), path(name)).unwrap();
                write(&path("table.txt"), b"ours").unwrap();
                assert_eq!(fs::read_to_string(path("table.txt")).unwrap(), "ours");
                assert!(!path("table.txt").is_symlink());
                assert_eq!(fs::read_to_string(path("foreign")).unwrap(), "theirs");
            }
        }
        fs::remove_file(path("table.txt")).unwrap();
        fs::hard_link(path("foreign"), path("table.txt")).unwrap();
        write(&path("table.txt"), b"ours").unwrap();
        assert_eq!(fs::read_to_string(path("foreign")).unwrap(), "theirs");
    }

    #[test]
    fn a_folder_is_made_once_and_never_through_a_link() {
        let place = tempfile::tempdir().unwrap();
        let (own, foreign) = (place.path().join("own"), place.path().join("foreign"));
        fs::create_dir(&own).unwrap();
        fs::create_dir(&foreign).unwrap();
        for _ in 0..2 {
            let made = make_folder(&own, Path::new("cells/a")).unwrap();
            assert_eq!(made, own.join("cells/a"));
            assert!(made.is_dir());
        }
        symlink(&foreign, own.join("report")).unwrap();
        let said = words(make_folder(&own, Path::new("report/figures")));
        assert!(said.contains("report is a link"), "{said}");
        assert_eq!(fs::read_dir(&foreign).unwrap().count(), 0);
    }
}
