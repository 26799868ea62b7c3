//! Turns the lists of an experiment into the cells of a plan: checks every value, and gives every error
//! its place.
//!
//! It reads no files: the caller passes the text and a way to look up profiles and systems.

use std::collections::{BTreeMap, BTreeSet};
use std::str::FromStr;

use endpoint::{
    ControllerSettings, Field, Hold, Lease, Mode, NoiseLaw, PageSettings, PlantSettings, Preset,
    SampleTime,
};
use system::System;
use toml::Spanned;

use crate::cell::Cell;
use crate::client::{Client, UnknownClient};
use crate::expect::Expectations;
use crate::experiment::{Block, Combination, ExperimentFile, Word};
use crate::fault::Fault;
use crate::seed::link_seed;
use crate::stall::stalling_seed;
use crate::{Instead, InvalidFile, Library, OwnName, Plan, Program, Reader};

/// Most cells that may run at a time, as for `--jobs`.
pub(crate) const TOGETHER_MAX: u16 = 64;

/// Most cells in one plan; the paper's whole matrix has 1142.
pub(crate) const CELLS_MAX: usize = 100_000;

impl Plan {
    /// Resolves an experiment's TOML.
    ///
    /// `origin` names the text in errors. `instead` replaces what the file says. `library` gives
    /// the texts of profiles and systems by the names or paths that the experiment uses, or says why
    /// it cannot.
    ///
    /// # Errors
    /// [`InvalidFile`], with line and column, if the text is not an experiment that can run.
    pub fn resolve(
        source: &str,
        origin: &str,
        instead: &Instead,
        mut library: impl Library,
    ) -> Result<Plan, InvalidFile> {
        let reader = Reader { source, origin };
        let examples = "see the experiments in orchestrator/experiments for examples";
        let file: ExperimentFile = reader.parse(examples)?;
        let name = reader.name(&file.name)?;
        if file.cells.is_empty() {
            return Err(reader.invalid(
                &Spanned::new(0..0, ()),
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
            programs: BTreeMap::new(),
            plants: BTreeMap::new(),
            expect: Vec::new(),
            known: Vec::new(),
            faults: BTreeMap::new(),
            cells: Vec::new(),
        };
        let faults = reader.faults(&file.fault)?;
        let mut expectations = Expectations::default();
        for block in &file.cells {
            let block = &instead.over(block);
            let topologies = block
                .words("topology")
                .iter()
                .map(|name| reader.topology(name, &mut plan.profiles, &mut library))
                .collect::<Result<Vec<_>, _>>()?;
            let systems = match block.words("system") {
                [] => vec![System::paper()],
                asked => asked
                    .iter()
                    .map(|name| reader.system(name, block, &mut plan, &mut library))
                    .collect::<Result<Vec<_>, _>>()?,
            };
            for (name, program) in block.programs() {
                let program = program.with_paths(|word| library.word(word));
                reader.program(name, program, &mut plan.programs)?;
            }
            let before = plan.cells.len();
            reader.block(block, &topologies, &systems, &faults, &mut plan)?;
            let clauses = reader.clauses(&file.expect, &block.expect)?;
            expectations.ask(clauses, &plan.cells[before..]);
        }
        if instead.joins_blocks() {
            let mut seen = BTreeSet::new();
            plan.cells.retain(|cell| seen.insert(cell.id.clone()));
        }
        // Every cell runs once before any cell runs again: a drift of this machine over an hour then
        // affects all cells alike, and not just the repeats of the last one.
        plan.cells.sort_by_key(|cell| cell.repeat);
        for (index, cell) in plan.cells.iter_mut().enumerate() {
            cell.index = index;
        }
        reader.no_twins(&plan)?;
        plan.expect = expectations.of(&plan.cells, reader)?;
        plan.known = reader.known(&file.known, &plan.cells, instead.joins_blocks())?;
        // Only names can still be wrong: that of a trace, or that of a topology if it is too long.
        plan.check()
            .map_err(|problem| InvalidFile::new(source, origin, 0..0, problem, ""))?;
        Ok(plan)
    }
}

impl Reader<'_> {
    /// Adds every combination of a block's lists to the plan.
    fn block(
        &self,
        block: &Block,
        topologies: &[String],
        systems: &[System],
        faults: &BTreeMap<String, Fault>,
        plan: &mut Plan,
    ) -> Result<(), InvalidFile> {
        if !(1..=TOGETHER_MAX).contains(block.together.get_ref()) {
            return Err(self.invalid(
                &block.together,
                format!("`together` is not between 1 and {TOGETHER_MAX}"),
                "1 runs each of these cells alone",
            ));
        }
        let size = block.size();
        if size == 0 {
            return Err(self.invalid(
                &block.place(),
                "the block of this `mode` describes no cell",
                "give topology, client, h, mode and duration at least one value, and repeats at least 1",
            ));
        }
        if plan.cells.len().saturating_add(size) > CELLS_MAX {
            return Err(self.invalid(
                &block.place(),
                format!("the block of this `mode` brings the plan to more than {CELLS_MAX} cells"),
                "split the experiment, or lower `repeats`",
            ));
        }
        let is_unknown = |name: &&Word| !topologies.contains(name.get_ref());
        if let Some(name) = block.words("stall_met").iter().find(is_unknown) {
            return Err(self.invalid(
                name,
                format!("`{}` is not a topology of this block", name.get_ref()),
                "name one of them, as it is called in its profile",
            ));
        }
        block.combinations().iter().try_for_each(|chosen| {
            let fault = match chosen.get("fault") {
                Some(word) => self.fault(word, faults, plan)?,
                None => None,
            };
            self.combination(block, chosen, topologies, systems, fault.as_ref(), plan)
        })
    }

    /// Adds one combination of a block's settings to the plan: a cell for each repeat, topology,
    /// system, client and h.
    fn combination(
        &self,
        block: &Block,
        chosen: &Combination,
        topologies: &[String],
        systems: &[System],
        fault: Option<&String>,
        plan: &mut Plan,
    ) -> Result<(), InvalidFile> {
        let mode: Mode = self.chosen(chosen, "mode")?.unwrap_or_default();
        let duration_ns = match chosen.get("duration") {
            Some(word) => self.duration(word)?,
            None => 0,
        };
        let preset: Option<Preset> = self.chosen(chosen, "preset")?;
        let words = block.words("client").iter();
        let clients = words
            .map(|word| Ok((word, self.client(word, &plan.programs)?)))
            .collect::<Result<Vec<_>, InvalidFile>>()?;
        let rates = self.read_all::<SampleTime>(block.words("h"))?;
        let hold: Option<Hold> = self.chosen(chosen, "hold")?;
        let max_age_ns = match chosen.get("max_age") {
            Some(word) => Some(self.duration(word)?),
            None => None,
        };
        let lease: Option<Lease> = self.chosen(chosen, "lease")?;
        let tick_noise: Option<NoiseLaw> = self.chosen(chosen, "tick_noise")?;
        for repeat in 1..=block.repeats {
            for (topology, system) in topologies
                .iter()
                .flat_map(|topology| systems.iter().map(move |system| (topology, system)))
            {
                let link_seed = self.link_seed(block, plan, topology, repeat)?;
                for (named, client) in &clients {
                    let preset = preset.unwrap_or(client.spec().preset);
                    for (place, h) in &rates {
                        if h.ns() > duration_ns {
                            return Err(self.invalid(
                                place,
                                format!("h = {h} is longer than the run"),
                                "lengthen `duration`",
                            ));
                        }
                        let mut settings = preset.settings(mode, *h);
                        // The plant of any but the paper's clients is safe, unless the block says otherwise. In
                        // open loop it applies nothing.
                        let plant = if mode == Mode::Open || preset.is_of_the_paper() {
                            PlantSettings::new(*h)
                        } else {
                            PlantSettings::safe(*h)
                        };
                        settings.late = plant.late;
                        settings.r = self.first_r(system, *h, duration_ns, place)?;
                        self.lay(ControllerSettings::FIELDS, chosen, &mut settings)?;
                        let suits = settings.check().and_then(|()| system.check(&settings));
                        suits.map_err(|invalid| {
                            let place = chosen.get(invalid.name).unwrap_or(named);
                            self.invalid(place, invalid.problem, invalid.remedy)
                        })?;
                        if !client.is_own() && !system.gives_each_input() {
                            let name = system.name();
                            return Err(self.invalid(
                                named,
                                format!("the law of system {name} gives one command, and its plant has two inputs"),
                                "name a client of your own, like { name = \"mine\", run = [\"./mine\"] }",
                            ));
                        }
                        let mut cell = Cell {
                            index: 0,
                            id: String::new(),
                            topology: topology.clone(),
                            system: system.name().to_owned(),
                            client: *client,
                            preset,
                            repeat,
                            link_seed,
                            duration_ns,
                            settings,
                            y0: system.y0(),
                            reference: system.reference().cloned(),
                            hold: hold.unwrap_or(plant.hold),
                            max_age_ns,
                            lease: lease.unwrap_or(plant.lease),
                            tick_noise,
                            fault: fault.cloned(),
                            page: self.page(chosen, *client, preset, &settings, named)?,
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

    /// Keeps a program of one's own under its name.
    fn program(
        &self,
        named: &Word,
        program: Program,
        programs: &mut BTreeMap<OwnName, Program>,
    ) -> Result<(), InvalidFile> {
        let name: OwnName = self.word(named)?;
        if program.is_empty() {
            let remedy = "give the program and its arguments, like run = [\"./mine\"]";
            return Err(self.invalid(named, format!("`{name}` has nothing to `run`"), remedy));
        }
        let before = programs.get(&name).cloned();
        if before.is_none_or(|before| before == program) {
            programs.insert(name, program);
            Ok(())
        } else {
            Err(self.invalid(
                named,
                format!("two different programs are both named `{name}`"),
                "give one of them another `name`",
            ))
        }
    }

    /// The client that a word names: one of webloop's, or a program of one's own.
    fn client(
        &self,
        word: &Word,
        programs: &BTreeMap<OwnName, Program>,
    ) -> Result<Client, InvalidFile> {
        let own = word.get_ref().parse::<OwnName>().ok();
        match own.filter(|name| programs.contains_key(name)) {
            Some(name) => Ok(Client::Own(name)),
            None => word.get_ref().parse().map_err(|unknown: UnknownClient| {
                let remedy =
                    "a program of your own is a table: { name = \"mine\", run = [\"./mine\"] }";
                self.invalid(word, unknown.to_string(), remedy)
            }),
        }
    }

    /// The link's seed for a topology and a repeat, taking `stall_met` into account.
    fn link_seed(
        &self,
        block: &Block,
        plan: &Plan,
        topology: &str,
        repeat: u32,
    ) -> Result<u64, InvalidFile> {
        let named = block
            .words("stall_met")
            .iter()
            .find(|name| name.get_ref() == topology);
        let Some(named) = named else {
            return Ok(link_seed(plan.seed, topology, repeat));
        };
        // The profile was checked when it was read.
        let text = plan.profiles.get(topology);
        text.and_then(|text| text.profile(topology).ok())
            .and_then(|profile| stalling_seed(plan.seed, &profile, topology, repeat))
            .ok_or_else(|| {
                self.invalid(
                    named,
                    format!("no link of {topology} was found that stalls while the step responds"),
                    "leave it out of `stall_met`, or let the profile's stalls be longer or more frequent",
                )
            })
    }

    /// The system's reference at the start; an error where it cannot move so in this run.
    fn first_r(
        &self,
        system: &System,
        h: SampleTime,
        duration_ns: u64,
        place: &Spanned<String>,
    ) -> Result<f64, InvalidFile> {
        let (r, _) = system.reference_over(h, duration_ns).map_err(|problem| {
            let problem = format!("system {}: {problem}", system.name());
            self.invalid(place, problem, "")
        })?;
        Ok(r)
    }

    /// The page's settings; `None` if the client is not a browser.
    fn page(
        &self,
        chosen: &Combination,
        client: Client,
        preset: Preset,
        settings: &ControllerSettings,
        named: &Spanned<String>,
    ) -> Result<Option<PageSettings>, InvalidFile> {
        let mut page = preset.page();
        self.lay(PageSettings::FIELDS, chosen, &mut page)?;
        if !client.is_browser() {
            return Ok(None);
        }
        match page.check(settings) {
            Ok(()) => Ok(Some(page)),
            Err(invalid) => {
                let problem = format!("in a browser {}", invalid.problem);
                Err(self.invalid(named, problem, invalid.remedy))
            }
        }
    }

    /// Overrides the preset's values with the chosen ones.
    fn lay<S>(
        &self,
        fields: &[Field<S>],
        chosen: &Combination,
        settings: &mut S,
    ) -> Result<(), InvalidFile> {
        for field in fields {
            if let Some(word) = chosen.get(field.name) {
                field
                    .read(settings, word.get_ref())
                    .map_err(|invalid| self.invalid(word, invalid.problem, invalid.remedy))?;
            }
        }
        Ok(())
    }

    /// The chosen value of a key; `None` if the block does not give one.
    fn chosen<T: FromStr<Err: std::fmt::Display>>(
        &self,
        chosen: &Combination,
        key: &str,
    ) -> Result<Option<T>, InvalidFile> {
        chosen.get(key).map(|word| self.word(word)).transpose()
    }

    /// Parses each word; returns it with its value.
    fn read_all<'a, T: FromStr<Err: std::fmt::Display>>(
        &self,
        words: &'a [Word],
    ) -> Result<Vec<(&'a Word, T)>, InvalidFile> {
        words
            .iter()
            .map(|word| Ok((word, self.word(word)?)))
            .collect()
    }

    /// Parses a word; the error of the type lists the choices.
    pub(crate) fn word<T: FromStr<Err: std::fmt::Display>>(
        &self,
        word: &Spanned<String>,
    ) -> Result<T, InvalidFile> {
        word.get_ref()
            .parse()
            .map_err(|error: T::Err| self.invalid(word, error.to_string(), ""))
    }

    /// Refuses equal cells: they would write into one folder.
    fn no_twins(&self, plan: &Plan) -> Result<(), InvalidFile> {
        let mut seen = BTreeMap::new();
        for cell in &plan.cells {
            if seen.insert(&cell.id, cell.index).is_some() {
                return Err(self.invalid(
                    &Spanned::new(0..0, ()),
                    format!("the experiment has the cell {} twice", cell.id),
                    "remove one of the two, or use `repeats`",
                ));
            }
        }
        Ok(())
    }
}
