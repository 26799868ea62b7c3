//! Cells that run in containers: the orchestrator's container, watched from the host.

use std::process::Child;
use std::sync::mpsc::{self, Receiver};
use std::time::Duration;

use rustix::process::{Pid, Signal, kill_process};

use crate::docker::{ask, kill, unstarted};
use crate::tail::Tail;
use crate::{Problem, Project};

/// What Compose says where the orchestrator could not be started, because an agent was not well.
const AGENT_UNWELL: &str = "dependency failed to start";

/// For the engine to pass a signal on, and to find an agent's last words.
const WITHIN: Duration = Duration::from_secs(10);

/// Cells under way. Dropping it ends Compose, not the containers: [`Project::down`] does that.
pub struct Cells<'project> {
    project: &'project Project,
    child: Child,
    tail: Tail,
    lines: Receiver<String>,
}

/// How the orchestrator ended.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Ended {
    /// Its exit code; none where Compose was killed.
    pub code: Option<i32>,
    /// The last it said, and where it could not be started, what the agents said.
    pub words: String,
}

impl Project {
    /// Runs cells of the campaign's plan, after the agents are up and well. `options` are more
    /// options of `webloop run-cell`.
    ///
    /// The child dies with the calling thread where the leash sees to it, so that thread has
    /// to live as long as the cells.
    ///
    /// # Errors
    /// When Compose cannot be started. How the cells end, [`Cells::ended`] says.
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

    /// What the orchestrator said since this was last asked, line by line. Compose's own
    /// account of its steps is among it, indented.
    pub fn said(&self) -> impl Iterator<Item = String> {
        self.lines.try_iter()
    }

    /// Whether it has ended, and how; does not wait.
    ///
    /// # Errors
    /// When the system does not say it.
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
    /// Compose does not pass a signal on but leaves its containers alone; so this asks the
    /// engine. If the orchestrator is not there yet, Compose itself gets the signal.
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
