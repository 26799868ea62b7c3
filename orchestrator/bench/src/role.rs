//! Webloop's roles and peers' servers as processes, which end with the value, and their memory.

use std::io::{self, BufRead, BufReader};
use std::net::SocketAddr;
use std::path::Path;
use std::process::{Child, Command, Stdio};

use rustix::process::{Pid, Signal, kill_process};
use shaper::Namespace;

use crate::contender::{Lack, Measured};
use crate::context::Context;

/// A process that runs until this value is dropped.
#[derive(Debug)]
pub(crate) struct Process(Child);

impl Process {
    /// Starts `command`, in a namespace if one is given.
    pub(crate) fn start(
        command: &mut Command,
        namespace: Option<&Namespace>,
    ) -> Result<Process, Lack> {
        command.stdin(Stdio::null()).stdout(Stdio::piped());
        backend::spawn::bind(command, namespace)?;
        Ok(Process(command.spawn()?))
    }

    /// What is resident of it, kB.
    pub(crate) fn resident_kb(&self) -> Result<f64, Lack> {
        self.status_kb("VmRSS:")
    }

    /// The most that was, kB.
    pub(crate) fn most_kb(&self) -> Result<f64, Lack> {
        self.status_kb("VmHWM:")
    }

    /// A line of proc(5)'s status, which counts in 1024 bytes.
    fn status_kb(&self, name: &str) -> Result<f64, Lack> {
        let text = std::fs::read_to_string(format!("/proc/{}/status", self.0.id()))?;
        let line = text.lines().find_map(|line| line.strip_prefix(name));
        let kib = line.and_then(|line| line.split_whitespace().next()?.parse::<f64>().ok());
        let kib = kib.ok_or_else(|| Lack(format!("the kernel does not say {name} of it")))?;
        Ok(kib * 1.024)
    }

    /// Stops it until what this gives is dropped.
    pub(crate) fn stop(&self) -> io::Result<Stopped> {
        let id = i32::try_from(self.0.id()).ok().and_then(Pid::from_raw);
        let id = id.ok_or(io::ErrorKind::NotFound)?;
        kill_process(id, Signal::STOP)?;
        Ok(Stopped(id))
    }

    /// Asks it to end, and waits until it has.
    pub(crate) fn end(mut self) -> io::Result<()> {
        backend::spawn::terminate(&mut self.0);
        self.0.wait()?;
        Ok(())
    }
}

impl Drop for Process {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// A process that is stopped until this value is dropped.
#[derive(Debug)]
pub(crate) struct Stopped(Pid);

impl Drop for Stopped {
    fn drop(&mut self) {
        let _ = kill_process(self.0, Signal::CONT);
    }
}

/// A process that serves until this value is dropped.
#[derive(Debug)]
pub(crate) struct Role {
    pub(crate) process: Process,
    /// Where it listens.
    pub(crate) address: SocketAddr,
}

impl Role {
    /// Starts `command` and waits for its line `ready ADDRESS:PORT`.
    pub(crate) fn start(command: &mut Command) -> Result<Role, Lack> {
        let mut process = Process::start(command, None)?;
        let mut line = String::new();
        if let Some(out) = process.0.stdout.take() {
            BufReader::new(out).read_line(&mut line)?;
        }
        let word = line.trim().rsplit([' ', '/']).next().unwrap_or_default();
        match word.parse() {
            Ok(address) => Ok(Role { process, address }),
            Err(_) => Err(Lack("its server did not start".to_owned())),
        }
    }

    /// Webloop's plant with this sample time.
    pub(crate) fn plant(context: &Context<'_>, h: &str, folder: &Path) -> Result<Role, Lack> {
        let mut command = Command::new(&context.programs.webloop);
        command
            .args(["serve", "plant", "--listen", "127.0.0.1:0", "--h", h])
            .arg("--out")
            .arg(folder);
        Role::start(&mut command)
    }

    /// A server of this binary without a plant: an end that peers are measured with, by its words.
    pub(crate) fn server(context: &Context<'_>, words: &[&str]) -> Result<Role, Lack> {
        Role::start(Command::new(&context.programs.own).arg("end").args(words))
    }

    /// Asks it to end, and waits until it has.
    pub(crate) fn end(self) -> io::Result<()> {
        self.process.end()
    }
}

/// Whether there is such a program in PATH; if not, who has it.
pub(crate) fn needs(name: &str, package: &str) -> Result<(), Lack> {
    let path = std::env::var_os("PATH").unwrap_or_default();
    if std::env::split_paths(&path).any(|folder| folder.join(name).is_file()) {
        return Ok(());
    }
    Err(Lack(format!("no `{name}` in PATH; {package} has it")))
}

/// Runs a program to its end, and gives what it printed.
pub(crate) fn output(command: &mut Command) -> Result<String, Lack> {
    output_in(command, None)
}

/// The same in a namespace.
pub(crate) fn output_in(
    command: &mut Command,
    namespace: Option<&Namespace>,
) -> Result<String, Lack> {
    command.stdin(Stdio::null());
    backend::spawn::bind(command, namespace)?;
    let output = command.output()?;
    if output.status.success() {
        return Ok(String::from_utf8_lossy(&output.stdout).into_owned());
    }
    let said = String::from_utf8_lossy(&output.stderr);
    let last = said.lines().rfind(|line| !line.trim().is_empty());
    let name = command.get_program().to_string_lossy();
    Err(Lack(match last {
        Some(line) => format!("{name}: {}", text::plain(line.trim())),
        None => format!("{name} ended with {}", output.status),
    }))
}

/// The figures that a script has printed, among other lines: a name and a value a line.
pub(crate) fn figures(said: &str) -> Result<Measured, Lack> {
    const NAMES: [&str; 7] = [
        "p50_us",
        "p99_us",
        "p99.9_us",
        "sd_us",
        "x_real",
        "read_mb_s",
        "write_mb_s",
    ];
    let figure = |line: &str| {
        let (name, value) = line.split_once(' ')?;
        let name = NAMES.iter().find(|known| **known == name)?;
        Some((*name, value.trim().parse().ok()?))
    };
    let figures: Measured = said.lines().filter_map(figure).collect();
    if figures.is_empty() {
        return Err(Lack("it printed no figures".to_owned()));
    }
    Ok(figures)
}
