//! What a program of somebody's own does not see of this machine: the rows of its run and of the runs beside it,
//! the processes outside its namespace, the sockets of services, and disks as devices.
//!
//! It gets mounts of its own, in which all that is covered. What covers a place is prepared before the fork;
//! [`Shelter::enter`] runs after it, and makes system calls only. A place that is mounted elsewhere as well is not
//! covered there, nor is what comes into being later.

use std::ffi::{CStr, CString};
use std::fs::{self, FileType};
use std::io::{self, ErrorKind};
use std::os::unix::ffi::OsStrExt;
use std::os::unix::fs::FileTypeExt;
use std::path::{Path, PathBuf};

use rustix::fs::Mode;
use rustix::mount::{
    MountFlags, MountPropagationFlags, mount, mount_bind, mount_change, mount_remount,
};

/// Where services have their sockets, and machines their disks.
const SEARCHED: [&str; 4] = ["/run", "/var/run", "/dev", "/tmp"];

/// What is not covered: a display, to draw on, and the system's log, to write to.
const LEFT: [&str; 3] = [".X11-unix", "wayland-", "journal"];

/// How deep to search below each of them, and how many entries to look at in all.
const DEPTH: usize = 4;
const ENTRIES: usize = 20_000;

/// Most places that are covered: each takes some 10 us.
const COVERS: usize = 512;

const NONE: MountFlags = MountFlags::NOSUID
    .union(MountFlags::NODEV)
    .union(MountFlags::NOEXEC);

/// The folders that are hidden from a program.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Hidden {
    /// The folder that it finds empty, and cannot write to.
    pub folder: PathBuf,
    /// The folder in there that it keeps, with its content.
    pub kept: Option<PathBuf>,
}

/// What covers a program's view of this machine.
#[derive(Debug)]
pub(crate) struct Shelter {
    /// Where it starts, which may be in a hidden folder.
    start: CString,
    rooms: Option<Rooms>,
    /// Sockets and disks.
    covered: Vec<CString>,
}

/// A hidden folder and what is made anew in it.
#[derive(Debug)]
struct Rooms {
    folder: CString,
    /// The folders from there down to the one that is kept, itself the last.
    made: Vec<CString>,
}

impl Shelter {
    /// Finds what is to be covered: sockets and disks only in a run, whose rows are hidden. One that is tried by hand
    /// may be a container, which the engine's socket starts.
    ///
    /// # Errors
    /// When a folder to be hidden, or the one to start in, is not there.
    pub(crate) fn find(hidden: Option<&Hidden>) -> io::Result<Shelter> {
        Ok(Shelter {
            start: named(&std::env::current_dir()?)?,
            rooms: hidden.map(Rooms::of).transpose()?,
            covered: hidden.map_or_else(Vec::new, |_| covered()),
        })
    }

    /// Covers it all for the calling process, whose mounts are its own by now; only system calls.
    ///
    /// # Errors
    /// When a folder cannot be hidden. What else cannot be covered is left as it is.
    pub(crate) fn enter(&self) -> io::Result<()> {
        let private = MountPropagationFlags::PRIVATE | MountPropagationFlags::REC;
        let changed = mount_change(c"/", private);
        if let Some(rooms) = &self.rooms {
            changed?;
            rooms.hide()?;
            // What was the current folder may be below what hides it now.
            rustix::process::chdir(self.start.as_c_str())?;
        }
        for path in &self.covered {
            let _ = mount_bind(c"/dev/null", path.as_c_str());
        }
        let _ = mount(c"proc", c"/proc", c"proc", NONE, None::<&CStr>);
        Ok(())
    }
}

/// The sockets of services, and the disks, that are there now.
fn covered() -> Vec<CString> {
    // `/var/run` is a link to `/run` on most machines.
    let folders = SEARCHED.iter().map(PathBuf::from);
    let folders = folders.filter(|folder| !folder.is_symlink()).collect();
    let mut covered = search(folders, ENTRIES);
    for variable in ["DOCKER_HOST", "CONTAINER_HOST", "SSH_AUTH_SOCK"] {
        let named = std::env::var_os(variable).unwrap_or_default();
        let path = named.as_bytes();
        let path = path.strip_prefix(b"unix://").unwrap_or(path);
        covered.extend(CString::new(path).ok().filter(|path| !path.is_empty()));
    }
    covered
}

impl Rooms {
    fn of(hidden: &Hidden) -> io::Result<Rooms> {
        let folder = fs::canonicalize(&hidden.folder)?;
        let mut made = Vec::new();
        if let Some(kept) = &hidden.kept {
            let kept = fs::canonicalize(kept)?;
            let below = kept.strip_prefix(&folder).map_err(|_| {
                io::Error::new(ErrorKind::InvalidInput, "what is kept is not in the folder")
            })?;
            let mut path = folder.clone();
            for name in below {
                path.push(name);
                made.push(named(&path)?);
            }
        }
        Ok(Rooms {
            folder: named(&folder)?,
            made,
        })
    }

    /// Mounts an empty folder over the hidden one, and in it the one that is kept.
    fn hide(&self) -> rustix::io::Result<()> {
        let folder = self.folder.as_c_str();
        let kept = self.made.last();
        if let Some(kept) = kept {
            // From here it is still reached once its path is hidden.
            rustix::process::chdir(kept.as_c_str())?;
        }
        mount(c"tmpfs", folder, c"tmpfs", NONE, c"size=64k,mode=755")?;
        for path in &self.made {
            rustix::fs::mkdir(path.as_c_str(), Mode::RWXU)?;
        }
        if let Some(kept) = kept {
            mount_bind(c".", kept.as_c_str())?;
        }
        mount_remount(folder, NONE.union(MountFlags::RDONLY), c"")
    }
}

/// The sockets and disks below some folders, those that lie less deep first.
fn search(folders: Vec<PathBuf>, entries: usize) -> Vec<CString> {
    let (mut left, mut found) = (entries, Vec::new());
    let mut level = folders;
    for _ in 0..DEPTH {
        let mut below = Vec::new();
        for entries in level.iter().filter_map(|folder| fs::read_dir(folder).ok()) {
            for entry in entries.flatten() {
                if left == 0 || found.len() >= COVERS {
                    return found;
                }
                left -= 1;
                let (name, kind) = (entry.file_name(), entry.file_type());
                let is_left = LEFT
                    .iter()
                    .any(|left| name.as_bytes().starts_with(left.as_bytes()));
                match kind {
                    Ok(_) if is_left => {}
                    Ok(kind) if kind.is_dir() => below.push(entry.path()),
                    Ok(kind) if is_covered(kind) => found.extend(named(&entry.path())),
                    _ => {}
                }
            }
        }
        level = below;
    }
    found
}

fn is_covered(kind: FileType) -> bool {
    kind.is_socket() || kind.is_block_device()
}

fn named(path: &Path) -> io::Result<CString> {
    Ok(CString::new(path.as_os_str().as_bytes())?)
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use std::os::unix::net::UnixListener;

    use super::*;

    #[test]
    fn sockets_are_found_and_displays_and_files_are_left() {
        let place = tempfile::tempdir().unwrap();
        let path = |name: &str| place.path().join(name);
        fs::create_dir_all(path("user/1000")).unwrap();
        let _engine = UnixListener::bind(path("user/1000/docker.sock")).unwrap();
        let _display = UnixListener::bind(path("user/1000/wayland-0")).unwrap();
        fs::write(path("file"), "").unwrap();
        let found = search(vec![place.path().to_owned()], ENTRIES);
        assert_eq!(found, [named(&path("user/1000/docker.sock")).unwrap()]);
        // However many entries there are, the search ends.
        assert!(search(vec![place.path().to_owned()], 1).is_empty());
    }

    #[test]
    fn what_is_kept_must_be_in_what_is_hidden() {
        let place = tempfile::tempdir().unwrap();
        let folder = place.path().join("cells");
        let kept = folder.join("a/own");
        fs::create_dir_all(&kept).unwrap();
        let hidden = |folder: &Path, kept: &Path| Hidden {
            folder: folder.to_owned(),
            kept: Some(kept.to_owned()),
        };
        let rooms = Rooms::of(&hidden(&folder, &kept)).unwrap();
        assert_eq!(rooms.made.len(), 2);
        assert!(Rooms::of(&hidden(&kept, &folder)).is_err());
    }
}
