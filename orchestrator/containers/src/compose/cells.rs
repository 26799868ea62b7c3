//! Runs cells in containers: starts the orchestrator's container and watches it from the host.

use std::process::Child;
use std::sync::mpsc::{self, Receiver};
use std::time::Duration;

use rustix::process::{Pid, Signal, kill_process};

use crate::compose::docker::{ask, kill, unstarted};
use crate::compose::problem::Problem;
use crate::compose::project::Project;
use crate::compose::tail::Tail;

/// What Compose prints if it does not start the orchestrator because an agent is unhealthy.
const AGENT_UNWELL: &str = "dependency failed to start";

/// Time limit for the engine to pass on a signal, and for reading the agents' last words.
const WITHIN: Duration = Duration::from_secs(10);

/// Running cells. Dropping this ends Compose but not the containers; [`Project::down`] ends those.
pub struct Cells<'project> {
    project: &'project Project,
    child: Child,
    tail: Tail,
    lines: Receiver<String>,
}

/// How the orchestrator ended.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Ended {
    /// Its exit code; `None` if Compose was killed.
    pub code: Option<i32>,
    /// Its last words; if it could not be started, also those of the agents.
    pub words: String,
}

impl Project {
    /// Runs cells of the campaign's plan, once the agents are up and healthy. `options` are further
    /// options of `webloop run-cell`.
    ///
    /// If the leash arranges it, the child dies with the calling thread, so that thread has to live
    /// as long as the cells.
    ///
    /// # Errors
    /// When Compose cannot be started. [`Cells::ended`] reports how the cells end.
    pub fn run_cells(&mut self, indices: &[usize], options: &[&str]) -> Result<Cells<'_>, Problem> {
        let indices: Vec<String> = indices.iter().map(usize::to_string).collect();
        let (name, indices) = (self.orchestrator(), indices.join(","));
        let mut command = self.compose(&["run", "--rm", "--no-TTY", "--name", &name])?;
        command
            .args(["orchestrator", "run-cell", "--plan", "/results/plan.json"])
            .args([
                "--index",
                &indices,
                "--out",
                "/results",
                "--backend",
                "attach",
            ])
            .args(options);
        self.up = true;
        let child = command.spawn().map_err(|problem| unstarted(&problem))?;
        Ok(Cells::new(self, child))
    }
}

impl<'project> Cells<'project> {
    pub(crate) fn new(project: &'project Project, mut child: Child) -> Self {
        let (sender, lines) = mpsc::channel();
        let tail = Tail::of(&mut child, move |line| {
            // The receiver may be gone.
            let _ = sender.send(line.to_owned());
        });
        Cells {
            project,
            child,
            tail,
            lines,
        }
    }

    /// Output of the orchestrator since the last call, line by line. It includes Compose's own
    /// report of its steps, indented.
    pub fn said(&self) -> impl Iterator<Item = String> {
        self.lines.try_iter()
    }

    /// How it ended; `None` if it still runs. Does not wait.
    ///
    /// # Errors
    /// When the system does not give the state of its process.
    pub fn ended(&mut self) -> Result<Option<Ended>, Problem> {
        let status = self
            .child
            .try_wait()
            .map_err(|problem| Problem::failed("wait for docker compose", &problem))?;
        let Some(status) = status else {
            return Ok(None);
        };
        let mut words = self.tail.words();
        if words.contains(AGENT_UNWELL) {
            words.push_str(&self.project.words_of_agents(WITHIN));
        }
        Ok(Some(Ended {
            code: status.code(),
            words,
        }))
    }

    /// Tells the orchestrator to end: it still writes its rows and ends the agents.
    ///
    /// Compose does not pass a signal on to its containers, so this asks the engine. If the
    /// orchestrator does not exist yet, Compose itself gets the signal.
    pub fn terminate(&mut self) {
        let name = self.project.orchestrator();
        let told = ask(&["container", "kill", "--signal", "TERM", &name], WITHIN)
            .is_ok_and(|answer| answer.status.success());
        if !told
            && matches!(self.child.try_wait(), Ok(None))
            && let Some(pid) = i32::try_from(self.child.id()).ok().and_then(Pid::from_raw)
        {
            let _ = kill_process(pid, Signal::TERM);
        }
    }
}

impl Drop for Cells<'_> {
    fn drop(&mut self) {
        kill(&mut self.child);
    }
}
