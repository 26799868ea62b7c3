//! The same without privileges: in a user namespace.

use std::fs;
use std::os::unix::fs::{PermissionsExt, chown};
use std::os::unix::process::CommandExt;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Duration;

use rustix::process::geteuid;

use crate::complete::came_to_its_end;
use crate::ending::{GONE_WITHIN, kill};
use crate::webloop::{Experiment, code, command_of, doctor, manifest, said};

/// The user who owns nothing, by custom.
const NOBODY: u32 = 65_534;

pub(crate) fn an_unprivileged_user_can_run_and_leaves_nothing_when_killed() -> Result<(), String> {
    let folder = tempfile::tempdir().unwrap();
    let experiment = Experiment::new(folder.path(), &["office"], "3ms", "3s");
    let program = handed_over(folder.path(), &experiment);
    let command = || as_nobody(&program);
    doctor(command()).map_err(|lack| format!("not without root on this machine:\n{lack}"))?;

    // Kill it in the middle of a run, 2 s after its start: the loop begins 0.5 s after it.
    let mut run = experiment.run(command()).spawn().unwrap();
    std::thread::sleep(Duration::from_secs(2));
    let killed = kill(&mut run, &experiment.out);
    assert!(killed.processes >= 4, "{killed:?}");
    assert!(killed.namespaces >= 3, "{killed:?}");
    assert!(killed.gone_after < GONE_WITHIN);

    let output = experiment.run(command()).output().unwrap();
    let cells = experiment.cells();
    let manifest = manifest(&cells[0]);
    // Only root has real-time scheduling. Without it a busy machine may be too late for the link,
    // and then has to report that. Which packets are lost depends on the seed alone.
    came_to_its_end(&manifest);
    assert!(matches!(code(&output), Some(0 | 1)), "{}", said(&output));
    assert_eq!(manifest.authority, "user-namespace");
    Ok(())
}

/// A copy of the program that any user can reach, and a results folder of the user `nobody`.
fn handed_over(folder: &Path, experiment: &Experiment) -> PathBuf {
    let program = folder.join("webloop");
    fs::copy(env!("CARGO_BIN_EXE_webloop"), &program).unwrap();
    fs::create_dir(&experiment.out).unwrap();
    for path in [folder, program.as_path()] {
        fs::set_permissions(path, fs::Permissions::from_mode(0o755)).unwrap();
    }
    if geteuid().is_root() {
        chown(&experiment.out, Some(NOBODY), Some(NOBODY)).unwrap();
    }
    program
}

/// Runs the program as `nobody` if we are root, or else as ourselves, who have no rights either.
fn as_nobody(program: &Path) -> Command {
    let mut command = command_of(program);
    if geteuid().is_root() {
        command.uid(NOBODY).gid(NOBODY);
    }
    command
}
