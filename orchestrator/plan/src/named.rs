//! Looks up the topologies and systems that an experiment names, checks them, and keeps them in the
//! plan.

use std::collections::BTreeMap;

use crate::system::System;
use endpoint::SampleTime;
use text::{Diagnostic, or_nearest};
use toml::Spanned;

use crate::experiment::Block;
use crate::invalid::{Reader, Word};
use crate::library::Library;
use crate::plan::Plan;
use crate::profile_text::ProfileText;

/// Maximum bytes of all traces of a plan together, which is one file.
const TRACES_BYTES: usize = 64 << 20;

impl Reader<'_> {
    /// Looks up the topologies and the systems of a block, which has the paper's system if it names none.
    pub(crate) fn named(
        &self,
        block: &Block,
        plan: &mut Plan,
        library: &mut impl Library,
    ) -> Result<(Vec<String>, Vec<System>), Diagnostic> {
        let topologies = block.words("topology").iter();
        let topologies = topologies
            .map(|name| self.topology(name, &mut plan.profiles, library))
            .collect::<Result<_, _>>()?;
        let systems = match block.words("system") {
            [] => vec![System::paper()],
            asked => asked
                .iter()
                .map(|name| self.system(name, block.words("h"), plan, library))
                .collect::<Result<_, _>>()?,
        };
        Ok((topologies, systems))
    }

    /// Looks up the profile of a topology, checks it, and keeps its source under its own name, which it
    /// returns.
    pub(crate) fn topology(
        &self,
        asked: &Spanned<String>,
        profiles: &mut BTreeMap<String, ProfileText>,
        library: &mut impl Library,
    ) -> Result<String, Diagnostic> {
        let text = library.profile(asked.get_ref()).map_err(|problem| {
            let remedy = format!(
                "use one of {}, or the path of a profile file",
                link::Profile::choices()
            );
            let names = link::Profile::names();
            self.invalid(asked, problem, &or_nearest(asked.get_ref(), names, &remedy))
        })?;
        let parsed = text.profile(asked.get_ref()).map_err(|findings| {
            let problem = findings
                .iter()
                .map(|finding| format!("  {}", finding.inside()))
                .collect::<Vec<_>>()
                .join("\n");
            let remedy = format!(
                "`webloop link lint {}` shows each in its place",
                asked.get_ref()
            );
            self.invalid(
                asked,
                format!("the profile cannot be played:\n{problem}"),
                &remedy,
            )
        })?;
        let name = parsed.name().to_owned();
        let text = text.kept(&parsed);
        if profiles
            .insert(name.clone(), text.clone())
            .is_some_and(|before| before != text)
        {
            return Err(self.invalid(
                asked,
                format!("two different profiles are both named `{name}`"),
                "give one of them another `name`",
            ));
        }
        let texts = profiles.values().flat_map(|text| text.traces.values());
        let bytes: usize = texts.map(String::len).sum();
        if bytes > TRACES_BYTES {
            let problem = format!(
                "with it the traces have {bytes} bytes, and a plan has room for {TRACES_BYTES}"
            );
            let remedy = "cut the traces, or make two experiments of it";
            return Err(self.invalid(asked, problem, remedy));
        }
        Ok(name)
    }

    /// Looks up a system, checks it with every one of these h, and keeps its text under its name, with the
    /// program that is its plant if it has one.
    pub(crate) fn system(
        &self,
        asked: &Spanned<String>,
        rates: &[Word],
        plan: &mut Plan,
        library: &mut impl Library,
    ) -> Result<System, Diagnostic> {
        let text = library.system(asked.get_ref()).map_err(|problem| {
            let names: Vec<&str> = System::built_in_names().collect();
            let remedy = format!(
                "use one of {}, or the path of a system file",
                names.join(", ")
            );
            let names = System::built_in_names();
            self.invalid(asked, problem, &or_nearest(asked.get_ref(), names, &remedy))
        })?;
        let system = System::read(&text).map_err(|fault| {
            let remedy = format!(
                "`webloop system lint {}` shows it in its place",
                asked.get_ref()
            );
            self.invalid(
                asked,
                format!("it is not a valid system: {}", fault.inside()),
                &remedy,
            )
        })?;
        for h in rates {
            let value: SampleTime = self.word(h)?;
            if let Err(unfit) = system.law_at(value) {
                let remedy = "use another h, or another system";
                return Err(self.invalid(asked, unfit.to_string(), remedy));
            }
        }
        let name = system.name().to_owned();
        if system.is_paper() {
            return Ok(system);
        }
        let program = system
            .plant_program()
            .map(|program| program.with_paths(|word| library.word_beside(asked.get_ref(), word)));
        let had_program = match &program {
            Some(program) => plan.plants.insert(name.clone(), program.clone()),
            None => plan.plants.get(&name).cloned(),
        };
        match plan.systems.insert(name.clone(), text.clone()) {
            Some(before) if before != text || had_program != program => Err(self.invalid(
                asked,
                format!("two different systems are both named `{name}`"),
                "give one of them another `name`",
            )),
            _ => Ok(system),
        }
    }
}
