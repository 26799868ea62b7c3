//! Runs a plan's cells in containers: a Compose project for each kind of ends, from its images to its end.
//!
//! The orchestrator in there writes into the campaign's folder, which it shares with this process.
//! A cell has ended when its manifest is there.

use std::fs::File;
use std::path::Path;
use std::process::Command;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use containers::compose::{Cells, ComposeFile, Ended, Ends, Engine, Problem, Project};
use plan::{Cell, Plan, Verdict};
use record::Manifest;

use crate::ends::ends;
use crate::error::Error;
use crate::progress::{Begun, Progress};

/// How often to check manifests, containers and the stop flag.
const POLL: Duration = Duration::from_millis(200);

/// What containers need. It is found before anything is created.
#[derive(Debug)]
pub struct ComposeRunner {
    engine: Engine,
    file: ComposeFile,
    /// Whether to build the images first, as far as they are out of date.
    build: bool,
}

/// Settings of the orchestrator in the containers.
#[derive(Debug, Clone, Copy)]
pub struct Inside<'a> {
    /// What is run.
    pub plan: &'a Plan,
    /// The campaign's folder.
    pub campaign: &'a Path,
    /// Maximum number of runs of a cell while it is disturbed.
    pub tries: u8,
    /// Its options besides plan, cells and folder.
    pub options: &'a [&'a str],
}

impl ComposeRunner {
    /// Looks for engine, Compose and webloop's compose file. Images will be built if `build`, or
    /// else used as they are.
    ///
    /// # Errors
    /// When one of the three is missing.
    pub fn find(build: bool) -> Result<ComposeRunner, Error> {
        Ok(ComposeRunner {
            engine: Engine::check()?,
            file: ComposeFile::find(None)?,
            build,
        })
    }

    /// Runs those of `cells` that are not complete yet, and takes everything down.
    ///
    /// Runs the cells with the same containers one after another.
    ///
    /// # Errors
    /// When the engine fails, or the containers end before the cells do.
    pub fn run(
        &self,
        cells: &[&Cell],
        inside: &Inside<'_>,
        stop: &AtomicBool,
        progress: &dyn Progress,
    ) -> Result<(), Error> {
        let mut by_ends: Vec<(Ends, Vec<&Cell>)> = Vec::new();
        for cell in cells {
            let ends = ends(inside.plan, cell).map_err(Error::Compose)?;
            match by_ends.iter_mut().find(|(known, _)| *known == ends) {
                Some((_, cells)) => cells.push(cell),
                None => by_ends.push((ends, vec![cell])),
            }
        }
        for (ends, cells) in by_ends {
            if !stop.load(Ordering::Relaxed) {
                self.run_ends(ends, &cells, inside, stop, progress)?;
            }
        }
        Ok(())
    }

    fn run_ends(
        &self,
        ends: Ends,
        cells: &[&Cell],
        inside: &Inside<'_>,
        stop: &AtomicBool,
        progress: &dyn Progress,
    ) -> Result<(), Error> {
        let engine = self.engine.to_string();
        let mut project = Project::new(self.file.clone(), inside.campaign, &engine, ends, leash)?;
        if self.build {
            progress.say("building the images; the first time this takes minutes");
            match project.build(stop, |line| tracing::info!("{line}")) {
                Err(Problem::Interrupted) => return Ok(()),
                built => built?,
            }
        } else {
            project.has_images()?;
        }
        let mut watch = Watch::new(cells, inside.campaign, inside.tries)?;
        let indices = watch.indices();
        if indices.is_empty() {
            return Ok(());
        }
        let mut running = project.run_cells(&indices, inside.options)?;
        let ended = watch.until_ended(&mut running, progress, stop);
        drop(running);
        let down = project.down();
        let ended = ended?;
        down?;
        if watch.pending.is_empty() || stop.load(Ordering::Relaxed) {
            return Ok(());
        }
        // Some cells have no manifest, so the last words are all there is to report.
        Err(Error::Unfinished {
            source: ended.words.into(),
            code: ended.code,
        })
    }
}

/// The cells to wait for.
struct Watch<'a> {
    campaign: &'a Path,
    tries: u8,
    /// Each cell with the manifest of an earlier run, if it has one.
    pending: Vec<(&'a Cell, Option<Manifest>)>,
}

impl<'a> Watch<'a> {
    fn new(cells: &[&'a Cell], campaign: &'a Path, tries: u8) -> Result<Watch<'a>, Error> {
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

    /// Reports the end of each cell when its manifest is there, until the orchestrator has ended.
    fn until_ended(
        &mut self,
        running: &mut Cells<'_>,
        progress: &dyn Progress,
        stop: &AtomicBool,
    ) -> Result<Ended, Error> {
        let mut told = false;
        let mut begun: Option<Begun<'_>> = None;
        loop {
            // Look for the end first, so that manifests written before it are still read below.
            let ended = running.ended()?;
            running.said().for_each(|line| tracing::info!("{line}"));
            while let Some((cell, manifest)) = self.next()? {
                drop(begun.take());
                let reason = manifest.reasons.join("; ");
                progress.on_ended(cell, manifest.verdict, &reason);
            }
            if let Some(ended) = ended {
                return Ok(ended);
            }
            if stop.load(Ordering::Relaxed) && !told {
                told = true;
                running.terminate();
            }
            if begun.is_none()
                && let Some((cell, _)) = self.pending.first()
            {
                begun = Some(Begun::new(progress, cell));
            }
            std::thread::sleep(POLL);
        }
    }

    /// Whether a disturbed run will be repeated.
    fn is_asked_again(&self, manifest: &Manifest) -> bool {
        manifest.verdict == Verdict::Disturbed
            && manifest.earlier.len() + 1 < usize::from(self.tries)
    }

    /// The first pending cell, if its manifest is there.
    fn next(&mut self) -> Result<Option<(&'a Cell, Manifest)>, Error> {
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

fn manifest(campaign: &Path, cell: &Cell) -> Result<Option<Manifest>, Error> {
    Ok(Manifest::read(&campaign.join(cell.folder()))?)
}

/// Makes docker end when this process does, whatever ends it.
fn leash(command: &mut Command) -> std::io::Result<()> {
    backend::spawn::bind(command, None::<&File>)
}
