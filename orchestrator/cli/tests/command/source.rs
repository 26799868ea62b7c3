//! Files that are none: a pipe, a socket, a device, a folder, hundreds of megabytes. Whatever reads one that the
//! command line names refuses it at once, and says what it is.
#![allow(clippy::unwrap_used)]

use std::fs::{self, File};
use std::os::unix::fs::symlink;
use std::os::unix::net::UnixListener;
use std::process::Command;
use std::time::{Duration, Instant};

use rustix::fs::{CWD, FileType, Mode, mknodat};

/// Far above what a refusal takes, far below what reading for ever does.
const AT_ONCE: Duration = Duration::from_secs(1);

const READERS: [&str; 9] = [
    "run NAME.toml --dry-run",
    "run NAME.json --dry-run",
    "matrix NAME.toml",
    "sweep NAME.toml",
    "system lint NAME.toml",
    "margin --system NAME.toml",
    "link lint NAME.toml",
    "link show ./NAME.toml",
    "run smoke --backend sim --timing NAME.toml --out new",
];

#[test]
fn a_file_that_is_none_is_refused_at_once() {
    serial::timed("a_file_that_is_none_is_refused_at_once", || {
        let place = tempfile::tempdir().unwrap();
        let path = |name: &str| place.path().join(name);
        mknodat(
            CWD,
            path("pipe"),
            FileType::Fifo,
            Mode::RUSR | Mode::WUSR,
            0,
        )
        .unwrap();
        let _socket = UnixListener::bind(path("socket")).unwrap();
        symlink("/dev/zero", path("device")).unwrap();
        fs::create_dir(path("folder")).unwrap();
        File::create(path("long"))
            .unwrap()
            .set_len(300 << 20)
            .unwrap();
        for (kind, says) in [
            ("pipe", "a pipe"),
            ("socket", "a socket"),
            ("device", "a device"),
            ("folder", "a folder"),
            ("long", "has 314572800 bytes"),
        ] {
            for line in READERS {
                let word = line.split(' ').find(|word| word.contains("NAME")).unwrap();
                let name = word.replace("NAME", "that").replace("./", "");
                symlink(path(kind), path(&name)).unwrap();
                let begun = Instant::now();
                let output = Command::new(env!("CARGO_BIN_EXE_webloop"))
                    .args(line.replace("NAME", "that").split(' '))
                    .current_dir(place.path())
                    .output()
                    .unwrap();
                let took = begun.elapsed();
                let said = String::from_utf8_lossy(&output.stderr);
                assert_eq!(output.status.code(), Some(2), "{kind}, {line}: {said}");
                assert!(
                    said.contains(says) && said.contains(&name),
                    "{kind}, {line}: {said}"
                );
                assert!(took < AT_ONCE, "{kind}, {line}: {took:?}");
                fs::remove_file(path(&name)).unwrap();
            }
        }
    });
}
