//! Runs a plan's cells in containers: one Compose project, from the images to its end.
//!
//! The orchestrator in there writes into the campaign's folder, which it shares with this
//! process; a cell's manifest says that the cell has ended.

use std::fs::File;
use std::process::Command;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use anyhow::anyhow;
use backend::Manifest;
use compose::{Cells, ComposeFile, Ended, Engine, Problem, Project};
use plan::{Cell, Client, Verdict};

use crate::campaign::Campaign;
use crate::exit::{Exit, Failure};
use crate::jobs::{Conditions, word};
use crate::progress::{CellBar, Progress};

/// How often manifests, the containers, and whether to stop are looked at.
const POLL: Duration = Duration::from_millis(200);

/// What containers need, found before anything is made.
pub(crate) struct ComposeRunner {
    engine: Engine,
    file: ComposeFile,
    /// Whether the images are built first, as far as they are not up to date.
    build: bool,
}

impl ComposeRunner {
    /// Looks for engine, Compose and webloop's compose file; the images are to be built if
    /// `build`, or else used as they are.
    pub(crate) fn find(build: bool) -> Result<ComposeRunner, Failure> {
        Ok(ComposeRunner {
            engine: Engine::check().map_err(failure)?,
            file: ComposeFile::find(None).map_err(failure)?,
            build,
        })
    }

    /// Runs `cells`, those that are complete already left out, and takes everything down.
    ///
    /// One client after another, since each has a container of its own kind.
    pub(crate) fn run(
        self,
        cells: &[&Cell],
        campaign: &Campaign,
        conditions: &Conditions<'_>,
        stop: &AtomicBool,
        progress: &Progress,
    ) -> Result<(), Failure> {
        for client in Client::ALL {
            let cells: Vec<&Cell> = cells
                .iter()
                .copied()
                .filter(|cell| cell.client == client)
                .collect();
            if !cells.is_empty() && !stop.load(Ordering::Relaxed) {
                self.run_client(client, &cells, campaign, conditions, stop, progress)?;
            }
        }
        Ok(())
    }

    fn run_client(
        &self,
        client: Client,
        cells: &[&Cell],
        campaign: &Campaign,
        conditions: &Conditions<'_>,
        stop: &AtomicBool,
        progress: &Progress,
    ) -> Result<(), Failure> {
        let (engine, client) = (self.engine.to_string(), client.to_string());
        let file = self.file.clone();
        let mut project =
            Project::new(file, campaign.folder(), &engine, &client, leash).map_err(failure)?;
        if self.build {
            progress.say("building the images; the first time that takes minutes");
            match project.build(stop, |line| tracing::info!("{line}")) {
                Err(Problem::Interrupted) => return Ok(()),
                built => built.map_err(failure)?,
            }
        } else {
            project.has_images().map_err(failure)?;
        }
        let mut watch = Watch::new(cells, campaign, conditions.tries)?;
        let indices = watch.indices();
        if indices.is_empty() {
            return Ok(());
        }
        let tries = conditions.tries.to_string();
        let options = ["--player", &word(&conditions.player), "--tries", &tries];
        let mut running = project.run_cells(&indices, &options).map_err(failure)?;
        let ended = watch.until_ended(&mut running, progress, stop);
        drop(running);
        let down = project.down().map_err(failure);
        let ended = ended?;
        down?;
        match watch.pending.is_empty() || stop.load(Ordering::Relaxed) {
            true => Ok(()),
            false => Err(unfinished(&ended)),
        }
    }
}

/// Cells that are waited for.
struct Watch<'a> {
    campaign: &'a Campaign,
    tries: u8,
    /// With what an earlier try left.
    pending: Vec<(&'a Cell, Option<Manifest>)>,
}

impl<'a> Watch<'a> {
    fn new(cells: &[&'a Cell], campaign: &'a Campaign, tries: u8) -> anyhow::Result<Watch<'a>> {
        let mut pending = Vec::new();
        for cell in cells {
            let before = manifest(campaign, cell)?;
            let complete = before.as_ref().is_some_and(|before| {
                before.verdict == Verdict::Complete && before.cell.is_same(cell)
            });
            if !complete {
                pending.push((*cell, before));
            }
        }
        Ok(Watch {
            campaign,
            tries,
            pending,
        })
    }

    fn indices(&self) -> Vec<usize> {
        self.pending.iter().map(|(cell, _)| cell.index).collect()
    }

    /// Tells each cell's end as its manifest comes, until the orchestrator has ended.
    fn until_ended(
        &mut self,
        running: &mut Cells<'_>,
        progress: &Progress,
        stop: &AtomicBool,
    ) -> anyhow::Result<Ended> {
        let mut told = false;
        let mut bar: Option<CellBar> = None;
        loop {
            // In this order, so that what was written before the end is seen after it.
            let ended = running.ended()?;
            running.said().for_each(|line| tracing::info!("{line}"));
            while let Some((cell, manifest)) = self.next()? {
                drop(bar.take());
                let reason = manifest.reasons.join("; ");
                progress.end(cell, manifest.verdict, &reason);
            }
            if let Some(ended) = ended {
                return Ok(ended);
            }
            if stop.load(Ordering::Relaxed) && !told {
                told = true;
                running.terminate();
            }
            if bar.is_none()
                && let Some((cell, _)) = self.pending.first()
            {
                bar = Some(progress.begin(cell));
            }
            std::thread::sleep(POLL);
        }
    }

    /// Whether a run that was disturbed is about to be made again.
    fn is_asked_again(&self, manifest: &Manifest) -> bool {
        manifest.verdict == Verdict::Disturbed
            && manifest.earlier.len() + 1 < usize::from(self.tries)
    }

    /// The first cell, if its manifest has come.
    fn next(&mut self) -> anyhow::Result<Option<(&'a Cell, Manifest)>> {
        let Some((cell, before)) = self.pending.first() else {
            return Ok(None);
        };
        let cell = *cell;
        match manifest(self.campaign, cell)? {
            Some(now)
                if before.as_ref().is_none_or(|old| old.started != now.started)
                    && !self.is_asked_again(&now) =>
            {
                self.pending.remove(0);
                Ok(Some((cell, now)))
            }
            _ => Ok(None),
        }
    }
}

fn manifest(campaign: &Campaign, cell: &Cell) -> anyhow::Result<Option<Manifest>> {
    backend::manifest(campaign.folder(), cell).map_err(|problem| anyhow!(problem))
}

/// Ends docker with this process, whatever ends that.
fn leash(command: &mut Command) -> std::io::Result<()> {
    backend::spawn::bind(command, None::<&File>)
}

/// Cells without a manifest: what was said last is all there is to tell.
fn unfinished(ended: &Ended) -> Failure {
    let error = anyhow!("{}", ended.words).context("the containers ended before the cells did");
    match ended.code {
        Some(code) if code == Exit::Usage as i32 => Failure::usage(error),
        Some(code) if code == Exit::Unsupported as i32 => Failure::unsupported(error),
        _ => error.into(),
    }
}

/// A problem with the engine, by its kind.
pub(crate) fn failure(problem: Problem) -> Failure {
    match problem {
        Problem::Unsupported { .. } => Failure::unsupported(problem),
        Problem::Usage(_) => Failure::usage(problem),
        Problem::Failed { .. } | Problem::Interrupted => problem.into(),
    }
}
