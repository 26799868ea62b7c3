//! Who may make a link, and what is left of one. These tests start this program again in a
//! role.

use std::fs;
use std::io::{BufRead, BufReader, Write};
use std::os::fd::{AsFd, AsRawFd};
use std::os::unix::fs::PermissionsExt;
use std::os::unix::process::CommandExt;
use std::path::PathBuf;
use std::process::{Command, ExitCode, Stdio};
use std::thread;
use std::time::{Duration, Instant};

use shaper::{Authority, Error, become_root};

use crate::attempt::{held, holds};
use crate::cell::{Cell, MS, SECOND, constant};
use crate::crossing;

/// Precedes the role that this program is to play.
pub(crate) const ROLE_FLAG: &str = "--role";

/// The user whom every Unix system has and who owns nothing.
pub(crate) const NOBODY: u32 = 65_534;

pub(crate) fn play_role(role: &str) -> ExitCode {
    match role {
        "play-unprivileged" => play_unprivileged(),
        "hold" => hold(),
        "hold-tunnel" => crossing::hold(),
        "tunnel-without-capabilities" => crossing::play_without_capabilities(),
        "try-tc" => crate::trap::try_tc(),
        other => {
            println!("no such role: {other}");
            ExitCode::FAILURE
        }
    }
}

/// A second of a link, in a user namespace.
fn play_unprivileged() -> ExitCode {
    match become_root() {
        Ok(authority) => assert_eq!(authority, Authority::UserNamespace),
        Err(error @ Error::Unsupported { .. }) => {
            println!("  SKIPPED: {error}");
            return ExitCode::SUCCESS;
        }
        Err(error) => panic!("{error}"),
    }
    holds("a link as nobody", || {
        let cell = Cell::start(&constant("5ms"), 1, SECOND).unwrap();
        held(&cell.prove("as nobody", 5 * MS, 200)?.certificate)
    });
    ExitCode::SUCCESS
}

pub(crate) fn an_unprivileged_user_can_play_a_link() {
    if !rustix::process::geteuid().is_root() || in_user_namespace() {
        println!("  SKIPPED: all of these tests run unprivileged already");
        return;
    }
    // Where this program lies, nobody may not be let in.
    let folder = tempfile::tempdir().unwrap();
    let copy = folder.path().join("namespaces");
    fs::copy(std::env::current_exe().unwrap(), &copy).unwrap();
    fs::set_permissions(folder.path(), fs::Permissions::from_mode(0o755)).unwrap();
    let status = Command::new(&copy)
        .args([ROLE_FLAG, "play-unprivileged"])
        .current_dir("/")
        .uid(NOBODY)
        .gid(NOBODY)
        .status()
        .unwrap();
    assert!(status.success());
}

/// The initial user namespace maps all users; any other one that we make maps one.
fn in_user_namespace() -> bool {
    !fs::read_to_string("/proc/self/uid_map")
        .unwrap()
        .split_whitespace()
        .eq(["0", "0", "4294967295"])
}

/// Plays until killed, and tells its namespaces.
fn hold() -> ExitCode {
    become_root().unwrap();
    let cell = Cell::start(&constant("5ms"), 1, 0).unwrap();
    for namespace in [&cell.controller, &cell.plant] {
        let link = format!("/proc/self/fd/{}", namespace.as_fd().as_raw_fd());
        println!("{}", fs::read_link(link).unwrap().display());
    }
    println!("playing");
    std::io::stdout().flush().unwrap();
    loop {
        thread::park();
    }
}

/// A namespace lives as long as a process, a descriptor or a mount holds it. So it is gone
/// when none is left in /proc; nothing here ever mounts one.
pub(crate) fn nothing_is_left_of_a_killed_process() {
    let mut child = Command::new(std::env::current_exe().unwrap())
        .args([ROLE_FLAG, "hold"])
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    let namespaces: Vec<PathBuf> = BufReader::new(child.stdout.take().unwrap())
        .lines()
        .map(Result::unwrap)
        .take_while(|line| line != "playing")
        .map(PathBuf::from)
        .collect();
    assert_eq!(namespaces.len(), 2);
    assert!(
        namespaces.iter().all(is_held),
        "they are there while it plays"
    );
    child.kill().unwrap();
    child.wait().unwrap();
    let killed = Instant::now();
    while namespaces.iter().any(is_held) {
        assert!(
            killed.elapsed() < Duration::from_secs(5),
            "a namespace outlives its process"
        );
        thread::sleep(Duration::from_millis(10));
    }
    println!("  gone after {} ms", killed.elapsed().as_millis());
}

/// Whether any thread is in this namespace or any process has it open.
fn is_held(namespace: &PathBuf) -> bool {
    fs::read_dir("/proc")
        .unwrap()
        .flatten()
        .filter(|entry| entry.file_name().to_string_lossy().parse::<u32>().is_ok())
        .any(|process| {
            let descriptors = fs::read_dir(process.path().join("fd"));
            let threads = fs::read_dir(process.path().join("task"));
            let open = descriptors
                .into_iter()
                .flatten()
                .flatten()
                .map(|fd| fd.path());
            let inside = threads
                .into_iter()
                .flatten()
                .flatten()
                .map(|thread| thread.path().join("ns/net"));
            open.chain(inside)
                .any(|link| fs::read_link(link).is_ok_and(|target| &target == namespace))
        })
}
