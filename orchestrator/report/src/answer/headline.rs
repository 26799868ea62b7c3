//! The answer in one line, which the page begins with and `run` ends with.
//!
//! It is one line on a page 1280 pixels wide, whatever failed and whatever is missing: what there is no room for
//! is said in fewer words, and then only counted.

use std::collections::BTreeSet;

use analysis::LoopVerdict;
use plan::Client;

use super::words::listed;
use super::{Answer, Row, Standing};

/// What a line has room for, characters.
pub(super) const LINE: usize = 72;

impl Answer {
    /// One line: `Holds in 22 of 24 runs; lost over diego-vpn with c, 1 of 1.`
    pub(super) fn headline(&self) -> String {
        let runs = |figure: fn(&Standing) -> usize| -> usize {
            self.loops().map(|(_, _, standing)| figure(standing)).sum()
        };
        if self.survival().is_none() {
            return "No loop was closed: this experiment has open loops only.".to_owned();
        }
        let (planned, complete) = (runs(|of| of.planned), runs(|of| of.complete));
        if complete == 0 {
            return match planned {
                1 => "Not known whether the loop holds: its one run is not complete.".to_owned(),
                _ => {
                    format!("Not known whether the loop holds: none of {planned} runs is complete.")
                }
            };
        }
        let what = match (complete == planned, complete) {
            (true, 1) => "run".to_owned(),
            (true, _) => "runs".to_owned(),
            (false, 1) => format!("complete run of {planned}"),
            (false, _) => format!("complete runs of {planned}"),
        };
        let (holds, badly) = (runs(|of| of.holds), runs(|of| of.verdicts[1]));
        let of_all = |n: usize| match (n == complete, complete) {
            (true, 1) => format!("in its one {what}"),
            (true, _) => format!("in all {complete} {what}"),
            (false, _) => format!("in {n} of {complete} {what}"),
        };
        let opening = match (holds, badly) {
            (0, 0) if complete == 1 => format!("Does not hold in its one {what}"),
            (0, 0) => format!("Does not hold in any of {complete} {what}"),
            (0, badly) => format!("Holds badly {}", of_all(badly)),
            (holds, 0) => format!("Holds {}", of_all(holds)),
            (holds, badly) => format!("Holds {}, badly in {badly}", of_all(holds)),
        };
        let most_pct = self.loops().map(|(_, _, of)| of.overshoot_most_pct);
        let most_pct = most_pct.fold(0.0, f64::max);
        // Where a loop fails, that is said in its place.
        let overshoot = match badly > 0 && holds + badly == complete && most_pct > 100.0 {
            true => format!(" (overshoot to {most_pct:.0} %)"),
            false => String::new(),
        };
        let is_short = opening.chars().count() + overshoot.chars().count() < LINE;
        let opening = opening + if is_short { &overshoot } else { "" };
        // One for the full stop.
        let room = LINE.saturating_sub(opening.chars().count() + 1);
        opening + &self.failures(badly > 0 && holds == 0, room) + "."
    }

    /// Where the loop failed and how, as far as the line has room: `; lost over diego-vpn with c, 1 of 1`.
    fn failures(&self, badly_is_said: bool, room: usize) -> String {
        let length = |words: &str| words.chars().count();
        let verdicts = LoopVerdict::ALL.into_iter().skip(1).rev();
        let failed = |verdict| {
            let places = self.topologies.iter();
            places.filter_map(move |topology| Some((verdict, self.failure(verdict, topology)?)))
        };
        let mut parts: Vec<(LoopVerdict, Failure)> = verdicts.flat_map(failed).collect();
        // How many hold badly has been said: where, only beside no loop that fails.
        let is_fatal = |verdict: LoopVerdict| verdict != LoopVerdict::HoldsBadly;
        let has_fatal = parts.iter().any(|(verdict, _)| is_fatal(*verdict));
        parts.retain(|(verdict, _)| is_fatal(*verdict) || !(badly_is_said || has_fatal));
        let (mut line, mut said) = (String::new(), None);
        for (at, (verdict, failure)) in parts.iter().enumerate() {
            let opening = match (said == Some(*verdict), is_fatal(*verdict)) {
                (true, _) => ", ".to_owned(),
                (false, true) => format!("; {verdict} "),
                (false, false) => "; badly ".to_owned(),
            };
            let left = parts.len() - at - 1;
            let kept = if left > 0 { length(&more(left)) } else { 0 };
            let has_room = |words: &String| length(&line) + length(words) + kept <= room;
            let ways =
                [failure.words(), failure.short_words()].map(|words| opening.clone() + &words);
            // The last ways of saying the first are shorter: without clients, then without places.
            let fits = match at {
                0 => ways.into_iter().find(has_room),
                _ => Some(ways[0].clone()).filter(has_room),
            };
            match fits {
                Some(words) => line += &words,
                None if at > 0 => return line + &more(left + 1),
                None if is_fatal(*verdict) => return totals(&parts, room),
                None => return line,
            }
            said = Some(*verdict);
        }
        line
    }

    /// Complete runs of closed loops.
    pub(super) fn complete(&self) -> usize {
        self.loops().map(|(_, _, of)| of.complete).sum()
    }

    /// The runs over one topology that ended so, and their clients.
    fn failure(&self, verdict: LoopVerdict, topology: &str) -> Option<Failure> {
        let here = || {
            self.loops()
                .filter(|(_, place, of)| *place == topology && of.complete > 0)
        };
        let count = |of: &Standing| of.verdicts[verdict as usize];
        let failing = || here().filter(|(_, _, of)| count(of) > 0);
        let failed: usize = failing().map(|(_, _, of)| count(of)).sum();
        if failed == 0 {
            return None;
        }
        let clients = |of: &mut dyn Iterator<Item = &Row>| -> BTreeSet<Client> {
            of.map(|row| row.client).collect()
        };
        let (all, own) = (
            clients(&mut here().map(|(row, ..)| row)),
            clients(&mut failing().map(|(row, ..)| row)),
        );
        let complete = |of: &BTreeSet<Client>| -> usize {
            here()
                .filter(|(row, ..)| of.contains(&row.client))
                .map(|(_, _, standing)| standing.complete)
                .sum()
        };
        let word = match self.reference.as_deref() == Some(topology) {
            true => "on",
            false => "over",
        };
        let names: Vec<&str> = own.iter().map(Client::prose).collect();
        Some(Failure {
            place: format!("{word} {topology}"),
            clients: (all != own).then(|| listed(&names)),
            failed,
            of_these: complete(&own),
            of_all: complete(&all),
            is_all: self.complete() == 1,
        })
    }
}

/// Runs over one topology that ended alike.
struct Failure {
    /// `over diego-vpn`.
    place: String,
    /// Their clients; `None` if they are all that ran there.
    clients: Option<String>,
    failed: usize,
    /// Complete runs there, of their clients and of all.
    of_these: usize,
    of_all: usize,
    /// Whether no other run is complete anywhere.
    is_all: bool,
}

impl Failure {
    /// `over diego-vpn with c, 1 of 1`.
    fn words(&self) -> String {
        let Failure { place, failed, .. } = self;
        match &self.clients {
            Some(clients) => format!("{place} with {clients}, {failed} of {}", self.of_these),
            None => self.short_words(),
        }
    }

    /// The same without naming clients: `over diego-vpn, 1 of 4`.
    fn short_words(&self) -> String {
        let Failure { place, failed, .. } = self;
        // Of its one run, that is all.
        if self.is_all {
            place.clone()
        } else {
            format!("{place}, {failed} of {}", self.of_all)
        }
    }
}

/// How many failures are not said.
fn more(left: usize) -> String {
    format!("; and {left} more")
}

/// How many runs failed in which way, wherever: `; 3 lost, 1 silent`. Without room for that, how many in all.
fn totals(parts: &[(LoopVerdict, Failure)], room: usize) -> String {
    let by_verdict = parts.chunk_by(|one, other| one.0 == other.0).map(|alike| {
        let failed: usize = alike.iter().map(|(_, failure)| failure.failed).sum();
        match alike[0].0 {
            LoopVerdict::Unsettled => format!("{failed} not settled"),
            verdict => format!("{failed} {verdict}"),
        }
    });
    let words = format!("; {}", by_verdict.collect::<Vec<_>>().join(", "));
    if words.chars().count() <= room {
        return words;
    }
    let failed: usize = parts.iter().map(|(_, failure)| failure.failed).sum();
    let words = format!("; {failed} do not hold");
    // How many hold, of how many, has been said.
    match words.chars().count() <= room {
        true => words,
        false => String::new(),
    }
}
