//! A disk that is too small for the rows: a tmpfs in the mount namespace of one thread, which
//! disappears with that thread. Only this file of these tests has `unsafe` code.
#![allow(unsafe_code)]

use std::fs;
use std::path::Path;
use std::thread;

use plan::Verdict;
use rustix::mount::{MountFlags, MountPropagationFlags, mount, mount_change, mount_remount};
use rustix::process::geteuid;
use rustix::thread::{UnshareFlags, unshare_unsafe};

use crate::webloop::{Experiment, code, command, files, manifest, said};

/// Holds some seconds of ticks at 1 kHz with some 60 bytes each: it is full before the loop is closed.
const TOO_SMALL: &str = "size=200k";

/// Enough for the same run.
const ENOUGH: &str = "size=20m";

pub(crate) fn a_full_disk_is_told_and_the_run_is_made_once_there_is_space() -> Result<(), String> {
    if !geteuid().is_root() {
        return Err("only root can mount a disk that is small enough".into());
    }
    let folder = tempfile::tempdir().unwrap();
    let experiment = Experiment::new(folder.path(), &["office"], "1ms", "2s");
    fs::create_dir(&experiment.out).unwrap();
    // Only the thread, and the processes that it starts, see the disk.
    thread::scope(|scope| {
        scope
            .spawn(|| {
                mount_here(&experiment.out)
                    .map_err(|problem| format!("cannot mount a small disk: {problem}"))?;
                fill_and_free(&experiment)
            })
            .join()
            .unwrap_or_else(|panic| std::panic::resume_unwind(panic))
    })
}

fn mount_here(out: &Path) -> rustix::io::Result<()> {
    // SAFETY: only this thread's view of the mounts is separated from the others'; no descriptor
    // and no memory is touched.
    unsafe { unshare_unsafe(UnshareFlags::NEWNS) }?;
    let private = MountPropagationFlags::PRIVATE | MountPropagationFlags::REC;
    mount_change("/", private)?;
    let size = std::ffi::CString::new(TOO_SMALL).unwrap();
    mount(
        "tmpfs",
        out,
        "tmpfs",
        MountFlags::empty(),
        Some(size.as_c_str()),
    )
}

fn fill_and_free(experiment: &Experiment) -> Result<(), String> {
    let full = experiment.run(command()).output().unwrap();
    assert_eq!(code(&full), Some(1), "{}", said(&full));
    let words = said(&full);
    assert!(words.contains("No space left"), "{words}");
    assert!(words.contains("free"), "the remedy is missing: {words}");
    assert!(
        words.contains(".csv") || words.contains(".json"),
        "which file? {words}"
    );
    let cell = &experiment.cells()[0];
    if cell.join("manifest.json").exists() {
        assert_ne!(manifest(cell).verdict, Verdict::Complete);
    }
    let rows = files(cell);
    assert!(!rows["ticks.csv"].is_empty());

    mount_remount(&experiment.out, MountFlags::empty(), ENOUGH).unwrap();
    let freed = experiment.complete()?;
    assert_eq!(code(&freed), Some(0), "{}", said(&freed));
    assert_eq!(manifest(cell).verdict, Verdict::Complete);
    Ok(())
}
