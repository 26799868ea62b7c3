//! One call of the command `docker`: bounded in time, without a terminal, with its own errors.

use std::io::{self, Read};
use std::os::unix::process::CommandExt;
use std::process::{Child, Command, ExitStatus, Stdio};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use rustix::process::{Pid, Signal, kill_process_group};

use crate::compose::problem::Problem;

/// How often to check whether a call has ended.
pub(crate) const POLL: Duration = Duration::from_millis(10);

/// The remedy if the command is missing.
const INSTALL: &str = "install Docker Engine and its Compose plugin, 2.20 or later";

/// Result of a call.
#[derive(Debug)]
pub(crate) struct DockerOutput {
    pub(crate) status: ExitStatus,
    pub(crate) out: String,
    pub(crate) err: String,
}

impl DockerOutput {
    /// Its last words, in one line.
    pub(crate) fn words(&self) -> String {
        last_line(&self.err)
            .or_else(|| last_line(&self.out))
            .unwrap_or_else(|| format!("docker ended with {}", self.status))
    }
}

/// `docker` without arguments yet, in a process group of its own: Ctrl-C reaches the process that
/// started it but not docker, so that a campaign ends in order.
pub(crate) fn docker() -> Command {
    let mut command = Command::new("docker");
    command
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        // Keeps advertisements out of the output.
        .env("DOCKER_CLI_HINTS", "false")
        .process_group(0);
    command
}

/// Calls `docker` and waits for its answer, which may be a failure.
pub(crate) fn ask(arguments: &[&str], within: Duration) -> Result<DockerOutput, Problem> {
    let mut command = docker();
    command.args(arguments);
    call(command, within)
}

/// Calls a command made by [`docker`], and kills it when its time is up.
pub(crate) fn call(mut command: Command, within: Duration) -> Result<DockerOutput, Problem> {
    let mut child = command.spawn().map_err(|problem| unstarted(&problem))?;
    let (out, err) = (read_all(child.stdout.take()), read_all(child.stderr.take()));
    let deadline = Instant::now() + within;
    let status = loop {
        match child.try_wait() {
            Ok(Some(status)) => break status,
            Ok(None) if Instant::now() < deadline => std::thread::sleep(POLL),
            Ok(None) => {
                kill(&mut child);
                return Err(Problem::failed(
                    sentence(&command),
                    &format!("no answer within {} s; check the engine", within.as_secs()),
                ));
            }
            Err(problem) => return Err(Problem::failed(sentence(&command), &problem)),
        }
    };
    let text = |reader: JoinHandle<String>| reader.join().unwrap_or_default();
    Ok(DockerOutput {
        status,
        out: text(out),
        err: text(err),
    })
}

/// Why `docker` could not be started.
pub(crate) fn unstarted(problem: &io::Error) -> Problem {
    if problem.kind() == io::ErrorKind::NotFound {
        Problem::lacks("there is no command docker", INSTALL)
    } else {
        Problem::failed("start the command docker", problem)
    }
}

/// Kills a child made from [`docker`], with the plugins that it started, and waits for it.
pub(crate) fn kill(child: &mut Child) {
    // The kernel does not reuse its process number until it has been waited for.
    if matches!(child.try_wait(), Ok(None))
        && let Some(group) = i32::try_from(child.id()).ok().and_then(Pid::from_raw)
    {
        let _ = kill_process_group(group, Signal::KILL);
        let _ = child.wait();
    }
}

/// The command as a person would read it.
fn sentence(command: &Command) -> String {
    let arguments: Vec<_> = command
        .get_args()
        .map(|argument| argument.to_string_lossy())
        .collect();
    format!("run `docker {}`", arguments.join(" "))
}

/// Reads on a thread of its own, so that the child never blocks on a full pipe.
fn read_all(stream: Option<impl Read + Send + 'static>) -> JoinHandle<String> {
    std::thread::spawn(move || {
        let mut bytes = Vec::new();
        if let Some(mut stream) = stream {
            let _ = stream.read_to_end(&mut bytes);
        }
        String::from_utf8_lossy(&bytes).into_owned()
    })
}

/// The last line that is not empty and not advice on where to read more.
fn last_line(text: &str) -> Option<String> {
    text.lines()
        .map(str::trim)
        .rfind(|line| {
            !line.is_empty() && !line.starts_with("See '") && !line.starts_with("Run 'docker")
        })
        .map(str::to_owned)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_docker_said_last_is_its_problem_and_not_its_advice() {
        let text = "docker: Error response from daemon: no such thing.\n\nRun 'docker run --help' for more information\n";
        assert_eq!(
            last_line(text).as_deref(),
            Some("docker: Error response from daemon: no such thing.")
        );
        assert_eq!(last_line(" \n\n"), None);
    }

    #[test]
    fn a_call_that_does_not_end_is_killed_with_what_it_started() {
        let mut command = Command::new("sh");
        command
            .args(["-c", "sleep 60 & sleep 60"])
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .process_group(0);
        let started = Instant::now();
        let problem = call(command, Duration::from_millis(100)).expect_err("it never answers");
        assert!(started.elapsed() < Duration::from_secs(20));
        assert!(
            problem.to_string().contains("no answer within"),
            "{problem}"
        );
    }
}
