//! From an experiment's lists to a plan's cells, every value checked and every error placed.
//!
//! Reading files is left to the caller, who hands in the texts and a way to look up profiles.

use std::collections::{BTreeMap, BTreeSet};
use std::str::FromStr;

use endpoint::{ControllerSettings, Hold, Mode, PageSettings, Preset, SampleTime};
use jiff::SignedDuration;
use system::System;
use toml::Spanned;

use crate::cell::Cell;
use crate::client::Client;
use crate::experiment::{Block, ExperimentFile};
use crate::seed::link_seed;
use crate::{Instead, Library, Misfit, Plan};

/// The longest run: a week. Beyond it a typing error is likelier than a run.
const DURATION_MAX: SignedDuration = SignedDuration::from_hours(24 * 7);

/// The most cells at a time, as with `--jobs`.
const TOGETHER_MAX: u16 = 64;

/// The most cells of one plan; the paper's whole matrix has 433.
const CELLS_MAX: usize = 100_000;

impl Plan {
    /// Resolves an experiment's TOML.
    ///
    /// `origin` names the text in errors. `instead` replaces what the file says. `library` gives
    /// the texts of profiles and systems by the names or paths that the experiment uses, or says why
    /// it cannot.
    ///
    /// # Errors
    /// [`Misfit`], with line and column, for everything that is not an experiment that can run.
    pub fn resolve(
        source: &str,
        origin: &str,
        instead: &Instead,
        mut library: impl Library,
    ) -> Result<Plan, Misfit> {
        let file: ExperimentFile = toml::from_str(source).map_err(|error| {
            let span = error.span().unwrap_or(0..0);
            Misfit::new(
                source,
                origin,
                span,
                error.message(),
                "see the experiments in orchestrator/experiments for examples",
            )
        })?;
        let reader = Reader { source, origin };
        let name = reader.name(&file.name)?;
        if file.cells.is_empty() {
            return Err(Misfit::new(
                source,
                origin,
                0..0,
                "the experiment has no cells",
                "add a [[cells]] block with topology, client, mode, h and duration",
            ));
        }
        let mut plan = Plan {
            version: Plan::VERSION,
            experiment: name,
            about: file.about.clone(),
            seed: instead.seed.unwrap_or(file.seed),
            profiles: BTreeMap::new(),
            systems: BTreeMap::new(),
            cells: Vec::new(),
        };
        for block in &file.cells {
            let block = &instead.over(block);
            let topologies = block
                .topology
                .iter()
                .map(|name| reader.topology(name, &mut plan.profiles, &mut library))
                .collect::<Result<Vec<_>, _>>()?;
            let systems = match block.system.as_slice() {
                [] => vec![System::paper()],
                asked => asked
                    .iter()
                    .map(|name| reader.system(name, block, &mut plan.systems, &mut library))
                    .collect::<Result<Vec<_>, _>>()?,
            };
            reader.block(block, &topologies, &systems, &mut plan)?;
        }
        if instead.joins_blocks() {
            let mut seen = BTreeSet::new();
            plan.cells.retain(|cell| seen.insert(cell.id.clone()));
        }
        // Repeats go round the whole matrix, so that what drifts on this machine over an hour
        // falls on every cell alike and not on the last one's repeats.
        plan.cells.sort_by_key(|cell| cell.repeat);
        for (index, cell) in plan.cells.iter_mut().enumerate() {
            cell.index = index;
        }
        reader.no_twins(&plan)?;
        Ok(plan)
    }
}

/// The text being read, for the places of errors.
pub(crate) struct Reader<'a> {
    source: &'a str,
    origin: &'a str,
}

impl Reader<'_> {
    pub(crate) fn misfit<T>(
        &self,
        at: &Spanned<T>,
        problem: impl Into<String>,
        remedy: &str,
    ) -> Misfit {
        Misfit::new(self.source, self.origin, at.span(), problem, remedy)
    }

    /// A name that can start a folder's name.
    fn name(&self, name: &Spanned<String>) -> Result<String, Misfit> {
        let text = name.get_ref();
        let plain = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '-';
        if text.is_empty() || text.len() > 40 || !text.chars().all(plain) {
            return Err(self.misfit(
                name,
                format!("`{text}` cannot name a results folder"),
                "use up to 40 of a-z, 0-9 and -",
            ));
        }
        Ok(text.clone())
    }

    /// Adds every combination of a block's lists to the plan.
    fn block(
        &self,
        block: &Block,
        topologies: &[String],
        systems: &[System],
        plan: &mut Plan,
    ) -> Result<(), Misfit> {
        let mode: Mode = self.word(&block.mode)?;
        let duration_ns = self.duration(&block.duration)?;
        if !(1..=TOGETHER_MAX).contains(block.together.get_ref()) {
            return Err(self.misfit(
                &block.together,
                format!("`together` is not between 1 and {TOGETHER_MAX}"),
                "1 runs each of these cells alone",
            ));
        }
        let preset = block
            .preset
            .as_ref()
            .map(|word| self.word(word))
            .transpose()?;
        let clients = block
            .client
            .iter()
            .map(|word| self.word::<Client>(word).map(|client| (word, client)))
            .collect::<Result<Vec<_>, _>>()?;
        let rates = block
            .h
            .iter()
            .map(|h| self.word::<SampleTime>(h).map(|value| (h, value)))
            .collect::<Result<Vec<_>, _>>()?;
        if block.repeats == 0 || topologies.is_empty() || clients.is_empty() || rates.is_empty() {
            return Err(self.misfit(
                &block.mode,
                "the block of this `mode` describes no cell",
                "give topology, client and h at least one value, and repeats at least 1",
            ));
        }
        let size = [topologies.len(), systems.len(), clients.len(), rates.len()]
            .iter()
            .fold(block.repeats as usize, |size, n| size.saturating_mul(*n));
        if plan.cells.len().saturating_add(size) > CELLS_MAX {
            return Err(self.misfit(
                &block.mode,
                format!("the block of this `mode` brings the plan to more than {CELLS_MAX} cells"),
                "split the experiment, or lower `repeats`",
            ));
        }
        let mut hold = Hold::Last;
        self.lay(&block.hold, &mut hold)?;
        for repeat in 1..=block.repeats {
            for (topology, system) in topologies
                .iter()
                .flat_map(|topology| systems.iter().map(move |system| (topology, system)))
            {
                for (named, client) in &clients {
                    let preset = preset.unwrap_or(client.preset());
                    for (place, h) in &rates {
                        if h.ns() > duration_ns {
                            return Err(self.misfit(
                                place,
                                format!("h = {h} is longer than the run"),
                                "lengthen `duration`",
                            ));
                        }
                        let mut settings = self.settings(block, preset.settings(mode, *h))?;
                        settings.r = system.r();
                        let mut cell = Cell {
                            index: 0,
                            id: String::new(),
                            topology: topology.clone(),
                            system: system.name().to_owned(),
                            client: *client,
                            preset,
                            repeat,
                            link_seed: link_seed(plan.seed, topology, repeat),
                            duration_ns,
                            settings,
                            hold,
                            page: self.page(block, *client, preset, &settings, named)?,
                            together: *block.together.get_ref(),
                        };
                        cell.identify();
                        plan.cells.push(cell);
                    }
                }
            }
        }
        Ok(())
    }

    /// The preset's settings with the block's own words laid over them.
    fn settings(
        &self,
        block: &Block,
        preset: ControllerSettings,
    ) -> Result<ControllerSettings, Misfit> {
        let mut settings = preset;
        self.lay(&block.outstanding, &mut settings.outstanding)?;
        self.lay(&block.transport, &mut settings.transport)?;
        self.lay(&block.connection, &mut settings.connection)?;
        self.lay(&block.schedule, &mut settings.schedule)?;
        self.lay(&block.integrate, &mut settings.integrate)?;
        self.lay(&block.late, &mut settings.late)?;
        if let Some(timeout) = &block.timeout {
            settings.timeout_ns = self.duration(timeout)?;
        }
        if let (Some(word), Some(problem)) = (&block.connection, settings.misfit()) {
            let (problem, remedy) = problem.split_once("; ").unwrap_or((problem, ""));
            return Err(self.misfit(word, problem, remedy));
        }
        Ok(settings)
    }

    /// How the page goes about it, where the client is a browser.
    fn page(
        &self,
        block: &Block,
        client: Client,
        preset: Preset,
        settings: &ControllerSettings,
        named: &Spanned<String>,
    ) -> Result<Option<PageSettings>, Misfit> {
        let mut page = preset.page();
        self.lay(&block.thread, &mut page.thread)?;
        self.lay(&block.sender, &mut page.sender)?;
        self.lay(&block.timer, &mut page.timer)?;
        if let Some(floor) = &block.timer_floor {
            page.floor_ns = self.duration(floor)?;
        }
        if !client.is_browser() {
            return Ok(None);
        }
        match page.misfit(settings) {
            Some(problem) => {
                let (problem, remedy) = problem.split_once("; ").unwrap_or((problem, ""));
                Err(self.misfit(named, format!("in a browser {problem}"), remedy))
            }
            None => Ok(Some(page)),
        }
    }

    fn lay<T: FromStr<Err: std::fmt::Display>>(
        &self,
        word: &Option<Spanned<String>>,
        setting: &mut T,
    ) -> Result<(), Misfit> {
        if let Some(word) = word {
            *setting = self.word(word)?;
        }
        Ok(())
    }

    /// A word that its type knows; the type's own error lists the choices.
    pub(crate) fn word<T: FromStr<Err: std::fmt::Display>>(
        &self,
        word: &Spanned<String>,
    ) -> Result<T, Misfit> {
        word.get_ref()
            .parse()
            .map_err(|error: T::Err| self.misfit(word, error.to_string(), ""))
    }

    fn duration(&self, text: &Spanned<String>) -> Result<u64, Misfit> {
        let remedy = "write it with its unit, like 6s, 500ms or 10m";
        let duration: SignedDuration = text.get_ref().parse().map_err(|_| {
            self.misfit(
                text,
                format!("`{}` is not a length of time", text.get_ref()),
                remedy,
            )
        })?;
        if duration <= SignedDuration::ZERO || duration > DURATION_MAX {
            return Err(self.misfit(
                text,
                format!("`{}` is not between 0 and a week", text.get_ref()),
                remedy,
            ));
        }
        // Between 0 and a week in ns is far inside u64.
        Ok(u64::try_from(duration.as_nanos()).unwrap_or(u64::MAX))
    }

    /// Two equal cells would write into one folder.
    fn no_twins(&self, plan: &Plan) -> Result<(), Misfit> {
        let mut seen = BTreeMap::new();
        for cell in &plan.cells {
            if seen.insert(&cell.id, cell.index).is_some() {
                return Err(Misfit::new(
                    self.source,
                    self.origin,
                    0..0,
                    format!("the experiment asks twice for the cell {}", cell.id),
                    "remove one of the two, or use `repeats`",
                ));
            }
        }
        Ok(())
    }
}
