//! A player that plays another link than the requested one: for one thread and its children a
//! script is mounted over webloop's own file, so that starting `webloop` starts the script. Only
//! this file of these tests has `unsafe` code.
#![allow(unsafe_code)]

use std::fs::{self, File};
use std::os::fd::AsRawFd;
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};

use rustix::mount::{MountPropagationFlags, mount_bind, mount_change};
use rustix::thread::{UnshareFlags, unshare_unsafe};

/// Changes the player's settings, which it reads from its standard input, and continues as webloop.
const SCRIPT: &str = "#!/bin/sh
if [ \"$1 $2\" = 'serve link' ]; then
    sed -E -f FOLDER/other-player.sed > FOLDER/other-player.json
    exec WEBLOOP \"$@\" < FOLDER/other-player.json
fi
exec WEBLOOP \"$@\"
";

/// Replaces the value of a JSON key, a number or a text.
const EDIT: &str = r#"s/"KEY":([0-9]+|"([^"\\]|\\.)*")/"KEY":VALUE/"#;

/// Webloop's own file behind the script. Starting this file starts webloop, and what that starts by
/// its own name is the script.
pub(crate) struct OtherPlayer {
    file: File,
}

impl OtherPlayer {
    /// Mounts the script over `program` for the calling thread, which should end soon after, and
    /// for the processes that it starts. The player then has `value`, in JSON, at `key` of its
    /// settings. `folder` keeps the script.
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
            // Escapes the three characters that sed does not take literally.
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
            // SAFETY: only this thread's view of the mounts is separated from the others'; no
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

    /// The path to start webloop by. The descriptor is still open when the child resolves it.
    pub(crate) fn program(&self) -> PathBuf {
        format!("/proc/self/fd/{}", self.file.as_raw_fd()).into()
    }
}
