//! Turns the lists of an experiment into the cells of a plan: checks every value, and gives every error
//! its place. `combination` makes the cells.
//!
//! It reads no files: the caller passes the text and a way to look up profiles and systems.

use std::collections::{BTreeMap, BTreeSet};
use std::str::FromStr;

use crate::system::{Program, System};
use text::{Diagnostic, TomlText};
use toml::Spanned;

use crate::expect::Expectations;
use crate::experiment::{Block, ExperimentFile};
use crate::fault::Fault;
use crate::instead::Instead;
use crate::invalid::{Reader, Word};
use crate::library::Library;
use crate::limit::CELLS_MAX;
use crate::own::OwnName;
use crate::plan::Plan;

impl Plan {
    /// Resolves an experiment's TOML.
    ///
    /// `origin` names the text in errors. `instead` replaces what the file says. `library` gives
    /// the texts of profiles and systems by the names or paths that the experiment uses, or says why
    /// it cannot.
    ///
    /// # Errors
    /// [`Diagnostic`], with line and column, if the text is not an experiment that can run.
    pub fn resolve(
        source: &str,
        origin: &str,
        instead: &Instead,
        mut library: impl Library,
    ) -> Result<Plan, Diagnostic> {
        let text = TomlText {
            text: source,
            origin,
        };
        let reader = Reader(text);
        let examples = "the book's page Experiments has an example";
        let file: ExperimentFile = reader.parse(examples)?;
        let name = reader.name(&file.name)?;
        let mut plan = Plan {
            version: Plan::VERSION,
            experiment: name,
            about: file.about.clone(),
            seed: instead.seed.unwrap_or(file.seed),
            ..Plan::default()
        };
        if let Some(table) = &file.sweep {
            reader.only_a_sweep(table, &file)?;
            reader.sweep(table, instead, &mut plan, &mut library)?;
        } else if file.cells.is_empty() {
            return Err(reader.invalid(
                &Spanned::new(0..0, ()),
                "the experiment has no cells",
                "add a [[cells]] block with topology, client, mode, h and duration, or a [sweep]",
            ));
        } else if let Some((axis, _)) = instead.fixed.first() {
            return Err(reader.invalid(
                &Spanned::new(0..0, ()),
                format!("`{axis}` cannot be fixed, since the experiment is no sweep"),
                "leave --fix out",
            ));
        }
        let faults = reader.faults(&file.fault)?;
        let mut expectations = Expectations::default();
        for block in &file.cells {
            let block = &instead.over(block);
            let (topologies, systems) = reader.named(block, &mut plan, &mut library)?;
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
            .map_err(|problem| text.error(0..0, problem.to_string(), ""))?;
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
    ) -> Result<(), Diagnostic> {
        let size = block.size();
        if size == 0 {
            return Err(self.invalid(
                &block.place(),
                "the block of this `mode` describes no cell",
                "give topology, client, h, mode and duration at least one value",
            ));
        }
        if plan.cells.len().saturating_add(size) > CELLS_MAX {
            let problem =
                format!("the block of this `mode` brings the plan to more than {CELLS_MAX} cells");
            let remedy = "split the experiment, or lower `repeats`";
            return Err(self.invalid(&block.place(), problem, remedy));
        }
        let is_unknown = |name: &&Word| !topologies.contains(name.get_ref());
        if let Some(name) = block.words("stall_met").iter().find(is_unknown) {
            let problem = format!("`{}` is not a topology of this block", name.get_ref());
            let remedy = "name one of them, as it is called in its profile";
            return Err(self.invalid(name, problem, remedy));
        }
        block.combinations().iter().try_for_each(|chosen| {
            let fault = match chosen.get("fault") {
                Some(word) => self.fault(word, faults, plan)?,
                None => None,
            };
            self.combination(block, chosen, topologies, systems, fault.as_ref(), plan)
        })
    }

    /// Keeps a program of one's own under its name.
    fn program(
        &self,
        named: &Word,
        program: Program,
        programs: &mut BTreeMap<OwnName, Program>,
    ) -> Result<(), Diagnostic> {
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

    /// Parses a word; the error of the type lists the choices.
    pub(crate) fn word<T: FromStr<Err: std::fmt::Display>>(
        &self,
        word: &Spanned<String>,
    ) -> Result<T, Diagnostic> {
        word.get_ref()
            .parse()
            .map_err(|error: T::Err| self.invalid(word, error.to_string(), ""))
    }

    /// Refuses equal cells: they would write into one folder.
    fn no_twins(&self, plan: &Plan) -> Result<(), Diagnostic> {
        let mut seen = BTreeMap::new();
        for cell in &plan.cells {
            if seen.insert(&cell.id, cell.index).is_some() {
                let problem = format!("the experiment has the cell {} twice", cell.id);
                let remedy = "remove one of the two, or use `repeats`";
                return Err(self.invalid(&Spanned::new(0..0, ()), problem, remedy));
            }
        }
        Ok(())
    }
}
