//! A sweep in a plan: kept with the profiles and systems that it names, and read again.

use std::collections::BTreeMap;

use text::{Diagnostic, TomlText, Whole};
use toml::Spanned;

use crate::expect::Expect;
use crate::experiment::ExperimentFile;
use crate::instead::Instead;
use crate::invalid::{Reader, Word};
use crate::library::Library;
use crate::plan::Plan;
use crate::sweep::reading::{Places, Reading};
use crate::sweep::table::SweepTable;
use crate::sweep::{Axis, Sweep, SweepText};

/// How long a made link's jitter keeps its value by default: within the range that suits diego-vpn.
const HOLD_NS: u64 = 50_000_000;

impl Reader<'_> {
    /// Refuses what an experiment has beside a sweep and a sweep has no use for.
    pub(crate) fn only_a_sweep(
        &self,
        table: &Spanned<SweepTable>,
        file: &ExperimentFile,
    ) -> Result<(), Diagnostic> {
        let expects = !self.clauses(&file.expect, &Expect::default())?.is_empty();
        let others = [
            ("[[cells]]", !file.cells.is_empty()),
            ("[expect]", expects),
            ("[[known]]", !file.known.is_empty()),
            ("[[fault]]", !file.fault.is_empty()),
        ];
        match others.iter().find(|(_, is_there)| *is_there) {
            None => Ok(()),
            Some((other, _)) => Err(self.invalid(
                table,
                format!("a sweep has no use for {other}, and the experiment has both"),
                "write two experiments",
            )),
        }
    }

    /// Checks a sweep, and keeps it in the plan with the profiles and systems that it names.
    pub(crate) fn sweep(
        &self,
        table: &Spanned<SweepTable>,
        instead: &Instead,
        plan: &mut Plan,
        library: &mut impl Library,
    ) -> Result<(), Diagnostic> {
        let own = table.get_ref();
        let mut axes = own.axes();
        for (axis, words) in instead.fixed() {
            let place = axes.get(&axis).map_or(0..0, Spanned::span);
            let placed = |word: &String| Spanned::new(place.clone(), word.clone());
            let only = words.iter().map(placed).collect();
            axes.insert(axis, Spanned::new(place.clone(), only));
        }
        for (axis, words) in &mut axes {
            for word in words.get_mut() {
                let name = match axis {
                    Axis::Topology => self.topology(word, &mut plan.profiles, library)?,
                    Axis::System => self.system(word, &[], plan, library)?.name().to_owned(),
                    _ => continue,
                };
                *word.get_mut() = name;
            }
        }
        let hold_ns = own.hold.as_ref().map(|hold| self.duration(hold));
        let sweep = SweepText {
            duration_ns: match &instead.duration {
                None => self.duration(&own.duration)?,
                Some(word) => self.duration(&Spanned::new(own.duration.span(), word.clone()))?,
            },
            repeats: instead.repeats.map_or(own.repeats.get(), Whole::get),
            rho: *own.rho.get_ref(),
            hold_ns: hold_ns.transpose()?.unwrap_or(HOLD_NS),
            axes: axes
                .iter()
                .map(|(axis, words)| (*axis, texts(words)))
                .collect(),
        };
        let places = Places {
            whole: table.span(),
            duration: own.duration.span(),
            rho: own.rho.span(),
        };
        plan.reading(*self, places, axes, &sweep).sweep()?;
        plan.sweep = Some(sweep);
        Ok(())
    }
}

impl Plan {
    /// Its sweep, if it has one.
    ///
    /// # Errors
    /// [`Diagnostic`] without a place, if it cannot be run; that of a plan that was read from a file was checked.
    pub fn swept(&self) -> Result<Option<Sweep>, Diagnostic> {
        let Some(text) = &self.sweep else {
            return Ok(None);
        };
        let word = |word: &String| Spanned::new(0..0, word.clone());
        let words = |words: &Vec<String>| Spanned::new(0..0, words.iter().map(word).collect());
        let axes = text.axes.iter().map(|(axis, of)| (*axis, words(of)));
        let nowhere = Reader(TomlText {
            text: "",
            origin: "",
        });
        let sweep = self
            .reading(nowhere, Places::default(), axes.collect(), text)
            .sweep()?;
        Ok(Some(Sweep {
            name: self.experiment.clone(),
            about: self.about.clone(),
            seed: self.seed,
            ..sweep
        }))
    }

    fn reading<'a>(
        &'a self,
        text: Reader<'a>,
        places: Places,
        axes: BTreeMap<Axis, Spanned<Vec<Word>>>,
        common: &'a SweepText,
    ) -> Reading<'a> {
        Reading {
            text,
            places,
            axes,
            common,
            profiles: &self.profiles,
            systems: &self.systems,
        }
    }
}

/// The words of an axis, without their places.
fn texts(words: &Spanned<Vec<Word>>) -> Vec<String> {
    let words = words.get_ref().iter();
    words.map(|word| word.get_ref().clone()).collect()
}
