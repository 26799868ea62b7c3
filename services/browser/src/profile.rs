//! The folder of a browser's own files: fresh for each visit, and gone after it.
//!
//! A launcher that was killed leaves its folder behind. It held a lock on a
//! file in it, which no longer is held then: so the next launcher removes it.

use std::{
    fs::{self, File, Permissions},
    io,
    os::unix::fs::{MetadataExt, PermissionsExt, chown},
    path::{Path, PathBuf},
    time::Duration,
};

use tempfile::TempDir;

/// What all such folders begin with.
const PREFIX: &str = "webloop-browser-";

/// The file that whoever made the folder has a lock on.
const LOCK: &str = "lock";

/// What a browser may write in.
const HOME: &str = "home";

/// A folder younger than this may still be waiting for its lock.
const SETTLED: Duration = Duration::from_secs(60);

/// A browser's own folder.
pub(crate) struct Profile {
    folder: TempDir,
    /// Held as long as this is.
    _lock: File,
}

impl Profile {
    /// Makes one in `scratch`, and removes what killed launchers left there.
    pub(crate) fn make(scratch: &Path) -> io::Result<Self> {
        sweep(scratch);
        let folder = tempfile::Builder::new()
            .prefix(PREFIX)
            .tempdir_in(scratch)?;
        let lock = File::create_new(folder.path().join(LOCK))?;
        lock.lock()?;
        // Another user may pass to what is theirs in it.
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

    /// Writes a file of the browser's.
    pub(crate) fn write(&self, name: &str, text: &str) -> io::Result<()> {
        fs::write(self.home().join(name), text)
    }

    /// Gives all that is there to another user.
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

/// Removes folders that no process holds. What cannot be removed is left to the next call.
fn sweep(scratch: &Path) {
    for entry in fs::read_dir(scratch).into_iter().flatten().flatten() {
        let ours = entry.file_name().to_string_lossy().starts_with(PREFIX);
        if ours && is_abandoned(&entry.path()) {
            let _ = fs::remove_dir_all(entry.path());
        }
    }
}

/// Whether a folder was made by a launcher of this user that is gone.
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
        // As of a launcher that was killed: its lock went with it.
        let killed = Profile::make(scratch.path()).expect("a profile");
        let Profile { folder, _lock } = killed;
        let killed_path = folder.keep();
        drop(_lock);
        // As of somebody else.
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
