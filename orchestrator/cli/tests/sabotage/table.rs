//! A table of what became of each kind.

use std::collections::BTreeMap;

use crate::cell::Outcome;
use crate::kind::Kind;

/// Number of characters of a reason that are shown.
const SHOWN: usize = 100;

/// The cells of a kind, counted.
pub(crate) struct Row {
    kind: &'static Kind,
    made: usize,
    /// Cells that were `invalid` or `disturbed`.
    found: usize,
    /// Cells with a reason that has one of the kind's words.
    named: usize,
    verdicts: BTreeMap<String, usize>,
    /// One reason of each cell: the first that names the kind, or else the first.
    reasons: BTreeMap<String, usize>,
    /// Why no more of them can be made.
    pub(crate) skipped: Option<String>,
}

impl Row {
    pub(crate) fn new(kind: &'static Kind) -> Self {
        Self {
            kind,
            made: 0,
            found: 0,
            named: 0,
            verdicts: BTreeMap::new(),
            reasons: BTreeMap::new(),
            skipped: None,
        }
    }

    /// Records why no more of them can be made.
    pub(crate) fn skip(&mut self, reason: String) {
        self.skipped = Some(reason);
    }

    pub(crate) fn count(&mut self, outcome: &Outcome) {
        *self.verdicts.entry(outcome.verdict.clone()).or_default() += 1;
        match &outcome.done {
            // It may have ended before anything was done to it.
            _ if outcome.has_failed() => return,
            // We did nothing to it but the host did: a real disturbance, not a false alarm.
            _ if self.kind.words.is_empty() && outcome.is_host_s() => return,
            Err(problem) => return self.skip(problem.clone()),
            Ok(_) => self.made += 1,
        }
        self.found += usize::from(["invalid", "disturbed"].contains(&outcome.verdict.as_str()));
        let names = |reason: &&String| self.kind.words.iter().any(|word| reason.contains(word));
        let naming = outcome.reasons.iter().find(names);
        self.named += usize::from(naming.is_some());
        if let Some(reason) = naming.or(outcome.reasons.first()) {
            *self.reasons.entry(shape(reason)).or_default() += 1;
        }
    }

    /// To be called after the last cell.
    pub(crate) fn finish(&mut self) {
        if self.made == 0 && self.skipped.is_none() {
            self.skip(
                "the machine was too busy: no cell ran to its end undisturbed by it".to_owned(),
            );
        }
    }

    /// Whether it was found although nothing was done, or was not found or not named although
    /// something was done.
    pub(crate) fn is_missed(&self) -> bool {
        match (&self.skipped, self.kind.words) {
            (Some(_), _) => false,
            (None, []) => self.found >= self.made,
            (None, _) => self.found.min(self.named) < self.made,
        }
    }

    /// The result in a word, in the style of the usual harness.
    pub(crate) fn result(&self) -> String {
        match &self.skipped {
            Some(reason) => format!("SKIPPED: {reason}"),
            None if !self.is_missed() => "ok".to_owned(),
            None if self.kind.words.is_empty() => "FALSE ALARM".to_owned(),
            None if self.found < self.made => "NOT FOUND".to_owned(),
            None => "NOT NAMED".to_owned(),
        }
    }
}

/// A reason without its numbers, so that reasons of one cause are equal.
fn shape(reason: &str) -> String {
    let mut shape = String::new();
    for letter in reason.chars() {
        let letter = if letter.is_ascii_digit() { '#' } else { letter };
        if !(letter == '#' && shape.ends_with('#')) {
            shape.push(letter);
        }
    }
    shape.chars().take(SHOWN).collect()
}

/// Prints all rows.
pub(crate) fn print(rows: &[Row]) {
    let width = rows
        .iter()
        .map(|row| row.kind.name.len())
        .max()
        .unwrap_or(0);
    println!("\n{:width$}  made  found  named  verdicts; reasons", "kind");
    for row in rows {
        let list = |counts: &BTreeMap<String, usize>, separator: &str| {
            let words = counts.iter().map(|(word, count)| format!("{count} {word}"));
            words.collect::<Vec<_>>().join(separator)
        };
        println!(
            "{:width$}  {:4}  {:5}  {:5}  {}; {}",
            row.kind.name,
            row.made,
            row.found,
            row.named,
            row.skipped
                .clone()
                .unwrap_or_else(|| list(&row.verdicts, ", ")),
            list(&row.reasons, " | ")
        );
    }
    let sabotaged = rows.iter().filter(|row| !row.kind.words.is_empty());
    let (made, found, kinds) = sabotaged.fold((0, 0, 0), |(made, found, kinds), row| {
        (
            made + row.made,
            found + row.found,
            kinds + usize::from(row.made > 0),
        )
    });
    println!("row 3: {found} of {made} sabotaged runs found, of {kinds} kinds");
}
