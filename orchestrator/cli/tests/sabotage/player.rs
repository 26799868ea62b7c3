//! A player that plays another link than the one that was asked for: in the eyes of one thread and
//! its children a script lies over webloop's own file, and whoever starts `webloop` starts that.
//! This is the one file of these tests with `unsafe`.
#![allow(unsafe_code)]

use std::fs::{self, File};
use std::os::fd::AsRawFd;
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};

use rustix::mount::{MountPropagationFlags, mount_bind, mount_change};
use rustix::thread::{UnshareFlags, unshare_unsafe};

/// Changes the player's settings, which it reads from its standard input, and goes on as webloop.
const SCRIPT: &str = "#!/bin/sh
if [ \"$1 $2\" = 'serve link' ]; then
    sed -E -f FOLDER/other-player.sed > FOLDER/other-player.json
    exec WEBLOOP \"$@\" < FOLDER/other-player.json
fi
exec WEBLOOP \"$@\"
";

/// Puts another value, a number or a text, at a key of JSON.
const EDIT: &str = r#"s/"KEY":([0-9]+|"([^"\\]|\\.)*")/"KEY":VALUE/"#;

/// Webloop's own file behind the script: what is started by it is webloop, and what that starts by
/// its own name is the script.
pub(crate) struct OtherPlayer {
    file: File,
}

impl OtherPlayer {
    /// Puts the script over `program` for the calling thread, which should end soon after, and for
    /// the processes that it starts, so that the player has `value`, in JSON, at `key` of its settings.
    /// `folder` keeps the script.
    pub(crate) fn with(
        key: &str,
        value: &str,
        program: &Path,
        folder: &Path,
    ) -> Result<Self, String> {
        let put = || -> std::io::Result<Self> {
            let (script, real) = (folder.join("other-player.sh"), folder.join("webloop"));
            let text = SCRIPT
                .replace("FOLDER", &folder.display().to_string())
                .replace("WEBLOOP", &real.display().to_string());
            // What follows stands for itself: sed has three letters that do not.
            let literal = ['\\', '/', '&']
                .into_iter()
                .fold(value.to_owned(), |text, letter| {
                    text.replace(letter, &format!("\\{letter}"))
                });
            let edit = EDIT.replace("KEY", key).replace("VALUE", &literal);
            fs::write(folder.join("other-player.sed"), edit)?;
            fs::write(&script, text)?;
            fs::set_permissions(&script, fs::Permissions::from_mode(0o755))?;
            fs::write(&real, "")?;
            let file = File::open(program)?;
            // SAFETY: only this thread's view of the mounts is parted from the others'; no
            // descriptor and no memory is touched.
            unsafe { unshare_unsafe(UnshareFlags::NEWNS) }?;
            let private = MountPropagationFlags::PRIVATE | MountPropagationFlags::REC;
            mount_change("/", private)?;
            mount_bind(program, &real)?;
            mount_bind(&script, program)?;
            Ok(Self { file })
        };
        put().map_err(|problem| format!("cannot put a script over webloop: {problem}"))
    }

    /// What to start webloop by. The descriptor is still there when the child looks.
    pub(crate) fn program(&self) -> PathBuf {
        format!("/proc/self/fd/{}", self.file.as_raw_fd()).into()
    }
}
