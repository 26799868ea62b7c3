//! Makes the cells of one combination of a block's settings, once its values are read: one for each repeat, topology,
//! system, client and h.

use std::collections::BTreeMap;
use std::fmt;
use std::str::FromStr;

use crate::system::{Program, System};
use endpoint::{ControllerSettings, Field, Mode, PageSettings, PlantSettings, Preset, SampleTime};
use text::Diagnostic;

use crate::cell::Cell;
use crate::client::{Client, UnknownClient};
use crate::experiment::{Block, Combination};
use crate::invalid::{Reader, Word};
use crate::own::OwnName;
use crate::plan::Plan;
use crate::seed::link_seed;
use crate::stall::stalling_seed;

/// What the cells of a combination have in common.
struct Common<'a> {
    chosen: &'a Combination,
    mode: Mode,
    duration_ns: u64,
    preset: Option<Preset>,
    clients: Vec<(&'a Word, Client)>,
    rates: Vec<(&'a Word, SampleTime)>,
    fault: Option<&'a String>,
    together: u16,
}

impl Reader<'_> {
    /// Adds one combination of a block's settings to the plan: a cell for each repeat, topology,
    /// system, client and h.
    pub(crate) fn combination(
        &self,
        block: &Block,
        chosen: &Combination,
        topologies: &[String],
        systems: &[System],
        fault: Option<&String>,
        plan: &mut Plan,
    ) -> Result<(), Diagnostic> {
        let duration = |key: &str| chosen.get(key).map(|word| self.duration(word)).transpose();
        let client = |word| Ok((word, self.client(word, &plan.programs)?));
        let clients = block.words("client").iter();
        let rate = |word| Ok((word, self.word(word)?));
        let rates = block.words("h").iter();
        let common = Common {
            chosen,
            mode: self.chosen(chosen, "mode")?.unwrap_or_default(),
            duration_ns: duration("duration")?.unwrap_or_default(),
            preset: self.chosen(chosen, "preset")?,
            clients: clients.map(client).collect::<Result<_, Diagnostic>>()?,
            rates: rates.map(rate).collect::<Result<_, Diagnostic>>()?,
            fault,
            together: block.together.get() as u16,
        };
        for repeat in 1..=block.repeats.get() {
            for (topology, system) in topologies
                .iter()
                .flat_map(|topology| systems.iter().map(move |system| (topology, system)))
            {
                let link_seed = self.link_seed(block, plan, topology, repeat)?;
                for client in &common.clients {
                    for rate in &common.rates {
                        let mut cell = self.cell(&common, system, *client, *rate)?;
                        cell.topology.clone_from(topology);
                        (cell.repeat, cell.link_seed) = (repeat, link_seed);
                        cell.identify();
                        plan.cells.push(cell);
                    }
                }
            }
        }
        Ok(())
    }

    /// A cell of a combination, still without its link.
    fn cell(
        &self,
        common: &Common<'_>,
        system: &System,
        (named, client): (&Word, Client),
        rate: (&Word, SampleTime),
    ) -> Result<Cell, Diagnostic> {
        let preset = common.preset.unwrap_or(client.spec().preset);
        let (settings, plant) = self.settings(common, preset, system, rate)?;
        let suits = client
            .check(&settings, plant.lease)
            .and_then(|()| system.check(&settings));
        suits.map_err(|invalid| {
            let place = common.chosen.get(invalid.name).unwrap_or(named);
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
            system: system.name().to_owned(),
            duration_ns: common.duration_ns,
            y0: system.y0(),
            reference: system.reference().cloned(),
            fault: common.fault.cloned(),
            together: common.together,
            ..Cell::new(client, preset, settings, &plant)
        };
        cell.page = self.page(common.chosen, &cell, named)?;
        Ok(cell)
    }

    /// The settings of a cell's client and of its plant.
    fn settings(
        &self,
        common: &Common<'_>,
        preset: Preset,
        system: &System,
        (place, h): (&Word, SampleTime),
    ) -> Result<(ControllerSettings, PlantSettings), Diagnostic> {
        // The plant of any but the paper's clients is safe, unless the block says otherwise. In
        // open loop it applies nothing.
        let mut plant = if common.mode == Mode::Open || preset.is_of_the_paper() {
            PlantSettings::new(h)
        } else {
            PlantSettings::safe(h)
        };
        let of_plant = PlantSettings::lists().map(|(field, _)| &field.option);
        self.lay(of_plant, common.chosen, &mut plant)?;
        if h.ns() > common.duration_ns {
            let problem = format!("h = {h} is longer than the run");
            return Err(self.invalid(place, problem, "lengthen `duration`"));
        }
        let mut settings = preset.settings(common.mode, h);
        settings.late = plant.late;
        // At the start; an error where the reference cannot move so in this run.
        let reference = system.reference_over(h, common.duration_ns);
        (settings.r, _) = reference.map_err(|problem| {
            let problem = format!("system {}: {problem}", system.name());
            self.invalid(place, problem, "")
        })?;
        self.lay(ControllerSettings::FIELDS, common.chosen, &mut settings)?;
        Ok((settings, plant))
    }

    /// The client that a word names: one of webloop's, or a program of one's own.
    fn client(
        &self,
        word: &Word,
        programs: &BTreeMap<OwnName, Program>,
    ) -> Result<Client, Diagnostic> {
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
    ) -> Result<u64, Diagnostic> {
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

    /// The settings of a cell's page; `None` if the client is not a browser.
    fn page(
        &self,
        chosen: &Combination,
        cell: &Cell,
        named: &Word,
    ) -> Result<Option<PageSettings>, Diagnostic> {
        let mut page = cell.preset.page();
        self.lay(PageSettings::FIELDS, chosen, &mut page)?;
        if !cell.client.is_browser() {
            return Ok(None);
        }
        match page.check(&cell.settings) {
            Ok(()) => Ok(Some(page)),
            Err(invalid) => {
                let problem = format!("in a browser {}", invalid.problem);
                Err(self.invalid(named, problem, invalid.remedy))
            }
        }
    }

    /// Overrides the preset's values with the chosen ones.
    fn lay<'a, S: 'a>(
        &self,
        fields: impl IntoIterator<Item = &'a Field<S>>,
        chosen: &Combination,
        settings: &mut S,
    ) -> Result<(), Diagnostic> {
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
    fn chosen<T: FromStr<Err: fmt::Display>>(
        &self,
        chosen: &Combination,
        key: &str,
    ) -> Result<Option<T>, Diagnostic> {
        chosen.get(key).map(|word| self.word(word)).transpose()
    }
}
