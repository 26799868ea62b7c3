//! The folder of a browser's own files: fresh for each visit, and removed afterwards.
//!
//! A launcher that was killed leaves its folder behind. It held a lock on a file in the folder, which
//! the kernel releases; the next launcher sees that and removes the folder.

use std::{
    fs::{self, File, Permissions},
    io,
    os::unix::fs::{MetadataExt, PermissionsExt, chown},
    path::{Path, PathBuf},
    time::Duration,
};

use tempfile::TempDir;

/// Prefix of all such folders.
const PREFIX: &str = "webloop-browser-";

/// The file on which the launcher that made the folder holds a lock.
const LOCK: &str = "lock";

/// The folder in which a browser may write.
const HOME: &str = "home";

/// The launcher of a folder younger than this may not hold its lock yet.
const SETTLED: Duration = Duration::from_secs(60);

/// A browser's own folder.
pub(crate) struct Profile {
    folder: TempDir,
    /// Held as long as the profile exists.
    _lock: File,
}

impl Profile {
    /// Creates one in `scratch`, and removes those that killed launchers left there.
    pub(crate) fn make(scratch: &Path) -> io::Result<Self> {
        sweep(scratch);
        let folder = tempfile::Builder::new()
            .prefix(PREFIX)
            .tempdir_in(scratch)?;
        let lock = File::create_new(folder.path().join(LOCK))?;
        lock.lock()?;
        // Another user may pass through to its own files.
        fs::set_permissions(folder.path(), Permissions::from_mode(0o711))?;
        let home = folder.path().join(HOME);
        fs::create_dir(&home)?;
        fs::set_permissions(&home, Permissions::from_mode(0o700))?;
        Ok(Self {
            folder,
            _lock: lock,
        })
    }

    /// Where the browser writes.
    pub(crate) fn home(&self) -> PathBuf {
        self.folder.path().join(HOME)
    }

    /// Writes one of the browser's files.
    pub(crate) fn write(&self, name: &str, text: &str) -> io::Result<()> {
        fs::write(self.home().join(name), text)
    }

    /// Gives the browser's folder and its files to another user.
    pub(crate) fn give_to(&self, user: u32) -> io::Result<()> {
        let home = self.home();
        for entry in fs::read_dir(&home)? {
            chown(entry?.path(), Some(user), Some(user))?;
        }
        chown(&home, Some(user), Some(user))
    }

    /// Deletes the folder.
    pub(crate) fn remove(self) -> io::Result<()> {
        self.folder.close()
    }
}

/// Removes folders that no process holds. Those that cannot be removed are left to the next call.
fn sweep(scratch: &Path) {
    for entry in fs::read_dir(scratch).into_iter().flatten().flatten() {
        let ours = entry.file_name().to_string_lossy().starts_with(PREFIX);
        if ours && is_abandoned(&entry.path()) {
            let _ = fs::remove_dir_all(entry.path());
        }
    }
}

/// Whether a launcher of this user made the folder and has ended since.
fn is_abandoned(folder: &Path) -> bool {
    let Ok(meta) = folder.symlink_metadata() else {
        return false;
    };
    let settled = meta
        .modified()
        .is_ok_and(|time| time.elapsed().is_ok_and(|age| age > SETTLED));
    let ours = meta.uid() == rustix::process::geteuid().as_raw();
    meta.is_dir()
        && ours
        && settled
        && match File::open(folder.join(LOCK)) {
            Ok(lock) => lock.try_lock().is_ok(),
            Err(error) => error.kind() == io::ErrorKind::NotFound,
        }
}

#[cfg(test)]
mod tests {
    use std::time::SystemTime;

    use super::*;

    fn age(folder: &Path) {
        let hour_ago = SystemTime::now() - Duration::from_secs(3600);
        let folder = File::open(folder).expect("the folder");
        folder.set_modified(hour_ago).expect("its time");
    }

    #[test]
    fn a_folder_is_removed_with_its_profile_or_by_the_next_one_and_never_from_under_it() {
        let scratch = tempfile::tempdir().expect("a folder");
        let left = || fs::read_dir(scratch.path()).expect("it is there").count();
        let held = Profile::make(scratch.path()).expect("a profile");
        let held_path = held.folder.path().to_owned();
        // Like a launcher that was killed: its lock is released.
        let killed = Profile::make(scratch.path()).expect("a profile");
        let Profile { folder, _lock } = killed;
        let killed_path = folder.keep();
        drop(_lock);
        // Like a folder of another program.
        fs::create_dir(scratch.path().join("other")).expect("a folder");
        age(&held_path);
        age(&killed_path);

        let next = Profile::make(scratch.path()).expect("a profile");
        assert!(held.home().is_dir() && !killed_path.exists());
        assert_eq!(left(), 3);
        next.remove().expect("it can be removed");
        held.remove().expect("it can be removed");
        assert_eq!(left(), 1);
    }
}
