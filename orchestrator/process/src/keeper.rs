//! Keeps the process of a plant of somebody's own: starts it, takes in its end, and brings that about.

use std::ffi::OsString;
use std::io;
use std::os::fd::OwnedFd;
use std::os::unix::net::UnixStream;
use std::os::unix::process::CommandExt;
use std::process::{Child, Command};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, OnceLock, mpsc};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use rustix::process::{Pid, Signal, kill_process_group};

use crate::exit::exit_code;
use crate::plant::start::{Confinement, Start};
use crate::program::{keep, unsheltered};
use crate::python_path::PythonPath;
use crate::shelter::Shelter;
use crate::spawn;

/// How long a program may take to end when its input has ended.
pub(crate) const END_WITHIN: Duration = Duration::from_secs(1);

/// How often to look whether it has ended.
const LOOK_EVERY: Duration = Duration::from_millis(10);

/// The thread that started a program and takes in its end: the program dies with it.
#[derive(Debug)]
pub(crate) struct Keeper {
    code: Arc<OnceLock<i32>>,
    is_over: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl Keeper {
    pub(crate) fn start(start: &Start<'_>, theirs: UnixStream) -> io::Result<Keeper> {
        let (printed, writer) = io::pipe()?;
        let log = keep(printed)?;
        let run = start.run.to_vec();
        let package = PythonPath::new()?;
        let mut environment: Vec<_> = start.environment.clone();
        environment.push(package.variable());
        let confinement = start.confinement.clone();
        let (code, is_over) = (Arc::new(OnceLock::new()), Arc::new(AtomicBool::new(false)));
        let (tell, told) = mpsc::channel();
        let thread = thread::Builder::new().name("plant-program".to_owned());
        let thread = thread.spawn({
            let (code, is_over) = (Arc::clone(&code), Arc::clone(&is_over));
            move || {
                let input = OwnedFd::from(theirs);
                let output = input.try_clone();
                let child = output.and_then(|output| {
                    spawn_program(&run, environment, &confinement, |command| {
                        command.stdin(input).stdout(output).stderr(writer);
                    })
                });
                match child {
                    Ok(child) => {
                        let _ = tell.send(Ok(()));
                        take_in(child, &code, &is_over);
                    }
                    Err(problem) => {
                        let _ = tell.send(Err(problem));
                    }
                }
                // What a process wrote that left the group is not waited for.
                let deadline = Instant::now() + END_WITHIN;
                while !log.is_finished() && Instant::now() < deadline {
                    thread::sleep(LOOK_EVERY);
                }
            }
        })?;
        told.recv()
            .unwrap_or_else(|_| Err(io::Error::other("its thread ended")))?;
        Ok(Keeper {
            code,
            is_over,
            thread: Some(thread),
        })
    }

    /// Its exit code, as a shell has it, once it has ended.
    pub(crate) fn code_within(&self, within: Duration) -> Option<i32> {
        let deadline = Instant::now() + within;
        loop {
            let code = self.code.get().copied();
            if code.is_some() || Instant::now() >= deadline {
                return code;
            }
            thread::sleep(LOOK_EVERY);
        }
    }

    /// Waits for its end, which is near: its input has ended. Kills it after a second.
    pub(crate) fn end(&mut self) {
        self.is_over.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

/// Starts a program that dies with the calling thread: confined in a PID namespace of its own where that is
/// wanted and allowed, or else in a process group of its own.
fn spawn_program(
    run: &[String],
    environment: Vec<(&'static str, OsString)>,
    confinement: &Confinement,
    attach: impl FnOnce(&mut Command),
) -> io::Result<Child> {
    if let Confinement::Confined(hidden) = confinement
        && spawn::separate().is_ok()
    {
        let mut command = Command::new("/proc/self/exe");
        command.args(["serve", "first", "--"]).args(run);
        spawn::confine(&mut command, Shelter::find(hidden.as_ref())?);
        attach(command.process_group(0).envs(environment));
        return command.spawn().map_err(unsheltered);
    }
    let (program, arguments) = run
        .split_first()
        .ok_or_else(|| io::Error::other("it has no command"))?;
    let mut command = Command::new(program);
    command.args(arguments);
    spawn::bind(&mut command, None::<&OwnedFd>)?;
    attach(command.process_group(0).envs(environment));
    command.spawn()
}

/// Waits for a program's end, and brings it about when all is over.
fn take_in(mut child: Child, code: &OnceLock<i32>, is_over: &AtomicBool) {
    let group = i32::try_from(child.id()).ok().and_then(Pid::from_raw);
    let mut deadline = None;
    loop {
        match child.try_wait() {
            Ok(None) => {}
            Ok(Some(status)) => {
                let _ = code.set(exit_code(status));
                break;
            }
            Err(_) => break,
        }
        if is_over.load(Ordering::Relaxed) {
            let deadline = *deadline.get_or_insert_with(|| Instant::now() + END_WITHIN);
            if Instant::now() >= deadline {
                let _ = child.kill();
            }
        }
        thread::sleep(LOOK_EVERY);
    }
    // What it left behind, where it has no namespace that ends with it.
    if let Some(group) = group {
        let _ = kill_process_group(group, Signal::KILL);
    }
}
