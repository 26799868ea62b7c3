//! Cells that are still to be run, and how each back-end runs them.

use std::sync::atomic::{AtomicBool, Ordering};

use analysis::campaign::Fresh;
use backend::{Agents, Timings, Virtual};
use campaign::{CampaignFolder, CellRun, ComposeRunner, Inside, Own, Pace, Processes, Queue};
use plan::{Cell, Plan};

use crate::argument::{Run, word};
use crate::command::run_cell;
use crate::exit::{Failure, words};
use crate::progress::Progress;

/// Cells of a plan that are still to be run, and what they have in common.
pub(super) struct Pending<'a> {
    pub(super) argument: &'a Run,
    pub(super) plan: &'a Plan,
    pub(super) cells: &'a [&'a Cell],
    pub(super) folder: &'a CampaignFolder,
    pub(super) pace: Pace,
    pub(super) stop: &'a AtomicBool,
    pub(super) progress: &'a Progress,
}

impl Pending<'_> {
    /// Runs them in containers.
    pub(super) fn in_containers(&self, containers: &ComposeRunner) -> Result<(), Failure> {
        let tries = self.argument.tries.to_string();
        let inside = Inside {
            plan: self.plan,
            campaign: self.folder.path(),
            tries: self.argument.tries,
            options: &["--player", &word(&self.argument.player), "--tries", &tries],
        };
        containers.run(self.cells, &inside, self.stop, self.progress)?;
        Ok(())
    }

    /// Runs them in virtual time, in threads; returns what is known of their rows.
    pub(super) fn in_virtual_time(&self, timings: Timings, own: Own) -> Result<Fresh, Failure> {
        let queue = Queue::unmeasured(self.cells, self.pace.jobs.unwrap_or(1));
        let how = CellRun {
            campaign: self.folder.path(),
            backend: &backend::Backend::Sim(Box::new(Virtual::new(timings))),
            player: self.argument.player.into(),
            own,
            tries: self.argument.tries,
            together: 1,
        };
        let said = |problem: campaign::Error| words(&problem.into());
        let (plan, stop, progress) = (self.plan, self.stop, self.progress);
        Ok(campaign::simulate(
            &queue, plan, &how, stop, progress, said,
        )?)
    }

    /// Runs them in real time, each in a process.
    pub(super) fn in_processes(&self, agents: Option<&Agents>) -> Result<(), Failure> {
        let program = Processes(run_cell::command(self.argument, agents, self.folder)?);
        let (path, tries) = (self.folder.path(), self.argument.tries);
        let mut due = self.cells.to_vec();
        for last in (0..tries).rev() {
            let queue = Queue::new(&due, self.pace.jobs, clock::now::now_ns);
            due = campaign::run(&queue, path, &program, tries, self.stop, self.progress)?;
            if due.is_empty() || last == 0 || self.stop.load(Ordering::Relaxed) {
                break;
            }
            self.progress.on_again(due.len());
        }
        Ok(())
    }
}
